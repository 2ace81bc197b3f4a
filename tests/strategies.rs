//! The lecture's path tracers are one estimator in many forms: all have the same mean, and the variance that they state
//! is the one that reruns show.

use std::sync::atomic::AtomicBool;

use statrs::distribution::{ContinuousCDF, Normal};
use whitefurnace::math::sum::Moments;
use whitefurnace::render::film::Film;
use whitefurnace::render::path::{PathTracer, Roulette, Strategy};
use whitefurnace::render::progressive::{Job, Stop, batch_for, render};
use whitefurnace::sampling::filter::Filter;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::Scene;
use whitefurnace::scene::builtin::builtin;

const SIZE: usize = 16;

fn cornell() -> Scene {
    let scene = builtin("cornell-original", &[]).expect("a built-in scene").expect("a sound one");
    Scene::new(scene).expect("a scene").with_size(SIZE, SIZE)
}

fn image(scene: &Scene, tracer: &PathTracer, samples: u64, seed: u64) -> Film {
    image_by(SamplerKind::Independent, scene, tracer, samples, seed)
}

fn image_by(kind: SamplerKind, scene: &Scene, tracer: &PathTracer, samples: u64, seed: u64) -> Film {
    image_on(Film::new(SIZE, SIZE), kind, scene, tracer, samples, seed)
}

fn image_on(mut film: Film, kind: SamplerKind, scene: &Scene, tracer: &PathTracer, samples: u64, seed: u64) -> Film {
    let job = Job { scene, radiance: tracer, filter: &Filter::BOX, sampler: &kind.sampler(seed, samples, SIZE as u64) };
    render(&job, &mut film, Stop::Samples(samples), &AtomicBool::new(false), &mut |_, _| {});
    film
}

/// Relative standard error up to which the mean of a pixel is normal: it is that of 100 events of equal size.
const NORMAL: f64 = 0.1;

/// The largest |z| over pixels and channels whose means are normal, how many those are, and the z of the whole image's mean,
/// worst channel.
fn differences(a: &Film, b: &Film) -> (f64, usize, f64) {
    let (mut worst, mut judged, mut whole) = (0.0_f64, 0, 0.0_f64);
    for channel in 0..3 {
        let (mut gap, mut variance) = (0.0, 0.0);
        for (p, q) in a.pixels().iter().zip(b.pixels()) {
            let [m, n] = [p, q].map(|pixel| pixel.mean().to_array()[channel]);
            let [v, w] = [p, q].map(|pixel| pixel.variance_of_mean().to_array()[channel]);
            if v.sqrt() <= NORMAL * m && w.sqrt() <= NORMAL * n && v + w > 0.0 {
                worst = worst.max((m - n).abs() / (v + w).sqrt());
                judged += 1;
            }
            gap += m - n;
            variance += v + w;
        }
        whole = whole.max(gap.abs() / variance.sqrt());
    }
    (worst, judged, whole)
}

/// |z| that one of `tests` independent normal numbers exceeds with probability `level`.
fn bound(tests: usize, level: f64) -> f64 {
    let each = 1.0 - (1.0 - level).powf(1.0 / tests as f64);
    -Normal::standard().inverse_cdf(0.5 * each)
}

fn strategies() -> Vec<(&'static str, PathTracer)> {
    let base = PathTracer { bounces: Some(2), roulette: Roulette::Off, ..PathTracer::default() };
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
    // By chance light is found in a hundredth of the samples.
    let samples = |tracer: &PathTracer| if tracer.strategy == Strategy::Bsdf { 16384 } else { 4096 };
    let images: Vec<_> =
        strategies().iter().map(|(name, tracer)| (*name, image(&scene, tracer, samples(tracer), 1))).collect();
    let pairs = images.len() * (images.len() - 1) / 2;
    // One false alarm in 1000 seeds each; neighbouring channels share their paths, which makes it rarer.
    let (per_pixel, per_image) = (bound(pairs * SIZE * SIZE * 3, 1e-3), bound(pairs * 3, 1e-3));
    for (i, (a, first)) in images.iter().enumerate() {
        for (b, second) in &images[i + 1..] {
            let (worst, judged, whole) = differences(first, second);
            assert!(judged > SIZE * SIZE, "{a} against {b}: {judged} of {} values can be compared", 3 * SIZE * SIZE);
            assert!(worst <= per_pixel, "{a} against {b}: a pixel differs by {worst:.1} sigma");
            assert!(whole <= per_image, "{a} against {b}: the image differs by {whole:.1} sigma");
        }
    }
    // The test sees one bounce more or less.
    let longer = PathTracer { bounces: Some(3), ..strategies()[0].1 };
    let (.., whole) = differences(&images[0].1, &image(&scene, &longer, 4096, 2));
    assert!(whole > per_image, "an off-by-one in depth is {whole:.1} sigma");
}

/// The mean over pixels of variance shown by reruns over variance stated, of the green channel.
fn shown_over_stated(films: &[Film]) -> f64 {
    let count = films.len() as f64;
    let green = |film: &Film, at: usize| film.pixels()[at].mean().0.y;
    let (mut ratios, mut pixels) = (0.0, 0.0);
    for at in 0..SIZE * SIZE {
        let mean = films.iter().map(|film| green(film, at)).sum::<f64>() / count;
        let shown = films.iter().map(|film| (green(film, at) - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let stated = films.iter().map(|film| film.pixels()[at].variance_of_mean().0.y).sum::<f64>() / count;
        if stated > 0.0 {
            (ratios, pixels) = (ratios + shown / stated, pixels + 1.0);
        }
    }
    assert!(pixels > 150.0, "{pixels} pixels");
    ratios / pixels
}

#[test]
fn reruns_show_the_variance_that_is_stated() {
    let scene = cornell();
    let (_, mis) = strategies()[0];
    let films: Vec<Film> = (0..32).map(|seed| image(&scene, &mis, 64, 100 + seed)).collect();
    // Some 200 pixels with 31 degrees of freedom each, all of one weight: √(2 / 6200) = 1.8 %. The sum of the variances would
    // be that of the few pixels on the edge of the light.
    let ratio = shown_over_stated(&films);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn sequences_state_an_upper_bound_of_their_variance() {
    let scene = cornell();
    let (_, mis) = strategies()[0];
    for kind in [SamplerKind::Halton, SamplerKind::Lattice, SamplerKind::Sobol, SamplerKind::BlueSobol] {
        let ratio_with = |batch: u64| {
            let rerun = |seed: u64| {
                let film = Film::new(SIZE, SIZE).with_batches(batch);
                image_on(film, kind, &scene, &mis, 64, 200 + seed)
            };
            shown_over_stated(&(0..32).map(rerun).collect::<Vec<_>>())
        };
        // Where the variance falls as N^-p, eight batches of 8 state 1 (p = 1, as for independent samples) to 9 times (p = 2)
        // what it is: that the bars are no narrower than the truth, and not absurdly wide. 5 %: as above.
        let batches = ratio_with(batch_for(kind, Some(64)));
        assert!((1.0 / 9.0..1.05).contains(&batches), "{kind:?}: {batches}");
        // Samples one by one would state more, by at least ten times what chance can do.
        let single = ratio_with(1);
        assert!(single < 0.8 * batches, "{kind:?}: {single} and {batches}");
    }
}

#[test]
fn every_sampler_has_the_same_mean_and_the_better_ones_less_noise() {
    let scene = cornell();
    let tracer = PathTracer { bounces: Some(4), roulette: Roulette::Off, ..PathTracer::default() };
    // The means of whole images under 200 seeds, of 16 samples in each pixel.
    let means = |kind| {
        let mut moments = [Moments::default(); 3];
        for seed in 0..200 {
            let film = image_by(kind, &scene, &tracer, 16, 1000 + seed);
            for (channel, moments) in moments.iter_mut().enumerate() {
                let sum: f64 = film.pixels().iter().map(|pixel| pixel.mean().to_array()[channel]).sum();
                moments.add(sum / (SIZE * SIZE) as f64);
            }
        }
        moments
    };
    let independent = means(SamplerKind::Independent);
    let others: Vec<_> = SamplerKind::ALL.iter().filter(|(_, kind)| *kind != SamplerKind::Independent).collect();
    let bound = bound(3 * others.len(), 1e-3);
    for (name, kind) in others {
        for (a, b) in independent.iter().zip(means(*kind)) {
            let z = (a.mean() - b.mean()) / a.std_err().hypot(b.std_err());
            assert!(z.abs() <= bound, "{name}: {a:?} and {b:?}");
            // The spread of two variances of 200 values each is 14 %: half would be 5 standard deviations away.
            assert!(b.variance() < 0.5 * a.variance(), "{name}: {a:?} and {b:?}");
        }
    }
}
