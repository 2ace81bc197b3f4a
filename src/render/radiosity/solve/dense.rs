//! The dense solver: LU factors of I − ρF, at 8 n² bytes besides F itself.
//!
//! A row of I − ρF has the reflectance of its own patch, so that channels in which all reflectances agree share their factors:
//! one factorisation serves grey surfaces in any light, three serve colours.

use rayon::prelude::*;

use super::super::system::{System, largest};
use super::lu::Factors;
use super::progress::{Claim, Progress};
use super::{Settings, Solved};
use crate::math::color::Rgb;

pub(super) fn solve(system: &System, settings: Settings) -> Solved {
    let n = system.n();
    let mut b = vec![Rgb::BLACK; n];
    for channels in groups(system) {
        let factors = Factors::new(n, matrix(system, channels[0]));
        let mut sides: Vec<f64> =
            channels.iter().flat_map(|&c| system.emission().iter().map(move |e| e.0[c])).collect();
        factors.solve(&mut sides);
        for (&c, side) in channels.iter().zip(sides.chunks(n)) {
            for (b, &side) in b.iter_mut().zip(side) {
                b.0[c] = side;
            }
        }
    }
    let residual = system.residual(&b);
    let mut progress = Progress::new(system, settings);
    progress.iterations = 1;
    progress.history.push(residual);
    // Nothing would change any more.
    let claim = Claim { residual, change: 0.0, scale: 0.0, largest: largest(b.iter().copied()) };
    let settled = progress.claims(claim);
    progress.finish(b, settled)
}

/// Channels whose reflectances agree in every patch.
fn groups(system: &System) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for c in 0..3 {
        let alike = |group: &&mut Vec<usize>| system.reflectance().iter().all(|rho| rho.0[c] == rho.0[group[0]]);
        match groups.iter_mut().find(alike) {
            Some(group) => group.push(c),
            None => groups.push(vec![c]),
        }
    }
    groups
}

/// I − ρF of one channel, row by row.
fn matrix(system: &System, channel: usize) -> Vec<f64> {
    let n = system.n();
    let mut values = vec![0.0; n * n];
    values.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
        let rho = system.reflectance()[i].0[channel];
        for (value, factor) in row.iter_mut().zip(system.factors().row(i)) {
            *value = -rho * factor;
        }
        row[i] += 1.0;
    });
    values
}

#[cfg(test)]
mod tests {
    use super::super::networks::{colourful, cube};
    use super::super::{Method, Settings};
    use super::*;

    #[test]
    fn the_cube_has_the_values_of_its_network() {
        let known = [(0.5, [1.090909098, 0.181745826, 0.181836269]), (0.9, [2.372881375, 1.525310551, 1.525452019])];
        for (rho, [bottom, top, side]) in known {
            let found = Method::Dense.solve(&cube(rho, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), Settings::default()).unwrap();
            assert!(found.converged && found.certified_bound < 1e-13);
            for (found, expected) in found.radiosity.iter().zip([bottom, top, side, side, side, side]) {
                // Nine decimals are known.
                assert!((*found - Rgb::grey(expected)).map(f64::abs).max_channel() <= 6e-10, "ρ = {rho}: {found}");
            }
        }
    }

    #[test]
    fn channels_that_agree_share_their_factors() {
        assert_eq!(groups(&cube(0.5, [1.0; 6])), [vec![0, 1, 2]]);
        assert_eq!(groups(&colourful(10)), [vec![0], vec![1], vec![2]]);
    }
}
