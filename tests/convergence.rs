//! The convergence lab: known means and standard deviations are found, rates agree with theory, and what must not be
//! believed is not.

#[path = "common/family.rs"]
mod family;

use family::Family;
use whitefurnace::bsdf::subject::parse;
use whitefurnace::converge::roulette::Furnace;
use whitefurnace::converge::variance::variance_std_err;
use whitefurnace::converge::{Estimator, Study, Target, Theory, Verdict, albedo, irradiance, square};
use whitefurnace::integrate::Estimate;
use whitefurnace::math::sphere::direction_mu;
use whitefurnace::sampling::sampler::{Sampler, SamplerKind};

/// The probability that a verdict is wrong by chance: the seeds are fixed, so it will not be.
const LEVEL: f64 = 1e-4;

fn study(number: u64, from: u32, to: u32, replicates: u64) -> Study {
    let counts = (from..=to).map(|k| 1 << k).collect();
    Study { counts, replicates, seed: 1, number, sampler: SamplerKind::Independent }
}

fn estimator<'a>(draw: impl Fn(&mut dyn Sampler) -> f64 + Sync + 'a) -> Estimator<'a> {
    Estimator { name: "test", draw: Box::new(draw), sigma: None }
}

#[test]
fn six_estimators_of_an_irradiance_have_their_means_spreads_and_rates() {
    let mut family = Family::default();
    for (name, published) in [("unit-square", 0.752274688454), ("unit-square-corner", 0.435209875684)] {
        let target = irradiance::irradiance(name).expect("a target");
        // Twelve digits are published.
        assert!((target.exact - published).abs() < 5e-13, "{name}: {}", target.exact);
        for (i, estimator) in target.estimators.iter().enumerate() {
            // 64 means of 16 to 4096 samples: a million, whose spread is known to .4 % even for the heaviest tail here.
            let found = study(i as u64, 4, 13, 64).run(estimator, target.exact, target.error);
            if let Some(sigma) = estimator.sigma {
                let ratio = found.samples.variance().sqrt() / sigma;
                assert!((ratio - 1.0).abs() < 0.02, "{name} {}: σ {ratio} of what it should be", estimator.name);
            }
            family.add(format!("{name} {}", estimator.name), Estimate::from(&found.samples), target.exact, 1e-15);
            assert_eq!(
                found.verdict(&Theory::of(SamplerKind::Independent), LEVEL),
                Verdict::Agrees,
                "{}",
                estimator.name
            );
        }
    }
    family.judge();
}

#[test]
fn estimators_of_an_albedo_agree_with_the_integrator() {
    let mut family = Family::default();
    for (s, subject) in
        ["lambert:rho=0.8", "ggx:alpha=0.3", "phong:n=20,norm=n+2", "rough-dielectric:alpha=0.4,eta=1.5", "mirror"]
            .into_iter()
            .enumerate()
    {
        let bsdf = parse(subject).expect("a model");
        let target = albedo::albedo(subject, &bsdf, direction_mu(0.6, 0.0));
        for (i, estimator) in target.estimators.iter().enumerate() {
            let found = study((10 * s + i) as u64, 6, 10, 64).run(estimator, target.exact, target.error);
            family.add(
                format!("{subject} {}", estimator.name),
                Estimate::from(&found.samples),
                target.exact,
                target.error,
            );
        }
    }
    family.judge();
}

#[test]
fn roulette_has_its_variance_and_an_infinite_one_is_not_called_a_rate() {
    for (i, (rho, q)) in [(0.5, 0.4), (0.5, 0.7), (0.9, 0.95)].into_iter().enumerate() {
        let furnace = Furnace::new(rho, q).expect("probabilities");
        let found = study(100 + i as u64, 6, 13, 64).run(&furnace.estimator(), furnace.mean(), 0.0);
        // Four standard errors; those of 0.4 are known barely, since 0.5^(4/3) is 0.397.
        let error = 4.0 * variance_std_err(&found.samples);
        assert!((found.samples.variance() - furnace.variance()).abs() < error, "ρ {rho}, q {q}: {:?}", found.samples);
        assert_eq!(found.verdict(&Theory::of(SamplerKind::Independent), LEVEL), Verdict::Agrees, "ρ {rho}, q {q}");
    }
    // q ≤ ρ²: no variance.
    let furnace = Furnace::new(0.9, 0.6).expect("probabilities");
    assert!(furnace.variance().is_infinite());
    let found = study(110, 6, 13, 64).run(&furnace.estimator(), furnace.mean(), 0.0);
    assert_eq!(found.verdict(&Theory::of(SamplerKind::Independent), LEVEL), Verdict::HeavyTail);
}

#[test]
fn a_bias_is_no_rate_and_little_data_no_verdict() {
    let theory = Theory::of(SamplerKind::Independent);
    let biased = estimator(|sampler| 1.02 * sampler.next_1d());
    assert_eq!(study(200, 6, 14, 64).run(&biased, 0.5, 0.0).verdict(&theory, LEVEL), Verdict::Differs);
    let fair = estimator(|sampler| sampler.next_1d());
    assert_eq!(study(201, 6, 14, 64).run(&fair, 0.5, 0.0).verdict(&theory, LEVEL), Verdict::Agrees);
    let little = study(202, 6, 8, 4).run(&fair, 0.5, 0.0).verdict(&theory, LEVEL);
    assert!(matches!(little, Verdict::Insufficient(_)), "{little:?}");
    // Nothing spreads, so that there is nothing to fit.
    let certain = study(203, 6, 14, 64).run(&estimator(|_| 0.5), 0.5, 0.0).verdict(&theory, LEVEL);
    assert!(matches!(certain, Verdict::Insufficient(_)), "{certain:?}");
}

/// Fits over N = 64 to 16384, in powers of `base`, with 256 replicates: the slope's standard error is then .008 for powers of
/// two and .010 for powers of four. With 64 it would be twice that, and chance alone could break the tolerances below.
fn rate(kind: SamplerKind, number: u64, base: u64, target: &Target) -> (f64, Verdict, Verdict) {
    let counts: Vec<u64> = (0..9).map(|k| 64 * base.pow(k)).filter(|&n| n <= 16_384).collect();
    let study = Study { counts, replicates: 256, seed: 1, number, sampler: kind };
    let found = study.run(&target.estimators[0], target.exact, target.error);
    let slope = found.fit.expect("a fit").slope;
    let [own, independent] = [kind, SamplerKind::Independent].map(|kind| found.verdict(&Theory::of(kind), LEVEL));
    (slope, own, independent)
}

#[test]
fn points_converge_as_theory_says_and_not_as_something_else() {
    let targets = ["smooth", "sum", "edge"].map(|name| square::square(name).expect("a target"));
    // The rates and tolerances of independent and jittered points, and of Sobol's at the edge, are those of independent
    // measurements, those of multi-jittered points are of theory; both are best at squares. For smooth integrands the error of
    // scrambled nets is N^(-3/2) where each term has one coordinate, and that times √ln N at most where they are mixed (Owen
    // 1997): over this range .076 of the exponent. Multi-jittered points are as even along each coordinate, and no more in both.
    // At least four standard errors are allowed.
    let log = 0.5 * (16_384_f64.ln() / 64_f64.ln()).ln() / (16_384_f64 / 64.0).ln();
    for (i, (kind, base, rates, tolerances)) in [
        (SamplerKind::Independent, 2, [(-0.5, -0.5); 3], [0.03; 3]),
        (SamplerKind::Jittered, 4, [(-0.99, -0.99), (-1.0, -1.0), (-0.78, -0.78)], [0.05; 3]),
        (SamplerKind::MultiJittered, 4, [(-1.0, -1.0), (-1.5, -1.5), (-0.75, -0.75)], [0.05; 3]),
        (SamplerKind::Sobol, 2, [(-1.5, -1.5 + log), (-1.5, -1.5), (-0.74, -0.74)], [0.033, 0.033, 0.06]),
    ]
    .into_iter()
    .enumerate()
    {
        for (k, ((target, expected), tolerance)) in targets.iter().zip(rates).zip(tolerances).enumerate() {
            let (slope, own, independent) = rate(kind, (300 + 3 * i + k) as u64, base, target);
            let (steepest, flattest) = expected;
            assert!((steepest - tolerance..=flattest + tolerance).contains(&slope), "{kind:?} {k}: {slope}");
            assert_eq!(own, Verdict::Agrees, "{kind:?} {k}: {slope}");
            let expected = if kind == SamplerKind::Independent { Verdict::Agrees } else { Verdict::Differs };
            assert_eq!(independent, expected, "{kind:?} {k}: {slope}, declared as independent");
        }
    }
}
