//! What radiosity cannot be computed of.

use thiserror::Error;

use crate::math::color::Rgb;

/// Why a scene has no solution, or cannot be asked for one.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RadiosityError {
    /// There is nothing to be lit.
    #[error("the scene has no surface of any area; radiosity needs at least one")]
    NoSurface,
    /// A material is not diffuse.
    #[error(
        "material {material} of shape {shape} is not diffuse; radiosity takes Lambertian surfaces alone, or, with the diffuse \
         approximation, the albedo of others"
    )]
    NotDiffuse {
        /// Its name.
        material: String,
        /// A shape made of it.
        shape: String,
    },
    /// A material is there in part only.
    #[error("material {material} of shape {shape} is masked; radiosity takes surfaces that are there everywhere")]
    Masked {
        /// Its name.
        material: String,
        /// A shape made of it.
        shape: String,
    },
    /// Light would never end.
    #[error("material {material} of shape {shape} reflects {reflectance}; allowed is each channel below 1")]
    TooReflective {
        /// Its name.
        material: String,
        /// A shape made of it.
        shape: String,
        /// Its reflectance.
        reflectance: Rgb,
    },
    /// Two surfaces lie in one place.
    #[error("shapes {first} and {second} coincide and face the same way, so that nothing says which of them is seen")]
    Coincident {
        /// Name of the one.
        first: String,
        /// Name of the other.
        second: String,
    },
    /// A light is not a surface.
    #[error("the scene has a light that is not a surface; radiosity takes surfaces that emit")]
    NotASurface,
    /// Too many patches.
    #[error("{patches} patches; allowed are 1 to {allowed}")]
    TooMany {
        /// How many are asked for, or would be needed.
        patches: usize,
        /// The largest number.
        allowed: usize,
    },
    /// Patches of no size.
    #[error("patches of area {0}; allowed is a number > 0")]
    Area(f64),
    /// An error that cannot be asked for.
    #[error("a relative error of {0}; allowed is a number above 0 and below 1")]
    Error(f64),
    /// Too many links.
    #[error(
        "the links of this accuracy take more than the {allowed} MiB that are allowed. A larger error, fewer patches or more \
         memory would do"
    )]
    Links {
        /// MiB.
        allowed: u64,
    },
    /// Light without end.
    #[error(
        "the links reflect ever more light: they are too rough for reflectances near 1. A smaller error, or another seed, would do"
    )]
    Endless,
    /// The matrix does not fit.
    #[error(
        "the view factors of {patches} patches take {needed} MiB; allowed are {allowed} MiB. Fewer patches, more memory, or \
         the hierarchical method would do"
    )]
    Memory {
        /// How many patches there are.
        patches: usize,
        /// Mebibytes that they take.
        needed: u64,
        /// The limit.
        allowed: u64,
    },
    /// The equations are none.
    #[error(transparent)]
    System(#[from] super::system::SystemError),
    /// The solver cannot do what it is asked.
    #[error(transparent)]
    Solve(#[from] super::solve::SolveError),
    /// View factors of this kind do not exist for every pair.
    #[error("view factors by {method}: {reason}")]
    NotApplicable {
        /// Name of the method.
        method: &'static str,
        /// What is in the way, and what is allowed.
        reason: String,
    },
}
