//! Lights that are not surfaces.

use glam::{DMat3, DVec3};
use std::sync::Arc;

use crate::math::color::Rgb;

/// A light that is not the surface of a shape.
#[derive(Clone, Debug)]
pub enum Light {
    /// A point that shines alike in all directions.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity [W/sr].
        intensity: Rgb,
    },
    /// A point that shines into a cone: the full intensity up to `beam`, falling linearly in the angle to 0 at `cutoff`.
    Spot {
        /// Where it is.
        position: DVec3,
        /// Unit vector along the axis.
        direction: DVec3,
        /// Radiant intensity on the axis [W/sr].
        intensity: Rgb,
        /// Half angle of the bright cone \[rad\].
        beam: f64,
        /// Half angle beyond which nothing shines \[rad\], ≥ `beam`.
        cutoff: f64,
    },
    /// Parallel light from infinitely far.
    Directional {
        /// Unit vector along which the light travels.
        direction: DVec3,
        /// Irradiance of a surface perpendicular to it [W/m²].
        irradiance: Rgb,
    },
    /// The same radiance from everywhere.
    Constant {
        /// [W/(sr m²)].
        radiance: Rgb,
    },
    /// A picture of radiance from every direction.
    Environment(EnvironmentMap),
}

/// Radiance from every direction in the latitude-longitude format.
///
/// In its own space +y is up: row 0 is the pole +y, and the azimuth of column u ∈ [0, 1) is measured so that the
/// direction is (sin 2πu sin θ, cos θ, −cos 2πu sin θ), θ = π v, as in Mitsuba.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    /// Linear radiance, rows from the top.
    pub pixels: Arc<Vec<[f32; 3]>>,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rotation from the map's space to the world.
    pub to_world: DMat3,
    /// Multiplies the pixels.
    pub scale: f64,
}
