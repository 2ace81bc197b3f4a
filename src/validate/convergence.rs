//! `convergence`: the Monte Carlo albedo agrees with quadrature, and its error falls as N^(−1/2).
//!
//! A heavy tail makes both statements worthless: where one sample carries more than a twentieth of the sum, or the
//! kurtosis grows with the number of samples, the verdict is inconclusive and never pass.

use glam::DVec3;

use super::check::{Check, Outcome};
use super::claim::Claim;
use super::draws::{SHORTEST, Tally};
use super::power::{POWER, normal_upper, smallest};
use crate::bsdf::{Bsdf, Lobes};
use crate::integrate::{Estimate, Hemisphere, Integral, RateFit, RatePoint, Side, fit_rate};
use crate::math::sum::Moments;
use statrs::distribution::{ContinuousCDF, Normal};

/// −ln of the probability with which an event that n draws did not show is still this much more likely than 1/n.
const UNSEEN: f64 = 14.0;
/// Tolerance of the quadrature that sampling is compared with.
const FINEST: f64 = 8e-7;
/// Share of the standard error that the quadrature may be off where it is dear.
const NEEDED: f64 = 0.05;
/// Share of the sum above which a single sample makes an estimate untrustworthy.
const LARGEST_SHARE: f64 = 0.05;
/// Excess kurtosis above which its growth is looked at; bounded weights stay far below.
const NOTABLE_KURTOSIS: f64 = 50.0;
/// Standard deviations above the mean beyond which a weight, if it is also twice the mean, is a sign of a tail; a draw
/// that is merely lost lies below.
const FAR_ABOVE: f64 = 20.0;
/// Largest Var[ln MSE] at which the logarithm of a mean square is still about linear in it.
const LARGEST_LOG_VARIANCE: f64 = 0.2;
/// Largest excess kurtosis per sample at which the mean is taken as normal.
const NORMAL_KURTOSIS: f64 = 0.01;
/// Growth of the excess kurtosis from one block to all of them that betrays an infinite fourth moment, for which it
/// would be the number of blocks, 64.
const KURTOSIS_GROWTH: f64 = 4.0;

/// What the draws from one direction say about the estimator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence {
    pub(crate) estimate: Estimate,
    pub(crate) exact: Integral<f64>,
    pub(crate) z: f64,
    pub(crate) fit: Option<RateFit>,
    pub(crate) heavy: bool,
    /// The spread comes from events too rare for a normal mean.
    rare: bool,
}

impl Evidence {
    pub(crate) fn new(bsdf: &dyn Bsdf, wo: DVec3, tally: &Tally) -> Self {
        let estimate = Estimate::from(&tally.weights);
        // What is transmitted through facets ends at edges that no chart follows: no better than the draws need it.
        let transmits = bsdf.lobes().contains(Lobes::TRANSMIT);
        let tol = if transmits { (NEEDED * estimate.std_err).max(FINEST) } else { FINEST };
        let albedo = Hemisphere::with_tol(tol).albedo(bsdf, Side::Eye, wo);
        let exact = Integral {
            value: albedo.value.mean(),
            error: albedo.error,
            resolved: albedo.resolved,
            evals: albedo.evals,
        };
        let mut slack = exact.error + 1e-9 * exact.value.abs();
        if is_certain(&estimate) {
            slack += unseen(&estimate);
        }
        Self {
            estimate,
            exact,
            z: estimate.z(exact.value, slack),
            fit: rate(tally, exact.value, slack),
            heavy: is_heavy(&tally.weights, &tally.kurtoses),
            rare: tally.weights.excess_kurtosis() > NORMAL_KURTOSIS * tally.n as f64,
        }
    }

    pub(crate) fn p_values(&self) -> [f64; 2] {
        let normal = 2.0 * Normal::standard().sf(self.z.abs());
        // Chebyshev's inequality holds for any distribution.
        let agreement = if self.rare { (1.0 / (self.z * self.z)).min(1.0) } else { normal };
        [agreement, self.fit.map_or(1.0, |fit| fit.p_value(-0.5))]
    }
}

/// How far the mean may lie from the truth through lost draws so rare that n draws showed none.
fn unseen(estimate: &Estimate) -> f64 {
    UNSEEN / estimate.n as f64 * estimate.mean.abs()
}

/// Whether the draws spread so little that rare events which they do not show matter more: agreement is then no matter
/// of chance.
fn is_certain(estimate: &Estimate) -> bool {
    estimate.std_err <= unseen(estimate)
}

/// Fits the rate at which the replicates' error about the exact value falls, as far as that value, uncertain by `slack`,
/// is good enough to show it.
fn rate(tally: &Tally, exact: f64, slack: f64) -> Option<RateFit> {
    let lengths = tally.means.first()?.len();
    let kurtosis = tally.weights.excess_kurtosis();
    if is_certain(&Estimate::from(&tally.weights)) {
        return None;
    }
    let points: Vec<RatePoint> = (0..lengths)
        .map(|k| {
            let means = tally.means.iter().map(|means| means[k]);
            RatePoint::of_means((SHORTEST << k) as f64, means, exact, kurtosis)
        })
        .filter(|point| point.log_variance <= LARGEST_LOG_VARIANCE && point.mean_square_error.sqrt() > 10.0 * slack)
        .collect();
    fit_rate(&points)
}

/// Whether these weights, with the excess kurtoses of their blocks, have so heavy a tail that their mean is no good.
pub(crate) fn is_heavy(weights: &Moments, kurtoses: &[f64]) -> bool {
    let sum = weights.mean() * weights.count() as f64;
    let mut sorted = kurtoses.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let whole = weights.excess_kurtosis();
    let above = weights.max() - weights.mean();
    let far = above > FAR_ABOVE * weights.variance().sqrt() && above > weights.mean();
    let grows = far && whole > NOTABLE_KURTOSIS && whole > KURTOSIS_GROWTH * median.max(1.0);
    grows || (sum > 0.0 && weights.max() > LARGEST_SHARE * sum)
}

/// The check over several directions.
pub(crate) fn check(bsdf: &dyn Bsdf, runs: &[(Claim, Tally)], level: f64) -> Check {
    let mut check = Check::new("convergence");
    let evidence: Vec<(DVec3, Evidence)> =
        runs.iter().map(|(claim, tally)| (claim.wo, Evidence::new(bsdf, claim.wo, tally))).collect();
    if let Some((wo, _)) = evidence.iter().find(|(_, e)| !e.exact.resolved) {
        return check.inconclusive(*wo, "quadrature did not resolve the albedo, so there is nothing to compare with");
    }
    if let Some((wo, e)) = evidence.iter().find(|(_, e)| !e.estimate.mean.is_finite()) {
        check.outcome = Outcome::Fail;
        check.worst = Some((*wo, *wo));
        check.detail = format!("the mean weight is {}: a sample is not finite", e.estimate.mean);
        return check;
    }
    if evidence.iter().all(|(_, e)| e.exact.value == 0.0 && e.estimate.mean == 0.0) {
        return check.inconclusive_here("the model is black: no light, nothing to converge to");
    }
    if let Some((wo, e)) = evidence.iter().find(|(_, e)| e.heavy) {
        check.statistic = e.z;
        return check.inconclusive(
            *wo,
            &format!(
                "the weights have a heavy tail, so that no sample count makes their mean trustworthy: {:.6} by sampling, \
                 {:.6} by quadrature",
                e.estimate.mean, e.exact.value
            ),
        );
    }
    check.p_value = Some(smallest(evidence.iter().flat_map(|(_, e)| e.p_values())));
    let least = |e: &Evidence| e.p_values()[0].min(e.p_values()[1]);
    let Some((wo, worst)) = evidence.iter().min_by(|a, b| least(&a.1).total_cmp(&least(&b.1))) else { return check };
    check.statistic = worst.z;
    check.worst = Some((*wo, *wo));
    check.outcome = Outcome::Pass;
    let bar = level / (2 * evidence.len()) as f64;
    let quantiles = normal_upper(0.5 * bar) + normal_upper(1.0 - POWER);
    let bias = evidence.iter().map(|(_, e)| quantiles * e.estimate.std_err / e.exact.value.abs()).fold(0.0, f64::max);
    check.detects.insert("albedo_relative_bias", bias);
    let slope = worst.fit.map(|fit| format!("rate N^{:.3} ± {:.3} (99 %)", fit.slope, fit.half_width(0.99)));
    check.detail = format!(
        "sampling gives {:.6} ± {:.1e}, quadrature {:.6}: {:.1} standard errors apart; {}",
        worst.estimate.mean,
        worst.estimate.std_err,
        worst.exact.value,
        worst.z,
        slope.unwrap_or_else(|| "too little spread to fit a rate".into())
    );
    if let Some(fit) = worst.fit {
        check.detects.insert("rate", quantiles * fit.std_err);
    }
    check
}
