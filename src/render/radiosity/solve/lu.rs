//! LU factors of a diagonally dominant matrix, in place.
//!
//! A strictly dominant matrix needs no pivots: every remainder of the elimination is dominant again, no pivot is smaller than
//! what its row or column holds besides it, and no entry grows beyond twice the largest of the matrix. So the matrix may be split
//! in halves,
//!
//! A_00 = L_00 U_00,   U_01 = L_00⁻¹ A_01,   L_10 = A_10 U_00⁻¹,   A_11 − L_10 U_01 = L_11 U_11
//!
//! and so may triangles that are solved by, which leaves nearly all of the 2/3 n³ operations to products of large blocks. Blocks
//! are cut by their size alone and multiplied one per thread: the same bits for any number of threads.
//! # References
//! - Toledo 1997, Locality of reference in LU decomposition with partial pivoting, SIAM J. Matrix Anal. Appl. 18(4) (by halves)
//! - Higham 2002, Accuracy and stability of numerical algorithms, theorem 9.9 (dominance by rows or columns: growth of 2)

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};

/// A matrix of this size is eliminated row by row.
const LEAF: usize = 64;

/// A triangle of this size is solved by row by row.
const TRIANGLE: usize = 32;

/// Blocks larger than this, either way, are cut for other threads to take a part.
const BLOCK: usize = 512;

/// L (unit diagonal, not stored) and U of the n × n matrix K, in its memory.
#[derive(Debug)]
pub(super) struct Factors {
    n: usize,
    values: Vec<f64>,
}

impl Factors {
    /// Of K, given row by row, n² values: strictly diagonally dominant, or the result is worthless.
    pub(super) fn new(n: usize, mut values: Vec<f64>) -> Self {
        if let Ok(matrix) = ArrayViewMut2::from_shape((n, n), &mut values) {
            factor(matrix);
        }
        Self { n, values }
    }

    /// Solves K x = y for several right sides, given one after the other, in place.
    pub(super) fn solve(&self, sides: &mut [f64]) {
        for x in sides.chunks_mut(self.n) {
            let row = |i: usize| &self.values[i * self.n..(i + 1) * self.n];
            let dot = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
            for i in 0..self.n {
                x[i] -= dot(&row(i)[..i], &x[..i]);
            }
            for i in (0..self.n).rev() {
                x[i] = (x[i] - dot(&row(i)[i + 1..], &x[i + 1..])) / row(i)[i];
            }
        }
    }
}

/// Where to cut: half, in steps that suit vector units and caches.
fn half(n: usize) -> usize {
    (n / 2).next_multiple_of(if n > 4 * LEAF { LEAF } else { 8 })
}

fn factor(a: ArrayViewMut2<'_, f64>) {
    let n = a.nrows();
    if n <= LEAF {
        return eliminate(a);
    }
    let (top, bottom) = a.split_at(Axis(0), half(n));
    let (mut corner, mut right) = top.split_at(Axis(1), half(n));
    let (mut below, mut rest) = bottom.split_at(Axis(1), half(n));
    factor(corner.view_mut());
    let done = corner.view();
    rayon::join(|| solve_lower(&done, right.view_mut()), || solve_upper(&done, below.view_mut()));
    subtract_product(rest.view_mut(), &below.view(), &right.view());
    factor(rest);
}

fn eliminate(mut a: ArrayViewMut2<'_, f64>) {
    for k in 0..a.nrows() {
        let (done, mut rest) = a.view_mut().split_at(Axis(0), k + 1);
        for mut row in rest.rows_mut() {
            let l = row[k] / done[(k, k)];
            row[k] = l;
            row.slice_mut(s![k + 1..]).zip_mut_with(&done.slice(s![k, k + 1..]), |x, u| *x -= l * u);
        }
    }
}

/// x ← L⁻¹ x.
fn solve_lower(l: &ArrayView2<'_, f64>, mut x: ArrayViewMut2<'_, f64>) {
    let n = l.nrows();
    if x.ncols() > BLOCK {
        let at = half(x.ncols());
        let (a, b) = x.split_at(Axis(1), at);
        rayon::join(|| solve_lower(l, a), || solve_lower(l, b));
    } else if n > TRIANGLE {
        let (mut a, mut b) = x.split_at(Axis(0), half(n));
        solve_lower(&l.slice(s![..half(n), ..half(n)]), a.view_mut());
        general_mat_mul(-1.0, &l.slice(s![half(n).., ..half(n)]), &a, 1.0, &mut b);
        solve_lower(&l.slice(s![half(n).., half(n)..]), b);
    } else {
        for k in 0..n {
            let (done, mut rest) = x.view_mut().split_at(Axis(0), k + 1);
            for (i, mut row) in rest.rows_mut().into_iter().enumerate() {
                let l = l[(k + 1 + i, k)];
                row.zip_mut_with(&done.row(k), |x, d| *x -= l * d);
            }
        }
    }
}

/// x ← x U⁻¹.
fn solve_upper(u: &ArrayView2<'_, f64>, mut x: ArrayViewMut2<'_, f64>) {
    let n = u.nrows();
    if x.nrows() > BLOCK {
        let at = half(x.nrows());
        let (a, b) = x.split_at(Axis(0), at);
        rayon::join(|| solve_upper(u, a), || solve_upper(u, b));
    } else if n > TRIANGLE {
        let (mut a, mut b) = x.split_at(Axis(1), half(n));
        solve_upper(&u.slice(s![..half(n), ..half(n)]), a.view_mut());
        general_mat_mul(-1.0, &a, &u.slice(s![..half(n), half(n)..]), 1.0, &mut b);
        solve_upper(&u.slice(s![half(n).., half(n)..]), b);
    } else {
        for mut row in x.rows_mut() {
            for k in 0..n {
                let done = row[k] / u[(k, k)];
                row[k] = done;
                row.slice_mut(s![k + 1..]).zip_mut_with(&u.slice(s![k, k + 1..]), |x, u| *x -= done * u);
            }
        }
    }
}

/// c ← c − a b.
fn subtract_product(mut c: ArrayViewMut2<'_, f64>, a: &ArrayView2<'_, f64>, b: &ArrayView2<'_, f64>) {
    let (rows, columns) = c.dim();
    if rows.max(columns) <= BLOCK {
        general_mat_mul(-1.0, a, b, 1.0, &mut c);
    } else if columns >= rows {
        let (c, d) = c.split_at(Axis(1), half(columns));
        let (b, e) = b.split_at(Axis(1), half(columns));
        rayon::join(|| subtract_product(c, a, &b), || subtract_product(d, a, &e));
    } else {
        let (c, d) = c.split_at(Axis(0), half(rows));
        let (a, e) = a.split_at(Axis(0), half(rows));
        rayon::join(|| subtract_product(c, &a, b), || subtract_product(d, &e, b));
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
