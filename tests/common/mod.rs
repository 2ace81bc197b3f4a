//! What tests of closed forms share: scenes built in code, rays at a point, and one level for all comparisons of a test.

mod family;

use std::f64::consts::{PI, TAU};

use whitefurnace::glam::{DAffine3, DMat3, DVec2, DVec3};
use whitefurnace::integrate::Estimate;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::Radiance;
use whitefurnace::render::path::{PathTracer, Roulette, Strategy};
use whitefurnace::render::probe::Probe;
use whitefurnace::sampling::filter::Filter;
use whitefurnace::sampling::sampler::Sampler;
use whitefurnace::scene::builtin::builtin;
use whitefurnace::scene::{
    Camera, FilmSettings, Geometry, Light, Material, Ray, RenderSettings, Scene, SceneDescription, Shape,
};

pub(crate) use family::Family;

pub(crate) const STRATEGIES: [Strategy; 4] = [Strategy::Mis, Strategy::Direct, Strategy::Bsdf, Strategy::RandomConnect];

/// A path tracer of this strategy that ends after `bounces` reflections, and not before where there is a limit.
pub(crate) fn tracer(strategy: Strategy, bounces: Option<u32>) -> PathTracer {
    let roulette = if bounces.is_some() { Roulette::Off } else { Roulette::Albedo };
    PathTracer { strategy, bounces, roulette, ..PathTracer::default() }
}

/// The built-in scene of this name, with parameters as `name=value`.
pub(crate) fn named(name: &str, params: &[&str]) -> Scene {
    let pairs: Vec<_> = params.iter().map(|p| p.split_once('=').expect("name=value")).collect();
    let pairs: Vec<_> = pairs.iter().map(|(key, value)| ((*key).to_string(), (*value).to_string())).collect();
    Scene::new(builtin(name, &pairs).expect("a known scene").expect("good parameters")).expect("a sound scene")
}

/// A scene of these parts, with a camera that no test looks through.
pub(crate) fn scene(materials: Vec<Material>, shapes: Vec<Shape>, lights: Vec<Light>) -> Scene {
    Scene::new(SceneDescription {
        name: "test".into(),
        camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0),
        film: FilmSettings { width: 1, height: 1, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials,
        shapes,
        lights,
    })
    .expect("a sound scene")
}

pub(crate) fn shape(name: &str, geometry: Geometry, material: usize, emission: Option<f64>) -> Shape {
    Shape { name: name.into(), geometry, flip_normals: false, material, emission: emission.map(Rgb::grey) }
}

pub(crate) fn diffuse(rho: f64) -> Material {
    Material::diffuse("diffuse", Rgb::grey(rho).into())
}

/// The map that takes the unit shapes to `centre`, scaled, with +z to `normal`.
pub(crate) fn facing(centre: DVec3, normal: DVec3, scale: f64) -> DAffine3 {
    let x = normal.any_orthonormal_vector();
    DAffine3::from_mat3_translation(DMat3::from_cols(x, normal.cross(x), normal) * scale, centre)
}

/// A ray that meets the surface at `p`, whose normal is `n`, from a distance of `from` and 20 degrees off the normal.
pub(crate) fn onto(p: DVec3, n: DVec3, from: f64) -> Ray {
    let dir = (n + 0.36 * n.any_orthonormal_vector()).normalize();
    Ray::new(p + dir * from, -dir)
}

/// A ray within a closed room from `eye` to a uniform point of the parallelogram.
pub(crate) fn towards(eye: DVec3, corner: DVec3, x: DVec3, y: DVec3, u: DVec2) -> Ray {
    Ray::new(eye, (corner + x * u.x + y * u.y - eye).normalize())
}

/// A uniform direction.
pub(crate) fn anywhere(u: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * u.x;
    let (s, c) = (TAU * u.y).sin_cos();
    DVec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
}

/// π times the mean radiance of the first channel: the radiosity of a diffuse surface.
pub(crate) fn radiosity(
    number: u64,
    samples: u64,
    tracer: &dyn Radiance,
    scene: &Scene,
    ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
) -> Estimate {
    let [red, ..] = Probe { seed: 1, number, samples }.estimate(tracer, scene, ray);
    let estimate = Estimate::from(&red);
    Estimate { mean: PI * estimate.mean, std_err: PI * estimate.std_err, n: estimate.n }
}
