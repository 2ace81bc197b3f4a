//! Southwell's relaxation, which is progressive refinement: shoot what is largest first.
//!
//! Every patch has an unshot radiosity ΔB, at first E. A shot takes the patch i with the largest unshot power A_i Σ_channels ΔB_i
//! and sends it to all others,
//!
//! ΔB_j += ρ_j F_ji ΔB_i,   B_j += the same,   ΔB_i = 0 (or what it has sent to itself)
//!
//! with F_ji = A_i F_ij / A_j: reciprocity makes a row of what would be a column. B is always what has been shot and what has not,
//! as Cohen et al. display it, so that its residual is ρ F ΔB and no larger than max ρ · max ΔB. Each shot takes at least
//! (1 − max ρ)/n of the unshot power away.
//!
//! Of a matrix without reciprocity the shots solve another system. When they are done, what is missing for the right one is
//! unshot radiosity again, above 0 or below; a few rounds end that, where the matrix is nearly reciprocal.
//! # References
//! - Cohen, Chen, Wallace & Greenberg 1988, A progressive refinement approach to fast radiosity image generation, SIGGRAPH
//! - Gortler, Cohen & Slusallek 1994, Radiosity and relaxation methods, IEEE CG&A 14(6) (that it is Southwell's method)

use super::super::system::System;
use super::progress::{Claim, Progress};
use super::{Settings, Solved};
use crate::math::color::Rgb;

/// The state: one list per channel, for the vector unit.
struct Shooting<'a> {
    system: &'a System,
    rho: [Vec<f64>; 3],
    b: [Vec<f64>; 3],
    unshot: [Vec<f64>; 3],
    /// F_ji of the patch i that shoots.
    received: Vec<f64>,
    survey: Survey,
}

/// What is unshot.
#[derive(Clone, Copy, Debug, Default)]
struct Survey {
    /// Σ_j A_j Σ_channels |ΔB_j|.
    power: f64,
    /// max |ΔB| over patches and channels.
    most: f64,
    /// max |B|.
    largest: f64,
    /// The patch with the largest unshot power, the first of equals.
    next: usize,
}

pub(super) fn solve(system: &System, settings: Settings) -> Solved {
    let mut progress = Progress::new(system, settings);
    let mut shooting = Shooting::new(system);
    let scale = shooting.survey.power;
    let every = system.n() as u64;
    loop {
        let Survey { power: change, most, largest, .. } = shooting.survey;
        if progress.iterations > 0 && progress.iterations.is_multiple_of(every) {
            progress.history.push(most);
        }
        let claim = Claim { residual: system.contraction() * most, change, scale, largest };
        let claimed = progress.claims(claim);
        let settled = claimed && progress.confirms(&shooting.radiosity());
        if settled || !progress.may_go_on(claim) {
            if !progress.iterations.is_multiple_of(every) {
                progress.history.push(most);
            }
            return progress.finish(shooting.radiosity(), settled);
        }
        if claimed {
            shooting.begin_again();
        }
        shooting.shoot();
        progress.iterations += 1;
    }
}

impl<'a> Shooting<'a> {
    fn new(system: &'a System) -> Self {
        let planes = |values: &[Rgb]| [0, 1, 2].map(|c| values.iter().map(|v| v.0[c]).collect::<Vec<f64>>());
        let mut shooting = Self {
            system,
            rho: planes(system.reflectance()),
            b: planes(system.emission()),
            unshot: planes(system.emission()),
            received: vec![0.0; system.n()],
            survey: Survey::default(),
        };
        shooting.look();
        shooting
    }

    fn radiosity(&self) -> Vec<Rgb> {
        let [x, y, z] = &self.b;
        x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Rgb::new(x, y, z)).collect()
    }

    /// Shoots from the patch with the largest unshot power.
    fn shoot(&mut self) {
        let from = self.survey.next;
        let (areas, row) = (self.system.areas(), self.system.factors().row(from));
        for ((received, &factor), &area) in self.received.iter_mut().zip(row).zip(areas) {
            *received = areas[from] * factor / area;
        }
        for ((rho, b), unshot) in self.rho.iter().zip(&mut self.b).zip(&mut self.unshot) {
            let shot = std::mem::take(&mut unshot[from]);
            for (((unshot, b), &rho), &received) in unshot.iter_mut().zip(b).zip(rho).zip(&self.received) {
                let reflected = rho * received * shot;
                *unshot += reflected;
                *b += reflected;
            }
        }
        self.look();
    }

    /// Takes for unshot what the radiosity lacks, E − (I − ρF) B.
    fn begin_again(&mut self) {
        let now = self.radiosity();
        for (i, (reflected, now)) in self.system.reflect(&now).into_iter().zip(now).enumerate() {
            for (c, lack) in (reflected - now).to_array().into_iter().enumerate() {
                self.unshot[c][i] = lack;
                self.b[c][i] += lack;
            }
        }
        self.look();
    }

    fn look(&mut self) {
        let mut survey = Survey::default();
        let mut highest = 0.0;
        let [ux, uy, uz] = &self.unshot;
        for (j, (((&x, &y), &z), &area)) in ux.iter().zip(uy).zip(uz).zip(self.system.areas()).enumerate() {
            let power = area * (x.abs() + y.abs() + z.abs());
            survey.power += power;
            survey.most = survey.most.max(x.abs()).max(y.abs()).max(z.abs());
            if power > highest {
                (highest, survey.next) = (power, j);
            }
        }
        survey.largest = self.b.iter().flatten().fold(0.0, |most, b| f64::max(most, b.abs()));
        self.survey = survey;
    }
}

#[cfg(test)]
mod tests {
    use super::super::networks::{colourful, cube, sphere};
    use super::super::{Method, Settings, Stop};
    use super::*;

    #[test]
    fn shots_of_the_cube() {
        for (rho, expected) in [(0.5, 106), (0.9, 662)] {
            let settings = Settings { stop: Stop::Change, ..Settings::default() };
            let found = Method::Southwell.solve(&cube(rho, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), settings).unwrap();
            assert_eq!((found.iterations, found.converged), (expected, true), "ρ = {rho}");
            // After every sixth shot, and the last.
            assert_eq!(found.history.len() as u64, expected.div_ceil(6));
        }
    }

    #[test]
    fn every_shot_takes_its_share_of_the_unshot_power_away() {
        for system in [cube(0.9, [1.0, 0.0, 0.5, 0.0, 0.0, 0.0]), sphere(30), colourful(40)] {
            let mut shooting = Shooting::new(&system);
            let kept = 1.0 - (1.0 - system.contraction()) / system.n() as f64;
            for shot in 0..500 {
                let before = shooting.survey.power;
                shooting.shoot();
                // The roundings of a sum.
                assert!(shooting.survey.power <= kept * before * (1.0 + 1e-14), "shot {shot}");
                let residual = system.residual(&shooting.radiosity());
                assert!(residual <= system.contraction() * shooting.survey.most + 1e-14, "shot {shot}");
            }
        }
    }

    #[test]
    fn what_was_shot_and_what_was_not_make_the_whole() {
        // B − ρ F B + ρ F ΔB = E at any time.
        let system = colourful(40);
        let mut shooting = Shooting::new(&system);
        for _ in 0..100 {
            shooting.shoot();
        }
        let b = shooting.radiosity();
        let [x, y, z] = &shooting.unshot;
        let unshot: Vec<Rgb> = (0..40).map(|i| Rgb::new(x[i], y[i], z[i])).collect();
        let shot: Vec<Rgb> = b.iter().zip(&unshot).map(|(&b, &unshot)| b - unshot).collect();
        let gap = super::super::super::system::largest_gap(&system.reflect(&shot), &b);
        assert!(gap <= 1e-13, "a hundred roundings: {gap}");
    }
}
