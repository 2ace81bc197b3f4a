//! Gauss-Seidel: patch by patch, each with the newest radiosity of all others.
//!
//! B_i ← (E_i + ρ_i Σ_{j≠i} F_ij B_j) / (1 − ρ_i F_ii)
//!
//! in the order of the patches, from B = E. What a patch sends to itself is summed up at once, by the divisor.
//!
//! The sums over j > i depend on nothing that the sweep changes before it comes to i, so they are known when it begins, and those
//! over j < i are what they are when it ends: together they are the residual, without another product. Blocks of rows gather
//! from the blocks before them in parallel; only within a block does one patch wait for the other.

use rayon::prelude::*;

use super::super::matrix::Planes;
use super::super::system::{System, largest};
use super::progress::{Claim, Progress};
use super::{Settings, Solved};
use crate::math::color::Rgb;

/// Patches that wait for one another, while the sums over all before them are taken in parallel.
const BLOCK: usize = 128;

/// Rows that one thread multiplies at a time.
const ROWS: usize = 8;

struct Sweep<'a> {
    system: &'a System,
    b: Vec<Rgb>,
    planes: Planes,
    /// Σ_{j<i} F_ij B_j.
    lower: Vec<Rgb>,
    /// Σ_{j>i} F_ij B_j.
    upper: Vec<Rgb>,
}

pub(super) fn solve(system: &System, settings: Settings) -> Solved {
    let mut progress = Progress::new(system, settings);
    let scale = largest(system.emission().iter().copied());
    let mut sweep = Sweep::new(system);
    let (mut residual, mut change) = (system.residual(&sweep.b), f64::INFINITY);
    loop {
        let claim = Claim { residual, change, scale, largest: largest(sweep.b.iter().copied()) };
        let settled = progress.claims(claim) && progress.confirms(&sweep.b);
        if settled || !progress.may_go_on(claim) {
            return progress.finish(sweep.b, settled);
        }
        change = sweep.run();
        residual = sweep.residual();
        progress.iterations += 1;
        progress.history.push(residual);
    }
}

impl<'a> Sweep<'a> {
    fn new(system: &'a System) -> Self {
        let b = system.emission().to_vec();
        let none = vec![Rgb::BLACK; b.len()];
        let mut sweep = Self { system, planes: Planes::new(&b), b, lower: none.clone(), upper: none };
        sweep.gather_upper();
        sweep
    }

    fn gather_upper(&mut self) {
        let Self { system, planes, upper, .. } = self;
        upper.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, out)| {
            for (k, out) in out.iter_mut().enumerate() {
                let i = chunk * ROWS + k;
                *out = planes.dot(&system.factors().row(i)[i + 1..], i + 1);
            }
        });
    }

    /// One sweep; the largest change of any patch and channel.
    fn run(&mut self) -> f64 {
        let mut change = 0.0;
        for start in (0..self.b.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(self.b.len());
            let Self { system, planes, lower, .. } = self;
            lower[start..end].par_chunks_mut(ROWS).enumerate().for_each(|(chunk, out)| {
                for (k, out) in out.iter_mut().enumerate() {
                    *out = planes.dot(&system.factors().row(start + chunk * ROWS + k)[..start], 0);
                }
            });
            for i in start..end {
                change = f64::max(change, self.patch(i, start));
            }
        }
        self.gather_upper();
        change
    }

    /// Solves row `i`, whose lower sum is there up to column `start`; the largest change of its channels.
    fn patch(&mut self, i: usize, start: usize) -> f64 {
        let row = self.system.factors().row(i);
        self.lower[i] = self.lower[i] + self.planes.dot(&row[start..i], start);
        let (rho, e) = (self.system.reflectance()[i], self.system.emission()[i]);
        let new = (e + rho * (self.lower[i] + self.upper[i])) / (Rgb::WHITE - rho * row[i]);
        let change = (new - self.b[i]).map(f64::abs).max_channel();
        self.b[i] = new;
        self.planes.set(i, new);
        change
    }

    fn residual(&self) -> f64 {
        let (rho, e) = (self.system.reflectance(), self.system.emission());
        largest((0..self.b.len()).map(|i| {
            let own = self.system.factors().at(i, i) * self.b[i];
            e[i] + rho[i] * (self.lower[i] + own + self.upper[i]) - self.b[i]
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::networks::{colourful, cube, sphere};
    use super::super::{Method, Settings, Stop};
    use super::*;

    #[test]
    fn iterations_and_rate_of_the_cube() {
        for (rho, expected, rate) in [(0.5, 18, 0.27412), (0.9, 107, 0.81196)] {
            let system = cube(rho, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let found = Method::GaussSeidel.solve(&system, Settings { stop: Stop::Change, ..Settings::default() });
            let found = found.unwrap();
            assert_eq!((found.iterations, found.converged), (expected, true), "ρ = {rho}");
            let late = found.history.len() - 4;
            let ratio = found.history[late] / found.history[late - 1];
            // Five digits are known, and the second eigenvalue is gone by then.
            assert!((ratio - rate).abs() < 1e-5, "ρ = {rho}: {ratio}");
        }
    }

    #[test]
    fn a_sweep_is_that_of_the_definition() {
        // 300 patches are three blocks.
        for system in [colourful(300), sphere(300), cube(0.9, [1.0, 0.0, 0.5, 0.0, 0.0, 0.0])] {
            let mut sweep = Sweep::new(&system);
            let mut b = system.emission().to_vec();
            for _ in 0..3 {
                sweep.run();
                for i in 0..b.len() {
                    let row = system.factors().row(i);
                    let others: Rgb = (0..b.len()).filter(|&j| j != i).map(|j| row[j] * b[j]).sum();
                    let (rho, e) = (system.reflectance()[i], system.emission()[i]);
                    b[i] = (e + rho * others) / (Rgb::WHITE - rho * row[i]);
                }
                // Roundings of sums of 300 terms, of radiosities of 10 at most.
                assert!(largest(b.iter().zip(&sweep.b).map(|(&a, &b)| a - b)) <= 1e-13);
                assert!(
                    (sweep.residual() - system.residual(&b)).abs() <= 1e-13,
                    "the sums of a sweep are its residual"
                );
            }
        }
    }

    #[test]
    fn it_needs_fewer_iterations_than_jacobi() {
        for system in [colourful(40), sphere(30), cube(0.9, [1.0, 0.0, 0.5, 0.0, 0.0, 0.0])] {
            let count = |method: Method| method.solve(&system, Settings::default()).unwrap().iterations;
            assert!(count(Method::GaussSeidel) < count(Method::Jacobi));
        }
    }
}
