//! Why there is no photon map.

use thiserror::Error;

/// What a photon map cannot be made of, or asked for.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PhotonError {
    /// Nothing emits.
    #[error("the scene has no light; photons need one that emits")]
    NoLight,
    /// No photon was asked for.
    #[error("0 photons; allowed is 1 or more")]
    NoPhotons,
    /// Nothing was stored.
    #[error(
        "none of {emitted} photons reached a surface that stores it in the {map} map; more photons, or another map, would do"
    )]
    NothingReached {
        /// Photons emitted.
        emitted: u64,
        /// Name of the map.
        map: &'static str,
    },
    /// Fewer photons than neighbours.
    #[error("k = {k} neighbours of {stored} stored photons; allowed are no more than there are")]
    TooFew {
        /// Neighbours asked for.
        k: usize,
        /// Photons there are.
        stored: usize,
    },
    /// A number of neighbours that says nothing.
    #[error("k = {k} with the estimator {estimator}, which leaves out the last; allowed is {least} or more")]
    NoNeighbours {
        /// Neighbours asked for.
        k: usize,
        /// Name of the estimator.
        estimator: &'static str,
        /// The least.
        least: usize,
    },
    /// A radius that is none.
    #[error("a radius of {0}; allowed is a number > 0")]
    Radius(f64),
    /// An exponent that is none.
    #[error("an exponent of {0}; allowed is a number above 0 and below 1")]
    Exponent(f64),
    /// A number of rays that is none.
    #[error("0 rays of final gather; allowed is 1 or more")]
    NoRays,
    /// More than fits.
    #[error("more than {most} photons would be stored; fewer photons would do, or surfaces that absorb more")]
    TooMany {
        /// The largest number.
        most: usize,
    },
}
