//! Strict diagonal dominance of I − ρF: the condition under which every solver of this crate converges.
//!
//! Row k is strictly dominant when
//!
//! ρ_k Σ_{j≠k} F_kj < 1 − ρ_k F_kk,   that is ρ_k Σ_j F_kj < 1
//!
//! so that with row sums of 1 or less it asks for ρ_k < 1 and nothing else: of the light that arrives, some is lost at every
//! reflection. A patch that sees itself (F_kk > 0) makes the diagonal smaller and the other side too.

use std::fmt;

use super::super::matrix::FactorMatrix;
use crate::math::color::Rgb;

/// The row of I − ρF that is nearest to losing dominance, or has lost it furthest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dominance {
    /// The patch.
    pub row: usize,
    /// The channel, 0 to 2.
    pub channel: usize,
    /// ρ of that patch and channel.
    pub reflectance: f64,
    /// Σ_j F_kj of that patch.
    pub row_sum: f64,
    /// ρ_k Σ_{j≠k} F_kj.
    pub off_diagonal: f64,
    /// 1 − ρ_k F_kk.
    pub diagonal: f64,
}

/// Why a row is not strictly dominant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lapse {
    /// ρ ≥ 1: a reflection loses nothing, and light in a closed room never dies out.
    Reflectance,
    /// The factors sum to more than 1: the patch sends out more than it has.
    RowSum,
    /// A number is NaN.
    NotANumber,
}

impl Dominance {
    /// The worst row over all patches and channels, by [`margin`](Self::margin); None where there are no patches.
    ///
    /// Reflectances need not be those of a valid [`System`](super::System): a report on ρ = 1 is one of the uses.
    pub fn of(factors: &FactorMatrix, reflectance: &[Rgb]) -> Option<Self> {
        let mut worst: Option<Self> = None;
        for (row, (row_sum, rho)) in factors.row_sums().into_iter().zip(reflectance).enumerate() {
            let own = factors.at(row, row);
            for (channel, rho) in rho.to_array().into_iter().enumerate() {
                let (off_diagonal, diagonal) = (rho * (row_sum - own), 1.0 - rho * own);
                let found = Self { row, channel, reflectance: rho, row_sum, off_diagonal, diagonal };
                // Less than the best so far, or NaN.
                if worst.is_none_or(|worst| found.margin() < worst.margin() || found.margin().is_nan()) {
                    worst = Some(found);
                }
            }
        }
        worst
    }

    /// The diagonal less the other side, 1 − ρ_k Σ_j F_kj: above 0 where the row is strictly dominant.
    pub fn margin(&self) -> f64 {
        self.diagonal - self.off_diagonal
    }

    /// Whether this row, and so every row, is strictly dominant.
    pub fn holds(&self) -> bool {
        self.off_diagonal < self.diagonal
    }

    /// Why it does not hold; None where it does.
    pub fn lapse(&self) -> Option<Lapse> {
        if self.holds() {
            None
        } else if self.margin().is_nan() {
            Some(Lapse::NotANumber)
        } else if self.reflectance >= 1.0 {
            Some(Lapse::Reflectance)
        } else {
            Some(Lapse::RowSum)
        }
    }
}

impl fmt::Display for Lapse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reflectance => "the reflectance is 1 or more: light that a closed room reflects would never die out",
            Self::RowSum => "the view factors of the row sum to more than 1: the patch sends out more than it has",
            Self::NotANumber => "a number of the row is NaN",
        })
    }
}

impl fmt::Display for Dominance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { row, channel, off_diagonal, diagonal, .. } = self;
        match self.lapse() {
            None => {
                write!(f, "strictly dominant: at worst {off_diagonal} < {diagonal}, in row {row}, channel {channel}")
            }
            Some(lapse) => write!(
                f,
                "row {row}, channel {channel} is not strictly dominant: {off_diagonal} is not below {diagonal}, since {lapse}"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere() -> FactorMatrix {
        FactorMatrix::new(2, vec![0.25, 0.75, 0.25, 0.75]).unwrap()
    }

    #[test]
    fn the_worst_row_is_named_with_its_two_sides() {
        let found = Dominance::of(&sphere(), &[Rgb::grey(0.2), Rgb::new(0.5, 0.8, 0.1)]).unwrap();
        assert_eq!((found.row, found.channel), (1, 1));
        assert!((found.off_diagonal - 0.2).abs() < 1e-15 && (found.diagonal - 0.4).abs() < 1e-15, "two roundings");
        assert!(found.holds() && found.lapse().is_none());
    }

    #[test]
    fn it_fails_at_a_reflectance_of_one_and_says_why() {
        let lapse = |rho: f64, factors: &FactorMatrix| {
            Dominance::of(factors, &[Rgb::grey(rho), Rgb::grey(0.5)]).unwrap().lapse()
        };
        assert_eq!(lapse(0.999, &sphere()), None);
        assert_eq!(lapse(1.0, &sphere()), Some(Lapse::Reflectance));
        assert_eq!(lapse(f64::NAN, &sphere()), Some(Lapse::NotANumber));
        let more = FactorMatrix::new(2, vec![0.5, 0.75, 0.25, 0.75]).unwrap();
        assert_eq!(lapse(0.9, &more), Some(Lapse::RowSum));
        let words = Dominance::of(&more, &[Rgb::grey(0.9), Rgb::BLACK]).unwrap().to_string();
        assert!(words.contains("row 0") && words.contains("sends out more than it has"), "{words}");
    }
}
