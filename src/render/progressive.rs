//! Rendering an image: samples of every pixel, in passes over the film, until enough is enough.
//!
//! Sample k of pixel i depends on the seed, i and k alone, and a pixel's samples are added in the order of k: the film
//! has the same bits for any number of threads and however the work was cut into passes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;

use super::film::{Film, Pixel};
use super::{Radiance, Sample, Samples, WAVE};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{AnySampler, Sampler, SamplerKind};
use crate::scene::{Ray, Scene, rays};

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
    /// Where random numbers come from, for any pixel and sample.
    pub sampler: &'a AnySampler,
}

impl std::fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { filter, sampler, .. } = self;
        write!(f, "Job {{ scene: {}, {filter}, {sampler:?} }}", self.scene.name())
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

/// Batches that the error is judged from, at least half as many and at most so many: enough for a variance of each pixel
/// that is known to about a half.
const BATCHES: u64 = 8;

/// Samples of a batch, by which a film judges the error of `planned` samples of this kind, or of an unknown number.
///
/// The larger, the nearer its upper bound is to the truth; where the number is unknown, the first [`LEAST_SAMPLES`] must
/// be two. What comes in random order is not better judged by batches than one by one.
pub fn batch_for(kind: SamplerKind, planned: Option<u64>) -> u64 {
    if !kind.is_sequence() {
        return 1;
    }
    planned.unwrap_or(LEAST_SAMPLES / 2 * BATCHES).div_ceil(BATCHES).next_power_of_two()
}

/// How far a rendering has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples that every pixel has.
    pub samples: u64,
    /// Seconds since the start.
    pub seconds: f64,
    /// Share of the work that is done, in [0, 1].
    pub share: f64,
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
        // Samples a pass may hold, from the speed so far; the first is a single one, by which the speed is known but roughly.
        let per_sample = if done > first { seconds / (done - first) as f64 } else { PASS_SECONDS };
        let growth = match stop {
            Stop::Samples(_) | Stop::Seconds(_) => 3,
            // What is drawn beyond the bound was not asked for.
            Stop::RelativeError(_) => 1,
        };
        let pass = ((PASS_SECONDS / per_sample) as u64).clamp(1, (growth * (done - first)).max(1));
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
        let share = match stop {
            Stop::Samples(n) => done as f64 / n as f64,
            Stop::Seconds(limit) => seconds / limit,
            // The error falls as the root of the time.
            Stop::RelativeError(bound) => (bound / film.relative_error()).powi(2),
        };
        report(film, Progress { samples: done, seconds, share: share.clamp(0.0, 1.0) });
    }
    cost.seconds = start.elapsed().as_secs_f64();
    cost
}

/// The fewest samples of any pixel, lost ones included.
pub fn least_samples(film: &Film) -> u64 {
    film.pixels().iter().map(Pixel::drawn).min().unwrap_or(0)
}

/// Brings every pixel up to `target` samples; the number of rays that it took.
fn raise(job: &Job, film: &mut Film, target: u64, interrupted: &AtomicBool) -> u64 {
    let (width, batch) = (film.width(), film.batch());
    let counts: Vec<u64> = film
        .pixels_mut()
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, pixels)| {
            if interrupted.load(Ordering::Relaxed) {
                return 0;
            }
            let before = rays::cast();
            job.raise_pixels(Part { first: chunk * CHUNK, width, batch, pixels }, target);
            rays::cast() - before
        })
        .collect();
    counts.into_iter().sum()
}

/// Consecutive pixels of a film.
struct Part<'p> {
    /// The number of the first.
    first: usize,
    /// Columns of the film.
    width: usize,
    /// Samples of a batch.
    batch: u64,
    pixels: &'p mut [Pixel],
}

impl Job<'_> {
    /// Brings the pixels up to `target` samples.
    fn raise_pixels(&self, part: Part, target: u64) {
        match self.sampler {
            AnySampler::Independent(sampler) => self.raise_by(sampler, part, target),
            AnySampler::Lattice(sampler) => self.raise_by(sampler, part, target),
            any => self.raise_by(any, part, target),
        }
    }

    /// Many samples at once, in the order of their numbers.
    fn raise_by<S: Sampler + Clone>(&self, sampler: &S, mut part: Part, target: u64)
    where
        for<'s> Samples<'s>: From<&'s mut [Sample<S>]>,
    {
        let mut wave = Vec::with_capacity(WAVE);
        let mut places = Vec::with_capacity(WAVE);
        for i in 0..part.pixels.len() {
            for number in part.pixels[i].drawn()..target {
                let pixel = part.first + i;
                let mut sampler = sampler.clone();
                sampler.begin(pixel as u64, number);
                let (ray, weight) = self.camera_ray(pixel, part.width, &mut sampler);
                wave.push(Sample::new(ray, sampler));
                places.push((i, weight));
                if wave.len() == WAVE {
                    self.develop(&mut wave, &mut places, &mut part);
                }
            }
        }
        self.develop(&mut wave, &mut places, &mut part);
    }

    /// The ray of a sample of a pixel, and the weight that the filter gives it.
    pub(crate) fn camera_ray(&self, pixel: usize, width: usize, sampler: &mut impl Sampler) -> (Ray, f64) {
        let (offset, weight) = self.filter.sample(sampler.next_2d());
        let lens = if self.scene.camera().has_lens() { sampler.next_2d() } else { DVec2::ZERO };
        let centre = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
        (self.scene.camera_ray(centre + offset, lens), weight)
    }

    /// Traces the samples and adds each to the pixel of its place.
    fn develop<S>(&self, wave: &mut Vec<Sample<S>>, places: &mut Vec<(usize, f64)>, part: &mut Part)
    where
        for<'s> Samples<'s>: From<&'s mut [Sample<S>]>,
    {
        self.radiance.radiances(self.scene, wave.as_mut_slice().into());
        for (sample, (pixel, weight)) in wave.drain(..).zip(places.drain(..)) {
            part.pixels[pixel].add(sample.radiance * weight, part.batch);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::color::Rgb;
    use crate::scene::{Camera, FilmSettings, Light, RenderSettings, SceneDescription};
    use glam::DVec3;

    /// Noise that depends on the ray and the sampler.
    struct Noise;

    impl Radiance for Noise {
        fn radiance(&self, _: &Scene, ray: crate::scene::Ray, sampler: &mut dyn Sampler) -> Rgb {
            Rgb::new(sampler.next_1d(), ray.dir.x.abs(), sampler.next_1d() + 1.0)
        }
    }

    fn sky() -> Scene {
        Scene::new(SceneDescription {
            name: "sky".into(),
            camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0),
            film: FilmSettings { width: 23, height: 11, filter: Filter::BOX },
            render: RenderSettings::default(),
            materials: Vec::new(),
            shapes: Vec::new(),
            lights: vec![Light::Constant { radiance: Rgb::WHITE }],
        })
        .unwrap()
    }

    fn rendered(kind: SamplerKind, threads: usize, targets: &[u64]) -> Film {
        let (scene, filter) = (sky(), Filter::BOX);
        let job = Job { scene: &scene, radiance: &Noise, filter: &filter, sampler: &kind.sampler(7, 40, 23) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut film = Film::new(23, 11).with_batches(batch_for(kind, Some(40)));
        for &target in targets {
            let mut progress = 0;
            pool.install(|| {
                render(&job, &mut film, Stop::Samples(target), &AtomicBool::new(false), &mut |_, p| {
                    progress = p.samples;
                })
            });
            assert_eq!(progress, target);
        }
        film
    }

    #[test]
    fn bits_do_not_depend_on_threads_or_passes() {
        for &(name, kind) in SamplerKind::ALL {
            let once = rendered(kind, 1, &[40]);
            assert!(once == rendered(kind, 3, &[40]) && once == rendered(kind, 2, &[3, 17, 40]), "{name}");
            assert!(once != rendered(kind, 1, &[39]), "{name}");
            assert_eq!(once.samples(), 40 * 23 * 11);
        }
    }

    #[test]
    fn an_interrupted_rendering_goes_on_where_it_was() {
        let (scene, filter) = (sky(), Filter::BOX);
        let job = Job {
            scene: &scene,
            radiance: &Noise,
            filter: &filter,
            sampler: &SamplerKind::Independent.sampler(7, 40, 23),
        };
        let (mut film, interrupted) = (Film::new(23, 11), AtomicBool::new(false));
        render(&job, &mut film, Stop::Samples(40), &interrupted, &mut |_, p| {
            interrupted.store(p.samples >= 5, Ordering::Relaxed);
        });
        assert!(film.samples() < 40 * 23 * 11);
        render(&job, &mut film, Stop::Samples(40), &AtomicBool::new(false), &mut |_, _| {});
        assert!(film == rendered(SamplerKind::Independent, 1, &[40]));
    }

    #[test]
    fn the_error_asked_for_is_reached_and_not_much_more_is_done() {
        let (scene, filter) = (sky(), Filter::BOX);
        let job = Job {
            scene: &scene,
            radiance: &Noise,
            filter: &filter,
            sampler: &SamplerKind::Independent.sampler(7, 40, 23),
        };
        let mut film = Film::new(23, 11);
        render(&job, &mut film, Stop::RelativeError(0.02), &AtomicBool::new(false), &mut |_, _| {});
        // The standard deviation is about .28 in two of three channels, the mean .8: 80 to 100 samples; passes double.
        assert!(film.relative_error() <= 0.02 && film.relative_error() > 0.01, "{}", film.relative_error());
    }
}
