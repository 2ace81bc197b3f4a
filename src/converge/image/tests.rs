//! Studies of small images, and of values that are made up.

use super::*;
use crate::converge::{Theory, Verdict};
use crate::render::path::PathTracer;
use crate::sampling::filter::Filter;
use crate::sampling::stream::{stream, uniform};
use crate::scene::Scene;
use crate::scene::builtin::builtin;

fn measured(spread: Spread) -> Measured {
    Measured { spread, seconds: 1.0, nonfinite: 0 }
}

/// `replicates` images of normal-like noise in 20 pixels at each of seven counts, of variance n^(2 `slope`).
fn made_up(seed: u64, replicates: u64, slope: f64) -> ImageConvergence {
    let points = (0..7_u64).map(|k| {
        let n = 4_u64 << k;
        let image = |r| {
            let mut rng = stream(seed, k, r);
            let mut noise = || (0..12).map(|_| uniform(&mut rng)).sum::<f64>() - 6.0;
            let size = (n as f64).powf(slope);
            (0..20_u32).map(|at| Rgb::grey(1.0 + size * f64::from(1 + at % 4) * noise())).collect()
        };
        let images: Vec<Vec<Rgb>> = (0..replicates).map(image).collect();
        (n, measured(spread(&images, None)))
    });
    ImageConvergence::new(SamplerKind::Independent, points.collect(), 20.0 * replicates as f64)
}

#[test]
fn a_true_rate_is_rejected_as_often_as_the_level_says_and_a_false_one_always() {
    let theory = Theory::of(SamplerKind::Independent);
    let rejected = |replicates, slope| {
        let verdict = |seed| theory.verdict(made_up(seed, replicates, slope).fit.as_ref(), false, 0.05);
        (0..400).filter(|seed| verdict(*seed) == Verdict::Differs).count()
    };
    // 20 of 400 at level .05; the spread of replicates is itself estimated, which costs up to half as much again with six.
    let [few, many] = [6, 16].map(|replicates| rejected(replicates, -0.5));
    assert!((5..=45).contains(&few) && (5..=38).contains(&many), "{few} and {many} of 400");
    assert!(rejected(16, -0.62) > 380, "the fit has lost its power");
}

#[test]
fn one_value_that_carries_all_is_a_heavy_tail() {
    let spread = |share| Spread {
        variance: 1.0,
        log_variance: 0.01,
        largest_share: share,
        mean: 1.0,
        std_err: 0.1,
        floor: None,
    };
    let of = |shares: [f64; 4]| {
        let points = shares.iter().enumerate().map(|(k, share)| (1 << k, measured(spread(*share))));
        ImageConvergence::new(SamplerKind::Independent, points.collect(), 1.0)
    };
    let light = of([0.01; 4]);
    assert!(!light.heavy && light.fit.is_some());
    assert!(of([0.01, 0.01, 0.01, 0.1]).heavy);
    // What is heavy at small counts only is not fitted.
    let start = of([0.5, 0.5, 0.01, 0.01]);
    assert!(!start.heavy && start.fit.is_none());
}

#[test]
fn a_study_goes_on_after_every_image_to_the_same_bits() {
    let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap().with_size(6, 5);
    let tracer = PathTracer { bounces: Some(1), ..PathTracer::default() };
    let study = |number, sampler| {
        let plan = Study { counts: vec![1, 2, 4], replicates: 4, seed: 1, number, sampler };
        ImageStudy { radiance: &tracer, plan }
    };
    let colours = vec![Rgb::grey(0.1); 30];
    let reference = Reference { colours, variance: None };
    let lab = ImageLab {
        view: View { scene: &scene, filter: &Filter::BOX, pixel: None },
        reference: Some(&reference),
        studies: vec![study(0, SamplerKind::Independent), study(1, SamplerKind::Sobol)],
    };
    let timeless = |mut state: State| {
        state.measured.iter_mut().for_each(|measured| measured.seconds = 0.0);
        state
    };
    let mut whole = State::default();
    lab.go_on(&mut whole, &AtomicBool::new(false), &mut |_| {});
    assert_eq!((whole.measured.len(), lab.work(&whole)), (6, (56, 56)));
    let mut broken = State::default();
    let mut stops = 0;
    while broken.measured.len() < 6 {
        let interrupted = AtomicBool::new(false);
        lab.go_on(&mut broken, &interrupted, &mut |_| interrupted.store(true, Ordering::Relaxed));
        let (all, done) = lab.work(&broken);
        assert!(done > 0 && done <= all);
        let bytes = broken.encode("x");
        let path = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(path.path(), bytes).unwrap();
        broken = State::read(path.path(), "x", lab.extent()).unwrap();
        stops += 1;
    }
    assert_eq!(stops, 24);
    assert_eq!(timeless(broken), timeless(whole.clone()));
    let found = lab.found(&whole);
    assert_eq!((found.len(), found[1].points[2].0), (2, 4));
    assert!(found[0].points[0].1.spread != found[1].points[0].1.spread, "the studies share no number");
}
