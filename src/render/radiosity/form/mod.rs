//! View factors without anything in between: the geometry of the exchange of light between two diffuse surfaces.
//!
//! All kernels give the *exchange* A_a F_ab = A_b F_ba \[m²\], which has no direction: F_ab is the share of what leaves
//! the front of a that reaches the front of b. (That a kernel is symmetric is therefore no evidence that it is right.)

pub mod contour;
mod exchange;
mod gauss;
pub mod hemicube;
pub mod point;
#[cfg(test)]
mod published;
pub mod quadrature;
pub mod rectangles;

pub use exchange::{Route, TOLERANCE, exchange, of_pair};
pub use quadrature::Quadrature;
