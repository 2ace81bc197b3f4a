//! `albedo_…`: a surface of the model in constant light of radiance 1.
//!
//! The model covers a sphere, or, if it transmits, a disk. Both are convex: every ray that leaves finds the light. The
//! radiance along a ray that comes in at the cosine μ is then the directional albedo ∫ f |cos| dω, which the hemisphere
//! integrator knows to many digits.
//!
//! Light sampling draws from the whole sphere, and finds a lobe of solid angle Ω once in 4π/Ω samples. Where its spread,
//! known by quadrature, is too large for the number of samples, it is not asked.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::compare::{self, Comparison, Plan};
use super::rooms::{scene, settings, shape};
use crate::bsdf::{Bsdf, Lobes};
use crate::integrate::{Half, Hemisphere, Integral, Side, hints, is_isotropic};
use crate::math::color::Rgb;
use crate::math::sphere::direction_mu;
use crate::math::sum::Moments;
use crate::render::path::Strategy;
use crate::scene::{EnvironmentMap, Geometry, Light, Material, Ray, Scene};
use crate::validate::Check;

/// Cosines of incidence, and azimuths for models that are not isotropic.
const COSINES: [f64; 5] = [1.0, 0.8, 0.5, 0.25, 0.1];
const AZIMUTHS: [f64; 2] = [0.3, 1.9];
/// Largest relative standard error at which an estimate is compared: a lobe is then hit 16 times on average, and missed
/// altogether once in ten million runs.
const WORTH_COMPARING: f64 = 0.25;

/// A direction from which the surface is looked at, and what is known of it.
#[derive(Clone, Copy, Debug)]
struct View {
    wo: DVec3,
    albedo: Integral,
    /// Second moment of one connection; infinite where it is not known.
    second_moment: Rgb,
}

impl View {
    fn new(model: &dyn Bsdf, wo: DVec3) -> Self {
        let albedo = Hemisphere::default().albedo(model, Side::Eye, wo);
        // Two digits are enough to say what is worth comparing.
        let (coarse, hints) = (Hemisphere::with_tol(1e-2), hints(model, wo));
        let mut second_moment = Rgb::BLACK;
        for half in Half::all(model, wo) {
            let square = |v: DVec3| {
                let value = model.eval(wo, half.free(v)) * v.z;
                (value * value * (4.0 * PI)).to_array()
            };
            let (_, part) = coarse.over(&half, &hints, &square);
            second_moment += if part.resolved { Rgb::from(part.value) } else { Rgb::grey(f64::INFINITY) };
        }
        Self { wo, albedo, second_moment }
    }

    /// Whether `samples` of this strategy tell anything here.
    fn is_within_reach(&self, strategy: Strategy, samples: u64) -> bool {
        let connections = match strategy {
            Strategy::Bsdf | Strategy::Mis => return true,
            Strategy::Direct => 1.0,
            // One of two bounces connects, with twice the weight, or one of three past a Dirac lobe.
            Strategy::RandomConnect => 3.0,
        };
        let worth = WORTH_COMPARING * WORTH_COMPARING * samples as f64;
        let channels = self.albedo.value.to_array().into_iter().zip(self.second_moment.to_array());
        channels.into_iter().all(|(mean, square)| connections * square <= worth * mean * mean)
    }
}

/// A surface of the model and light that is 1 everywhere: a map of a single pixel, because multiple importance sampling
/// does not connect to a constant environment, and densities are to be tested.
fn surface_of(model: &Arc<dyn Bsdf>) -> Scene {
    let geometry = if model.lobes().contains(Lobes::TRANSMIT) {
        Geometry::Disk { to_world: DAffine3::IDENTITY }
    } else {
        Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }
    };
    let light = Light::Environment(EnvironmentMap {
        pixels: Arc::new(vec![[1.0; 3]]),
        width: 1,
        height: 1,
        to_world: DMat3::IDENTITY,
        scale: 1.0,
    });
    let material = Material::uniform("subject", Box::new(model.clone()));
    scene(vec![material], vec![shape("subject", geometry, 0, 0.0)], vec![light])
}

/// The ray that meets the surface from the local direction `wo`, at a point of no special place.
fn ray_from(scene: &Scene, wo: DVec3) -> Option<Ray> {
    // Meets the sphere as well as the disk, whose frame has no direction of its own at the centre.
    let surface = scene.intersect(&Ray::new(DVec3::new(0.3, -0.4, 2.0), DVec3::NEG_Z))?;
    let dir = surface.frame.to_world(wo);
    Some(Ray::new(surface.p + dir, -dir))
}

fn strategy_of(name: &str) -> Strategy {
    match name {
        "albedo_bsdf" => Strategy::Bsdf,
        "albedo_direct" => Strategy::Direct,
        "albedo_mis" => Strategy::Mis,
        _ => Strategy::RandomConnect,
    }
}

/// The checks called `names`; unless they are `asked` for, those that are out of reach are left out.
pub(super) fn checks(
    model: &Arc<dyn Bsdf>,
    names: &[&'static str],
    asked: bool,
    subject: u64,
    plan: &Plan,
) -> Vec<Check> {
    let undecided =
        |why: &str| -> Vec<Check> { names.iter().map(|&name| Check::new(name).inconclusive_here(why)).collect() };
    let azimuths = if is_isotropic(&**model) { &AZIMUTHS[..1] } else { &AZIMUTHS[..] };
    let directions = COSINES.iter().flat_map(|&mu| azimuths.iter().map(move |&phi| direction_mu(mu, phi)));
    let views: Vec<View> = directions.map(|wo| View::new(&**model, wo)).collect();
    if views.iter().all(|view| view.albedo.value.is_black()) {
        return undecided("the model is black: nothing can be compared");
    }
    if let Some(view) = views.iter().find(|view| !view.albedo.resolved) {
        let why = "the integrator did not resolve the albedo, so there is nothing to compare with";
        return names.iter().map(|&name| Check::new(name).inconclusive(view.wo, why)).collect();
    }
    let scene = surface_of(model);
    let out_of_reach = |name| {
        let why = "light sampling finds lobes this narrow too rarely; more samples would tell";
        asked.then(|| Check::new(name).inconclusive_here(why))
    };
    let one = |&name: &&'static str| check(name, subject, plan, &scene, &views).or_else(|| out_of_reach(name));
    names.iter().filter_map(one).collect()
}

/// None where no view is within reach.
fn check(name: &'static str, subject: u64, plan: &Plan, scene: &Scene, views: &[View]) -> Option<Check> {
    let strategy = strategy_of(name);
    // One more than the one reflection that there is: a second must find nothing.
    let tracer = settings(strategy, Some(2));
    let within_reach = views.iter().enumerate().filter(|(_, view)| view.is_within_reach(strategy, plan.samples));
    let mut all: Vec<Comparison> = Vec::new();
    let mut worst: Option<(f64, DVec3)> = None;
    for (i, view) in within_reach.clone() {
        let ray = ray_from(scene, view.wo)?;
        let number = (subject << 16) + 2000 + 100 * strategy as u64 + i as u64;
        let found = plan.estimate(number, &tracer, scene, &|_| ray);
        let channels = found.iter().zip(view.albedo.value.to_array()).zip(["red", "green", "blue"]);
        for ((found, value), colour) in channels {
            let label = format!("{strategy:?}, μ = {}, {colour}", view.wo.z);
            let comparison = Comparison::with_exact(label, found, value, view.albedo.error + unseen(found, plan.share));
            if worst.is_none_or(|(z, _)| comparison.z().abs() > z) {
                worst = Some((comparison.z().abs(), view.wo));
            }
            all.push(comparison);
        }
    }
    let (_, wo) = worst?;
    let mut check = compare::check(name, &all, plan.share);
    check.worst = Some((wo, wo));
    let left_out = views.len() - within_reach.count();
    if left_out > 0 {
        check.detail = format!("{}; {left_out} of {} angles are out of its reach", check.detail, views.len());
    }
    Some(check)
}

/// What an event that none of the samples has seen may hide: where all are equal, a draw that is lost with probability q
/// stays unseen with probability (1 − q)ⁿ, which is the check's share of the level at q = ln(1/share)/n.
fn unseen(found: &Moments, share: f64) -> f64 {
    // Far below any spread that is not rounding.
    let equal = found.variance().sqrt() <= 1e-9 * found.mean().abs();
    if equal { -share.ln() / found.count() as f64 * found.mean().abs() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::Furnace;
    use super::*;
    use crate::bsdf::subject;
    use crate::validate::{Outcome, Sheet};

    fn sheet(text: &str, only: &[&'static str]) -> Sheet {
        let model: Arc<dyn Bsdf> = Arc::from(subject::parse(text).unwrap());
        let furnace = Furnace { samples: 4096, level: 1e-3, only: only.to_vec(), ..Furnace::default() };
        furnace.subjects(&[model]).swap_remove(0)
    }

    #[test]
    fn pixels_are_albedos() {
        for text in [
            "lambert:rho=0.8",
            "ggx:alpha=0.3",
            "phong:n=20,norm=n+1,divide=true",
            "mirror:rho=0.7",
            "rough-dielectric:alpha=0.3",
        ] {
            let sheet = sheet(text, &[]);
            assert_eq!(sheet.outcome(), Outcome::Pass, "{sheet:#?}");
            assert_eq!(sheet.checks.len(), 4);
        }
    }

    #[test]
    fn light_sampling_is_not_asked_for_what_it_cannot_see() {
        let sheet_of_all = sheet("ggx:alpha=0.0001", &[]);
        let names: Vec<_> = sheet_of_all.checks.iter().map(|check| check.name).collect();
        assert_eq!((sheet_of_all.outcome(), names), (Outcome::Pass, vec!["albedo_bsdf", "albedo_mis"]));
        assert_eq!(sheet("ggx:alpha=0.0001", &["albedo_direct"]).outcome(), Outcome::Inconclusive);
    }

    #[test]
    fn the_second_moment_of_a_connection_is_the_one_it_has() {
        // Lambert: 4π ∫ (ρ/π)² cos² dω = 8ρ²/3.
        let lambert = subject::parse("lambert:rho=0.6").unwrap();
        let view = View::new(&*lambert, direction_mu(0.5, 0.0));
        assert!((view.second_moment.0.x - 8.0 / 3.0 * 0.36).abs() < 0.01, "{view:?}");
        assert!(view.is_within_reach(Strategy::Direct, 50) && !view.is_within_reach(Strategy::Direct, 10));
    }
}
