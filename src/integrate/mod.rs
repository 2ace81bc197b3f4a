//! Integrals of BRDFs over directions: certified by quadrature, estimated by Monte Carlo.

mod convergence;
mod dirac;
mod half;
mod hemisphere;
mod monte_carlo;

pub use convergence::{RateFit, RatePoint, fit_rate};
pub use dirac::{DiracLobe, dirac_lobes, way_back};
pub use half::{Half, is_two_faced};
pub use hemisphere::{Hemisphere, Integral, Side, hints, is_isotropic};
pub use monte_carlo::Estimate;
