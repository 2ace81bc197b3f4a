//! The verdict sheet: checks of a BRDF that say what they found, and how large an error they would have caught.

pub mod broken;
#[cfg(test)]
mod calibration;
mod check;
mod chi2;
mod claim;
mod consistency;
pub(crate) mod convergence;
mod draws;
mod energy;
mod furnace;
mod laws;
mod mass;
pub(crate) mod power;
mod suite;
mod uniformity;

pub use check::{Check, Outcome, Sheet};
pub(crate) use suite::judge;
pub use suite::{CHECKS, Effort, Suite, suite};
