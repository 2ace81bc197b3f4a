//! The laws of noise: how the error falls with the number of samples, for each kind of points.

use super::rates::{ERRORS, FITS, Row, study, tables};
use super::{File, Set, literal};
use crate::converge::Target;
use crate::converge::square::{self, square};
use crate::sampling::sampler::SamplerKind;

/// `noise.csv` and `noise_fits.csv`.
pub const SET: Set = Set {
    name: "the laws of noise",
    files: &[
        File {
            name: "noise.csv",
            about: "Error of a mean over the unit square against the number of points, for a smooth integrand, an edge, and a sum",
            columns: ERRORS,
        },
        File { name: "noise_fits.csv", about: "The exponents of these errors", columns: FITS },
    ],
    make: || tables(&studies()),
};

/// Means of each number of points: the slope over five powers of four is then known to .037 at 99 %.
const REPLICATES: u64 = 128;

/// Powers of four are squares, as grids want it, and powers of two, as nets do.
const COUNTS: [u64; 5] = [64, 256, 1024, 4096, 16384];

fn studies() -> Vec<Row> {
    let targets: Vec<_> = square::NAMES.iter().map(|(name, _)| literal(square(name).ok_or(name))).collect();
    // Within one pixel, the points that are blue over pixels are Sobol's.
    let kinds = SamplerKind::ALL.iter().map(|(_, kind)| *kind).filter(|kind| *kind != SamplerKind::BlueSobol);
    let pairs = targets.iter().flat_map(|target| kinds.clone().map(move |kind| (target, kind)));
    let run = |(number, (target, kind)): (usize, (&Target, SamplerKind))| {
        study(target, &target.estimators[0], kind, &COUNTS, REPLICATES, number as u64)
    };
    pairs.enumerate().map(run).collect()
}
