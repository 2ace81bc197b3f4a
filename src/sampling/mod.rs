//! Random streams and the maps from the unit square to directions, each with density and inverse.

pub mod discrete;
pub mod filter;
pub mod points;
pub mod sampler;
pub mod solid_angle;
pub mod stream;
pub mod tabulated;
pub mod visible_normals;
pub mod warp;
