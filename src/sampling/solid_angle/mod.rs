//! Directions to a surface, uniform in solid angle as seen from a point.

mod rectangle;
mod triangle;

pub use rectangle::SphericalRectangle;
pub use triangle::{SphericalTriangle, triangle_solid_angle};
