//! Rendering: estimates of radiance, and the film that gathers them.

pub mod film;
pub mod filter;
