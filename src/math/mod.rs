//! Geometry, special functions, sums and deterministic quadrature: everything that knows nothing of light.

pub mod chart;
pub mod color;
pub mod cubature;
pub mod frame;
pub mod power_law;
pub mod quadrature;
pub mod special;
pub mod spectrum;
pub mod sphere;
pub mod sum;
