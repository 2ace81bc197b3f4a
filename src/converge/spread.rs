//! The standard deviation of one sample of an importance-sampling estimator, as integrals.
//!
//! An estimator draws one direction from each of its ways. Way i has the density pᵢ [1/sr] and the weight wᵢ of multiple
//! importance sampling (1 for a single way); with the integrand g, one sample has the mean and the variance
//!
//! E = Σᵢ ∫ wᵢ g dω,    V = Σᵢ [ ∫ wᵢ² g² / pᵢ dω − (∫ wᵢ g dω)² ]
//!
//! Draws that are lost count as 0 and need no term of their own.
//! # References
//! - Veach & Guibas 1995, Optimally combining sampling techniques for Monte Carlo rendering, SIGGRAPH

use crate::render::path::Heuristic;

/// The integrands of one estimator at a direction: wᵢ g and wᵢ² g² / pᵢ of its first way, then of its second.
pub(super) type Terms = [f64; 4];

/// An estimator with one way.
pub(super) fn one_way(g: f64, p: f64) -> Terms {
    [g, square_over(g, p), 0.0, 0.0]
}

/// An estimator with a draw from each of two ways.
pub(super) fn two_ways(by: Heuristic, g: f64, p: f64, q: f64) -> Terms {
    // A weight where neither way comes would be 0 / 0; the integrand must be 0 there.
    let part = |p: f64, q: f64| if p > 0.0 { by.weight(p, q) * g } else { 0.0 };
    let (first, second) = (part(p, q), part(q, p));
    [first, square_over(first, p), second, square_over(second, q)]
}

/// g² / p; nothing where there is nothing to find, and infinite where it is never found.
fn square_over(g: f64, p: f64) -> f64 {
    if g == 0.0 { 0.0 } else { g * g / p }
}

/// The standard deviation, from the integrals of the terms, each with an error of at most `error`.
pub(super) fn sigma([first, first_square, second, second_square]: Terms, error: f64) -> f64 {
    let variance = first_square - first * first + second_square - second * second;
    // What cannot be told from 0 is 0: a root would make 1e-5 of an error of 1e-10.
    if variance <= error { 0.0 } else { variance.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_two_ways_share_the_integrand() {
        for by in [Heuristic::Balance, Heuristic::Power] {
            for (p, q) in [(1.0, 2.0), (0.0, 3.0), (5.0, 0.0), (1e-200, 1e200)] {
                let [first, first_square, second, second_square] = two_ways(by, 7.0, p, q);
                assert!((first + second - 7.0).abs() < 1e-14, "{by:?} {p} {q}");
                assert!(first_square.is_finite() && second_square.is_finite(), "{by:?} {p} {q}");
            }
        }
        assert_eq!(one_way(0.0, 0.0), [0.0; 4]);
        assert_eq!(one_way(1.0, 0.0)[1], f64::INFINITY, "what is never found");
    }

    #[test]
    fn what_is_no_more_than_the_error_is_no_spread() {
        assert_eq!(sigma([1.0, 1.0 + 1e-12, 0.0, 0.0], 1e-11), 0.0);
        assert_eq!(sigma([1.0, 5.0, 0.0, 0.0], 1e-11), 2.0);
    }
}
