//! View factors between all pairs of patches, as a dense matrix.
//!
//! F_ij is the share of what patch i sends out that arrives at patch j, without a unit. Row i is what i sends, so a row
//! sums to 1 in a closed scene, and to less where light escapes. Reciprocity is A_i F_ij = A_j F_ji. F_ii > 0 where a patch
//! sees itself: a sphere's inside, any concave patch.

use rayon::prelude::*;

use super::system::SystemError;
use crate::math::color::Rgb;
use crate::math::sum::Neumaier;

/// A factor below 0 by no more than this is taken for 0: the differences of a closed form leave a few roundings of terms
/// near 1.
pub const NEGATIVE_ROUNDING: f64 = 1e-12;

/// Rows that one thread multiplies at a time.
const ROWS: usize = 16;

/// Partial sums of a product, for the vector unit; they are added up in the order of their index.
const LANES: usize = 8;

/// A dense n × n matrix of view factors, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorMatrix {
    n: usize,
    values: Vec<f64>,
}

impl FactorMatrix {
    /// `values` row by row: n² of them, finite, and not below 0 by more than [`NEGATIVE_ROUNDING`]. Whether the rows sum to 1
    /// at most is for [`System::new`](super::system::System::new) to see.
    pub fn new(n: usize, mut values: Vec<f64>) -> Result<Self, SystemError> {
        if Some(values.len()) != n.checked_mul(n) {
            return Err(SystemError::Length {
                what: "view factors",
                expected: n.saturating_mul(n),
                found: values.len(),
            });
        }
        for (at, value) in values.iter_mut().enumerate() {
            if !(*value >= -NEGATIVE_ROUNDING && value.is_finite()) {
                return Err(SystemError::Factor { row: at / n, column: at % n, value: *value });
            }
            *value = value.max(0.0);
        }
        Ok(Self { n, values })
    }

    /// The number of patches.
    pub fn n(&self) -> usize {
        self.n
    }

    /// What patch `i` sends to every patch.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.n..(i + 1) * self.n]
    }

    /// F_ij.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.row(i)[j]
    }

    /// Σ_j F_ij of every row, to one rounding.
    pub fn row_sums(&self) -> Vec<f64> {
        (0..self.n).into_par_iter().map(|i| self.row(i).iter().copied().collect::<Neumaier>().value()).collect()
    }

    /// The memory of a dense matrix of `n` patches \[bytes\], 8 n².
    pub fn bytes(n: usize) -> u64 {
        (n as u64).saturating_mul(n as u64).saturating_mul(size_of::<f64>() as u64)
    }

    /// F b: of a radiosity b the irradiance H_i = Σ_j F_ij b_j, in the unit of b.
    ///
    /// The same bits for any number of threads; the error is below n ε Σ_j F_ij |b_j|.
    pub fn product(&self, b: &[Rgb]) -> Vec<Rgb> {
        let b = Planes::new(b);
        let mut product = vec![Rgb::BLACK; self.n];
        product.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, out)| {
            for (k, out) in out.iter_mut().enumerate() {
                *out = b.dot(self.row(chunk * ROWS + k), 0);
            }
        });
        product
    }
}

/// The channels of a vector of colours one after the other, as a vector unit likes them.
#[derive(Clone, Debug)]
pub(super) struct Planes([Vec<f64>; 3]);

impl Planes {
    pub(super) fn new(values: &[Rgb]) -> Self {
        Self([0, 1, 2].map(|c| values.iter().map(|v| v.0[c]).collect()))
    }

    pub(super) fn set(&mut self, i: usize, value: Rgb) {
        for (plane, channel) in self.0.iter_mut().zip(value.to_array()) {
            plane[i] = channel;
        }
    }

    /// Σ_k row_k b_(from + k), of each channel.
    pub(super) fn dot(&self, row: &[f64], from: usize) -> Rgb {
        let [x, y, z] = self.0.each_ref().map(|plane| plane[from..from + row.len()].as_chunks::<LANES>());
        let (blocks, rest) = row.as_chunks::<LANES>();
        let mut sums = [[0.0; LANES]; 3];
        for (((f, x), y), z) in blocks.iter().zip(x.0).zip(y.0).zip(z.0) {
            for l in 0..LANES {
                sums[0][l] += f[l] * x[l];
                sums[1][l] += f[l] * y[l];
                sums[2][l] += f[l] * z[l];
            }
        }
        let last = [x.1, y.1, z.1];
        let total = |c: usize| {
            let sum = sums[c].iter().fold(0.0, |sum, lane| sum + lane);
            rest.iter().zip(last[c]).fold(sum, |sum, (f, b)| sum + f * b)
        };
        Rgb::new(total(0), total(1), total(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_what_a_patch_sends() {
        let matrix = FactorMatrix::new(2, vec![0.25, 0.5, 1.0, -1e-14]).unwrap();
        assert_eq!((matrix.row(1), matrix.at(0, 1), matrix.n()), (&[1.0, 0.0][..], 0.5, 2));
        assert_eq!(matrix.row_sums(), [0.75, 1.0]);
        assert_eq!(FactorMatrix::bytes(4000), 128_000_000);
    }

    #[test]
    fn what_is_no_share_is_refused() {
        for (value, allowed) in [(f64::NAN, false), (-1e-6, false), (f64::INFINITY, false), (-1e-13, true)] {
            let found = FactorMatrix::new(2, vec![0.5, 0.5, value, 0.5]);
            assert_eq!(found.is_ok(), allowed, "{value}");
            if let Err(error) = found {
                assert!(matches!(error, SystemError::Factor { row: 1, column: 0, .. }), "{error}");
            }
        }
        assert!(matches!(FactorMatrix::new(2, vec![0.0; 3]), Err(SystemError::Length { expected: 4, found: 3, .. })));
    }

    #[test]
    fn the_product_is_that_of_the_definition_for_any_number_of_threads() {
        for n in [1, 7, 8, 67, 200] {
            let value = |k: usize| ((k * 7919 + 13) % 1009) as f64 / 1009.0;
            let matrix = FactorMatrix::new(n, (0..n * n).map(value).collect()).unwrap();
            let b: Vec<Rgb> = (0..n).map(|j| Rgb::new(value(j), value(j + 500), -value(3 * j))).collect();
            let found = matrix.product(&b);
            for (i, found) in found.iter().enumerate() {
                let exact: Rgb = (0..n).map(|j| matrix.at(i, j) * b[j]).sum();
                // n roundings of terms below 1 on either side.
                assert!((*found - exact).map(f64::abs).max_channel() <= 2e-16 * (n * n) as f64);
            }
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                assert_eq!(pool.install(|| matrix.product(&b)), found);
            }
        }
    }
}
