//! Rays that start at emitters, with the power that each carries: what photons begin with.
//!
//! An emitter is chosen in proportion to its power; the power of a draw is L cos / p, the density p being that of the choice,
//! of the point and of the direction. Its mean is the power that all emitters send out, or, for light from infinitely far,
//! what passes the disk that just hides the scene.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::area::AreaEmitter;
use super::{Emitter, Emitters};
use crate::math::color::Rgb;
use crate::math::frame::Frame;
use crate::sampling::warp::{concentric_disk, cosine_hemisphere, uniform_cone, uniform_cone_pdf, uniform_sphere};

/// The start of a path of light.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Emission {
    /// Where it starts.
    pub(in crate::scene) point: DVec3,
    /// The normal of the emitter there, if it is a surface.
    pub(in crate::scene) normal: Option<DVec3>,
    /// Unit vector along which it goes.
    pub(in crate::scene) dir: DVec3,
    /// What it carries \[W\].
    pub(in crate::scene) power: Rgb,
}

impl Emitters {
    /// Draws a ray of light: `choice` picks the emitter, `at` the place, `along` the direction. None where nothing emits.
    pub(in crate::scene) fn emit(&self, choice: f64, at: DVec2, along: DVec2) -> Option<Emission> {
        let (number, probability, _) = self.every.as_ref()?.pick(choice);
        let (centre, radius) = self.bounds;
        // What goes along `dir` through the disk before the scene.
        let from_afar = |dir: DVec3, power: Rgb| {
            let disk = concentric_disk(at) * radius;
            let frame = Frame::about(dir);
            let point = centre + frame.to_world(DVec3::new(disk.x, disk.y, -radius));
            Emission { point, normal: None, dir, power: power * (PI * radius * radius) }
        };
        let drawn = match &self.all[number] {
            Emitter::Area { shape, radiance, .. } => {
                let (point, normal) = shape.point(at);
                let dir = Frame::about(normal).to_world(cosine_hemisphere(along));
                Emission { point, normal: Some(normal), dir, power: *radiance * (PI * shape.area()) }
            }
            Emitter::Point { position, intensity } => {
                Emission { point: *position, normal: None, dir: uniform_sphere(along), power: *intensity * (2.0 * TAU) }
            }
            Emitter::Spot { position, axis, intensity, beam, cutoff } => {
                let local = uniform_cone(along, *cutoff);
                // From the sine: the angle of a narrow cone has all digits.
                let angle = local.x.hypot(local.y).atan2(local.z);
                let share = if angle <= *beam { 1.0 } else { ((cutoff - angle) / (cutoff - beam)).max(0.0) };
                let pdf = uniform_cone_pdf(local, *cutoff);
                let power = if pdf > 0.0 && pdf.is_finite() { *intensity * (share / pdf) } else { Rgb::BLACK };
                Emission { point: *position, normal: None, dir: Frame::about(*axis).to_world(local), power }
            }
            Emitter::Directional { towards, irradiance } => from_afar(-*towards, *irradiance),
            Emitter::Environment(environment) => {
                let (wi, radiance, pdf) = environment.sample(along);
                from_afar(-wi, if pdf > 0.0 { radiance / pdf } else { Rgb::BLACK })
            }
        };
        Some(Emission { power: drawn.power / probability, ..drawn })
    }
}

impl AreaEmitter {
    /// A point of the surface, uniform in area, and the normal of the side that emits.
    pub(super) fn point(&self, u: DVec2) -> (DVec3, DVec3) {
        match *self {
            Self::Triangle { a, e1, e2, normal, .. } => {
                let (b1, b2) = if u.x > u.y { (u.x - 0.5 * u.y, 0.5 * u.y) } else { (0.5 * u.x, u.y - 0.5 * u.x) };
                (a + e1 * b1 + e2 * b2, normal)
            }
            Self::Rectangle { corner, x, y, normal, .. } => (corner + x * u.x + y * u.y, normal),
            Self::Quadric { quadric, sign, .. } => {
                let point = quadric.sample_area(u);
                (point, quadric.at(point).normal * sign)
            }
        }
    }
}
