//! The rate at which an error falls with the number of samples, with the interval of its fit.

use statrs::distribution::{ContinuousCDF, Normal};

/// A straight line fitted to ln(RMSE) against ln(N).
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct RateFit {
    /// The fitted exponent: −1/2 for independent samples of finite variance.
    pub slope: f64,
    /// Its standard error, from the known spread of a sample variance and not from the residuals.
    pub std_err: f64,
}

impl RateFit {
    /// Two-sided p-value of the hypothesis that the true exponent is `slope`.
    pub fn p_value(&self, slope: f64) -> f64 {
        let z = (self.slope - slope).abs() / self.std_err;
        2.0 * Normal::standard().sf(z)
    }

    /// Half the width of the interval that holds the true exponent with probability `confidence`.
    pub fn half_width(&self, confidence: f64) -> f64 {
        self.std_err * Normal::standard().inverse_cdf(0.5 + 0.5 * confidence)
    }
}

/// One point of a convergence plot: N, and the mean over R replicates of the squared error at that N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatePoint {
    /// Samples per replicate.
    pub n: f64,
    /// Mean over the replicates of (estimate − exact)².
    pub mean_square_error: f64,
    /// Variance of ln of that mean: for Gaussian errors ψ₁(R/2), about 2/R; more where the errors have heavy tails.
    pub log_variance: f64,
}

impl RatePoint {
    /// From the means of `n` values each, of this excess kurtosis, and the exact value.
    pub fn of_means(n: f64, means: impl ExactSizeIterator<Item = f64>, exact: f64, excess_kurtosis: f64) -> Self {
        let replicates = means.len() as f64;
        Self {
            n,
            mean_square_error: means.map(|mean| (mean - exact).powi(2)).sum::<f64>() / replicates,
            // A mean of n values has 1/n of their excess kurtosis, and its square that much more variance.
            log_variance: trigamma(0.5 * replicates) + excess_kurtosis.max(0.0) / (n * replicates),
        }
    }
}

/// Weighted least squares of ½ ln(MSE) on ln N. None for fewer than three points or where an error is 0.
///
/// # References
/// - Var[ln s²] = ψ₁(R/2) for s² a mean of R squared Gaussians (the log of a gamma variable)
pub fn fit_rate(points: &[RatePoint]) -> Option<RateFit> {
    if points.len() < 3 || points.iter().any(|p| !(p.mean_square_error > 0.0 && p.log_variance > 0.0)) {
        return None;
    }
    // Var[½ ln s²] = ¼ Var[ln s²]
    let weighted = points.iter().map(|p| (4.0 / p.log_variance, p.n.ln(), 0.5 * p.mean_square_error.ln()));
    let (mut sum, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0);
    for (weight, x, y) in weighted.clone() {
        sum += weight;
        sum_x += weight * x;
        sum_y += weight * y;
    }
    let (mean_x, mean_y) = (sum_x / sum, sum_y / sum);
    let (mut sxx, mut sxy) = (0.0, 0.0);
    for (weight, x, y) in weighted {
        sxx += weight * (x - mean_x) * (x - mean_x);
        sxy += weight * (x - mean_x) * (y - mean_y);
    }
    (sxx > 0.0).then(|| RateFit { slope: sxy / sxx, std_err: sxx.recip().sqrt() })
}

/// ψ₁(x) = Σ 1/(x + k)², the trigamma function, for x > 0 to about 10⁻¹² relative.
///
/// Recurrence up to x ≥ 10, then the asymptotic series (Abramowitz & Stegun 1964, 6.4.12).
fn trigamma(x: f64) -> f64 {
    let (mut x, mut sum) = (x, 0.0);
    while x < 10.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    sum + 1.0 / x + 0.5 * y + y / x * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y / 30.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trigamma_at_one_is_basel() {
        assert!((trigamma(1.0) - std::f64::consts::PI.powi(2) / 6.0).abs() < 1e-11);
    }

    #[test]
    fn recovers_an_exact_power_law_and_the_stated_interval() {
        // R replicates at K sizes, each double the last: the standard error of the slope to four decimals.
        for (replicates, sizes, exact) in
            [(16.0, 8, 0.0406), (32.0, 8, 0.0283), (32.0, 10, 0.0202), (64.0, 10, 0.0141), (256.0, 10, 0.0070)]
        {
            let log_variance = trigamma(0.5 * replicates);
            let point = |n: f64| RatePoint { n, mean_square_error: 3.0 / n, log_variance };
            let points: Vec<RatePoint> = (0..sizes).map(|k| point(f64::from(1 << k))).collect();
            let fit = fit_rate(&points).unwrap();
            assert!((fit.slope + 0.5).abs() < 1e-12);
            assert!((fit.std_err - exact).abs() < 6e-5, "R = {replicates}, K = {sizes}: {}", fit.std_err);
            assert!(fit.p_value(-0.5) > 0.999 && fit.p_value(-0.5 - 5.0 * exact) < 1e-5);
        }
        // R = 32, K = 10: a 99 % interval of ± .052.
        let fit = RateFit { slope: -0.5, std_err: 0.0202 };
        assert!((fit.half_width(0.99) - 0.052).abs() < 1e-3);
    }

    #[test]
    fn too_little_is_no_fit() {
        let point = RatePoint { n: 1.0, mean_square_error: 1.0, log_variance: 0.1 };
        assert!(fit_rate(&[point, point]).is_none());
        assert!(fit_rate(&[point, point, RatePoint { mean_square_error: 0.0, ..point }]).is_none());
    }
}
