//! Radiosity: the rendering equation of diffuse surfaces as a system of linear equations between patches.

pub mod face;
pub mod factors;
pub mod form;
pub mod hierarchical;
pub mod matrix;
pub mod model;
pub mod patch;
pub mod patches;
pub mod polygon;
pub mod solution;
pub mod solve;
pub mod surface_light;
pub mod system;

mod adaptive;
mod contact;
mod error;
mod locator;
mod reflectance;

pub use error::RadiosityError;
