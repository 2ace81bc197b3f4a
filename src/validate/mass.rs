//! `pdf_mass`: the mass of the pdf above the horizon and the lost draws add up to 1.

use super::check::{Check, Outcome};
use super::chi2::lost_p;
use super::claim::Claim;
use super::draws::Tally;
use super::power::{POWER, normal_upper, smallest};

/// Excess of the claimed mass over 1 that is put down to rounding beyond the cubature's own bound.
const ROUNDING: f64 = 1e-8;

/// The check over several directions.
pub(crate) fn check(runs: &[(Claim, Tally)], level: f64) -> Check {
    let mut check = Check::new("pdf_mass");
    check.bound = 1.0;
    if let Some((claim, _)) = runs.iter().find(|(claim, _)| !claim.mass.resolved) {
        let what = format!("the pdf could not be integrated: {:.6} ± {:.1e}", claim.mass.value, claim.mass.error);
        return check.inconclusive(claim.wo, &what);
    }
    if runs.iter().all(|(_, tally)| tally.kept() == 0) {
        return check.inconclusive_here("nothing was sampled: every draw was lost or below the horizon");
    }
    let sum = |(claim, tally): &(Claim, Tally)| claim.mass.value + tally.lost as f64 / tally.n as f64;
    let p = |(claim, tally): &(Claim, Tally)| {
        let n = tally.n as f64;
        let uncertainty = n * (claim.mass.error + ROUNDING);
        let expected = n * (1.0 - claim.mass.value);
        // A claimed mass above 1 is wrong whatever is drawn.
        if expected < -uncertainty { 0.0 } else { lost_p(tally.lost, expected, uncertainty) }
    };
    check.p_value = Some(smallest(runs.iter().map(p)));
    let Some(worst) =
        runs.iter().min_by(|a, b| p(a).total_cmp(&p(b)).then((sum(b) - 1.0).abs().total_cmp(&(sum(a) - 1.0).abs())))
    else {
        return check;
    };
    check.statistic = sum(worst);
    check.worst = Some((worst.0.wo, worst.0.wo));
    check.outcome = Outcome::Pass;
    let quantiles = normal_upper(0.5 * level / runs.len() as f64) + normal_upper(1.0 - POWER);
    let smallest_error = |(claim, tally): &(Claim, Tally)| {
        let lost = (1.0 - claim.mass.value).clamp(0.0, 1.0);
        // Where nothing should be lost, a handful of lost draws is proof.
        claim.mass.error + quantiles * (lost / tally.n as f64).sqrt() + 10.0 / tally.n as f64
    };
    check.detects.insert("pdf_scale", runs.iter().map(smallest_error).fold(0.0, f64::max));
    check.detail = format!(
        "the pdf integrates to {:.6} ± {:.0e} and {:.6} of the draws are lost: {:.6} in all",
        worst.0.mass.value,
        worst.0.mass.error,
        worst.1.lost as f64 / worst.1.n as f64,
        check.statistic
    );
    check
}
