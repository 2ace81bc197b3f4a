//! What cannot be a radiosity system, and why.

use super::dominance::Dominance;

/// Why a system is refused. Patches and channels are counted from 0; channels are red, green, blue.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// A list of another length than the patches ask for.
    #[error("{found} {what} were given, {expected} are needed")]
    Length {
        /// What is listed.
        what: &'static str,
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// There is nothing to solve.
    #[error("there are no patches")]
    Empty,
    /// A view factor that is no share.
    #[error("the view factor from patch {row} to patch {column} is {value}: a number in [0, 1] is allowed")]
    Factor {
        /// The patch that sends.
        row: usize,
        /// The patch that receives.
        column: usize,
        /// The factor.
        value: f64,
    },
    /// An area that is none.
    #[error("the area of patch {patch} is {value}: a finite number above 0 is allowed")]
    Area {
        /// The patch.
        patch: usize,
        /// Its area.
        value: f64,
    },
    /// A reflectance with which light would not die out, or that is no share.
    #[error("the reflectance of patch {patch} is {value} in channel {channel}: a number in [0, 1) is allowed")]
    Reflectance {
        /// The patch.
        patch: usize,
        /// The channel.
        channel: usize,
        /// Its reflectance.
        value: f64,
    },
    /// An emission that is none.
    #[error("the emission of patch {patch} is {value} in channel {channel}: a finite number of at least 0 is allowed")]
    Emission {
        /// The patch.
        patch: usize,
        /// The channel.
        channel: usize,
        /// Its emission.
        value: f64,
    },
    /// A patch that sends out more than it has.
    #[error("the view factors of patch {patch} sum to {value}: at most {allowed} is allowed")]
    RowSum {
        /// The patch.
        patch: usize,
        /// The sum of its factors.
        value: f64,
        /// The largest sum that is allowed.
        allowed: f64,
    },
    /// Reflectance and row sum, each allowed by itself, together bring light back undiminished.
    #[error("{0}")]
    NotDominant(Dominance),
}
