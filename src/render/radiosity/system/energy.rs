//! Where the power goes: emitted = absorbed + escaped, and what is left over, by cause.
//!
//! With H = F B and r = E − (I − ρF) B, summing A_i times row i of the system gives the identity
//!
//! ΣA E = ΣA (1 − ρ) H + ΣA B (1 − Σ_j F_ij) + ΣA (B Σ_j F_ij − H) + ΣA r
//!
//! The third sum is 0 when A_i F_ij = A_j F_ji: what all patches send to each other is what they receive from each other. A
//! matrix without that reciprocity makes power or loses it, at no residual at all.

use super::System;
use crate::math::color::Rgb;

/// The powers \[W\] of a radiosity, by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// ΣA E.
    pub emitted: Rgb,
    /// ΣA (1 − ρ) H.
    pub absorbed: Rgb,
    /// ΣA B (1 − Σ_j F_ij): sent to no patch.
    pub escaped: Rgb,
    /// ΣA (B Σ_j F_ij − H): sent, and not received. 0 of a reciprocal matrix.
    pub reciprocity_defect: Rgb,
    /// ΣA r: what the solver has left unsolved.
    pub unsolved: Rgb,
}

impl Energy {
    pub(super) fn of(system: &System, b: &[Rgb]) -> Self {
        let h = system.irradiance(b);
        let mut energy = Self {
            emitted: Rgb::BLACK,
            absorbed: Rgb::BLACK,
            escaped: Rgb::BLACK,
            reciprocity_defect: Rgb::BLACK,
            unsolved: Rgb::BLACK,
        };
        let properties = system.areas().iter().zip(system.emission()).zip(system.reflectance()).zip(system.row_sums());
        for ((((&area, &e), &rho), &sum), (&b, &h)) in properties.zip(b.iter().zip(&h)) {
            energy.emitted += area * e;
            energy.absorbed += area * (Rgb::WHITE - rho) * h;
            energy.escaped += area * (1.0 - sum) * b;
            energy.reciprocity_defect += area * (sum * b - h);
            energy.unsolved += area * (e + rho * h - b);
        }
        energy
    }

    /// emitted − absorbed − escaped: the defect of reciprocity and the unsolved together, up to rounding.
    pub fn imbalance(&self) -> Rgb {
        self.emitted - self.absorbed - self.escaped
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::matrix::FactorMatrix;
    use super::*;

    fn system(values: [f64; 4], areas: [f64; 2]) -> System {
        let factors = FactorMatrix::new(2, values.to_vec()).unwrap();
        let rho = vec![Rgb::new(0.5, 0.2, 0.0), Rgb::grey(0.8)];
        System::new(factors, areas.to_vec(), rho, vec![Rgb::WHITE, Rgb::BLACK]).unwrap()
    }

    /// Two patches by Cramer's rule.
    fn solution(system: &System) -> Vec<Rgb> {
        let f = |i: usize, j: usize| system.factors().at(i, j);
        let (rho, e) = (system.reflectance(), system.emission());
        let solve = |c: usize| {
            let k = |i: usize, j: usize| f64::from(i == j) - rho[i].0[c] * f(i, j);
            let det = k(0, 0) * k(1, 1) - k(0, 1) * k(1, 0);
            let e = |i: usize| e[i].0[c];
            [(e(0) * k(1, 1) - k(0, 1) * e(1)) / det, (k(0, 0) * e(1) - k(1, 0) * e(0)) / det]
        };
        let [x, y, z] = [0, 1, 2].map(solve);
        (0..2).map(|i| Rgb::new(x[i], y[i], z[i])).collect()
    }

    fn small(value: Rgb) -> bool {
        // Ten roundings of powers near 1.
        value.map(f64::abs).max_channel() <= 4e-15
    }

    #[test]
    fn power_is_absorbed_or_escapes() {
        // Areas of 1 and 2: A_0 F_01 = A_1 F_10 = 0.4.
        let open = system([0.1, 0.4, 0.2, 0.3], [1.0, 2.0]);
        let energy = open.energy(&solution(&open));
        assert_eq!(energy.emitted, Rgb::WHITE);
        assert!(energy.escaped.min_channel() > 0.5 && energy.absorbed.min_channel() > 0.01);
        assert!(small(energy.imbalance()) && small(energy.reciprocity_defect) && small(energy.unsolved), "{energy:?}");
    }

    #[test]
    fn what_is_missing_has_its_cause() {
        let broken = system([0.1, 0.4, 0.3, 0.3], [1.0, 2.0]);
        let exact = solution(&broken);
        let energy = broken.energy(&exact);
        assert!(
            energy.reciprocity_defect.map(f64::abs).min_channel() > 0.01,
            "a matrix without reciprocity is not seen"
        );
        assert!(small(energy.unsolved) && small(energy.imbalance() - energy.reciprocity_defect));
        let open = system([0.1, 0.4, 0.2, 0.3], [1.0, 2.0]);
        let direct = open.energy(open.emission());
        assert!(
            small(direct.reciprocity_defect) && direct.unsolved.max_channel() > 0.1,
            "what is unsolved is not seen"
        );
        assert!(small(direct.imbalance() - direct.unsolved));
    }
}
