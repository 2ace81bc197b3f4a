//! The lecture's path tracers are one estimator in many forms: all have the same mean, and the variance that they state
//! is the one that reruns show.

use std::sync::atomic::AtomicBool;

use statrs::distribution::{ContinuousCDF, Normal};
use whitefurnace::render::film::Film;
use whitefurnace::render::filter::Filter;
use whitefurnace::render::path::{PathTracer, Roulette, Strategy};
use whitefurnace::render::progressive::{Job, Stop, render};
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::Scene;
use whitefurnace::scene::builtin::builtin;

const SIZE: usize = 16;

fn cornell() -> Scene {
    let scene = builtin("cornell-original", &[]).expect("a built-in scene").expect("a sound one");
    Scene::new(scene).expect("a scene").with_size(SIZE, SIZE)
}

fn image(scene: &Scene, tracer: &PathTracer, samples: u64, seed: u64) -> Film {
    let job = Job { scene, radiance: tracer, filter: &Filter::BOX, sampler: SamplerKind::Independent, seed };
    let mut film = Film::new(SIZE, SIZE);
    render(&job, &mut film, Stop::Samples(samples), &AtomicBool::new(false), &mut |_, _| {});
    film
}

/// The largest |z| over pixels and channels, and the z of the whole image's mean, worst channel.
fn differences(a: &Film, b: &Film) -> (f64, f64) {
    let (mut worst, mut whole) = (0.0_f64, 0.0_f64);
    for channel in 0..3 {
        let (mut gap, mut variance) = (0.0, 0.0);
        for (p, q) in a.pixels().iter().zip(b.pixels()) {
            let d = p.mean().to_array()[channel] - q.mean().to_array()[channel];
            let v = p.variance_of_mean().to_array()[channel] + q.variance_of_mean().to_array()[channel];
            if d != 0.0 {
                worst = worst.max(d.abs() / v.sqrt());
            }
            gap += d;
            variance += v;
        }
        whole = whole.max(gap.abs() / variance.sqrt());
    }
    (worst, whole)
}

/// |z| that one of `tests` independent normal numbers exceeds with probability `level`.
fn bound(tests: usize, level: f64) -> f64 {
    let each = 1.0 - (1.0 - level).powf(1.0 / tests as f64);
    -Normal::standard().inverse_cdf(0.5 * each)
}

fn strategies() -> Vec<(&'static str, PathTracer)> {
    let base = PathTracer { bounces: Some(4), roulette: Roulette::Off, ..PathTracer::default() };
    vec![
        ("mis", base),
        ("direct", PathTracer { strategy: Strategy::Direct, ..base }),
        ("bsdf", PathTracer { strategy: Strategy::Bsdf, ..base }),
        ("random-connect", PathTracer { strategy: Strategy::RandomConnect, ..base }),
        ("first-split 4", PathTracer { first_split: 4, ..base }),
        ("rr albedo", PathTracer { roulette: Roulette::Albedo, ..base }),
        ("rr depth:2", PathTracer { roulette: Roulette::From(2), ..base }),
    ]
}

#[test]
fn every_strategy_gives_the_same_cornell_box() {
    let scene = cornell();
    // Enough that the mean of a pixel is normal also where light is found by chance in a hundredth of the samples.
    let images: Vec<_> = strategies().iter().map(|(name, tracer)| (*name, image(&scene, tracer, 4096, 1))).collect();
    let pairs = images.len() * (images.len() - 1) / 2;
    // One false alarm in 1000 seeds each; neighbouring channels share their paths, which makes it rarer.
    let (per_pixel, per_image) = (bound(pairs * SIZE * SIZE * 3, 1e-3), bound(pairs * 3, 1e-3));
    for (i, (a, first)) in images.iter().enumerate() {
        for (b, second) in &images[i + 1..] {
            let (worst, whole) = differences(first, second);
            assert!(worst <= per_pixel, "{a} against {b}: a pixel differs by {worst:.1} sigma");
            assert!(whole <= per_image, "{a} against {b}: the image differs by {whole:.1} sigma");
        }
    }
    // The test sees one bounce more or less.
    let longer = PathTracer { bounces: Some(5), ..strategies()[0].1 };
    let (_, whole) = differences(&images[0].1, &image(&scene, &longer, 4096, 2));
    assert!(whole > per_image, "an off-by-one in depth is {whole:.1} sigma");
}

#[test]
fn reruns_show_the_variance_that_is_stated() {
    let scene = cornell();
    let (_, mis) = strategies()[0];
    let films: Vec<Film> = (0..32).map(|seed| image(&scene, &mis, 64, 100 + seed)).collect();
    let green = |film: &Film, at: usize| film.pixels()[at].mean().0.y;
    let (mut stated, mut shown) = (0.0, 0.0);
    for at in 0..SIZE * SIZE {
        let mean = films.iter().map(|film| green(film, at)).sum::<f64>() / 32.0;
        shown += films.iter().map(|film| (green(film, at) - mean).powi(2)).sum::<f64>() / 31.0;
        stated += films.iter().map(|film| film.pixels()[at].variance_of_mean().0.y).sum::<f64>() / 32.0;
    }
    // 256 pixels with 31 degrees of freedom each: √(2 / 7936) = 1.6 % if all weigh alike.
    assert!((shown / stated - 1.0).abs() < 0.05, "shown {shown:.3e} against stated {stated:.3e}");
}
