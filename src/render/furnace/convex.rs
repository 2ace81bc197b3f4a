//! `albedo_…`: a sphere of the model in constant light of radiance 1.
//!
//! The sphere is convex: every ray that leaves it finds the light. The radiance along a ray that meets it at the cosine μ
//! is then the directional albedo ∫ f cos dω, which the hemisphere integrator knows to many digits.

use std::sync::Arc;

use glam::DVec3;

use super::compare::{self, Comparison, Plan};
use super::rooms::{STRATEGIES, scene, settings, shape};
use crate::bsdf::{Bsdf, Lobes};
use crate::integrate::{Hemisphere, Integral, Side, is_isotropic};
use crate::math::color::Rgb;
use crate::math::sphere::direction_mu;
use crate::render::path::Strategy;
use crate::scene::{Geometry, Light, Material, Ray, Scene};
use crate::validate::{Check, Outcome};

/// Cosines of incidence, and azimuths for models that are not isotropic.
const COSINES: [f64; 5] = [1.0, 0.8, 0.5, 0.25, 0.1];
const AZIMUTHS: [f64; 2] = [0.3, 1.9];

fn sphere_of(model: &Arc<dyn Bsdf>) -> Scene {
    let ball = shape("ball", Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }, 0, 0.0);
    let light = Light::Constant { radiance: Rgb::WHITE };
    scene(vec![Material::uniform("subject", Box::new(model.clone()))], vec![ball], vec![light])
}

/// The ray that meets the sphere, at a point of no special place, from the local direction `wo`.
fn ray_from(scene: &Scene, wo: DVec3) -> Option<Ray> {
    let n = DVec3::new(0.6, -0.48, 0.64);
    let surface = scene.intersect(&Ray::new(2.0 * n, -n))?;
    let dir = surface.frame.to_world(wo);
    Some(Ray::new(surface.p + dir, -dir))
}

fn strategy_of(name: &str) -> Strategy {
    match name {
        "albedo_bsdf" => Strategy::Bsdf,
        "albedo_direct" => Strategy::Direct,
        "albedo_mis" => Strategy::Mis,
        _ => STRATEGIES[3],
    }
}

pub(super) fn checks(model: &Arc<dyn Bsdf>, names: &[&'static str], subject: u64, plan: &Plan) -> Vec<Check> {
    let undecided =
        |why: &str| -> Vec<Check> { names.iter().map(|&name| Check::new(name).inconclusive_here(why)).collect() };
    let lobes = model.lobes();
    if lobes.contains(Lobes::TRANSMIT) || lobes.contains(Lobes::DIRAC) {
        return undecided("the model transmits or has a Dirac lobe: a sphere of it does not show its albedo");
    }
    let azimuths = if is_isotropic(&**model) { &AZIMUTHS[..1] } else { &AZIMUTHS[..] };
    let views: Vec<DVec3> =
        COSINES.iter().flat_map(|&mu| azimuths.iter().map(move |&phi| direction_mu(mu, phi))).collect();
    let hemisphere = Hemisphere::default();
    let exact: Vec<Integral> = views.iter().map(|&wo| hemisphere.albedo(model, Side::Eye, wo)).collect();
    if exact.iter().all(|albedo| albedo.value.is_black()) {
        return undecided("the model is black: nothing can be compared");
    }
    if let Some(at) = exact.iter().position(|albedo| !albedo.resolved) {
        let why = "the integrator did not resolve the albedo, so there is nothing to compare with";
        return names.iter().map(|&name| Check::new(name).inconclusive(views[at], why)).collect();
    }
    let scene = sphere_of(model);
    names.iter().map(|&name| check(name, subject, plan, &scene, &views, &exact)).collect()
}

fn check(name: &'static str, subject: u64, plan: &Plan, scene: &Scene, views: &[DVec3], exact: &[Integral]) -> Check {
    let strategy = strategy_of(name);
    // One more than the one reflection that there is: a second must find nothing.
    let tracer = settings(strategy, Some(2));
    let mut all: Vec<(DVec3, Comparison)> = Vec::new();
    for (i, (&wo, albedo)) in views.iter().zip(exact).enumerate() {
        let Some(ray) = ray_from(scene, wo) else { return Check::new(name) };
        let number = (subject << 16) + 2000 + 100 * strategy as u64 + i as u64;
        let found = plan.estimate(number, &tracer, scene, &|_| ray);
        for ((found, value), colour) in found.iter().zip(albedo.value.to_array()).zip(["red", "green", "blue"]) {
            let label = format!("{strategy:?}, μ = {}, {colour}", wo.z);
            all.push((wo, Comparison::with_exact(label, found, value, albedo.error)));
        }
    }
    let comparisons: Vec<Comparison> = all.iter().map(|(_, comparison)| comparison.clone()).collect();
    let mut check = compare::check(name, &comparisons, plan.share);
    if check.outcome == Outcome::Pass {
        let worst = all.iter().max_by(|a, b| a.1.z().abs().total_cmp(&b.1.z().abs()));
        check.worst = worst.map(|(wo, _)| (*wo, *wo));
    }
    check
}
