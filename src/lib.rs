//! Numerics of BRDFs and of the rendering equation.

pub mod bsdf;
pub mod cli;
pub mod integrate;
pub mod math;
pub mod report;
pub mod sampling;
pub mod validate;

pub use glam;
