//! Rendering an image: samples of every pixel, in passes over the film, until enough is enough.
//!
//! Sample k of pixel i depends on the seed, i and k alone, and a pixel's samples are added in the order of k: the film
//! has the same bits for any number of threads and however the work was cut into passes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;

use super::Radiance;
use super::film::{Film, Pixel};
use super::filter::Filter;
use crate::sampling::sampler::{Sampler, SamplerKind};
use crate::scene::{Scene, rays};

/// Pixels that one thread works on at a time.
const CHUNK: usize = 64;
/// Seconds that a pass should take: how long an interruption, a look at the clock or at the error has to wait.
const PASS_SECONDS: f64 = 0.5;

/// What is rendered, and how.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The algorithm.
    pub radiance: &'a dyn Radiance,
    /// The reconstruction filter.
    pub filter: &'a Filter,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// The seed of all random numbers.
    pub seed: u64,
}

impl std::fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { filter, sampler, seed, .. } = self;
        write!(f, "Job {{ scene: {}, {filter}, {sampler:?}, seed: {seed} }}", self.scene.name())
    }
}

/// When an image is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// When every pixel has this many samples.
    Samples(u64),
    /// After this many seconds.
    Seconds(f64),
    /// When [`Film::relative_error`] has come down to this, at the earliest with [`LEAST_SAMPLES`] samples.
    RelativeError(f64),
}

/// Samples of a pixel below which its variance says too little to stop by it.
pub const LEAST_SAMPLES: u64 = 16;

/// How far a rendering has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples that every pixel has.
    pub samples: u64,
    /// Seconds since the start.
    pub seconds: f64,
    /// Share of the work that is done, in [0, 1].
    pub share: f64,
    /// The film's relative error so far; infinite for fewer than two samples.
    pub relative_error: f64,
}

/// The cost of a rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Rays cast.
    pub rays: u64,
    /// Seconds of wall-clock time.
    pub seconds: f64,
}

/// Adds samples to `film` until `stop` says so, or `interrupted` is set. Calls `report` after every pass.
///
/// A film that holds samples of the same job already goes on where it was left.
pub fn render(
    job: &Job,
    film: &mut Film,
    stop: Stop,
    interrupted: &AtomicBool,
    report: &mut dyn FnMut(&Film, Progress),
) -> Cost {
    let start = Instant::now();
    let mut cost = Cost::default();
    let first = least_samples(film);
    let mut done = first;
    loop {
        let seconds = start.elapsed().as_secs_f64();
        // Samples a pass may hold, from the speed so far; the first is a single one.
        let per_sample = if done > first { seconds / (done - first) as f64 } else { PASS_SECONDS };
        let pass = ((PASS_SECONDS / per_sample) as u64).clamp(1, (done - first).max(1));
        let target = match stop {
            Stop::Samples(n) if done >= n => break,
            Stop::Samples(n) => n.min(done + pass),
            Stop::Seconds(limit) if done > first && seconds + per_sample > limit => break,
            Stop::Seconds(limit) => done + pass.min((((limit - seconds) / per_sample) as u64).max(1)),
            Stop::RelativeError(bound) if done >= LEAST_SAMPLES && film.relative_error() <= bound => break,
            Stop::RelativeError(_) => done + pass,
        };
        cost.rays += raise(job, film, target, interrupted);
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
        done = target;
        let seconds = start.elapsed().as_secs_f64();
        let relative_error = film.relative_error();
        let share = match stop {
            Stop::Samples(n) => done as f64 / n as f64,
            Stop::Seconds(limit) => seconds / limit,
            // The error falls as the root of the time.
            Stop::RelativeError(bound) => (bound / relative_error) * (bound / relative_error),
        };
        report(film, Progress { samples: done, seconds, share: share.clamp(0.0, 1.0), relative_error });
    }
    cost.seconds = start.elapsed().as_secs_f64();
    cost
}

/// The fewest samples of any pixel, lost ones included.
fn least_samples(film: &Film) -> u64 {
    film.pixels().iter().map(drawn).min().unwrap_or(0)
}

fn drawn(pixel: &Pixel) -> u64 {
    pixel.n + pixel.nonfinite
}

/// Brings every pixel up to `target` samples; the number of rays that it took.
fn raise(job: &Job, film: &mut Film, target: u64, interrupted: &AtomicBool) -> u64 {
    let width = film.width();
    let counts: Vec<u64> = film
        .pixels_mut()
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, pixels)| {
            if interrupted.load(Ordering::Relaxed) {
                return 0;
            }
            let before = rays::cast();
            let mut sampler = job.sampler.start(job.seed);
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let number = chunk * CHUNK + i;
                let corner = DVec2::new((number % width) as f64, (number / width) as f64);
                for sample in drawn(pixel)..target {
                    sampler.begin(number as u64, sample);
                    pixel.add(job.sample(corner, &mut *sampler));
                }
            }
            rays::cast() - before
        })
        .collect();
    counts.into_iter().sum()
}

impl Job<'_> {
    /// One sample of the pixel whose upper left corner is at `corner`.
    fn sample(&self, corner: DVec2, sampler: &mut dyn Sampler) -> crate::math::color::Rgb {
        let (offset, weight) = self.filter.sample(sampler.next_2d());
        let lens = if self.scene.camera().has_lens() { sampler.next_2d() } else { DVec2::ZERO };
        let ray = self.scene.camera_ray(corner + 0.5 + offset, lens);
        self.radiance.radiance(self.scene, ray, sampler) * weight
    }
}
