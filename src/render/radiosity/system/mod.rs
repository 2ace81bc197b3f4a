//! The radiosity system (I − ρF) B = E.
//!
//! B_i = E_i + ρ_i H_i,   H_i = Σ_j F_ij B_j
//!
//! with radiosity B, emission E and irradiance H in W/m², reflectance ρ in [0, 1), view factors F without a unit. The three
//! channels are three systems with one matrix F.
//!
//! # Errors of a solution
//! For any B, with B* the exact solution and r = E − (I − ρF) B,
//!
//! ‖B − B*‖_∞ ≤ ‖r‖_∞ / (1 − max ρ)
//!
//! since B* − B = Σ_k (ρF)^k r and ‖ρF‖_∞ ≤ max ρ while rows sum to 1 at most. It bounds what is left of the discrete system,
//! not the error of having cut a surface into patches.

pub mod dominance;
pub mod energy;
mod error;

use std::sync::Arc;

use self::dominance::Dominance;
use self::energy::Energy;
pub use self::error::SystemError;
use super::matrix::FactorMatrix;
use crate::math::color::Rgb;

/// The factors of a row may sum to 1 and this: coarse sampling may miss what hides by so much, and more is a mistake. The sum
/// is then part of the certified bound.
pub const ROW_SUM_TOLERANCE: f64 = 0.1;

/// Patches, what they send each other, reflect and emit.
#[derive(Clone, Debug)]
pub struct System {
    factors: Arc<FactorMatrix>,
    areas: Vec<f64>,
    reflectance: Vec<Rgb>,
    emission: Vec<Rgb>,
    row_sums: Vec<f64>,
    /// max_i ρ_i max(1, Σ_j F_ij), a bound of ‖ρF‖_∞ below 1.
    contraction: f64,
}

impl System {
    /// `factors` by value or in an [`Arc`] that several systems share; `areas` \[m²\] above 0; `reflectance` in [0, 1) in every
    /// channel; `emission` as a radiosity [W/m²], π times the radiance of a Lambertian emitter.
    ///
    /// Rows of `factors` sum to 1 + [`ROW_SUM_TOLERANCE`] at most. Reciprocity is not asked for: [`Energy`] measures what its
    /// lack costs.
    pub fn new(
        factors: impl Into<Arc<FactorMatrix>>,
        areas: Vec<f64>,
        reflectance: Vec<Rgb>,
        emission: Vec<Rgb>,
    ) -> Result<Self, SystemError> {
        let factors = factors.into();
        let n = factors.n();
        if n == 0 {
            return Err(SystemError::Empty);
        }
        for (what, found) in
            [("areas", areas.len()), ("reflectances", reflectance.len()), ("emissions", emission.len())]
        {
            if found != n {
                return Err(SystemError::Length { what, expected: n, found });
            }
        }
        if let Some((patch, &value)) = areas.iter().enumerate().find(|(_, a)| !(**a > 0.0 && a.is_finite())) {
            return Err(SystemError::Area { patch, value });
        }
        if let Some((patch, channel, value)) = first(&reflectance, |rho| !(0.0..1.0).contains(&rho)) {
            return Err(SystemError::Reflectance { patch, channel, value });
        }
        if let Some((patch, channel, value)) = first(&emission, |e| !(e >= 0.0 && e.is_finite())) {
            return Err(SystemError::Emission { patch, channel, value });
        }
        let row_sums = factors.row_sums();
        let allowed = 1.0 + ROW_SUM_TOLERANCE;
        if let Some((patch, &value)) = row_sums.iter().enumerate().find(|(_, sum)| **sum > allowed) {
            return Err(SystemError::RowSum { patch, value, allowed });
        }
        let norms = reflectance.iter().zip(&row_sums).map(|(rho, sum)| rho.max_channel() * sum.max(1.0));
        let contraction = norms.fold(0.0, f64::max);
        let system = Self { factors, areas, reflectance, emission, row_sums, contraction };
        let dominance = system.dominance();
        if dominance.holds() && contraction < 1.0 { Ok(system) } else { Err(SystemError::NotDominant(dominance)) }
    }

    /// The number of patches, at least 1.
    pub fn n(&self) -> usize {
        self.areas.len()
    }

    /// F.
    pub fn factors(&self) -> &FactorMatrix {
        &self.factors
    }

    /// A \[m²\].
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// ρ.
    pub fn reflectance(&self) -> &[Rgb] {
        &self.reflectance
    }

    /// E [W/m²].
    pub fn emission(&self) -> &[Rgb] {
        &self.emission
    }

    /// Σ_j F_ij of every patch.
    pub fn row_sums(&self) -> &[f64] {
        &self.row_sums
    }

    /// The row of I − ρF that is nearest to losing strict diagonal dominance. It holds: a system that lacks it is refused.
    pub fn dominance(&self) -> Dominance {
        Dominance::of(&self.factors, &self.reflectance).unwrap_or(Dominance {
            row: 0,
            channel: 0,
            reflectance: 0.0,
            row_sum: 0.0,
            off_diagonal: 0.0,
            diagonal: 1.0,
        })
    }

    /// H = F B [W/m²].
    pub fn irradiance(&self, b: &[Rgb]) -> Vec<Rgb> {
        self.factors.product(b)
    }

    /// E + ρ F B: one reflection of B, and what is emitted.
    pub fn reflect(&self, b: &[Rgb]) -> Vec<Rgb> {
        let mut reflected = self.irradiance(b);
        for ((h, &rho), &e) in reflected.iter_mut().zip(&self.reflectance).zip(&self.emission) {
            *h = e + rho * *h;
        }
        reflected
    }

    /// ‖E − (I − ρF) B‖_∞ over patches and channels [W/m²].
    pub fn residual(&self, b: &[Rgb]) -> f64 {
        largest_gap(&self.reflect(b), b)
    }

    /// The largest error ‖B − B*‖_∞ that a radiosity of this `residual` can have [W/m²]: residual / (1 − max ρ).
    ///
    /// Where a row sums to more than 1 within the tolerance, max ρ_i Σ_j F_ij takes the place of max ρ.
    pub fn certified_bound(&self, residual: f64) -> f64 {
        residual / (1.0 - self.contraction)
    }

    /// max ρ, or what takes its place in [`certified_bound`](Self::certified_bound): ‖ρF‖_∞ is no larger.
    pub fn contraction(&self) -> f64 {
        self.contraction
    }

    /// Where the power of a radiosity goes.
    pub fn energy(&self, b: &[Rgb]) -> Energy {
        Energy::of(self, b)
    }
}

fn first(values: &[Rgb], wrong: impl Fn(f64) -> bool) -> Option<(usize, usize, f64)> {
    let channels = values.iter().enumerate().flat_map(|(patch, v)| {
        v.to_array().into_iter().enumerate().map(move |(channel, value)| (patch, channel, value))
    });
    channels.into_iter().find(|&(_, _, value)| wrong(value))
}

/// max |a − b| over all entries and channels; NaN if any entry is.
pub(super) fn largest_gap(a: &[Rgb], b: &[Rgb]) -> f64 {
    largest(a.iter().zip(b).map(|(&a, &b)| a - b))
}

/// max |v| over all entries and channels; NaN if any entry is.
pub(super) fn largest(values: impl Iterator<Item = Rgb>) -> f64 {
    let mut most = 0.0;
    for value in values {
        for channel in value.to_array() {
            // Not f64::max, which would let NaN pass.
            if channel.abs() > most || channel.is_nan() {
                most = channel.abs();
            }
        }
        if most.is_nan() {
            return most;
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plates() -> FactorMatrix {
        FactorMatrix::new(2, vec![0.0, 1.0, 1.0, 0.0]).unwrap()
    }

    fn with(areas: [f64; 2], rho: [Rgb; 2], e: [Rgb; 2]) -> Result<System, SystemError> {
        System::new(plates(), areas.to_vec(), rho.to_vec(), e.to_vec())
    }

    #[test]
    fn what_is_no_system_is_refused_by_name() {
        let (ones, half, none) = ([1.0; 2], [Rgb::grey(0.5); 2], [Rgb::BLACK; 2]);
        assert!(with(ones, half, none).is_ok());
        for area in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = with([1.0, area], half, none);
            assert!(matches!(found, Err(SystemError::Area { patch: 1, .. })), "{area}: {found:?}");
        }
        for rho in [1.0, 1.5, -0.1, f64::NAN, f64::INFINITY] {
            let found = with(ones, [Rgb::grey(0.5), Rgb::new(0.1, rho, 0.1)], none);
            assert!(matches!(found, Err(SystemError::Reflectance { patch: 1, channel: 1, .. })), "{rho}: {found:?}");
        }
        for e in [-1.0, f64::NAN, f64::INFINITY] {
            let found = with(ones, half, [Rgb::new(0.0, 0.0, e), Rgb::BLACK]);
            assert!(matches!(found, Err(SystemError::Emission { patch: 0, channel: 2, .. })), "{e}: {found:?}");
        }
        let found = System::new(plates(), vec![1.0], half.to_vec(), none.to_vec());
        assert!(matches!(found, Err(SystemError::Length { what: "areas", expected: 2, found: 1 })));
        let more = FactorMatrix::new(1, vec![1.2]).unwrap();
        let found = System::new(more, vec![1.0], vec![Rgb::BLACK], vec![Rgb::BLACK]);
        assert!(matches!(found, Err(SystemError::RowSum { patch: 0, .. })), "{found:?}");
        let nearly = FactorMatrix::new(1, vec![1.0 + 5e-7]).unwrap();
        let found = System::new(nearly, vec![1.0], vec![Rgb::grey(1.0 - 1e-7)], vec![Rgb::BLACK]);
        assert!(matches!(found, Err(SystemError::NotDominant(_))), "each is allowed, both together are not: {found:?}");
        let words = with(ones, [Rgb::grey(1.0); 2], none).unwrap_err().to_string();
        assert_eq!(words, "the reflectance of patch 0 is 1 in channel 0: a number in [0, 1) is allowed");
    }

    #[test]
    fn between_infinite_plates() {
        // B_1 = (E_1 + ρ_1 E_2) / (1 − ρ_1 ρ_2) = 5/3, B_2 = 4/3.
        let system = with([1.0; 2], [Rgb::grey(0.5), Rgb::grey(0.8)], [Rgb::WHITE, Rgb::BLACK]).unwrap();
        let exact = [Rgb::grey(5.0 / 3.0), Rgb::grey(4.0 / 3.0)];
        assert!(system.residual(&exact) <= 1e-15, "three roundings");
        assert!((system.residual(&[Rgb::grey(5.0 / 3.0), Rgb::grey(1.0)]) - 1.0 / 3.0).abs() < 1e-15);
        assert_eq!(system.certified_bound(0.1), 0.1 / (1.0 - 0.8));
        assert!(system.dominance().holds() && system.dominance().row == 1);
    }

    #[test]
    fn nan_is_never_small() {
        assert!(largest([Rgb::WHITE, Rgb::new(0.0, f64::NAN, 0.0), Rgb::WHITE].into_iter()).is_nan());
        assert_eq!(largest([Rgb::grey(-2.0), Rgb::WHITE].into_iter()), 2.0);
    }
}
