//! `furnace_exact` and `furnace_mean`: closed rooms that emit and reflect alike everywhere.
//!
//! After r reflections the radiance is e (1 + ρ + … + ρʳ), in every direction and whatever the room's shape. A path that
//! finds emission by chance alone brings exactly that, without variance: an error of one in the number of reflections
//! cannot hide in noise.

use std::f64::consts::PI;

use glam::DVec3;

use super::Engine;
use super::compare::{Comparison, Plan, check};
use super::rooms::{STRATEGIES, anywhere, diffuse, inside_out, named, reflections, scene, settings, shape};
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::render::probe::{BLOCK, Probe};
use crate::scene::builtin::furnace_radiance;
use crate::scene::{Geometry, Light, Scene};
use crate::validate::{Check, Outcome};

const MOST_REFLECTIONS: u32 = 8;
/// A thousand roundings of a sum near 1.
const EXACT: f64 = 1e-12;

const EYE: DVec3 = DVec3::new(0.1, -0.3, 0.2);
/// Reflectance and emission of the three channels.
const WALLS: [(f64, f64); 3] = [(0.2, 0.8), (0.5, 0.5), (0.8, 0.2)];

fn room(name: &str) -> Scene {
    named(name, &[("rho", "0.2/0.5/0.8"), ("e", "0.8/0.5/0.2")])
}

/// The inside of a unit sphere of reflectance 1/2 about a point of intensity π: every connection brings the same.
fn point_in_a_sphere() -> Scene {
    let wall = inside_out(shape("wall", Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }, 0, 0.0));
    scene(vec![diffuse(0.5)], vec![wall], vec![Light::Point { position: DVec3::ZERO, intensity: Rgb::grey(PI) }])
}

pub(super) fn exact(engine: &Engine, plan: &Plan) -> Check {
    let mut result = Check::new("furnace_exact");
    (result.outcome, result.bound) = (Outcome::Pass, EXACT);
    let probe = Probe { seed: plan.seed, number: 100, samples: BLOCK };
    let mut see = |label: &str, bounces: u32, found: &Moments, exact: f64| {
        // Not only the mean: every path.
        let gap = (found.mean() - exact).abs() + found.variance().sqrt();
        let gap = if gap.is_nan() { f64::INFINITY } else { gap };
        if gap > result.statistic || result.detail.is_empty() {
            result.statistic = gap;
            result.detail = format!("{label}, {bounces} reflections: {} instead of {exact}", found.mean());
        }
    };
    let lamp = point_in_a_sphere();
    for bounces in 0..=MOST_REFLECTIONS {
        let by_chance = engine(settings(Strategy::Bsdf, Some(bounces)));
        for name in ["furnace-sphere", "furnace-box"] {
            let found = probe.estimate(&*by_chance, &room(name), &|s| anywhere(EYE, s.next_2d()));
            for (found, (rho, e)) in found.iter().zip(WALLS) {
                see(&format!("{name}, ρ = {rho}"), bounces, found, furnace_radiance(rho, e, Some(bounces)));
            }
        }
        let connecting = engine(settings(Strategy::Direct, Some(bounces)));
        let [found, ..] = probe.estimate(&*connecting, &lamp, &|s| anywhere(EYE, s.next_2d()));
        see("a point in a sphere", bounces, &found, 1.0 - 0.5_f64.powf(f64::from(bounces)));
    }
    result.outcome = if result.statistic <= EXACT { Outcome::Pass } else { Outcome::Fail };
    result.detail = format!("{}, the worst of {}", result.detail, 7 * (MOST_REFLECTIONS + 1));
    result.detects.insert("absolute_bias", 2.0 * EXACT);
    result
}

pub(super) fn mean(engine: &Engine, plan: &Plan) -> Check {
    let mut all = Vec::new();
    let mut number = 200;
    let scene = room("furnace-box");
    let mut see = |label: String, tracer: PathTracer| {
        number += 1;
        let found = plan.estimate(number, &*engine(tracer), &scene, &|s| anywhere(EYE, s.next_2d()));
        for (found, (rho, e)) in found.iter().zip(WALLS) {
            let exact = furnace_radiance(rho, e, tracer.bounces);
            let label = format!("{label}, {}, ρ = {rho}", reflections(tracer.bounces));
            all.push(Comparison::with_exact(label, found, exact, EXACT));
        }
    };
    for strategy in STRATEGIES {
        for bounces in 0..=MOST_REFLECTIONS {
            see(format!("{strategy:?}"), settings(strategy, Some(bounces)));
        }
        // q = .9 stays well above the square of every albedo.
        for roulette in [Roulette::Albedo, Roulette::From(5), Roulette::Constant(0.9)] {
            let tracer = PathTracer { roulette, ..settings(strategy, None) };
            see(format!("{strategy:?}, {roulette:?}"), tracer);
        }
        for first_split in [2, 5] {
            let tracer = PathTracer { first_split, ..settings(strategy, Some(3)) };
            see(format!("{strategy:?}, split {first_split}"), tracer);
        }
    }
    check("furnace_mean", &all, plan.share)
}
