//! One level for all comparisons of a test.

use statrs::distribution::{ContinuousCDF, Normal};
use whitefurnace::integrate::Estimate;

/// Comparisons with exact values that fail together at one family-wise level.
#[derive(Debug, Default)]
pub(crate) struct Family {
    scores: Vec<(String, f64)>,
}

/// The probability that a test fails though everything is right: the seeds are fixed, so it will not.
const LEVEL: f64 = 1e-3;

impl Family {
    /// Adds an estimate and its exact value, known to `error`. Beyond chance, 1e-9 of the value is allowed for rounding.
    pub(crate) fn add(&mut self, label: impl Into<String>, estimate: Estimate, exact: f64, error: f64) {
        let label = format!("{}: {} ± {:.1e} against {exact}", label.into(), estimate.mean, estimate.std_err);
        self.scores.push((label, estimate.z(exact, error + 1e-9 * exact.abs())));
    }

    /// Fails where any score is too far out for so many (Šidák).
    pub(crate) fn judge(&self) {
        assert!(!self.scores.is_empty());
        let each = 1.0 - (1.0 - LEVEL).powf(1.0 / self.scores.len() as f64);
        let bound = Normal::standard().inverse_cdf(1.0 - 0.5 * each);
        let (_, far): (Vec<_>, Vec<_>) = self.scores.iter().partition(|(_, z)| z.abs() <= bound);
        assert!(far.is_empty(), "beyond {bound:.2} standard errors of {} comparisons: {far:#?}", self.scores.len());
    }
}
