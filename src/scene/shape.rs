//! Shapes: a geometry, what it is made of, and what it emits.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::mesh::Mesh;
use crate::math::color::Rgb;

/// One surface of a scene.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its name in the scene; results per surface are reported under it.
    pub name: String,
    /// Where it is.
    pub geometry: Geometry,
    /// Turns the outside in: normals, and with them the side that emits.
    pub flip_normals: bool,
    /// Index of its material in the scene.
    pub material: usize,
    /// Radiance emitted by the outside [W/(sr m²)], or none.
    pub emission: Option<Rgb>,
}

/// The geometry of a shape, in world space.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// All points at a distance.
    Sphere {
        /// The centre.
        centre: DVec3,
        /// The distance, > 0.
        radius: f64,
    },
    /// The image of the unit disk of the xy-plane; its outside is +z. The map may not shear it out of round.
    Disk {
        /// From the unit disk to the world.
        to_world: DAffine3,
    },
    /// The image of \[−1, 1\]² in the xy-plane; its outside is +z, its texture coordinates run from (0, 0) to (1, 1).
    Rectangle {
        /// From the square to the world.
        to_world: DAffine3,
    },
    /// The image of \[−1, 1\]³.
    Cube {
        /// From the cube to the world.
        to_world: DAffine3,
    },
    /// The open tube of this radius around the segment from `from` to `to`.
    Cylinder {
        /// One end of the axis.
        from: DVec3,
        /// The other.
        to: DVec3,
        /// The distance from the axis, > 0.
        radius: f64,
    },
    /// Triangles.
    Mesh(Arc<Mesh>),
}
