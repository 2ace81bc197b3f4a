//! `chi2`: do the samples fall where the pdf says they do?
//!
//! About 1024 cells of nearly equal *claimed* mass, and 128 groups of them, in coordinates that follow the lobe. Lost
//! draws are a cell of their own; draws where nothing can be claimed (below the horizon) are another, in which none is
//! expected. Three tests of one direction: the coarse and the fine chi-square, and the single worst cell, which is the
//! one to find a small hole or a small leak.

use super::check::{Check, Outcome};
use super::claim::Claim;
use super::draws::Tally;
use super::power::{POWER, chi_square_p, detectable_noncentrality, normal_upper, poisson_p, smallest};

/// Least expected count of a cell in a chi-square, for its distribution to be one (Cochran's rule of thumb).
const LEAST_EXPECTED: f64 = 5.0;

/// The p-values of one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence {
    pub(crate) coarse: f64,
    pub(crate) fine: f64,
    pub(crate) worst_cell: f64,
    pub(crate) statistic: f64,
    pub(crate) dof: usize,
}

impl Evidence {
    pub(crate) fn new(claim: &Claim, tally: &Tally) -> Self {
        let n = tally.n as f64;
        let fine = cells(&claim.fine, &tally.fine, n);
        let coarse_count = claim.coarse_of.iter().max().map_or(0, |last| *last as usize + 1);
        let (mut masses, mut counts) = (vec![0.0; coarse_count], vec![0; coarse_count]);
        for ((mass, count), coarse) in claim.fine.iter().zip(&tally.fine).zip(&claim.coarse_of) {
            masses[*coarse as usize] += mass;
            counts[*coarse as usize] += count;
        }
        // Lost draws: what the claimed mass leaves over. Its uncertainty is that of the cubature.
        let lost = (n * (1.0 - claim.mass.value), tally.lost);
        let certain = n * claim.mass.error.max(1e-9);
        let mut coarse = cells(&masses, &counts, n);
        let mut with_lost = fine.clone();
        if lost.0 >= LEAST_EXPECTED {
            coarse.push(lost);
            with_lost.push(lost);
        }
        let (statistic, dof) = chi_square(&coarse);
        let (fine_statistic, fine_dof) = chi_square(&with_lost);
        let lost_p = lost_p(lost.1, lost.0, certain);
        let stray_p = if tally.stray == 0 { 1.0 } else { poisson_p(tally.stray, certain) };
        let per_cell = fine.iter().map(|&(expected, count)| poisson_p(count, expected));
        Self {
            coarse: chi_square_p(statistic, dof),
            fine: chi_square_p(fine_statistic, fine_dof),
            worst_cell: smallest(per_cell.chain([lost_p, stray_p])),
            statistic,
            dof,
        }
    }

    pub(crate) fn p_values(&self) -> [f64; 3] {
        [self.coarse, self.fine, self.worst_cell]
    }
}

/// p-value of the number of lost draws, given how many are expected and how uncertain that is.
pub(crate) fn lost_p(count: u64, expected: f64, uncertainty: f64) -> f64 {
    let (low, high) = ((expected - uncertainty).max(0.0), (expected + uncertainty).max(0.0));
    let nearest = (count as f64).clamp(low, high);
    if (low..=high).contains(&(count as f64)) { 1.0 } else { poisson_p(count, nearest) }
}

/// Expected and observed counts; cells that expect too little are pooled, and the last pool joins its neighbour.
fn cells(masses: &[f64], counts: &[u64], n: f64) -> Vec<(f64, u64)> {
    let mut cells: Vec<(f64, u64)> = Vec::with_capacity(masses.len());
    let (mut expected, mut count) = (0.0, 0);
    for (mass, observed) in masses.iter().zip(counts) {
        expected += n * mass;
        count += observed;
        if expected >= LEAST_EXPECTED {
            cells.push((expected, count));
            (expected, count) = (0.0, 0);
        }
    }
    match cells.last_mut() {
        Some(last) => {
            last.0 += expected;
            last.1 += count;
        }
        None => cells.push((expected, count)),
    }
    cells
}

/// Pearson's statistic and its degrees of freedom: one less than there are cells.
fn chi_square(cells: &[(f64, u64)]) -> (f64, usize) {
    let term = |&(expected, count): &(f64, u64)| (count as f64 - expected).powi(2) / expected;
    (cells.iter().map(term).sum(), cells.len().saturating_sub(1))
}

/// The check over several directions. `level` is the share of the sheet's level that a single p-value is sure to get.
pub(crate) fn check(runs: &[(Claim, Tally)], level: f64) -> Check {
    let mut check = Check::new("chi2");
    if let Some((claim, _)) = runs.iter().find(|(claim, _)| !claim.mass.resolved) {
        return check.inconclusive(claim.wo, "the pdf could not be integrated, so its cells have no known mass");
    }
    if runs.iter().all(|(_, tally)| tally.kept() == 0) {
        return check.inconclusive_here("nothing was sampled: every draw was lost or below the horizon");
    }
    let evidence: Vec<Evidence> = runs.iter().map(|(claim, tally)| Evidence::new(claim, tally)).collect();
    let p_values = || evidence.iter().flat_map(Evidence::p_values);
    check.p_value = Some(smallest(p_values()));
    let least = |e: &Evidence| e.p_values().into_iter().fold(1.0, f64::min);
    let Some((worst, (claim, tally))) = evidence.iter().zip(runs).min_by(|a, b| least(a.0).total_cmp(&least(b.0)))
    else {
        return check;
    };
    check.statistic = worst.statistic;
    check.worst = Some((claim.wo, tally.stray_at.unwrap_or(claim.wo)));

    let n = tally.n as f64;
    let bar = level / evidence.len() as f64 / 3.0;
    let shape = (detectable_noncentrality(worst.dof.max(1), bar) / n).sqrt();
    let cell = 1.0 / claim.fine.len() as f64;
    let noise = (cell / n).sqrt();
    let critical = normal_upper(bar / claim.fine.len() as f64 / 2.0);
    // A compact hole may lie across the corner of four cells, a quarter in each: it goes unseen only if all four do.
    let quarter = critical + normal_upper((1.0 - POWER).powf(0.25));
    check.detects.insert("pdf_relative_rms", shape);
    check.detects.insert("missing_mass", 4.0 * quarter * noise);
    // Where the pdf claims almost nothing, a single cell spans all of it.
    check.detects.insert("leak", (critical + normal_upper(1.0 - POWER)) * noise);
    check.outcome = Outcome::Pass;
    check.detail = if tally.stray > 0 {
        format!("{} of {} samples fell below the horizon or had no unit length or density", tally.stray, tally.n)
    } else {
        format!(
            "{} samples from each of {} directions; the worst has chi-square {:.1} on {} degrees of freedom, p = {:.3} \
             (coarse), {:.3} (fine), {:.3} (worst cell)",
            tally.n,
            evidence.len(),
            worst.statistic,
            worst.dof,
            worst.coarse,
            worst.fine,
            worst.worst_cell
        )
    };
    check
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_pool_is_flushed() {
        // The harness that drops its last pool accepts a leak there: ten cells that expect 1 each, all counts in the last.
        let pooled = cells(&[0.01; 10], &[0, 0, 0, 0, 0, 0, 0, 0, 0, 100], 100.0);
        assert_eq!(pooled.iter().map(|c| c.1).sum::<u64>(), 100);
        assert!((pooled.iter().map(|c| c.0).sum::<f64>() - 10.0).abs() < 1e-12);
    }

    #[test]
    fn degrees_of_freedom_do_not_wrap() {
        assert_eq!(chi_square(&[]).1, 0);
        assert_eq!(chi_square(&[(5.0, 5)]).1, 0);
    }

    #[test]
    fn lost_draws_are_compared_with_what_the_mass_leaves_over() {
        assert!(lost_p(100, 100.0, 1.0) >= 1.0 && lost_p(300, 100.0, 1.0) < 1e-10);
        assert!(lost_p(5, -3.0, 0.1) < 1e-5, "more mass than 1 is claimed, and draws are lost all the same");
    }
}
