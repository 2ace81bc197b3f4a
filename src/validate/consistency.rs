//! `weight`: what a sample says of itself agrees with eval and pdf.
//!
//! weight = f cos / density, and the density in the sample is pdf(wo, wi), on every sample drawn.

use super::check::{Check, Outcome};
use super::claim::Claim;
use super::draws::Tally;

/// Largest relative gap that is put down to rounding. A lobe of width 10⁻⁴ seen at grazing recovers its half vector
/// from wo + wi with a relative error of about 10⁻¹⁶ / (10⁻⁴ · 10⁻²), and the density follows it.
const ROUNDING: f64 = 1e-6;

/// The check over several directions.
pub(crate) fn check(runs: &[(Claim, Tally)]) -> Check {
    let mut check = Check::new("weight");
    check.bound = ROUNDING;
    let drawn: u64 = runs.iter().map(|(_, tally)| tally.n - tally.lost).sum();
    if drawn == 0 {
        return check.inconclusive_here("nothing was sampled: every draw was lost");
    }
    if let Some((claim, tally)) = runs.iter().find(|(_, tally)| tally.stray > 0 && tally.kept() == 0) {
        return check.inconclusive(claim.wo, &format!("none of {} samples has a density to compare", tally.n));
    }
    let gaps = runs.iter().flat_map(|(claim, tally)| {
        [("weight", tally.weight_gap), ("density", tally.density_gap)].map(|(what, gap)| (claim.wo, what, gap))
    });
    let Some((wo, what, gap)) = gaps.max_by(|a, b| a.2.size.total_cmp(&b.2.size)) else { return check };
    check.statistic = gap.size;
    check.worst = gap.wi.map(|wi| (wo, wi));
    check.outcome = if gap.size <= ROUNDING { Outcome::Pass } else { Outcome::Fail };
    check.detects.insert("weight", ROUNDING);
    check.detects.insert("density", ROUNDING);
    check.detail = match (check.outcome, what) {
        (Outcome::Pass, _) => format!("{drawn} samples agree with eval and pdf to {:.1e} relative", gap.size),
        (_, "weight") => format!("a sample's weight differs from f cos / density by {:.3e} relative", gap.size),
        _ => format!("a sample's density differs from pdf(wo, wi) by {:.3e} relative", gap.size),
    };
    check
}
