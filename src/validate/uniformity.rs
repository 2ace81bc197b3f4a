//! `uniformity`: the claimed cdf, applied to the samples, must give uniform numbers.
//!
//! The probability integral transforms of both coordinates are tabulated from the claimed density, in a chart that
//! zooms in on the lobe, so that a spike which no grid resolves is as good as any. Neyman's smooth test sums the squares
//! of the first eight Legendre moments: few degrees of freedom, and therefore sharp for the errors that samplers make,
//! a lobe a little too wide or turned.
//!
//! # References
//! - Neyman 1937, "Smooth test" for goodness of fit

use std::f64::consts::PI;

use super::check::{Check, Outcome};
use super::claim::Claim;
use super::draws::{MOMENTS, PartTally, Tally};
use super::power::{chi_square_p, detectable_noncentrality, smallest};

/// The statistic of one transform: χ² with [`MOMENTS`] degrees of freedom if it is uniform.
fn statistic(moments: &[f64; MOMENTS], n: u64) -> f64 {
    moments.iter().map(|m| m * m).sum::<f64>() / n as f64
}

/// p-values of both transforms of the samples in one hemisphere; 1 where nothing was sampled.
pub(crate) fn p_values(part: &PartTally) -> [f64; 2] {
    if part.n == 0 {
        return [1.0; 2];
    }
    part.moments.map(|moments| chi_square_p(statistic(&moments, part.n), MOMENTS))
}

/// The check over several directions.
pub(crate) fn check(runs: &[(Claim, Tally)], level: f64) -> Check {
    let mut check = Check::new("uniformity");
    if let Some((claim, _)) = runs.iter().find(|(claim, _)| !claim.mass.resolved) {
        return check.inconclusive(claim.wo, "the pdf could not be integrated, so it has no known cdf");
    }
    if runs.iter().all(|(claim, _)| claim.is_discrete()) {
        return check.inconclusive_here("all lobes are Dirac lobes: there is no cdf to transform samples with");
    }
    let parts = runs.iter().flat_map(|run| run.1.parts.iter().map(move |part| (run, part, p_values(part))));
    let all: Vec<(&(Claim, Tally), &PartTally, [f64; 2])> = parts.filter(|(_, part, _)| part.n > 0).collect();
    let least = |p: &[f64; 2]| p[0].min(p[1]);
    let Some(((claim, tally), part, p)) = all.iter().min_by(|a, b| least(&a.2).total_cmp(&least(&b.2))) else {
        return check.inconclusive_here("nothing was sampled: every draw was lost or below the horizon");
    };
    let axis = usize::from(p[1] < p[0]);
    check.p_value = Some(smallest(all.iter().flat_map(|(.., p)| p.iter().copied())));
    check.statistic = statistic(&part.moments[axis], part.n);
    check.worst = Some((claim.wo, claim.wo));
    check.outcome = Outcome::Pass;
    let bar = level / (2 * all.len()) as f64;
    // A shift of the median by δ in probability is a first moment of δ √12 / 2 … at the least: stated as an rms error.
    let shape = (detectable_noncentrality(MOMENTS, bar) / tally.n as f64).sqrt();
    check.detects.insert("cdf_relative_rms", shape);
    // A scale factor of a lobe whose logarithm is logistic (GGX) has Fisher information 4/3 per squared unit of ln α,
    // of an exponential one (Beckmann) 4; the weaker is stated. (Information 1/3 and 1 about ln tan².)
    check.detects.insert("lobe_width", shape / (4.0_f64 / 3.0).sqrt());
    let what = ["distance from the lobe's centre", "azimuth"][axis];
    check.detail = format!(
        "{} samples from each of {} directions, smallest p = {:.3}, for the {what} seen from {:.1} degrees",
        tally.n,
        runs.len(),
        p[axis],
        claim.wo.z.clamp(-1.0, 1.0).acos() * 180.0 / PI
    );
    check
}
