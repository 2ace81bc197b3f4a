//! A whole image as a target: how its error falls with the samples of a pixel.
//!
//! For each number of samples an image is made R times, with random numbers of its own each time. The spread of the R gives
//! the variance without any reference; the common part of their differences from a [`Reference`] is the floor, which no number
//! of samples takes away: see [`mod@spread`]. A rate is fitted to the variance alone.
//!
//! The work is cut into images. What has been done so far is a [`State`], from which the rest goes on to the same bits.

pub mod estimator;
pub mod reference;
pub mod spread;
pub mod state;
pub mod view;

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::integrate::{RateFit, RatePoint, fit_rate};
use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::render::film::Pixel;
use crate::sampling::sampler::SamplerKind;

pub use reference::Reference;
pub use spread::{Floor, Spread, spread};
pub use state::{Extent, State};
pub use view::{Numbers, View};

use super::Study;

/// An estimator's images, and how often and of what they are made.
pub struct ImageStudy<'a> {
    /// The estimator.
    pub radiance: &'a dyn Radiance,
    /// Counts, replicates, seeds and sampler.
    pub plan: Study,
}

impl fmt::Debug for ImageStudy<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ImageStudy").field("plan", &self.plan).finish_non_exhaustive()
    }
}

/// Several studies of one view against one reference. All have the same counts and replicates.
#[derive(Debug)]
pub struct ImageLab<'a> {
    /// What is looked at.
    pub view: View<'a>,
    /// What the floor is measured against.
    pub reference: Option<&'a Reference>,
    /// The studies, in the order of their work.
    pub studies: Vec<ImageStudy<'a>>,
}

/// What is done for one number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// What its images say.
    pub spread: Spread,
    /// Processor seconds that they took.
    pub seconds: f64,
    /// Samples that were NaN or infinite and are left out.
    pub nonfinite: u64,
}

/// What a study of an image has found.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageConvergence {
    /// Where the points came from.
    pub sampler: SamplerKind,
    /// The counts, with what was measured.
    pub points: Vec<(u64, Measured)>,
    /// The line through the variances; None where fewer than three can be used.
    pub fit: Option<RateFit>,
    /// Whether at the largest count one pixel of one replicate carries so much of the variance that a rate means nothing.
    pub heavy: bool,
    /// Processor seconds for one sample.
    pub seconds: f64,
}

/// Share of a variance above which a single outlier makes it untrustworthy: as of a single sample in a sum elsewhere.
const LARGEST_SHARE: f64 = 0.05;

/// Standard deviations below this share of the mean are roundings.
const ROUNDING: f64 = 1e-12;

impl ImageLab<'_> {
    /// How large a state may be.
    pub fn extent(&self) -> Extent {
        let plan = self.studies.first().map(|study| &study.plan);
        let [width, height] = self.view.size();
        Extent {
            measured: self.studies.iter().map(|study| study.plan.counts.len()).sum(),
            replicates: plan.map_or(0, |plan| plan.replicates as usize),
            pixels: width * height,
        }
    }

    /// Samples of a pixel for all images, and for those of `state`: shares of the work.
    pub fn work(&self, state: &State) -> (u64, u64) {
        let counts: Vec<u64> = self.studies.iter().flat_map(|study| study.plan.counts.iter().copied()).collect();
        let replicates = self.extent().replicates as u64;
        let of = |counts: &[u64]| counts.iter().map(|n| n * replicates).sum::<u64>();
        let done = state.measured.len().min(counts.len());
        let current = counts.get(done).map_or(0, |n| n * state.images.len() as u64);
        (of(&counts), of(&counts[..done]) + current)
    }

    /// Goes on from `state` until all is done or `interrupted` is set. Calls `report` after every image.
    pub fn go_on(&self, state: &mut State, interrupted: &AtomicBool, report: &mut dyn FnMut(&State)) {
        let units: Vec<(&ImageStudy, usize)> =
            self.studies.iter().flat_map(|study| (0..study.plan.counts.len()).map(move |k| (study, k))).collect();
        for (study, k) in units.into_iter().skip(state.measured.len()) {
            for r in state.images.len() as u64..study.plan.replicates {
                let numbers = Numbers {
                    sampler: study.plan.sampler,
                    seed: study.plan.seed_of(k, r),
                    samples: study.plan.counts[k],
                };
                let mut film = self.view.blank();
                let cost = self.view.raise(study.radiance, numbers, &mut film, interrupted, &mut |_, _| {});
                if interrupted.load(Ordering::Relaxed) {
                    // An image that lacks samples is none.
                    return;
                }
                state.nonfinite += film.nonfinite();
                state.seconds += cost.seconds * rayon::current_num_threads() as f64;
                state.images.push(film.pixels().iter().map(Pixel::mean).collect::<Vec<Rgb>>());
                // The last image of a count is reported with what it completes.
                if state.images.len() < study.plan.replicates as usize {
                    report(state);
                }
            }
            let spread = spread(&state.images, self.reference);
            state.measured.push(Measured { spread, seconds: state.seconds, nonfinite: state.nonfinite });
            (state.images, state.seconds, state.nonfinite) = (Vec::new(), 0.0, 0);
            report(state);
        }
    }

    /// What the studies have found, as far as they are done.
    pub fn found(&self, state: &State) -> Vec<ImageConvergence> {
        let mut rest = state.measured.iter().copied();
        let values = (self.extent().pixels * self.extent().replicates) as f64;
        let of = |study: &ImageStudy| {
            let points: Vec<_> = study.plan.counts.iter().copied().zip(rest.by_ref()).collect();
            ImageConvergence::new(study.plan.sampler, points, values)
        };
        self.studies.iter().map(of).collect()
    }
}

impl ImageConvergence {
    /// From what was measured; each of the points has so many values of a pixel of an image.
    fn new(sampler: SamplerKind, points: Vec<(u64, Measured)>, values: f64) -> Self {
        let is_heavy = |spread: &Spread| spread.largest_share > LARGEST_SHARE;
        let samples: f64 = points.iter().map(|(n, _)| *n as f64 * values).sum();
        let seconds = points.iter().map(|(_, measured)| measured.seconds).sum::<f64>() / samples;
        let usable: Vec<(u64, Spread)> = (points.iter().map(|(n, measured)| (*n, measured.spread)))
            .filter(|(_, spread)| !is_heavy(spread) && spread.variance.sqrt() > ROUNDING * spread.mean.abs())
            .collect();
        let rate_points: Vec<RatePoint> = (0..usable.len())
            .map(|k| {
                // Few replicates know the spread of their spread badly; it changes little from one count to the next.
                let near = &usable[k.saturating_sub(1)..usable.len().min(k + 2)];
                let log_variance = near.iter().map(|(_, spread)| spread.log_variance).sum::<f64>() / near.len() as f64;
                RatePoint { n: usable[k].0 as f64, mean_square_error: usable[k].1.variance, log_variance }
            })
            .collect();
        Self {
            sampler,
            fit: fit_rate(&rate_points),
            heavy: points.last().is_some_and(|(_, measured)| is_heavy(&measured.spread)),
            seconds,
            points,
        }
    }

    /// The variance of one independent sample that would bring the same error: at the largest count, or at all of them for
    /// samples that are independent.
    pub fn variance(&self) -> f64 {
        let of = |(n, measured): &(u64, Measured)| *n as f64 * measured.spread.variance;
        let Some(last) = self.points.last() else { return f64::NAN };
        if self.sampler != SamplerKind::Independent {
            return of(last);
        }
        let usable = |p: &&(u64, Measured)| p.1.spread.log_variance > 0.0;
        let weights = || self.points.iter().filter(usable).map(|p| (of(p), 1.0 / p.1.spread.log_variance));
        let (sum, weight) = weights().fold((0.0, 0.0), |(sum, all), (v, weight)| (sum + v * weight, all + weight));
        if weight > 0.0 { sum / weight } else { of(last) }
    }

    /// 1 / (variance × seconds).
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.variance() * self.seconds)
    }

    /// The floor at the largest count, where it is known best.
    pub fn floor(&self) -> Option<Floor> {
        self.points.last().and_then(|(_, measured)| measured.spread.floor)
    }
}

#[cfg(test)]
mod tests;
