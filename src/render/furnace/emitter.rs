//! `one_emitter` and `one_sided`: a cube with one bright face, and the back of a light.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::Engine;
use super::compare::{Comparison, Plan, check};
use super::rooms::{STRATEGIES, diffuse, facing, named, reflections, scene, settings, shape, towards};
use crate::render::path::Strategy;
use crate::scene::builtin::sphere_multiplier;
use crate::scene::{Geometry, Ray};
use crate::validate::{Check, Outcome};

/// A face of the unit cube: a corner and two edges.
pub(super) const BOTTOM: (DVec3, DVec3, DVec3) = (DVec3::ZERO, DVec3::X, DVec3::Y);
pub(super) const TOP: (DVec3, DVec3, DVec3) = (DVec3::Z, DVec3::X, DVec3::Y);
pub(super) const SIDE: (DVec3, DVec3, DVec3) = (DVec3::X, DVec3::Y, DVec3::Z);
pub(super) const EYE: DVec3 = DVec3::new(0.4, 0.5, 0.55);

/// Mean radiosities of bottom, top and side for ρ = 1/2, and to what they are known.
///
/// One reflection is half the view factors of parallel and perpendicular squares (Howell's catalogue C-11, C-14); the
/// others are view factors of patches, extrapolated.
const RADIOSITIES: [(Option<u32>, [f64; 3], f64); 4] = [
    (Some(1), [1.0, 0.5 * PARALLEL, 0.5 * PERPENDICULAR], 1e-14),
    (Some(2), [1.063938, 0.129263, 0.139200], 5e-7),
    (Some(3), [1.082722, 0.151010, 0.160317], 5e-7),
    (None, [1.104362, 0.171216, 0.181106], 5e-7),
];
/// View factors of opposite and of adjacent faces of a cube.
pub(super) const PARALLEL: f64 = 0.199824895698387;
const PERPENDICULAR: f64 = 0.200043776075403;

pub(super) fn cube(engine: &Engine, plan: &Plan) -> Check {
    let mut all = Vec::new();
    let scene = named("cube-one-emitter", &[("rho", "0.5")]);
    let port = named("integrating-sphere", &[]);
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        for (j, (bounces, exact, error)) in RADIOSITIES.into_iter().enumerate() {
            let tracer = engine(settings(strategy, bounces));
            for (i, face) in [BOTTOM, TOP, SIDE].into_iter().enumerate() {
                let number = (400 + 100 * k + 10 * j + i) as u64;
                let [found, ..] = plan.estimate(number, &*tracer, &scene, &|s| towards(EYE, face, s.next_2d()));
                let label = format!("{strategy:?}, {}, {}", reflections(bounces), ["bottom", "top", "side"][i]);
                all.push(Comparison::with_exact(label, &found, FRAC_1_PI * exact[i], error));
            }
        }
        let tracer = engine(settings(strategy, None));
        let ray = |film| port.camera_ray(film, glam::DVec2::ZERO);
        let [found, ..] = plan.estimate(450 + 100 * k as u64, &*tracer, &port, &|s| ray(512.0 * s.next_2d()));
        let label = format!("{strategy:?}, integrating sphere");
        all.push(Comparison::with_exact(label, &found, sphere_multiplier(0.9, 0.05), 1e-12));
    }
    check("one_emitter", &all, plan.share)
}

/// A square that shines down, under a ceiling and above nothing: neither its back nor the ceiling may be seen.
pub(super) fn one_sided(engine: &Engine, plan: &Plan) -> Check {
    let square = |z: f64, half_side: f64| Geometry::Rectangle {
        to_world: facing(DVec3::new(0.0, 0.0, z), DVec3::NEG_Z, half_side),
    };
    let room = scene(
        vec![diffuse(0.8), diffuse(0.0)],
        vec![shape("ceiling", square(2.0, 2.0), 0, 0.0), shape("light", square(1.0, 0.5), 1, 1.0)],
        vec![],
    );
    let mut result = Check::new("one_sided");
    let corner = DVec3::new(-1.0, -1.0, 2.0);
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        let tracer = engine(settings(strategy, Some(2)));
        let number = 800 + 10 * k as u64;
        // What has no chance of being wrong needs few samples.
        let plan = Plan { samples: plan.samples.min(4096), ..*plan };
        let eye = DVec3::new(0.9, 0.0, 1.5);
        let [back, ..] = plan.estimate(number, &*tracer, &room, &|_| Ray::new(eye, (DVec3::Z - eye).normalize()));
        let ceiling = (corner, 2.0 * DVec3::X, 2.0 * DVec3::Y);
        let [above, ..] = plan.estimate(number + 1, &*tracer, &room, &|s| towards(eye, ceiling, s.next_2d()));
        let [front, ..] = plan.estimate(number + 2, &*tracer, &room, &|_| Ray::new(DVec3::ZERO, DVec3::Z));
        let dark = back.mean().max(above.mean());
        // A tracer that sees nothing at all would be dark too.
        let leak = if (front.mean() - 1.0).abs() <= 1e-12 && dark.is_finite() { dark } else { f64::INFINITY };
        if leak > result.statistic || k == 0 {
            result.statistic = leak;
            result.detail = format!(
                "{strategy:?}: the front of a light of radiance 1 shows {}, its back {}, what it does not face {}",
                front.mean(),
                back.mean(),
                above.mean()
            );
        }
    }
    result.outcome = if result.statistic <= 0.0 { Outcome::Pass } else { Outcome::Fail };
    result
}

/// The mean radiance of the top of the cube after one reflection, and an estimator of it.
pub(super) fn top_after_one_reflection(strategy: Strategy) -> (crate::render::path::PathTracer, f64) {
    (settings(strategy, Some(1)), FRAC_1_PI * 0.5 * PARALLEL)
}
