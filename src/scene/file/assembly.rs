//! What formats of geometry leave open: a view of the whole, and light.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::Notes;
use super::error::{Place, SceneError};
use crate::math::color::Rgb;
use crate::sampling::filter::Filter;
use crate::scene::camera::{Camera, Projection};
use crate::scene::description::{FilmSettings, RenderSettings, SceneDescription};
use crate::scene::light::Light;
use crate::scene::material::Material;
use crate::scene::shape::{Geometry, Shape};

/// The triangles of a scene, copies included: some ten gigabytes.
pub(super) const MOST_TRIANGLES: usize = 1 << 27;
/// The full angle of the default view, along the shorter side of the image.
const FOV_DEG: f64 = 40.0;
/// How much wider than the scene the view is.
const MARGIN: f64 = 1.05;

/// The parts of a scene that a file gives.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) materials: Vec<Material>,
    pub(super) shapes: Vec<Shape>,
    pub(super) lights: Vec<Light>,
    /// The camera, and width over height of its image.
    pub(super) camera: Option<(Camera, f64)>,
}

impl Parts {
    /// The scene: without a camera seen from +z with +y up, from where its bounds just fit; without light in constant
    /// radiance 1, of which a warning tells. The image has 512 pixels on its longer side.
    pub(super) fn into_scene(self, path: &Path, notes: &Notes) -> Result<SceneDescription, SceneError> {
        let Self { materials, shapes, mut lights, camera } = self;
        let place = Place::whole(path);
        if shapes.is_empty() {
            let allowed = "a scene with surfaces".into();
            return Err(SceneError::Missing { place, what: "a surface".into(), allowed });
        }
        let shines = |shape: &Shape| shape.emission.is_some_and(|radiance| !radiance.is_black());
        if lights.is_empty() && !shapes.iter().any(shines) {
            notes.warn(format!("{place}: there is no light; radiance 1 comes from everywhere"));
            lights.push(Light::Constant { radiance: Rgb::WHITE });
        }
        let (camera, aspect) = if let Some(given) = camera {
            given
        } else {
            notes.warn(format!("{place}: there is no camera; the whole is seen from +z, with +y up"));
            (view_of_all(&shapes, &place)?, 1.0)
        };
        let longer = 512.0;
        let (width, height) = if aspect >= 1.0 { (longer, longer / aspect) } else { (longer * aspect, longer) };
        let pixels = |size: f64| (size.round() as usize).max(1);
        let film = FilmSettings { width: pixels(width), height: pixels(height), filter: Filter::BOX };
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(SceneDescription { name, camera, film, render: RenderSettings::default(), materials, shapes, lights })
    }
}

/// A camera that sees all meshes.
fn view_of_all(shapes: &[Shape], place: &Place) -> Result<Camera, SceneError> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for shape in shapes {
        if let Geometry::Mesh(mesh) = &shape.geometry {
            for &p in mesh.positions() {
                (low, high) = (low.min(p), high.max(p));
            }
        }
    }
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let tan = (0.5 * FOV_DEG.to_radians()).tan();
    let across = half.x.max(half.y).max(0.5 * half.z);
    let distance = half.z + MARGIN * across / tan;
    let eye = centre + DVec3::Z * distance;
    if !(eye.is_finite() && distance > 0.0) {
        return Err(SceneError::Value {
            place: place.clone(),
            what: "the extent of the scene".into(),
            given: format!("{low} to {high}"),
            allowed: "finite, and more than a point".into(),
        });
    }
    // It looks along −z, and +x is to the right.
    let axes = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
    let to_world = DAffine3::from_mat3_translation(axes, eye);
    Ok(Camera { to_world, projection: Projection::Perspective { tan_half_x: tan } })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::scene::mesh::Mesh;
    use glam::DVec2;

    #[test]
    fn the_whole_is_seen() {
        let corners = [DVec3::new(-3.0, 1.0, 5.0), DVec3::new(9.0, 1.5, 6.0), DVec3::new(0.0, 30.0, 4.0)];
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let geometry = Geometry::Mesh(Arc::new(mesh));
        let shape = Shape { name: "t".into(), geometry, flip_normals: false, material: 0, emission: None };
        let notes = Notes::new(false);
        let parts = Parts { shapes: vec![shape], ..Parts::default() };
        let scene = parts.into_scene(Path::new("t.obj"), &notes).unwrap();
        assert_eq!((scene.lights.len(), notes.into_warnings().len()), (1, 2));
        // The picture's edges are outside the mesh on every side, and x grows to the right.
        for p in corners {
            let (left, right) = (scene.camera.ray(DVec2::new(0.0, 0.5), 1.0, DVec2::ZERO), DVec2::new(1.0, 0.0));
            let right = scene.camera.ray(right, 1.0, DVec2::ZERO);
            let at = |ray: &crate::scene::Ray| ray.at((p.z - ray.origin.z) / ray.dir.z);
            assert!(at(&left).x < p.x && p.x < at(&right).x && p.y < at(&right).y, "{p}");
        }
    }
}
