//! What the built-in scenes are made of.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::math::color::Rgb;
use crate::sampling::filter::Filter;
use crate::scene::{Camera, FilmSettings, Geometry, Light, Material, Mesh, RenderSettings, SceneDescription, Shape};

/// A scene with a square image and a box filter that says nothing about how to render it.
pub(super) fn scene(name: &str, camera: Camera, materials: Vec<Material>, shapes: Vec<Shape>) -> SceneDescription {
    SceneDescription {
        name: name.into(),
        camera,
        film: FilmSettings { width: 512, height: 512, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials,
        shapes,
        lights: Vec::<Light>::new(),
    }
}

/// A surface that does not emit, as it is defined.
pub(super) fn shape(name: &str, geometry: Geometry, material: usize) -> Shape {
    Shape { name: name.into(), geometry, flip_normals: false, material, emission: None }
}

/// The same, emitting this radiance from its outside.
pub(super) fn emitting(shape: Shape, radiance: Rgb) -> Shape {
    Shape { emission: Some(radiance), ..shape }
}

/// The same, inside out.
pub(super) fn inside_out(shape: Shape) -> Shape {
    Shape { flip_normals: true, ..shape }
}

/// Four-cornered faces, each counter-clockwise seen from outside and cut along the diagonal from its first corner.
pub(super) fn faces(quads: &[[DVec3; 4]]) -> Geometry {
    let positions = quads.iter().flatten().copied().collect();
    let first = (0..quads.len() as u32).map(|i| 4 * i);
    let triangles = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
    // The corners are literals of this crate or finite parameters, and every index is one of theirs.
    Geometry::Mesh(Arc::new(Mesh::new(positions, triangles).unwrap_or_default()))
}

/// The map from the unit shapes to `centre`, with half sides along the columns of `axes`.
pub(super) fn placed(centre: DVec3, axes: [DVec3; 3]) -> glam::DAffine3 {
    glam::DAffine3::from_mat3_translation(DMat3::from_cols(axes[0], axes[1], axes[2]), centre)
}
