//! How large an error a statistical check would have caught: noncentral chi-square power, and p-values of counts.

use statrs::distribution::{ChiSquared, ContinuousCDF, Discrete, DiscreteCDF, Normal, Poisson};

/// The probability with which an error of the stated size is caught.
pub(crate) const POWER: f64 = 0.99;

/// The standard normal quantile that leaves `p` above it.
pub(crate) fn normal_upper(p: f64) -> f64 {
    -Normal::standard().inverse_cdf(p.clamp(1e-300, 1.0))
}

/// P(χ² ≥ statistic) with `dof` degrees of freedom. 0 degrees: nothing was compared, and p is 1.
pub(crate) fn chi_square_p(statistic: f64, dof: usize) -> f64 {
    match ChiSquared::new(dof as f64) {
        Ok(chi_square) if statistic.is_finite() => chi_square.sf(statistic),
        Ok(_) => 0.0,
        Err(_) => 1.0,
    }
}

/// The noncentrality at which a chi-square test of `dof` degrees of freedom rejects at `level` with probability
/// [`POWER`].
///
/// The noncentral distribution is taken as normal with mean dof + λ and variance 2 (dof + 2λ), good to a few percent
/// for the dof ≥ 8 used here (Johnson, Kotz & Balakrishnan 1995, chapter 29).
pub(crate) fn detectable_noncentrality(dof: usize, level: f64) -> f64 {
    let k = dof as f64;
    // Wilson-Hilferty's quantile: accurate to a percent, which is all that a statement of power needs.
    let h = 2.0 / (9.0 * k);
    let critical = k * (1.0 - h + normal_upper(level) * h.sqrt()).powi(3);
    let z = normal_upper(1.0 - POWER);
    // k + λ − critical = z √(2 (k + 2λ)), a quadratic in λ.
    let a = k - critical;
    let (b, c) = (2.0 * a - 4.0 * z * z, a * a - 2.0 * z * z * k);
    (0.5 * (-b + (b * b - 4.0 * c).max(0.0).sqrt())).max(0.0)
}

/// Two-sided p-value of a count that is Poisson with mean `expected`: twice the smaller tail, at most 1.
pub(crate) fn poisson_p(count: u64, expected: f64) -> f64 {
    let Ok(poisson) = Poisson::new(expected.max(1e-300)) else { return 1.0 };
    let lower = poisson.cdf(count);
    // sf(k) is P(X > k); P(X ≥ k) adds the point itself without cancellation.
    let upper = poisson.sf(count) + poisson.pmf(count);
    (2.0 * lower.min(upper)).min(1.0)
}

/// The smallest p-value of several, corrected for their number (Bonferroni): valid whatever their dependence.
pub(crate) fn smallest(p_values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut count, mut least) = (0.0, 1.0_f64);
    for p in p_values {
        count += 1.0;
        // NaN is no evidence of anything good.
        least = if p.is_nan() { 0.0 } else { least.min(p) };
    }
    (count * least).min(1.0)
}

/// Holm's step-down procedure: which hypotheses are rejected at the family-wise `level`, and the bound each was held to.
///
/// # References
/// - Holm 1979, Scandinavian Journal of Statistics 6
pub(crate) fn holm(p_values: &[f64], level: f64) -> Vec<(bool, f64)> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut verdicts = vec![(false, level); p_values.len()];
    let mut rejecting = true;
    for (rank, index) in order.into_iter().enumerate() {
        let bound = level / (p_values.len() - rank) as f64;
        rejecting = rejecting && p_values[index] <= bound;
        verdicts[index] = (rejecting, bound);
    }
    verdicts
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn holm_steps_down() {
        let verdicts = holm(&[0.02, 0.001, 0.04, 0.9], 0.05);
        let rejected: Vec<bool> = verdicts.iter().map(|v| v.0).collect();
        // .001 ≤ .05/4; .02 > .05/3, so nothing after it either.
        assert_eq!(rejected, [false, true, false, false]);
        assert!(holm(&[0.01, 0.02, 0.04], 0.05).iter().all(|v| v.0));
    }

    #[test]
    fn poisson_tails() {
        // P(X = 0) = e^-10, twice that.
        assert!((poisson_p(0, 10.0) - 2.0 * (-10.0_f64).exp()).abs() < 1e-12);
        assert!(poisson_p(10, 10.0) > 0.9);
        assert!(poisson_p(1, 1e-9) < 1e-8 && poisson_p(0, 0.0) > 0.99);
    }

    #[test]
    fn the_stated_power_is_met_by_simulation() {
        let (dof, level) = (127, 1e-3);
        let lambda = detectable_noncentrality(dof, level);
        let mut rng = crate::sampling::stream::stream(3, 0, 0);
        let trials = 2000;
        let rejections = (0..trials).filter(|_| {
            let mut statistic = 0.0;
            for i in 0..dof {
                let x: f64 = StandardNormal.sample(&mut rng);
                let shifted = if i == 0 { x + lambda.sqrt() } else { x };
                statistic += shifted * shifted;
            }
            chi_square_p(statistic, dof) <= level
        });
        // 99 % of 2000 is 1980 ± 4.4; the normal approximation may cost a little more.
        let count = rejections.count();
        assert!((1965..=1995).contains(&count), "{count}");
    }
}
