//! `roulette_variance`: the second moment of a path that roulette ends is finite.
//!
//! In a furnace a path that is ended after its K-th reflection brings e Σ gᵏ, k ≤ K, where g = ρ / q is what a survivor
//! is weighed up by. The share of paths that come so far falls by q each time, their squares grow by g². The variance
//! is finite if and only if q g² = ρ² / q < 1. Both q and g are read off the samples, and so is how the sample variance grows.

use glam::DVec3;
use rayon::prelude::*;

use super::Engine;
use super::compare::Plan;
use super::rooms::{anywhere, named, settings};
use crate::math::sum::Moments;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::render::probe::{BLOCK, Probe};
use crate::validate::power::normal_upper;
use crate::validate::{Check, Outcome};

const RHO: f64 = 0.8;
/// Fewest paths at a reflection from which a share is read off.
const ENOUGH: usize = 400;
/// Relative gap below which two sums are of the same number of reflections.
const SAME: f64 = 1e-9;
/// Reflections, the last that enough paths reach, that q and g are read off.
const READ: usize = 3;
/// Fewest samples: some must survive long enough for the law to show.
const LEAST_SAMPLES: u64 = 1 << 16;

/// What the samples say of the law by which paths end.
#[derive(Clone, Copy, Debug)]
struct Law {
    /// Share of the paths that go on after a reflection.
    q: f64,
    /// Its standard error.
    q_err: f64,
    /// By how much the next term of a survivor is larger than the last.
    g: f64,
}

impl Law {
    /// From sorted samples; None where no path was ended by chance, or too few come far.
    fn read(sorted: &[f64]) -> Option<Self> {
        let mut levels: Vec<(f64, usize)> = Vec::new();
        for (i, &x) in sorted.iter().enumerate() {
            let new = levels.last().is_none_or(|&(last, _)| x - last > SAME * last.abs());
            if new {
                // So many come at least as far.
                levels.push((x, sorted.len() - i));
            }
        }
        let deep = levels.iter().filter(|(_, reach)| *reach >= ENOUGH).count();
        if deep < READ + 1 {
            return None;
        }
        let read = &levels[deep - READ - 1..deep];
        let before: usize = read[..READ].iter().map(|(_, reach)| reach).sum();
        let after: usize = read[1..].iter().map(|(_, reach)| reach).sum();
        let q = after as f64 / before as f64;
        let steps: Vec<f64> = read.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        let (first, last) = (steps.first()?, steps.last()?);
        let g = (last / first).powf(1.0 / (READ - 1) as f64);
        Some(Self { q, q_err: (q * (1.0 - q) / before as f64).sqrt(), g })
    }

    /// ρ² / q, by which the contribution of each next reflection to the second moment changes.
    fn ratio(&self) -> (f64, f64) {
        (self.q * self.g * self.g, self.q_err * self.g * self.g)
    }
}

pub(super) fn check(engine: &Engine, plan: &Plan) -> Check {
    let mut check = Check::new("roulette_variance");
    check.bound = 1.0;
    let room = named("furnace-box", &[("rho", "0.8"), ("e", "0.2")]);
    let samples = plan.samples.max(LEAST_SAMPLES).div_ceil(BLOCK);
    let quantile = normal_upper(plan.share / 3.0);
    check.outcome = Outcome::Pass;
    for (k, roulette) in [Roulette::Albedo, Roulette::From(5), Roulette::Constant(0.9)].into_iter().enumerate() {
        let tracer = engine(PathTracer { roulette, ..settings(Strategy::Bsdf, None) });
        let probe = Probe { seed: plan.seed, number: 1400 + k as u64, samples: 0 };
        let block = |b: u64| -> Vec<f64> {
            let ray = |s: &mut dyn crate::sampling::sampler::Sampler| anywhere(DVec3::ZERO, s.next_2d());
            probe.values(&*tracer, &room, &ray, b * BLOCK..(b + 1) * BLOCK).map(|radiance| radiance.0.x).collect()
        };
        let blocks: Vec<Vec<f64>> = (0..samples).into_par_iter().map(block).collect();
        let growth = growth_of_variance(&blocks);
        let mut values: Vec<f64> = blocks.into_iter().flatten().collect();
        values.sort_by(f64::total_cmp);
        let Some(law) = Law::read(&values) else {
            return check.inconclusive_here(&format!("{roulette:?}: too few paths come far enough to tell"));
        };
        let (ratio, error) = law.ratio();
        let margin = quantile * error;
        if ratio > check.statistic {
            check.statistic = ratio;
            // At 1 itself the sum diverges: what is not shown to be below is not finite.
            let (outcome, verdict) = match ratio {
                _ if ratio + margin < 1.0 => (check.outcome, "finite variance"),
                _ if ratio >= 1.0 => (Outcome::Fail, "INFINITE variance"),
                _ => (Outcome::Fail, "not shown to be below 1, the variance may be INFINITE"),
            };
            check.outcome = outcome;
            check.detail = format!(
                "{roulette:?}: {:.1} % go on and are weighed up by {:.3}, so that ρ²/q = {ratio:.3} ± {margin:.1e}: {verdict}; \
                 from {BLOCK} to {} samples the sample variance grew {growth:.1} times",
                100.0 * law.q,
                law.g / RHO,
                samples * BLOCK
            );
        }
        check.detects.insert("rho2_over_q_above", 1.0 - margin);
    }
    check
}

/// The variance of all samples in multiples of the median of the blocks' own.
fn growth_of_variance(blocks: &[Vec<f64>]) -> f64 {
    let moments = |values: &[f64]| {
        let mut moments = Moments::default();
        for &value in values {
            moments.add(value);
        }
        moments
    };
    let each: Vec<Moments> = blocks.iter().map(|values| moments(values)).collect();
    let all = each.iter().fold(Moments::default(), |all, one| all.merge(one));
    let mut variances: Vec<f64> = each.iter().map(Moments::variance).collect();
    variances.sort_by(f64::total_cmp);
    variances.get(variances.len() / 2).map_or(1.0, |median| all.variance() / median)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Radiance;

    fn law(q: f64) -> Law {
        let room = named("furnace-box", &[("rho", "0.8"), ("e", "0.2")]);
        let tracer = PathTracer { roulette: Roulette::Constant(q), ..settings(Strategy::Bsdf, None) };
        let probe = Probe { seed: 1, number: 0, samples: 0 };
        let ray = |s: &mut dyn crate::sampling::sampler::Sampler| anywhere(DVec3::ZERO, s.next_2d());
        let mut values: Vec<f64> =
            probe.values(&tracer as &dyn Radiance, &room, &ray, 0..30_000).map(|radiance| radiance.0.x).collect();
        values.sort_by(f64::total_cmp);
        Law::read(&values).expect("many levels")
    }

    #[test]
    fn the_law_is_read_off_the_samples() {
        for q in [0.5, 0.64, 0.9] {
            let (ratio, error) = law(q).ratio();
            assert!((ratio - 0.64 / q).abs() < 4.0 * error, "1 in 16 000 seeds: {ratio} ± {error} for {q}");
        }
    }

    #[test]
    fn nothing_is_read_where_nothing_ends() {
        assert!(Law::read(&vec![1.0; 5000]).is_none());
    }
}
