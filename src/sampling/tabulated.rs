//! A distribution on an interval given by a table: piecewise linear, and inverted exactly.

use std::fmt;

/// The density on [0, `end`] that is linear between equally spaced nodes.
#[derive(Clone, PartialEq)]
pub struct PiecewiseLinear {
    step: f64,
    /// The density at the nodes, normalised.
    density: Vec<f64>,
    /// The mass below each node; 0 at the first, 1 at the last.
    below: Vec<f64>,
}

impl fmt::Debug for PiecewiseLinear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PiecewiseLinear").field("nodes", &self.density.len()).finish_non_exhaustive()
    }
}

impl PiecewiseLinear {
    /// The density in proportion to `values` at nodes from 0 to `end`, both included.
    ///
    /// None unless `end` > 0, there are at least two values, none is negative, and their sum is positive and finite.
    pub fn new(values: &[f64], end: f64) -> Option<Self> {
        let cells = values.len().checked_sub(1).filter(|&cells| cells > 0)?;
        let step = end / cells as f64;
        let mass = |pair: &[f64]| 0.5 * (pair[0] + pair[1]) * step;
        let total: f64 = values.windows(2).map(mass).sum();
        let usable = values.iter().all(|&v| v >= 0.0) && total > 0.0 && total.is_finite() && step > 0.0;
        usable.then(|| {
            let density: Vec<f64> = values.iter().map(|v| v / total).collect();
            let mut below = vec![0.0];
            let mut sum = 0.0;
            for pair in density.windows(2) {
                sum += mass(pair);
                below.push(sum);
            }
            // The last node holds all the mass, whatever the rounding of the sum.
            below[cells] = 1.0;
            Self { step, density, below }
        })
    }

    /// The x below which the share `u` in [0, 1) of the mass lies. Inverse: [`Self::sample_inv`].
    pub fn sample(&self, u: f64) -> f64 {
        // The last node with `below` ≤ u: the cell after it is the one that holds u, and it is not empty.
        let cell = self.below.partition_point(|&below| below <= u).clamp(1, self.below.len() - 1) - 1;
        let (low, high) = (self.density[cell], self.density[cell + 1]);
        let mass = self.below[cell + 1] - self.below[cell];
        let share = if mass > 0.0 { ((u - self.below[cell]) / mass).clamp(0.0, 1.0) } else { 0.0 };
        // low t + (high − low) t²/2 = share (low + high)/2, solved without a difference of close numbers.
        let root = (low * low + share * (high * high - low * low)).max(0.0).sqrt();
        let t = if low + root > 0.0 { share * (low + high) / (low + root) } else { 0.0 };
        (cell as f64 + t.clamp(0.0, 1.0)) * self.step
    }

    /// The density at `x`; 0 outside the table.
    pub fn sample_pdf(&self, x: f64) -> f64 {
        let Some((cell, t)) = self.locate(x) else { return 0.0 };
        self.density[cell] * (1.0 - t) + self.density[cell + 1] * t
    }

    /// The mass below `x`: the u that [`Self::sample`] maps to it.
    pub fn sample_inv(&self, x: f64) -> f64 {
        let Some((cell, t)) = self.locate(x) else { return if x > 0.0 { 1.0 } else { 0.0 } };
        let (low, high) = (self.density[cell], self.density[cell + 1]);
        (self.below[cell] + self.step * t * (low + 0.5 * (high - low) * t)).min(1.0)
    }

    /// The cell that holds `x` and the place in it, from 0 to 1.
    fn locate(&self, x: f64) -> Option<(usize, f64)> {
        let cells = self.density.len() - 1;
        let at = x / self.step;
        // One rounding beyond the last node still belongs to it: `sample` returns cells · step.
        (0.0..=cells as f64 * (1.0 + f64::EPSILON)).contains(&at).then(|| {
            let cell = (at as usize).min(cells - 1);
            (cell, (at - cell as f64).min(1.0))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_ramp_is_the_square_root() {
        // p(x) = x / 2 on [0, 2]: x = 2 √u.
        let ramp = PiecewiseLinear::new(&[0.0, 1.0], 2.0).unwrap();
        for u in [0.0, 1e-12, 0.25, 0.81] {
            assert!((ramp.sample(u) - 2.0 * u.sqrt()).abs() < 1e-15 * 4.0);
        }
        assert_eq!(ramp.sample_pdf(1.0), 0.5);
    }

    #[test]
    fn refuses_what_is_no_density() {
        for bad in [&[][..], &[1.0], &[0.0, 0.0], &[1.0, -1.0], &[f64::NAN, 1.0], &[f64::INFINITY, 1.0]] {
            assert!(PiecewiseLinear::new(bad, 1.0).is_none(), "{bad:?}");
        }
        assert!(PiecewiseLinear::new(&[1.0, 1.0], 0.0).is_none());
    }

    proptest! {
        #[test]
        fn the_inverse_inverts_and_the_density_is_its_slope(
            values in proptest::collection::vec(0.0..5.0_f64, 2..40), first in 0.1..1.0_f64, u in 0.001..0.998_f64,
        ) {
            let mut values = values;
            values[0] = first;
            let table = PiecewiseLinear::new(&values, 3.0).unwrap();
            let x = table.sample(u);
            // Where the density almost vanishes, x is ill-determined but u is not.
            prop_assert!((table.sample_inv(x) - u).abs() < 1e-13);
            let slope = (table.sample_inv(x + 1e-6) - table.sample_inv(x - 1e-6)) / 2e-6;
            // Second-order differences meet at most one kink, of size 5/step · 1e-6.
            prop_assert!((slope - table.sample_pdf(x)).abs() < 1e-3);
        }
    }
}
