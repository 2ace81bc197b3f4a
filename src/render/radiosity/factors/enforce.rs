//! Repairs of view factors, on demand: each says by how much it has changed them.

use rayon::prelude::*;
use serde::Serialize;

use super::cast::escape;
use crate::math::sum::Neumaier;
use crate::render::radiosity::patches::Patches;
use crate::scene::Scene;

/// A law that sampled factors break.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enforce {
    /// A_i F_ij = A_j F_ji: both become the mean of the two.
    Reciprocity,
    /// Rows sum to the share that rays find to reach any patch, 1 in a closed scene, and reciprocity holds: exchanges are
    /// scaled by d_i d_j, with the d that achieve it.
    Closure,
}

/// What a repair has changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Repair {
    /// Root of Σ (change)² / Σ F².
    pub rms: f64,
    /// The largest change of a factor.
    pub max: f64,
    /// The largest distance of a row's sum from what it should be that is left; 0 where none was asked for.
    pub left: f64,
}

/// Rays per patch that say what share of its light reaches any patch.
const RAYS: u64 = 4096;
/// The distance of a row's sum from its target at which scaling ends.
const CLOSED: f64 = 1e-12;
/// Rounds of scaling, each of which brings the sums closer by a factor.
const ROUNDS: u32 = 200;

impl Enforce {
    /// Repairs F_ij, row by row.
    pub fn apply(self, scene: &Scene, patches: &Patches, values: &mut [f64]) -> Repair {
        let areas: Vec<f64> = patches.all().iter().map(|patch| patch.area).collect();
        let before = values.to_vec();
        symmetrise(values, &areas);
        let left = match self {
            Self::Reciprocity => 0.0,
            Self::Closure => {
                let escape = escape(scene, patches, RAYS, 1);
                close(values, &escape.iter().map(|share| 1.0 - share).collect::<Vec<_>>())
            }
        };
        let (mut change, mut total, mut max) = (Neumaier::default(), Neumaier::default(), 0.0_f64);
        for (after, before) in values.iter().zip(&before) {
            change.add((after - before).powi(2));
            total.add(before * before);
            max = max.max((after - before).abs());
        }
        let rms = if total.value() > 0.0 { (change.value() / total.value()).sqrt() } else { 0.0 };
        Repair { rms, max, left }
    }
}

fn symmetrise(values: &mut [f64], areas: &[f64]) {
    let n = areas.len();
    for i in 0..n {
        for j in 0..i {
            let exchange = 0.5 * (areas[i] * values[i * n + j] + areas[j] * values[j * n + i]);
            (values[i * n + j], values[j * n + i]) = (exchange / areas[i], exchange / areas[j]);
        }
    }
}

/// Scales F_ij by d_i d_j so that row i sums to `targets[i]`; what is left to do in the end.
fn close(values: &mut [f64], targets: &[f64]) -> f64 {
    let n = targets.len();
    let mut left = f64::INFINITY;
    for _ in 0..ROUNDS {
        let sums: Vec<f64> =
            values.par_chunks(n).map(|row| row.iter().copied().collect::<Neumaier>().value()).collect();
        left = sums.iter().zip(targets).map(|(sum, target)| (sum - target).abs()).fold(0.0, f64::max);
        if left <= CLOSED {
            break;
        }
        // The root: the same factor comes again with the column.
        let scale: Vec<f64> = sums
            .iter()
            .zip(targets)
            .map(|(sum, target)| if *sum > 0.0 { (target / sum).sqrt() } else { 1.0 })
            .collect();
        values.par_chunks_mut(n).zip(&scale).for_each(|(row, here)| {
            for (value, there) in row.iter_mut().zip(&scale) {
                *value *= here * there;
            }
        });
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_closes_and_keeps_reciprocity() {
        // A closed scene of four patches with noise of a few per cent.
        let areas = [1.0, 2.0, 0.5, 1.5];
        let mut values = Vec::new();
        for i in 0..4 {
            for (j, area) in areas.iter().enumerate() {
                values.push(if i == j { 0.0 } else { area / 5.0 * (1.0 + 0.03 * ((i * 4 + j) as f64).sin()) });
            }
        }
        symmetrise(&mut values, &areas);
        let left = close(&mut values, &[1.0, 0.9, 1.0, 1.0]);
        assert!(left <= CLOSED, "{left}");
        for (i, here) in areas.iter().enumerate() {
            let sum: f64 = values[4 * i..4 * i + 4].iter().sum();
            assert!((sum - [1.0, 0.9, 1.0, 1.0][i]).abs() < 1e-11, "row {i}: {sum}");
            for (j, there) in areas.iter().enumerate() {
                let gap = here * values[4 * i + j] - there * values[4 * j + i];
                assert!(gap.abs() < 1e-14, "{i} {j}: {gap}");
            }
        }
    }
}
