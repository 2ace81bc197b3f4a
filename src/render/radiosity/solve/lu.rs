//! LU factors of a diagonally dominant matrix, in place.
//!
//! A strictly dominant matrix needs no pivots: every remainder of the elimination is dominant again, no pivot is smaller than
//! what its row or column holds besides it, and no entry grows beyond twice the largest of the matrix. So the matrix may be split
//! in halves,
//!
//! A_00 = L_00 U_00,   U_01 = L_00⁻¹ A_01,   L_10 = A_10 U_00⁻¹,   A_11 − L_10 U_01 = L_11 U_11
//!
//! which leaves nearly all of the 2/3 n³ operations to products of large blocks. Blocks are cut by their size alone and multiplied
//! one per thread: the same bits for any number of threads.
//! # References
//! - Toledo 1997, Locality of reference in LU decomposition with partial pivoting, SIAM J. Matrix Anal. Appl. 18(4) (by halves)
//! - Higham 2002, Accuracy and stability of numerical algorithms, theorem 9.9 (dominance by rows or columns: growth of 2)

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place, solve_unit_upper_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par};

/// A matrix of this size is eliminated column by column.
const LEAF: usize = 64;

/// Blocks larger than this, either way, are cut for other threads to take a part.
const BLOCK: usize = 512;

/// L (unit diagonal, not stored) and U of the n × n matrix K, in its memory.
#[derive(Debug)]
pub(super) struct Factors {
    n: usize,
    values: Vec<f64>,
}

impl Factors {
    /// Of K, given row by row: strictly diagonally dominant, or the result is worthless.
    pub(super) fn new(n: usize, mut values: Vec<f64>) -> Self {
        // Rows of K are taken for columns: Kᵀ = L U, and nothing need be transposed.
        factor(MatMut::from_column_major_slice_mut(&mut values, n, n));
        Self { n, values }
    }

    /// Solves K x = y for several right sides, given column by column, in place.
    pub(super) fn solve(&self, sides: &mut [f64]) {
        let k = MatRef::from_column_major_slice(&self.values, self.n, self.n).transpose();
        let count = sides.len() / self.n;
        let mut sides = MatMut::from_column_major_slice_mut(sides, self.n, count);
        solve_lower_triangular_in_place(k, sides.as_mut(), Par::Seq);
        solve_unit_upper_triangular_in_place(k, sides, Par::Seq);
    }
}

/// Where to cut: half, in steps that suit vector units and caches.
fn half(n: usize) -> usize {
    (n / 2).next_multiple_of(if n > 4 * LEAF { LEAF } else { 8 })
}

fn factor(a: MatMut<'_, f64>) {
    let n = a.nrows();
    if n <= LEAF {
        return eliminate(a);
    }
    let h = half(n);
    let (mut corner, mut right, mut below, mut rest) = a.split_at_mut(h, h);
    factor(corner.as_mut());
    let done = corner.as_ref();
    rayon::join(|| solve_lower(done, right.as_mut()), || solve_upper(done, below.as_mut()));
    subtract_product(rest.as_mut(), below.as_ref(), right.as_ref());
    factor(rest);
}

fn eliminate(mut a: MatMut<'_, f64>) {
    let n = a.nrows();
    for k in 0..n {
        let inverse = 1.0 / a[(k, k)];
        for i in k + 1..n {
            a[(i, k)] *= inverse;
        }
        for j in k + 1..n {
            let factor = a[(k, j)];
            for i in k + 1..n {
                let l = a[(i, k)];
                a[(i, j)] -= l * factor;
            }
        }
    }
}

/// x ← L⁻¹ x.
fn solve_lower(l: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    let n = x.ncols();
    if n <= BLOCK {
        return solve_unit_lower_triangular_in_place(l, x, Par::Seq);
    }
    let (a, b) = x.split_at_col_mut(half(n));
    rayon::join(|| solve_lower(l, a), || solve_lower(l, b));
}

/// x ← x U⁻¹.
fn solve_upper(u: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    let n = x.nrows();
    if n <= BLOCK {
        return solve_lower_triangular_in_place(u.transpose(), x.transpose_mut(), Par::Seq);
    }
    let (a, b) = x.split_at_row_mut(half(n));
    rayon::join(|| solve_upper(u, a), || solve_upper(u, b));
}

/// c ← c − a b.
fn subtract_product(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    let (rows, columns) = (c.nrows(), c.ncols());
    if rows.max(columns) <= BLOCK {
        matmul(c, Accum::Add, a, b, -1.0, Par::Seq);
    } else if columns >= rows {
        let h = half(columns);
        let (c, d) = c.split_at_col_mut(h);
        let (b, e) = b.split_at_col(h);
        rayon::join(|| subtract_product(c, a, b), || subtract_product(d, a, e));
    } else {
        let h = half(rows);
        let (c, d) = c.split_at_row_mut(h);
        let (a, e) = a.split_at_row(h);
        rayon::join(|| subtract_product(c, a, b), || subtract_product(d, e, b));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(k: usize) -> f64 {
        ((k * 7919 + 13) % 100_003) as f64 / 100_003.0
    }

    /// Rows of I − F, of which F sums to 0.95 at most.
    fn dominant(n: usize) -> Vec<f64> {
        let entry = |k: usize| f64::from(u8::from(k / n == k % n)) - 0.95 * value(k) / n as f64;
        (0..n * n).map(entry).collect()
    }

    fn worst(n: usize, k: &[f64], x: &[f64], y: &[f64]) -> f64 {
        let row = |i: usize| (0..n).map(|j| k[i * n + j] * x[j]).sum::<f64>() - y[i];
        (0..n).map(|i| row(i).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn factors_solve_what_they_are_of() {
        for n in [1, 2, 63, 64, 65, 200, 257, 700] {
            let k = dominant(n);
            let y: Vec<f64> = (0..2 * n).map(|i| value(5 * i) - 0.3).collect();
            let mut x = y.clone();
            Factors::new(n, k.clone()).solve(&mut x);
            for (x, y) in x.chunks(n).zip(y.chunks(n)) {
                // Sums of n terms on either side, and 1 / (1 − 0.95) at most in x; mostly far less.
                assert!(worst(n, &k, x, y) <= 1e-14, "n = {n}");
            }
            let transposed: Vec<f64> = (0..n * n).map(|at| k[at % n * n + at / n]).collect();
            let mut x = y.clone();
            Factors::new(n, transposed).solve(&mut x);
            assert!(n == 1 || worst(n, &k, &x[..n], &y[..n]) > 1e-6, "the transposed matrix is not seen, n = {n}");
        }
    }

    #[test]
    fn bits_do_not_depend_on_the_number_of_threads() {
        let n = 1200;
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Factors::new(n, dominant(n)).values)
        };
        let one = with(1);
        assert!(one == with(2) && one == with(3));
    }
}
