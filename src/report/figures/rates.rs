//! Studies of the lab as rows: the error at each number of samples, and the fitted exponents.

use super::{KNOWN, MEASURED, SEED, csv, rounded};
use crate::converge::study::CONFIDENCE;
use crate::converge::{Convergence, Estimator, Study, Target, Theory};
use crate::sampling::sampler::SamplerKind;

/// The columns of a table of errors.
pub(super) const ERRORS: &[(&str, &str)] = &[
    ("target", "the mean that is sought"),
    ("estimator", "how it is estimated"),
    ("sampler", "where the points come from"),
    ("n", "samples of a mean"),
    ("rmse", "root of the mean square error over the replicates, against the exact value"),
    ("log_std_err", "standard deviation of ln rmse"),
];

/// The columns of a table of fits.
pub(super) const FITS: &[(&str, &str)] = &[
    ("target", "the mean that is sought"),
    ("estimator", "how it is estimated"),
    ("sampler", "where the points come from"),
    ("exact", "the mean"),
    ("slope", "fitted exponent of the error"),
    ("half_width", "half of its 99 % interval"),
    ("steepest", "exponent of theory for smooth integrands; -inf where it may be faster still"),
    ("flattest", "exponent of theory for the worst integrand of finite variance"),
    ("sigma", "standard deviation of one sample, measured"),
    ("sigma_exact", "the same where it is known"),
    ("replicates", "means at each number of samples"),
];

/// One estimator with one kind of points.
pub(super) struct Row {
    target: String,
    exact: f64,
    estimator: &'static str,
    pub(super) sigma: Option<f64>,
    replicates: u64,
    pub(super) found: Convergence,
}

/// Studies `estimator` with points of this kind; studies of one file have numbers of their own.
pub(super) fn study(
    target: &Target,
    estimator: &Estimator,
    sampler: SamplerKind,
    counts: &[u64],
    replicates: u64,
    number: u64,
) -> Row {
    let study = Study { counts: counts.to_vec(), replicates, seed: SEED, number, sampler };
    let found = study.run(estimator, target.exact, target.error);
    Row {
        target: target.name.clone(),
        exact: target.exact,
        estimator: estimator.name,
        sigma: estimator.sigma,
        replicates,
        found,
    }
}

/// The table of errors and the table of fits.
pub(super) fn tables(rows: &[Row]) -> Vec<String> {
    vec![csv(ERRORS, rows.iter().flat_map(Row::errors)), csv(FITS, rows.iter().map(Row::fit))]
}

impl Row {
    fn head(&self) -> [String; 3] {
        [self.target.clone(), self.estimator.into(), self.found.sampler.name().into()]
    }

    /// The rows of a table of errors.
    fn errors(&self) -> impl Iterator<Item = Vec<String>> {
        self.found.points.iter().map(|point| {
            let numbers = [rounded(point.rmse, MEASURED), rounded(point.log_std_err, MEASURED)];
            self.head().into_iter().chain([point.n.to_string()]).chain(numbers).collect()
        })
    }

    /// The row of a table of fits.
    fn fit(&self) -> Vec<String> {
        let theory = Theory::of(self.found.sampler);
        let cell = |x: Option<f64>, digits| x.map_or(String::new(), |x| rounded(x, digits));
        let numbers = [
            rounded(self.exact, KNOWN),
            cell(self.found.fit.map(|fit| fit.slope), MEASURED),
            cell(self.found.fit.map(|fit| fit.half_width(CONFIDENCE)), MEASURED),
            theory.steepest.to_string(),
            theory.flattest.to_string(),
            rounded(self.found.samples.variance().sqrt(), MEASURED),
            cell(self.sigma, KNOWN),
            self.replicates.to_string(),
        ];
        self.head().into_iter().chain(numbers).collect()
    }
}
