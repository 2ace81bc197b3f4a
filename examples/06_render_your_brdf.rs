//! Your BRDF in the path tracer: a sphere of it under a constant sky shows its albedo in every pixel.
//!
//! The same number comes from the deterministic integrator, which shares no line with the renderer but the model.
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::sync::atomic::AtomicBool;

use whitefurnace::glam::DVec2;
use whitefurnace::prelude::*;
use whitefurnace::render::progressive::render;

/// A matt ground with a bright rim, as velvet has.
fn velvet() -> FnBsdf<impl Fn(DVec3, DVec3) -> Rgb + Send + Sync> {
    FnBsdf::new("velvet", |wo: DVec3, wi: DVec3| {
        let rim = (1.0 - wo.z) * (1.0 - wi.z);
        if wo.z > 0.0 && wi.z > 0.0 { Rgb::new(0.1, 0.02, 0.05) + Rgb::grey(0.2 * rim) } else { Rgb::BLACK }
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::new(SceneDescription {
        name: "velvet".into(),
        camera: Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 25.0),
        film: FilmSettings { width: 64, height: 64, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials: vec![Material::uniform("velvet", Box::new(velvet()))],
        shapes: vec![Shape {
            name: "ball".into(),
            geometry: Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 },
            flip_normals: false,
            material: 0,
            emission: None,
        }],
        lights: vec![Light::Constant { radiance: Rgb::WHITE }],
    })?;
    let tracer = PathTracer { bounces: Some(1), ..PathTracer::default() };
    let sampler = SamplerKind::Independent.sampler(1, 256, 1);
    let job = Job { scene: &scene, radiance: &tracer, filter: &Filter::BOX, sampler: &sampler };
    let mut film = Film::new(64, 64);
    render(&job, &mut film, Stop::Samples(256), &AtomicBool::new(false), &mut |_, _| {});

    for x in [32_u32, 40, 48] {
        // The angle at the pixel's centre; over the pixel the albedo hardly varies.
        let ray = scene.camera_ray(DVec2::new(f64::from(x) + 0.5, 32.5), DVec2::ZERO);
        let surface = scene.intersect(&ray).ok_or("the ball is there")?;
        let wo = surface.frame.to_local(-ray.dir);
        let exact = Hemisphere::default().albedo(&velvet(), Side::Eye, wo).value;
        let (seen, error) = (film.mean(x as usize, 32), film.variance_of_mean(x as usize, 32).map(f64::sqrt));
        println!("pixel {x}, mu = {:.3}: rendered {seen} ± {error}, integrated {exact}", wo.z);
        let gap = (seen - exact).0.abs();
        assert!((gap - 5.0 * error.0 - 0.02 * exact.0).max_element() <= 0.0, "{seen} ± {error} against {exact}");
    }
    Ok(())
}
