//! View factors between all patches of a scene, five ways and their product, each with a report of its error.
//!
//! | name | what it is | in the way | error |
//! |---|---|---|---|
//! | `point` | Lambert's formula at points of a patch, averaged | rays | between two numbers of points |
//! | `hemicube` | a picture of the scene from a patch's centre | nearest wins | between two resolutions |
//! | `rectangles` | closed form of rectangles in one frame | ignored | rounding |
//! | `contour` | contour integral of any polygons | ignored | rounding |
//! | `monte-carlo` | rays by the cosine | nearest wins | √(F (1 − F) / N) |
//! | `visibility` | quadrature or contour, times the share of rays that get through | rays | of that share |
//!
//! F_ij is the share of what patch i sends out that reaches patch j. Nothing is repaired unless it is asked for
//! ([`enforce`]).

mod blockers;
mod cast;
mod closed;
pub mod enforce;
mod fill;
mod hemicube;
mod point;
mod report;
mod visibility;

use std::fmt;

pub use cast::MonteCarlo;
pub use closed::{Contour, Rectangles};
pub use hemicube::Hemicube;
pub use point::Points;
pub use report::{Report, Spread};
pub use visibility::Visibility;

pub(super) use blockers::Blockers;
pub(super) use visibility::{End, kernel, lattice};

use self::enforce::{Enforce, Repair};
use super::RadiosityError;
use super::matrix::FactorMatrix;
use super::patches::Patches;
use crate::scene::{Scene, rays};

/// A way to find the view factors of a scene.
pub trait ViewFactors: fmt::Debug + Sync {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// Whether what lies between patches is seen.
    fn sees_what_is_between(&self) -> bool {
        true
    }

    /// All F_ij, row by row.
    fn find(&self, scene: &Scene, patches: &Patches) -> Result<Found, RadiosityError>;
}

/// View factors as a method has found them.
#[derive(Clone, Debug)]
pub struct Found {
    /// F_ij, row by row.
    pub values: Vec<f64>,
    /// Of each row the square root of the mean square error of its factors, as the method judges it.
    pub row_errors: Vec<f64>,
    /// Rays that were cast.
    pub rays: u64,
}

/// The most memory that a matrix may take unless more is allowed: 2 GiB, 16 384 patches.
pub const MEMORY: u64 = 2 << 30;

/// View factors with their report, and what was changed if a law is enforced: the report is of what was found before.
///
/// Refuses a matrix of more than `memory` bytes before it is begun.
pub fn find(
    method: &dyn ViewFactors,
    scene: &Scene,
    patches: &Patches,
    enforce: Option<Enforce>,
    memory: u64,
) -> Result<(FactorMatrix, Report, Option<Repair>), RadiosityError> {
    let n = patches.all().len();
    let needed = FactorMatrix::bytes(n);
    if needed > memory {
        return Err(RadiosityError::Memory { patches: n, needed: needed >> 20, allowed: memory >> 20 });
    }
    let start = std::time::Instant::now();
    let mut found = method.find(scene, patches)?;
    let seconds = start.elapsed().as_secs_f64();
    let report = Report::new(method, patches, &found, seconds);
    let repair = enforce.map(|enforce| enforce.apply(scene, patches, &mut found.values));
    Ok((FactorMatrix::new(n, found.values)?, report, repair))
}

/// The number of rays that `work` casts on this thread, with its result.
fn counted<T>(work: impl FnOnce() -> T) -> (T, u64) {
    let before = rays::cast();
    let result = work();
    (result, rays::cast() - before)
}
