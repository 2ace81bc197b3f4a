//! What is known about a matrix of view factors without knowing the right one.

use serde::Serialize;

use super::{Found, ViewFactors};
use crate::math::sum::Neumaier;
use crate::render::radiosity::patches::Patches;

/// The smallest, mean and largest of some numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The smallest.
    pub min: f64,
    /// The mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    fn of(values: &[f64]) -> Self {
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self { min, mean: values.iter().copied().collect::<Neumaier>().value() / values.len() as f64, max }
    }
}

/// A report on view factors.
///
/// Closure and reciprocity are necessary, not sufficient: the factors at the centres of a cube's faces are symmetric and
/// their rows sum to 1, though they are wrong by a fifth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the method.
    pub method: &'static str,
    /// Number of patches.
    pub patches: usize,
    /// Whether what lies between patches was seen.
    pub occlusion: bool,
    /// Factors that are not 0.
    pub nonzero: u64,
    /// Σ_j F_ij over the rows.
    pub row_sums: Spread,
    /// The share of all that would be sent out by patches of the same radiosity that reaches no patch: the mean of
    /// 1 − Σ_j F_ij by area. It leaves the scene or falls on black backs.
    pub escape: f64,
    /// Root of Σ (A_i F_ij − A_j F_ji)² / Σ (A_i F_ij)².
    pub reciprocity_rms: f64,
    /// The largest |A_i F_ij − A_j F_ji| over the larger of A_i and A_j.
    pub reciprocity_max: f64,
    /// Root mean square error of a factor, as the method judges it.
    pub error_rms: f64,
    /// The largest root mean square error of a row.
    pub error_max: f64,
    /// Rays cast.
    pub rays: u64,
    /// Seconds.
    pub seconds: f64,
}

impl Report {
    pub(super) fn new(method: &dyn ViewFactors, patches: &Patches, found: &Found, seconds: f64) -> Self {
        let all = patches.all();
        let n = all.len();
        let row = |i: usize| &found.values[i * n..(i + 1) * n];
        let sums: Vec<f64> = (0..n).map(|i| row(i).iter().copied().collect::<Neumaier>().value()).collect();
        let area: Neumaier = all.iter().map(|patch| patch.area).collect();
        let kept: Neumaier = all.iter().zip(&sums).map(|(patch, sum)| patch.area * sum).collect();
        let (mut defect, mut total, mut worst) = (0.0, 0.0, 0.0_f64);
        for i in 0..n {
            for (j, &factor) in row(i).iter().enumerate() {
                let here = all[i].area * factor;
                total += here * here;
                if j > i {
                    let gap = (here - all[j].area * row(j)[i]).abs();
                    defect += 2.0 * gap * gap;
                    worst = worst.max(gap / all[i].area.max(all[j].area));
                }
            }
        }
        let square = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>() / n as f64;
        Self {
            method: method.name(),
            patches: n,
            occlusion: method.sees_what_is_between(),
            nonzero: found.values.iter().filter(|value| **value > 0.0).count() as u64,
            row_sums: Spread::of(&sums),
            escape: 1.0 - kept.value() / area.value(),
            reciprocity_rms: if total > 0.0 { (defect / total).sqrt() } else { 0.0 },
            reciprocity_max: worst,
            error_rms: square(&found.row_errors).sqrt(),
            error_max: found.row_errors.iter().copied().fold(0.0, f64::max),
            rays: found.rays,
            seconds,
        }
    }
}
