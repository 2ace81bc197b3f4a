//! Gauss-Legendre rules: n nodes that integrate polynomials of degree 2n − 1.
//!
//! The nodes are the roots of P_n, found by Newton's method, and the weights 2/((1 − x²) P_n'(x)²).
//! # References
//! - Abramowitz & Stegun 1964, 25.4.29 (nodes, weights, and the error term)

use std::f64::consts::PI;
use std::sync::LazyLock;

/// A rule of N nodes on [0, 1]: (node, weight), ascending.
pub(super) type Rule<const N: usize> = [(f64, f64); N];

/// Sixteen nodes: exact to the last digit for functions whose singularities are as far away as the interval is long.
pub(super) static SIXTEEN: LazyLock<Rule<16>> = LazyLock::new(legendre);

/// The rule of N nodes on [0, 1].
pub(super) fn legendre<const N: usize>() -> Rule<N> {
    std::array::from_fn(|i| {
        let mut x = -(PI * (i as f64 + 0.75) / (N as f64 + 0.5)).cos();
        // Quadratic from a guess that is good to 1/n²: five steps are more than enough.
        for _ in 0..5 {
            let (p, slope) = polynomial(N, x);
            x -= p / slope;
        }
        let (_, slope) = polynomial(N, x);
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// P_n and its derivative, for |x| < 1.
fn polynomial(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut p) = (0.0, 1.0);
    for k in 1..=n {
        let k = k as f64;
        (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
    }
    (p, n as f64 * (before - x * p) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment<const N: usize>(degree: i32) -> f64 {
        legendre::<N>().iter().map(|(x, w)| w * x.powi(degree)).sum()
    }

    #[test]
    fn rules_are_exact_up_to_their_degree_and_no_further() {
        let error = |value: f64, degree: i32| (value * f64::from(degree + 1) - 1.0).abs();
        for degree in 0..32 {
            // Rounding of 16 terms.
            assert!(error(moment::<16>(degree), degree) < 1e-14, "{degree}");
            assert_eq!(error(moment::<3>(degree), degree) < 1e-14, degree <= 5);
            assert_eq!(error(moment::<1>(degree), degree) < 1e-14, degree <= 1);
        }
        let ascending = SIXTEEN.windows(2).all(|pair| 0.0 < pair[0].0 && pair[0].0 < pair[1].0 && pair[1].0 < 1.0);
        assert!(ascending);
    }
}
