//! Rendering: estimates of radiance, and the film that gathers them.

pub mod checkpoint;
pub mod film;
pub mod filter;
pub mod provenance;
