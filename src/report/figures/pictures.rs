//! The lecture's pictures as numbers: the noise of an image against its samples, and what each bounce adds.

use std::sync::atomic::AtomicBool;

use super::{File, MEASURED, SEED, Set, csv, rounded, scene};
use crate::math::color::Rgb;
use crate::render::film::Film;
use crate::render::progressive::{Job, Stop, render};
use crate::report::contact_sheet::tracer;
use crate::sampling::sampler::SamplerKind;
use crate::scene::Scene;

/// `cornell_samples.csv` and `cornell_bounces.csv`.
pub const SET: Set = Set {
    name: "the Cornell box in numbers",
    files: &[
        File {
            name: "cornell_samples.csv",
            about: "Noise of the measured Cornell box against samples per pixel, with one bounce as in the lecture",
            columns: SAMPLES_COLUMNS,
        },
        File {
            name: "cornell_bounces.csv",
            about: "Mean radiance of the measured Cornell box against the largest number of reflections",
            columns: BOUNCES_COLUMNS,
        },
    ],
    make: || vec![csv(SAMPLES_COLUMNS, by_samples()), csv(BOUNCES_COLUMNS, by_bounces())],
};

const SAMPLES_COLUMNS: &[(&str, &str)] = &[
    ("samples", "samples per pixel"),
    (
        "rmse",
        "root mean square error of a pixel's channel against an image of many samples, whose own noise is taken off",
    ),
    ("rmse_estimate", "the same as the image itself tells it, from the variance within its pixels"),
    ("mean", "mean of all pixels and channels"),
];

const BOUNCES_COLUMNS: &[(&str, &str)] = &[
    ("reflections", "largest number of reflections, inf for no limit"),
    ("red", "mean of all pixels"),
    ("green", "mean of all pixels"),
    ("blue", "mean of all pixels"),
    ("green_std_err", "standard error of green; the others' are alike"),
    ("samples", "samples per pixel"),
];

/// Pixels along each side.
const SIDE: usize = 64;
/// The numbers of samples of the lecture, and what lies around them.
const COUNTS: [u64; 8] = [1, 2, 5, 10, 20, 40, 80, 160];
/// Samples of the reference.
const MANY: u64 = 512;
/// Samples of each image of some number of reflections.
const ENOUGH: u64 = 64;
/// Reflections, up to where the next one adds less than a hundredth.
const MOST: u32 = 8;

fn room() -> Scene {
    scene("cornell-original", &[]).with_size(SIDE, SIDE)
}

/// Brings `film` up to so many samples.
fn sample(room: &Scene, film: &mut Film, reflections: Option<u32>, samples: u64, seed: u64) {
    let (tracer, sampler) = (tracer(reflections), SamplerKind::Independent.sampler(seed, samples, SIDE as u64));
    let job = Job { scene: room, radiance: &tracer, filter: &room.film().filter, sampler: &sampler };
    render(&job, film, Stop::Samples(samples), &AtomicBool::new(false), &mut |_, _| {});
}

fn by_samples() -> Vec<Vec<String>> {
    let room = room();
    let two_reflections = Some(2);
    let mut many = Film::new(SIDE, SIDE);
    sample(&room, &mut many, two_reflections, MANY, SEED + 1);
    let own = many.rmse_estimate().powi(2);
    let mut film = Film::new(SIDE, SIDE);
    let row = |samples: u64| {
        sample(&room, &mut film, two_reflections, samples, SEED);
        let squares = film.pixels().iter().zip(many.pixels()).map(|(a, b)| {
            let gap = a.mean().0 - b.mean().0;
            Rgb(gap * gap).mean()
        });
        let mse = squares.sum::<f64>() / (SIDE * SIDE) as f64 - own;
        vec![
            samples.to_string(),
            rounded(mse.max(0.0).sqrt(), MEASURED),
            if samples > 1 { rounded(film.rmse_estimate(), MEASURED) } else { String::new() },
            rounded(film.image_mean().mean(), MEASURED),
        ]
    };
    COUNTS.into_iter().map(row).collect()
}

fn by_bounces() -> Vec<Vec<String>> {
    let room = room();
    let row = |reflections: Option<u32>| {
        let mut film = Film::new(SIDE, SIDE);
        // The same random numbers for all: a longer path begins as the shorter one, and what it adds is known far better than
        // either image.
        sample(&room, &mut film, reflections, ENOUGH, SEED + 2);
        let mean = film.image_mean().to_array().map(|channel| rounded(channel, MEASURED));
        let variances: f64 = film.pixels().iter().map(|pixel| pixel.variance_of_mean().0.y).sum();
        let std_err = variances.sqrt() / film.pixels().len() as f64;
        let reflections = reflections.map_or("inf".to_string(), |r| r.to_string());
        std::iter::once(reflections).chain(mean).chain([rounded(std_err, MEASURED), ENOUGH.to_string()]).collect()
    };
    (0..=MOST).map(Some).chain([None]).map(row).collect()
}
