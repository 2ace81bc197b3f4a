//! Filling a matrix of view factors in parallel: by rows, or by pairs where an exchange is the same both ways.

use rayon::prelude::*;

use super::{Found, counted};
use crate::render::radiosity::patches::Patches;

/// Each row by itself: `row(i, values)` fills F_ij for all j and gives the root mean square error of them.
pub(super) fn by_rows(patches: &Patches, row: impl Fn(usize, &mut [f64]) -> f64 + Sync) -> Found {
    let n = patches.all().len();
    let mut values = vec![0.0; n * n];
    let rows = values.par_chunks_mut(n).enumerate();
    let (row_errors, rays): (Vec<f64>, Vec<u64>) = rows.map(|(i, values)| counted(|| row(i, values))).unzip();
    Found { values, row_errors, rays: rays.into_iter().sum() }
}

/// Rows and columns of a tile that is turned over at a time: both fit into a core's own memory.
const TILE: usize = 64;

/// Each pair once: `pair(i, j)` for i ≤ j gives A_i F_ij = A_j F_ji and its error, in the unit of area.
pub(super) fn by_pairs(patches: &Patches, pair: impl Fn(usize, usize) -> (f64, f64) + Sync) -> Found {
    let all = patches.all();
    let n = all.len();
    let mut values = vec![0.0; n * n];
    let rows = values.par_chunks_mut(n).enumerate();
    // Of row i the squares of errors of its pairs, which also belong to the rows of their partners.
    let parts: Vec<(Vec<f64>, u64)> = rows
        .map(|(i, row)| {
            counted(|| {
                let mut squares = Vec::new();
                for j in i..n {
                    let (exchange, error) = pair(i, j);
                    row[j] = exchange;
                    if error > 0.0 {
                        squares.resize(n - i, 0.0);
                        squares[j - i] = error * error;
                    }
                }
                squares
            })
        })
        .collect();
    let mut squares = vec![0.0; n];
    for (i, (of_row, _)) in parts.iter().enumerate() {
        for (at, square) in of_row.iter().enumerate() {
            squares[i] += square / (all[i].area * all[i].area);
            if at > 0 {
                squares[i + at] += square / (all[i + at].area * all[i + at].area);
            }
        }
    }
    mirror(&mut values, n);
    values.par_chunks_mut(n).enumerate().for_each(|(i, row)| row.iter_mut().for_each(|x| *x /= all[i].area));
    let row_errors = squares.iter().map(|sum| (sum / n as f64).sqrt()).collect();
    Found { values, row_errors, rays: parts.iter().map(|(_, rays)| rays).sum() }
}

/// Copies what is above the diagonal to below it.
fn mirror(values: &mut [f64], n: usize) {
    for top in (0..n).step_by(TILE) {
        for left in (0..=top).step_by(TILE) {
            for i in top..(top + TILE).min(n) {
                for j in left..(left + TILE).min(i) {
                    values[i * n + j] = values[j * n + i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_matrix_is_symmetric() {
        for n in [1, 5, 64, 130] {
            let above = |i: usize, j: usize| (i * 1000 + j) as f64;
            let mut values: Vec<f64> =
                (0..n * n).map(|at| if at % n >= at / n { above(at / n, at % n) } else { -1.0 }).collect();
            mirror(&mut values, n);
            assert!((0..n * n).all(|at| values[at] == above((at / n).min(at % n), (at / n).max(at % n))), "{n}");
        }
    }
}
