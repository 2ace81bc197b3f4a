//! The irradiance from a light of known closed form as a target.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Estimator, Target};
use crate::render::path::Heuristic;
use crate::sampling::solid_angle::SphericalRectangle;
use crate::sampling::warp::{cosine_hemisphere, uniform_hemisphere};

/// The names of the targets, with what they are.
pub const NAMES: &[(&str, &str)] = &[
    ("unit-square", "a unit square of radiance 1, seen from 1 below its centre"),
    ("unit-square-corner", "the same, seen from 1 below a corner"),
];

/// The standard deviations of the six estimators below the centre: published to ten digits.
const SIGMAS: [f64; 6] = [0.1310654085, 0.0325582572, 1.340680211, 1.963945333, 0.2806361183, 0.1380502427];

/// The target of this name.
pub fn irradiance(name: &str) -> Option<Target<'static>> {
    let corner = match name {
        "unit-square" => DVec2::splat(-0.5),
        "unit-square-corner" => DVec2::ZERO,
        _ => return None,
    };
    let sigmas = (name == "unit-square").then_some(SIGMAS);
    let square = Square { corner };
    let draws: [(&'static str, super::Draw<'static>); 6] = [
        ("area", Box::new(move |sampler| square.by_area(sampler.next_2d()).0)),
        ("solid-angle", square.by_solid_angle()),
        ("cosine", Box::new(move |sampler| square.by_cosine(sampler.next_2d()).0)),
        ("uniform", Box::new(move |sampler| square.by_hemisphere(sampler.next_2d()))),
        ("balance", Box::new(move |sampler| square.by_both(Heuristic::Balance, sampler.next_2d(), sampler.next_2d()))),
        ("power", Box::new(move |sampler| square.by_both(Heuristic::Power, sampler.next_2d(), sampler.next_2d()))),
    ];
    let estimators = draws.into_iter().enumerate().map(|(i, (name, draw))| Estimator {
        name,
        draw,
        sigma: sigmas.map(|sigmas| sigmas[i]),
    });
    // Four angles, each to a few roundings.
    let exact = square.irradiance();
    Some(Target { name: format!("irradiance:{name}"), exact, error: 1e-15, estimators: estimators.collect() })
}

/// A unit square of radiance 1 in the plane z = 1 that shines downwards, above a receiver in the origin that looks up.
#[derive(Clone, Copy, Debug)]
struct Square {
    corner: DVec2,
}

impl Square {
    /// ½ Σ Θ Γ·n over the edges, Lambert's formula for a polygon.
    fn irradiance(&self) -> f64 {
        let corner = |x, y| (self.corner + DVec2::new(x, y)).extend(1.0).normalize();
        let corners = [corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0)];
        let edges = (0..4).map(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            a.angle_between(b) * a.cross(b).normalize().z
        });
        0.5 * edges.sum::<f64>().abs()
    }

    fn is_hit_along(&self, w: DVec3) -> bool {
        let p = w.truncate() / w.z - self.corner;
        w.z > 0.0 && p.cmpge(DVec2::ZERO).all() && p.cmplt(DVec2::ONE).all()
    }

    /// The density over solid angle of uniform points of the square: d² / (A cosθ), both cosines being 1 / d.
    fn density(w: DVec3) -> f64 {
        w.z.powi(-3)
    }

    /// L cosθ cosθ' A / d² at a uniform point, and its direction.
    fn by_area(&self, u: DVec2) -> (f64, DVec3) {
        let w = (self.corner + u).extend(1.0);
        let d2 = w.length_squared();
        (1.0 / (d2 * d2), w / d2.sqrt())
    }

    fn by_solid_angle(&self) -> super::Draw<'static> {
        let seen = SphericalRectangle::new(DVec3::ZERO, self.corner.extend(1.0), DVec3::X, DVec3::Y);
        Box::new(move |sampler| {
            let u = sampler.next_2d();
            seen.map_or(0.0, |seen| seen.solid_angle() * seen.sample(u).normalize().z)
        })
    }

    /// L cosθ / pdf for a cosine-weighted direction, and the direction.
    fn by_cosine(&self, u: DVec2) -> (f64, DVec3) {
        let w = cosine_hemisphere(u);
        (if self.is_hit_along(w) { PI } else { 0.0 }, w)
    }

    fn by_hemisphere(&self, u: DVec2) -> f64 {
        let w = uniform_hemisphere(u);
        if self.is_hit_along(w) { 2.0 * PI * w.z } else { 0.0 }
    }

    /// A point of the square and a cosine-weighted direction.
    fn by_both(&self, by: Heuristic, u: DVec2, v: DVec2) -> f64 {
        let (by_area, w) = self.by_area(u);
        let by_area = by_area * by.weight(Self::density(w), w.z / PI);
        let (by_cosine, w) = self.by_cosine(v);
        by_area + by_cosine * by.weight(w.z / PI, Self::density(w))
    }
}
