//! `rate`: the error of every strategy falls as N^(−1/2), with the interval of the fit.
//!
//! Where the variance is not finite there is no such rate, however straight the line: the check then says so.

use rayon::prelude::*;

use super::Engine;
use super::compare::Plan;
use super::emitter::{EYE, TOP, top_after_one_reflection};
use super::rooms::{STRATEGIES, anywhere, named, settings, towards};
use crate::integrate::{RateFit, RatePoint, fit_rate};
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::path::Strategy;
use crate::render::probe::{Probe, merged};
use crate::sampling::sampler::Sampler;
use crate::scene::{Ray, Scene};
use crate::validate::convergence::is_heavy;
use crate::validate::power::{POWER, normal_upper, smallest};
use crate::validate::{Check, Outcome};

const REPLICATES: u64 = 64;
/// Samples of the shortest replicate, and how many lengths there are, each double the last.
const SHORTEST: u64 = 16;
const LENGTHS: u32 = 7;

/// Mean square errors about `exact` at every length, each from samples of its own.
fn points(
    probe: &Probe,
    tracer: &dyn Radiance,
    scene: &Scene,
    ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
    exact: f64,
) -> (Vec<RatePoint>, Moments, Vec<f64>) {
    let replicate = |r: u64| -> Vec<[Moments; 3]> {
        let start = |k: u32| (r << 32) + SHORTEST * ((1 << k) - 1);
        (0..LENGTHS).map(|k| probe.range(tracer, scene, ray, start(k)..start(k + 1))).collect()
    };
    let replicates: Vec<Vec<[Moments; 3]>> = (0..REPLICATES).into_par_iter().map(replicate).collect();
    let each: Vec<[Moments; 3]> = replicates.iter().map(|lengths| merged(lengths)).collect();
    let [all, ..] = merged(&each);
    let points = (0..LENGTHS as usize).map(|k| {
        let means = replicates.iter().map(|lengths| lengths[k][0].mean());
        RatePoint::of_means((SHORTEST << k) as f64, means, exact, all.excess_kurtosis())
    });
    (points.collect(), all, each.iter().map(|one| one[0].excess_kurtosis()).collect())
}

pub(super) fn check(engine: &Engine, plan: &Plan) -> Check {
    let mut check = Check::new("rate");
    let cube = named("cube-one-emitter", &[("rho", "0.5")]);
    let room = named("furnace-box", &[("rho", "0.8"), ("e", "0.2")]);
    let mut fits: Vec<(Strategy, &str, RateFit)> = Vec::new();
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        let probe = |number| Probe { seed: plan.seed, number, samples: 0 };
        let number = 1200 + 10 * k as u64;
        let (one, exact) = top_after_one_reflection(strategy);
        let direct = points(&probe(number), &*engine(one), &cube, &|s| towards(EYE, TOP, s.next_2d()), exact);
        let endless = engine(settings(strategy, None));
        let endless = points(&probe(number + 1), &*endless, &room, &|s| anywhere(glam::DVec3::ZERO, s.next_2d()), 1.0);
        for (name, (points, all, kurtoses)) in [("one reflection", direct), ("roulette", endless)] {
            if is_heavy(&all, &kurtoses) {
                return check.inconclusive_here(&format!(
                    "{strategy:?}, {name}: the tail is heavy (kurtosis {:.0}), so that the variance may be infinite and \
                     a rate means nothing",
                    all.excess_kurtosis()
                ));
            }
            fits.extend(fit_rate(&points).map(|fit| (strategy, name, fit)));
        }
    }
    let p_values = fits.iter().map(|(.., fit)| fit.p_value(-0.5));
    check.p_value = Some(smallest(p_values));
    let Some((strategy, name, worst)) = fits.iter().min_by(|a, b| a.2.p_value(-0.5).total_cmp(&b.2.p_value(-0.5)))
    else {
        return check.inconclusive_here("nothing spreads, so that no rate can be fitted");
    };
    check.outcome = Outcome::Pass;
    check.statistic = worst.slope;
    check.detail = format!(
        "{strategy:?}, {name}: N^{:.3} ± {:.3} (99 %), the farthest from -1/2 of {}",
        worst.slope,
        worst.half_width(0.99),
        fits.len()
    );
    let quantiles = normal_upper(0.5 * plan.share / fits.len() as f64) + normal_upper(1.0 - POWER);
    check.detects.insert("rate", quantiles * fits.iter().map(|(.., fit)| fit.std_err).fold(0.0, f64::max));
    check
}
