//! The lecture's pictures on one sheet: more and more samples, more and more bounces, and what the bounces add.
//!
//! The lecture's path tracer connects every surface it hits to a light, and then follows one random ray. A **bounce** of the
//! lecture is such a random ray: with one bounce, light arrives directly at what the camera sees, and by way of one other
//! surface. Light is then reflected twice. So b bounces are [`PathTracer::bounces`] = b + 1 reflections, found by
//! [`Strategy::Direct`], and nothing else ends a path.
//!
//! All pictures of a sheet draw from the same random numbers. Those of 5 samples are the first 5 of those of 80, and a path
//! of three bounces begins as the one of one bounce does: the difference of the two pictures is what the later bounces
//! bring, without the noise of what they have in common, and nowhere negative.

mod layout;

use std::sync::atomic::{AtomicBool, Ordering};

use crate::render::film::Film;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::render::progressive::{Job, Progress, Stop, render};
use crate::sampling::sampler::SamplerKind;
use crate::scene::Scene;

pub use layout::draw;

/// The numbers of samples per pixel of the first row.
pub const SAMPLES: [u64; 6] = [1, 5, 10, 20, 40, 80];
/// The few and the many samples of the second row.
pub const FEW_AND_MANY: [u64; 2] = [5, 80];
/// The numbers of bounces of the second row.
pub const BOUNCES: [u32; 3] = [1, 2, 3];

/// What a sheet is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of a small picture in pixels.
    pub size: (usize, usize),
    /// Seed of all random numbers.
    pub seed: u64,
    /// Stops by which all pictures are made brighter.
    pub exposure: f64,
}

/// One picture.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Samples per pixel.
    pub samples: u64,
    /// Bounces as the lecture counts them.
    pub bounces: u32,
    /// The picture.
    pub film: Film,
    /// Seconds for its samples, from the first one on.
    pub seconds: f64,
}

/// All pictures of a sheet.
#[derive(Clone, Debug)]
pub struct Shots {
    /// The small ones, each once.
    pub small: Vec<Shot>,
    /// The large ones: the most samples with the fewest and with the most bounces.
    pub large: [Shot; 2],
}

impl Shots {
    /// The small picture of so many samples and bounces.
    pub fn small(&self, samples: u64, bounces: u32) -> Option<&Shot> {
        self.small.iter().find(|shot| shot.samples == samples && shot.bounces == bounces)
    }
}

/// The path tracer of the lecture: light is connected to at every surface, and nothing but the limit of reflections ends a
/// path; without one, roulette by the albedo.
pub(in crate::report) fn tracer(reflections: Option<u32>) -> PathTracer {
    let roulette = if reflections.is_some() { Roulette::Off } else { Roulette::Albedo };
    PathTracer { strategy: Strategy::Direct, bounces: reflections, roulette, ..PathTracer::default() }
}

/// Renders all pictures; None where `interrupted` was set. Calls `progress` with the share of the work that is done.
pub fn shoot(
    scene: Scene,
    settings: &Settings,
    interrupted: &AtomicBool,
    progress: &mut dyn FnMut(f64),
) -> Option<Shots> {
    let large = layout::large(settings.size);
    let [fewest, .., most] = BOUNCES;
    let many = [FEW_AND_MANY[1]];
    // (size, bounces, numbers of samples): the first row holds the fewest bounces' part of the second.
    let rest = BOUNCES[1..].iter().map(|&bounces| (settings.size, bounces, &FEW_AND_MANY[..]));
    let series: Vec<_> = std::iter::once((settings.size, fewest, &SAMPLES[..]))
        .chain(rest)
        .chain([(large, fewest, &many[..]), (large, most, &many[..])])
        .collect();
    let work = |&((width, height), bounces, counts): &((usize, usize), u32, &[u64])| {
        counts.last().map_or(0.0, |&samples| (width * height) as f64 * samples as f64 * f64::from(bounces + 1))
    };
    let whole: f64 = series.iter().map(work).sum();
    let (mut scene, mut done, mut shots) = (scene, 0.0, Vec::new());
    for one in &series {
        let &((width, height), bounces, counts) = one;
        scene = scene.with_size(width, height);
        let share = &mut |part: f64| progress((done + part * work(one)) / whole);
        shots.extend(take(&scene, bounces, counts, settings.seed, interrupted, share));
        if interrupted.load(Ordering::Relaxed) {
            return None;
        }
        done += work(one);
    }
    let last = shots.pop()?;
    let large = [shots.pop()?, last];
    Some(Shots { small: shots, large })
}

/// The pictures of one number of bounces: one film that is gone on with, and looked at on the way.
fn take(
    scene: &Scene,
    bounces: u32,
    counts: &[u64],
    seed: u64,
    interrupted: &AtomicBool,
    progress: &mut dyn FnMut(f64),
) -> Vec<Shot> {
    let most = counts.last().copied().unwrap_or(1);
    let (tracer, sampler) =
        (tracer(Some(bounces + 1)), SamplerKind::Independent.sampler(seed, most, scene.film().width as u64));
    let job = Job { scene, radiance: &tracer, filter: &scene.film().filter, sampler: &sampler };
    let mut film = Film::new(scene.film().width, scene.film().height);
    let mut seconds = 0.0;
    let shot = |&samples: &u64| {
        let report = &mut |_: &Film, now: Progress| progress(now.samples as f64 / most as f64);
        seconds += render(&job, &mut film, Stop::Samples(samples), interrupted, report).seconds;
        Shot { samples, bounces, film: film.clone(), seconds }
    };
    counts.iter().map(shot).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    fn shots(size: (usize, usize)) -> Shots {
        let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap();
        let settings = Settings { size, seed: 1, exposure: 0.0 };
        let mut last = 0.0;
        let shots = shoot(scene, &settings, &AtomicBool::new(false), &mut |share| {
            assert!(share >= last && share <= 1.0 + 1e-12, "{last} then {share}");
            last = share;
        });
        shots.unwrap()
    }

    #[test]
    fn later_bounces_only_add() {
        let shots = shots((12, 10));
        assert_eq!(shots.small.len(), 6 + 4, "each picture once");
        for samples in FEW_AND_MANY {
            for pair in BOUNCES.windows(2) {
                let [less, more] = [pair[0], pair[1]].map(|bounces| shots.small(samples, bounces).unwrap());
                let added = less.film.pixels().iter().zip(more.film.pixels()).map(|(a, b)| b.mean().0 - a.mean().0);
                // The same paths: only a rounding of the mean may go the other way.
                assert!(added.clone().all(|gap| gap.min_element() >= -1e-12), "{samples} samples, {pair:?}");
                assert!(added.map(glam::DVec3::element_sum).sum::<f64>() > 0.0);
            }
        }
        let [few, many] = &shots.large;
        assert_eq!((few.bounces, many.bounces, few.samples, many.samples), (1, 3, 80, 80));
        assert!(few.film.width() > 2 * 12);
    }

    #[test]
    fn an_interrupted_sheet_is_none() {
        let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap();
        let settings = Settings { size: (8, 8), seed: 1, exposure: 0.0 };
        assert!(shoot(scene, &settings, &AtomicBool::new(true), &mut |_| ()).is_none());
    }
}
