//! Patches: the pieces of surface on each of which radiosity is one number per channel.

use glam::{DVec2, DVec3};

use super::face::Surface;
use super::polygon::Polygon;
use crate::math::color::Rgb;

/// The shape of a patch.
#[derive(Clone, Debug)]
pub enum Form {
    /// A convex plane polygon.
    Flat(Polygon),
    /// A part of a curved surface. It may see itself.
    Curved(Curved),
}

/// The part of a curved surface that a rectangle of the unit square covers, uniformly in area.
#[derive(Clone, Copy, Debug)]
pub struct Curved {
    pub(super) surface: Surface,
    /// Lower corner of the rectangle.
    pub(super) from: DVec2,
    /// Its size.
    pub(super) size: DVec2,
}

impl Form {
    /// The point of a `u` in [0, 1)², uniformly in area, and the normal there.
    pub fn at(&self, u: DVec2) -> (DVec3, DVec3) {
        match self {
            Self::Flat(polygon) => (polygon.sample(u), polygon.normal()),
            Self::Curved(Curved { surface, from, size }) => surface.at(*from + *size * u),
        }
    }

    /// A point in its middle.
    pub fn centre(&self) -> DVec3 {
        match self {
            Self::Flat(polygon) => polygon.centroid(),
            Self::Curved(_) => self.at(DVec2::splat(0.5)).0,
        }
    }

    /// The polygon, if it is one.
    pub fn polygon(&self) -> Option<&Polygon> {
        match self {
            Self::Flat(polygon) => Some(polygon),
            Self::Curved(_) => None,
        }
    }
}

/// A patch.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Number of the shape that it is part of.
    pub shape: usize,
    /// Number of the face that it is part of.
    pub face: usize,
    /// Its shape.
    pub form: Form,
    /// Its area \[m²\].
    pub area: f64,
    /// Reflectance, in [0, 1).
    pub reflectance: Rgb,
    /// Radiosity emitted [W/m²].
    pub emission: Rgb,
}
