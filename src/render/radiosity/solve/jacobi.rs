//! Jacobi's iteration in the form of Richardson: B ← E + ρ F B from B = E.
//!
//! Iterate r is Σ_{i≤r} (ρF)^i E, which is the light of r reflections exactly: light that a patch sends to itself counts as
//! reflected too. Jacobi proper divides by D = 1 − ρ_k F_kk instead, which sums up all reflections of a patch in itself at once;
//! the two are the same where no patch sees itself. The error falls by max ρ per iteration at least, and the residual with it.

use super::super::system::{System, largest, largest_gap};
use super::progress::{Claim, Progress};
use super::{Settings, Solved};

pub(super) fn solve(system: &System, settings: Settings) -> Solved {
    let mut progress = Progress::new(system, settings);
    let scale = largest(system.emission().iter().copied());
    let mut b = system.emission().to_vec();
    let mut next = system.reflect(&b);
    // That of iterate r is what iteration r + 1 changes.
    let mut residual = largest_gap(&next, &b);
    let mut change = f64::INFINITY;
    loop {
        let claim = Claim { residual, change, scale, largest: largest(b.iter().copied()) };
        let settled = progress.claims(claim);
        let enough = match settings.bounces {
            Some(bounces) => progress.iterations >= u64::from(bounces),
            None => settled || !progress.may_go_on(claim),
        };
        if enough {
            return progress.finish(b, settled);
        }
        (b, change) = (next, residual);
        next = system.reflect(&b);
        residual = largest_gap(&next, &b);
        progress.iterations += 1;
        progress.history.push(residual);
    }
}

#[cfg(test)]
mod tests {
    use super::super::networks::{alone, colourful, cube, sphere};
    use super::super::{Method, Settings, Stop};
    use crate::math::color::Rgb;
    use crate::render::radiosity::system::{largest, largest_gap};

    #[test]
    fn iterations_in_a_uniform_enclosure_are_those_of_the_geometric_series() {
        // ⌈ln 1e-6 / ln ρ⌉, where the r-th reflection brings ρ^r.
        for (rho, expected) in [(0.5, 20), (0.8, 62), (0.9, 132), (0.95, 270), (0.99, 1375)] {
            let settings = Settings { tolerance: 1e-6, stop: Stop::Change, ..Settings::default() };
            for system in [alone(rho), cube(rho, [1.0; 6])] {
                let found = Method::Jacobi.solve(&system, settings).unwrap();
                assert_eq!((found.iterations, found.converged), (expected, true), "ρ = {rho}");
            }
        }
    }

    #[test]
    fn iterations_of_the_cube() {
        for (rho, expected) in [(0.5, 31), (0.9, 202)] {
            let settings = Settings { stop: Stop::Change, ..Settings::default() };
            let found = Method::Jacobi.solve(&cube(rho, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), settings).unwrap();
            assert_eq!((found.iterations, found.converged), (expected, true), "ρ = {rho}");
        }
    }

    #[test]
    fn iterate_r_is_the_light_of_r_reflections() {
        for system in [cube(0.9, [1.0, 0.0, 0.5, 0.0, 0.0, 0.0]), sphere(30), colourful(40)] {
            let (mut order, mut sum) = (system.emission().to_vec(), system.emission().to_vec());
            for bounces in 0..6 {
                let settings = Settings { bounces: Some(bounces), ..Settings::default() };
                let found = Method::Jacobi.solve(&system, settings).unwrap();
                assert_eq!(found.iterations, u64::from(bounces));
                // A hundred roundings of radiosities of 10 at most.
                assert!(largest_gap(&found.radiosity, &sum) <= 1e-13, "{bounces} reflections");
                // One fewer or one more would be seen.
                assert!(largest(order.iter().copied()) > 1e-4);
                order = system.irradiance(&order).iter().zip(system.reflectance()).map(|(&h, &rho)| rho * h).collect();
                sum = sum.iter().zip(&order).map(|(&a, &b)| a + b).collect::<Vec<Rgb>>();
            }
        }
    }

    #[test]
    fn the_residual_falls_by_the_largest_reflectance_at_least() {
        for system in [cube(0.9, [1.0, 0.0, 0.5, 0.0, 0.0, 0.0]), sphere(30), colourful(40)] {
            let found = Method::Jacobi.solve(&system, Settings::default()).unwrap();
            assert_eq!(found.history.len() as u64, found.iterations);
            assert!(found.history.len() > 10);
            for pair in found.history.windows(2) {
                // 1e-15: the roundings of a radiosity near 10.
                assert!(pair[1] <= system.contraction() * pair[0] + 1e-15, "{pair:?}");
            }
        }
    }
}
