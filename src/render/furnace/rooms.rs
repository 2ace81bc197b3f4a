//! The rooms of the checks, and rays into them.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::math::color::Rgb;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::sampling::filter::Filter;
use crate::sampling::warp::uniform_sphere;
use crate::scene::builtin::builtin;
use crate::scene::{
    Camera, FilmSettings, Geometry, Light, Material, Ray, RenderSettings, Scene, SceneDescription, Shape,
};

pub(super) const STRATEGIES: [Strategy; 4] = [Strategy::Mis, Strategy::Direct, Strategy::Bsdf, Strategy::RandomConnect];

/// Settings that end paths at `bounces` reflections and not before; without a limit by the albedo.
pub(super) fn settings(strategy: Strategy, bounces: Option<u32>) -> PathTracer {
    let roulette = if bounces.is_some() { Roulette::Off } else { Roulette::Albedo };
    PathTracer { strategy, bounces, roulette, ..PathTracer::default() }
}

/// How the number of reflections is spelled in a sentence.
pub(super) fn reflections(bounces: Option<u32>) -> String {
    bounces.map_or_else(|| "any number of reflections".into(), |r| format!("{r} reflections"))
}

/// A built-in scene whose name and parameters are literals of this crate.
pub(super) fn named(name: &str, params: &[(&str, &str)]) -> Scene {
    let params: Vec<_> = params.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
    match builtin(name, &params).map(|scene| scene.map(Scene::new)) {
        Some(Ok(Ok(scene))) => scene,
        other => panic!("{name} is not as it is used here: {:?}", other.map(|scene| scene.map(|_| ()))),
    }
}

/// A scene of parts that are literals of this crate, with a camera that nobody looks through.
pub(super) fn scene(materials: Vec<Material>, shapes: Vec<Shape>, lights: Vec<Light>) -> Scene {
    let description = SceneDescription {
        name: "furnace".into(),
        camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0),
        film: FilmSettings { width: 1, height: 1, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials,
        shapes,
        lights,
    };
    Scene::new(description).unwrap_or_else(|error| panic!("a room is wrong: {error}"))
}

pub(super) fn shape(name: &str, geometry: Geometry, material: usize, radiance: f64) -> Shape {
    let emission = (radiance > 0.0).then(|| Rgb::grey(radiance));
    Shape { name: name.into(), geometry, flip_normals: false, material, emission }
}

pub(super) fn inside_out(shape: Shape) -> Shape {
    Shape { flip_normals: true, ..shape }
}

pub(super) fn diffuse(rho: f64) -> Material {
    Material::diffuse("diffuse", Rgb::grey(rho).into())
}

/// The map of the unit shapes to `centre`, scaled, with +z to `normal`.
pub(super) fn facing(centre: DVec3, normal: DVec3, scale: f64) -> DAffine3 {
    let x = normal.any_orthonormal_vector();
    DAffine3::from_mat3_translation(DMat3::from_cols(x, normal.cross(x), normal) * scale, centre)
}

/// A uniform direction from `eye`.
pub(super) fn anywhere(eye: DVec3, u: DVec2) -> Ray {
    Ray::new(eye, uniform_sphere(u))
}

/// A ray from `eye` to a uniform point of a parallelogram.
pub(super) fn towards(eye: DVec3, (corner, x, y): (DVec3, DVec3, DVec3), u: DVec2) -> Ray {
    Ray::new(eye, (corner + x * u.x + y * u.y - eye).normalize())
}
