//! Estimates by sampling: a mean with its standard error.

use crate::math::sum::Moments;

/// A Monte Carlo estimate. Lost draws count as 0 and are part of `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Estimate {
    /// Mean of the samples.
    pub mean: f64,
    /// Standard error of the mean; infinite for fewer than two samples.
    pub std_err: f64,
    /// Number of samples, lost draws included.
    pub n: u64,
}

impl From<&Moments> for Estimate {
    fn from(moments: &Moments) -> Self {
        Self { mean: moments.mean(), std_err: moments.std_err(), n: moments.count() }
    }
}

impl Estimate {
    /// How many standard errors lie between the mean and `exact`, itself uncertain by `error`: 0 where they agree
    /// exactly, infinite where the estimate has no spread and yet differs.
    pub fn z(&self, exact: f64, error: f64) -> f64 {
        let gap = (self.mean - exact).abs();
        let excess = (gap - error).max(0.0);
        let sign = if self.mean < exact { -1.0 } else { 1.0 };
        if gap.is_nan() {
            f64::NAN
        } else if excess == 0.0 {
            0.0
        } else {
            sign * excess / self.std_err
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_knows_zero_spread_and_nan() {
        let exact = Estimate { mean: 0.5, std_err: 0.0, n: 10 };
        assert_eq!(exact.z(0.5, 1e-12), 0.0);
        assert_eq!(exact.z(0.4, 1e-12), f64::INFINITY);
        assert!(exact.z(f64::NAN, 0.0).is_nan());
        let noisy = Estimate { mean: 0.5, std_err: 0.1, n: 10 };
        assert!((noisy.z(0.7, 0.0) + 2.0).abs() < 1e-12);
    }
}
