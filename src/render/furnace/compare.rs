//! From estimates to a check: how far each lies from what it must be, and how likely that is.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::integrate::Estimate;
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::probe::Probe;
use crate::sampling::sampler::Sampler;
use crate::scene::{Ray, Scene};
use crate::validate::power::{POWER, normal_upper, smallest};
use crate::validate::{Check, Outcome};

/// Largest excess kurtosis per sample at which a mean is taken as normal.
const NORMAL_KURTOSIS: f64 = 0.01;
/// Relative error that rounding may leave in a mean of a few thousand samples, a thousand times over.
const ROUNDING: f64 = 1e-12;

/// What all checks of a run share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub(super) seed: u64,
    pub(super) samples: u64,
    /// What a single check is sure to get of the level.
    pub(super) share: f64,
}

impl Plan {
    /// The estimate of this number, which separates its random numbers from all others'.
    pub(super) fn estimate(
        &self,
        number: u64,
        tracer: &dyn Radiance,
        scene: &Scene,
        ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
    ) -> [Moments; 3] {
        Probe { seed: self.seed, number, samples: self.samples }.estimate(tracer, scene, ray)
    }
}

/// One comparison of an estimate with what it must be.
#[derive(Clone, Debug)]
pub(super) struct Comparison {
    label: String,
    z: f64,
    p_value: f64,
    /// Standard error relative to what is estimated.
    relative: f64,
}

impl Comparison {
    /// An estimate against a value known to `error`.
    pub(super) fn with_exact(label: impl Into<String>, found: &Moments, exact: f64, error: f64) -> Self {
        let estimate = Estimate::from(found);
        let z = estimate.z(exact, error + ROUNDING * exact.abs());
        let label = format!("{}: {:.6} ± {:.1e} against {exact:.6}", label.into(), estimate.mean, estimate.std_err);
        let rare = found.excess_kurtosis() > NORMAL_KURTOSIS * found.count() as f64;
        Self { label, z, p_value: p_value(z, rare), relative: estimate.std_err / exact.abs() }
    }

    /// Two independent estimates of the same, each times its factor.
    pub(super) fn of_two(label: impl Into<String>, [a, b]: [&Moments; 2], [by_a, by_b]: [f64; 2]) -> Self {
        let (first, second) = (by_a * a.mean(), by_b * b.mean());
        let std_err = (by_a * a.std_err()).hypot(by_b * b.std_err());
        let gap = Estimate { mean: first - second, std_err, n: a.count() };
        let z = gap.z(0.0, ROUNDING * first.abs());
        let label = format!("{}: {first:.6} and {second:.6} ± {std_err:.1e}", label.into());
        let rare = [a, b].iter().any(|m| m.excess_kurtosis() > NORMAL_KURTOSIS * m.count() as f64);
        Self { label, z, p_value: p_value(z, rare), relative: std_err / first.abs() }
    }

    pub(super) fn z(&self) -> f64 {
        self.z
    }
}

/// Two-sided; of any distribution (Chebyshev) where rare events make the spread.
fn p_value(z: f64, rare: bool) -> f64 {
    match z.is_nan() {
        true => f64::NAN,
        false if rare => (1.0 / (z * z)).min(1.0),
        false => 2.0 * Normal::standard().sf(z.abs()),
    }
}

/// The check over all comparisons: passes until the family is judged.
pub(super) fn check(name: &'static str, comparisons: &[Comparison], share: f64) -> Check {
    let mut check = Check::new(name);
    let Some(worst) = comparisons.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value)) else { return check };
    check.outcome = Outcome::Pass;
    check.p_value = Some(smallest(comparisons.iter().map(|c| c.p_value)));
    check.statistic = worst.z;
    check.detail = format!("{}: {:.1} standard errors, the worst of {}", worst.label, worst.z, comparisons.len());
    let bar = share / comparisons.len() as f64;
    let quantiles = normal_upper(0.5 * bar) + normal_upper(1.0 - POWER);
    let errors = || comparisons.iter().map(|c| c.relative).filter(|&r| r > 0.0 && r.is_finite());
    // A mistake in one place is caught by that comparison, one that is everywhere by the sharpest.
    check.detects.insert("relative_bias_of_one", quantiles * errors().fold(0.0, f64::max));
    let sharpest = errors().fold(f64::INFINITY, f64::min);
    check.detects.insert("relative_bias_of_all", if sharpest.is_finite() { quantiles * sharpest } else { 0.0 });
    check
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(values: &[f64]) -> Moments {
        let mut moments = Moments::default();
        for &value in values {
            moments.add(value);
        }
        moments
    }

    #[test]
    fn nan_is_never_a_good_p_value() {
        let found = moments(&[f64::NAN, 1.0, 2.0]);
        let check = check("rate", &[Comparison::with_exact("x", &found, 1.0, 0.0)], 0.01);
        assert_eq!(check.p_value, Some(0.0));
    }

    #[test]
    fn what_has_no_spread_must_be_exact() {
        let found = moments(&[0.5; 10]);
        assert_eq!(Comparison::with_exact("x", &found, 0.5, 0.0).p_value, 1.0);
        assert_eq!(Comparison::with_exact("x", &found, 0.5 + 1e-9, 0.0).p_value, 0.0);
        assert_eq!(Comparison::of_two("x", [&found, &found], [1.0, 1.0]).p_value, 1.0);
        assert_eq!(Comparison::of_two("x", [&found, &found], [1.0, 2.0]).p_value, 0.0);
    }

    #[test]
    fn a_rare_event_is_not_normal() {
        let mut values = vec![0.0; 999];
        values.push(1000.0);
        // One standard error off, but the spread is a single event.
        let comparison = Comparison::with_exact("x", &moments(&values), 11.0, 0.0);
        assert!(comparison.z < -5.0 && comparison.p_value > 0.005, "{comparison:?}");
    }
}
