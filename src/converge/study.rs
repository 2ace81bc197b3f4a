//! The error of an estimator at growing numbers of samples, the fit of its rate, and what theory says.

use rand::Rng;
use rayon::prelude::*;
use std::time::Instant;

use super::Estimator;
use crate::integrate::{RateFit, RatePoint, fit_rate};
use crate::math::sum::Moments;
use crate::sampling::sampler::{Sampler, SamplerKind};
use crate::sampling::stream::stream;
use crate::validate::convergence::is_heavy;

/// How an error is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Numbers of samples, growing.
    pub counts: Vec<u64>,
    /// How many means of each number of samples are taken, with random numbers of their own.
    pub replicates: u64,
    /// The seed of all random numbers.
    pub seed: u64,
    /// Tells one study from another under the same seed: they share no number.
    pub number: u64,
    /// Where the points come from.
    pub sampler: SamplerKind,
}

/// The error at one number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Samples of a mean.
    pub n: u64,
    /// Root of the mean over all replicates of (mean − exact)².
    pub rmse: f64,
    /// The standard deviation of ln(rmse).
    pub log_std_err: f64,
    /// The mean of all replicates.
    pub mean: f64,
    /// Its standard error.
    pub std_err: f64,
}

/// What a study has found.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// Where the points came from.
    pub sampler: SamplerKind,
    /// One for each count.
    pub points: Vec<Point>,
    /// The line through them; None where there are fewer than three, or nothing spreads.
    pub fit: Option<RateFit>,
    /// All samples of all counts.
    pub samples: Moments,
    /// Whether so few samples carry so much of the sum that the variance may be infinite.
    pub heavy: bool,
    /// Processor seconds for one sample.
    pub seconds: f64,
}

/// The exponents that theory allows, whatever the integrand.
///
/// Stratified points are never slower than independent ones. How much faster they are depends on the integrand, and at few
/// samples an edge's −3/4 is not reached yet: only the bounds can be judged without knowing more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theory {
    /// The exponent for smooth integrands; −∞ where they may be faster still.
    pub steepest: f64,
    /// The exponent for the worst integrand of finite variance.
    pub flattest: f64,
}

/// What a study says of a theory.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The fit is as near to what theory allows as chance would have it.
    Agrees,
    /// It is not.
    Differs,
    /// The tail is heavy: the variance may be infinite, and a rate means nothing.
    HeavyTail,
    /// Replicates and range cannot tell one theory from another; why.
    Insufficient(String),
}

/// Half of the distance between −1/2 and −3/4, the rates of independent samples and of stratified ones at an edge: an
/// interval that is wider cannot tell the two apart.
const WIDEST: f64 = 0.125;

/// The confidence of an interval.
pub const CONFIDENCE: f64 = 0.99;

impl Theory {
    /// Of points in two dimensions.
    pub fn of(sampler: SamplerKind) -> Self {
        match sampler {
            SamplerKind::Independent => Self { steepest: -0.5, flattest: -0.5 },
            SamplerKind::Jittered => Self { steepest: -1.0, flattest: -0.5 },
            // What is a sum of functions of one dimension each has the rate of jittered points on a line.
            SamplerKind::MultiJittered => Self { steepest: -1.5, flattest: -0.5 },
            SamplerKind::Halton | SamplerKind::Lattice | SamplerKind::Sobol | SamplerKind::BlueSobol => {
                Self { steepest: f64::NEG_INFINITY, flattest: -0.5 }
            }
        }
    }
}

impl Study {
    /// Measures the error about `exact`, which itself is wrong by no more than `error`.
    pub fn run(&self, estimator: &Estimator, exact: f64, error: f64) -> Convergence {
        let units: Vec<(usize, u64)> =
            (0..self.counts.len()).flat_map(|k| (0..self.replicates).map(move |r| (k, r))).collect();
        let start = |&(k, r): &(usize, u64)| {
            let begun = Instant::now();
            let moments = mean(
                self.sampler,
                estimator,
                self.counts[k],
                stream(self.seed, self.number << 8 | k as u64, r).next_u64(),
            );
            (moments, begun.elapsed().as_secs_f64())
        };
        let means: Vec<(Moments, f64)> = units.par_iter().map(start).collect();
        let samples = means.iter().fold(Moments::default(), |all, (moments, _)| all.merge(moments));
        let of = |k: usize| means[k * self.replicates as usize..(k + 1) * self.replicates as usize].iter();
        let rate_points: Vec<RatePoint> = (self.counts.iter().enumerate())
            .map(|(k, &n)| {
                let means = of(k).map(|(moments, _)| moments.mean());
                RatePoint::of_means(n as f64, means, exact, samples.excess_kurtosis())
            })
            .collect();
        let points = rate_points.iter().zip(&self.counts).enumerate().map(|(k, (point, &n))| {
            let mut mean = Moments::default();
            of(k).for_each(|(moments, _)| mean.add(moments.mean()));
            Point {
                n,
                rmse: point.mean_square_error.sqrt(),
                log_std_err: 0.5 * point.log_variance.sqrt(),
                mean: mean.mean(),
                std_err: mean.std_err(),
            }
        });
        // What is as near to the exact value as that itself is known, and to rounding, says nothing of a rate.
        let floor = 10.0 * (error + 1e-13 * exact.abs());
        let fitted: Vec<RatePoint> =
            rate_points.iter().copied().filter(|point| point.mean_square_error.sqrt() > floor).collect();
        let last = self.counts.len().saturating_sub(1);
        let kurtoses: Vec<f64> = of(last).map(|(moments, _)| moments.excess_kurtosis()).collect();
        Convergence {
            sampler: self.sampler,
            points: points.collect(),
            fit: fit_rate(&fitted),
            heavy: is_heavy(&samples, &kurtoses),
            seconds: means.iter().map(|(_, seconds)| seconds).sum::<f64>() / samples.count().max(1) as f64,
            samples,
        }
    }
}

/// The values of one mean of `n` samples.
fn mean(sampler: SamplerKind, estimator: &Estimator, n: u64, seed: u64) -> Moments {
    let mut sampler = sampler.sampler(seed, n, 1);
    let mut moments = Moments::default();
    for sample in 0..n {
        sampler.begin(0, sample);
        moments.add((estimator.draw)(&mut sampler));
    }
    moments
}

impl Convergence {
    /// What the fit says of a theory. One that is true is rejected with probability `level`.
    pub fn verdict(&self, theory: &Theory, level: f64) -> Verdict {
        let Some(fit) = &self.fit else {
            return Verdict::Insufficient("fewer than three numbers of samples have an error to be seen".into());
        };
        let half = fit.half_width(CONFIDENCE);
        if self.heavy {
            return Verdict::HeavyTail;
        }
        let is_narrow = half <= WIDEST;
        if !is_narrow {
            Verdict::Insufficient(format!("the interval of the rate is ± {half:.3}, and must be ± {WIDEST} or less"))
        } else if fit.p_value(fit.slope.clamp(theory.steepest, theory.flattest)) >= level {
            Verdict::Agrees
        } else {
            Verdict::Differs
        }
    }

    /// The variance of one independent sample that would bring the same error at the largest count.
    pub fn variance(&self) -> f64 {
        match (self.sampler, self.points.last()) {
            // All samples know it better than the means of one count.
            (SamplerKind::Independent, _) => self.samples.variance(),
            (_, last) => last.map_or(f64::NAN, |point| point.rmse * point.rmse * point.n as f64),
        }
    }

    /// 1 / (variance × seconds).
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.variance() * self.seconds)
    }
}
