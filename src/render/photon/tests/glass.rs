//! Light through glass against paths.

use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::{build, floor, grey, quad, shape, shoot};
use crate::bsdf::Dielectric;
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::render::photon::gather::FinalGather;
use crate::render::photon::map::{Around, Gather};
use crate::render::photon::shoot::Shooting;
use crate::render::photon::{History, Kept};
use crate::sampling::sampler::{Independent, Sampler};
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::{Geometry, Light, Material, Ray, Scene, Shape};

#[test]
fn glass_makes_caustics_and_stores_nothing() {
    let ball = shape("ball", Geometry::Sphere { centre: DVec3::new(0.5, 0.5, 0.35), radius: 0.2 }, 1);
    let glass = Material::uniform("glass", Box::new(Dielectric::new(1.5).unwrap()));
    let (position, direction) = (DVec3::new(0.5, 0.5, 1.5), -DVec3::Z);
    // Half of the cone meets the ball.
    let lights = vec![Light::Spot { position, direction, intensity: Rgb::WHITE, beam: 0.25, cutoff: 0.25 }];
    let scene = build(vec![grey(0.6), glass], vec![floor(0), ball], lights);
    let all = shoot(&scene, 50_000);
    assert!(all.photons.iter().all(|photon| photon.shape == 0));
    let count = |history| all.photons.iter().filter(|photon| photon.history == history).count();
    for (kept, history) in [(Kept::Caustic, History::Caustic), (Kept::Indirect, History::Indirect)] {
        let shot = Shooting { photons: 50_000, kept, ..Shooting::default() }.shoot(&scene).unwrap();
        assert_eq!(shot.photons.len(), count(history));
        assert!(shot.photons.iter().all(|photon| photon.history == history && photon.bounces > 0));
    }
    assert!(count(History::Caustic) > 1000 && count(History::Direct) > 1000);
    // Under the ball there is no direct light: the spot of the lens is caustic alone.
    let middle = all.photons.iter().filter(|p| p.p.truncate().distance(DVec2::splat(0.5)) < 0.02);
    assert!(middle.clone().count() > 100 && middle.clone().all(|p| p.history != History::Direct));
}

/// A floor, a light above it, and something of glass between or around, with what is known of neither map nor path.
fn under_glass(rho: f64, geometry: Geometry) -> Scene {
    let glass = Material::uniform("glass", Box::new(Dielectric::new(1.5).unwrap()));
    let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    let light = Shape { emission: Some(Rgb::WHITE), ..shape("light", quad(square), 0) };
    build(vec![grey(rho), glass], vec![floor(0), shape("glass", geometry, 1), light], vec![])
}

fn cube(centre: DVec3, half: DVec3) -> Geometry {
    Geometry::Cube { to_world: DAffine3::from_scale_rotation_translation(half, DQuat::IDENTITY, centre) }
}

/// The flux that photons bring to the floor through glass, in units of basic radiance, and the same by paths that find the
/// light by chance.
fn through_glass(scene: &Scene) -> (Moments, Moments) {
    let mut photons = Moments::default();
    for seed in 0..20 {
        let shooting = Shooting { photons: 20_000, kept: Kept::Caustic, seed, ..Shooting::default() };
        let stored = shooting.shoot(scene).unwrap().photons;
        photons.add(stored.iter().filter(|p| p.shape == 0 && p.n.z > 0.0).map(|p| p.flux.mean() * p.basic).sum());
    }
    let tracer =
        PathTracer { strategy: Strategy::Bsdf, roulette: Roulette::Off, bounces: Some(50), ..PathTracer::default() };
    let (mut paths, mut sampler) = (Moments::default(), Independent::new(9));
    for sample in 0..300_000 {
        sampler.begin(0, sample);
        let (at, along) = (sampler.next_2d(), sampler.next_2d());
        let ray = Ray::new(at.extend(1e-9), cosine_hemisphere(along));
        let glass = scene.intersect(&ray).is_some_and(|met| met.shape == 1);
        // E = π times the mean of what arrives by the cosine; the floor's area is 1, and nothing else reflects.
        paths.add(if glass { PI * tracer.radiance(scene, ray, &mut sampler).mean() } else { 0.0 });
    }
    (photons, paths)
}

#[test]
fn light_through_glass_is_that_of_paths() {
    let slab = cube(DVec3::new(0.5, 0.5, 0.5), DVec3::new(0.4, 0.4, 0.1));
    let ball = Geometry::Sphere { centre: DVec3::new(0.5, 0.5, 0.4), radius: 0.3 };
    // The floor itself within the glass: flux is that of basic radiance times η², which is the law.
    let around = cube(DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.6, 0.6, 0.3));
    for (name, geometry) in [("slab", slab), ("ball", ball), ("around", around)] {
        let (photons, paths) = through_glass(&under_glass(0.0, geometry));
        let error = photons.std_err().hypot(paths.std_err());
        let gap = (photons.mean() - paths.mean()).abs();
        // 4 sigma with the error of the photons known from 20 maps.
        assert!(gap <= 4.0 * error, "{name}: photons {} paths {} ± {error}", photons.mean(), paths.mean());
        assert!(error < 0.02 * paths.mean(), "{name}: the test must see 1.5² and Fresnel's 4 %");
    }
}

#[test]
fn a_gather_past_glass_is_that_of_paths() {
    let ball = Geometry::Sphere { centre: DVec3::new(0.5, 0.5, 0.4), radius: 0.3 };
    let scene = under_glass(0.6, ball);
    // From above, past the light, and through the ball.
    let rays = |sampler: &mut Independent| {
        let at = sampler.next_2d() * 0.2 + 0.05;
        let from = DVec3::new(0.9, 0.95, 0.8);
        Ray::new(from, (at.extend(0.0) - from).normalize())
    };
    let mean = |light: &dyn Radiance, seed: u64, samples: u64| {
        let (mut moments, mut sampler) = (Moments::default(), Independent::new(seed));
        for sample in 0..samples {
            sampler.begin(1, sample);
            let ray = rays(&mut sampler);
            moments.add(light.radiance(&scene, ray, &mut sampler).mean());
        }
        moments
    };
    let paths = mean(&PathTracer::default(), 1, 200_000);
    // Without a limit the nearest of a caustic would be looked for where there is none.
    let around = Around::Nearest { k: 50, reach: 0.04 };
    let mut photons = Moments::default();
    for seed in 0..12 {
        let shot = Shooting { photons: 50_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
        let light = FinalGather::new(&scene, &shot.photons, Gather { around, ..Gather::default() }, 2, None).unwrap();
        photons.add(mean(&light, seed, 2000).mean());
    }
    let error = photons.std_err().hypot(paths.std_err());
    let gap = (photons.mean() - paths.mean()).abs();
    // 4 sigma of noise; a caustic in the 50 nearest photons is blurred, which moves light and loses none: 1 %.
    assert!(gap <= 4.0 * error + 0.01 * paths.mean(), "{} against {} ± {error}", photons.mean(), paths.mean());
}
