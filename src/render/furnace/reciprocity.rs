//! `transport_reciprocity`: what one patch receives from another does not change when they are swapped.
//!
//! In a diffuse room with a block in the way, patch A of radiance 1 sends to patch B the flux that B of radiance 1 sends
//! to A, after every number of reflections.

use glam::{DAffine3, DVec3};

use super::Engine;
use super::compare::{self, Comparison, Plan};
use super::rooms::{STRATEGIES, diffuse, facing, inside_out, reflections, scene, settings, shape};
use crate::math::sum::Moments;
use crate::sampling::sampler::Sampler;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::ray::offset_origin;
use crate::scene::{Geometry, Ray, Scene};
use crate::validate::Check;

fn patches() -> [DAffine3; 2] {
    [facing(DVec3::new(-0.4, 0.2, -0.95), DVec3::Z, 0.3), facing(DVec3::new(0.95, 0.3, 0.4), DVec3::NEG_X, 0.15)]
}

fn room(lit: usize) -> Scene {
    let wall = inside_out(shape("wall", Geometry::Cube { to_world: DAffine3::IDENTITY }, 0, 0.0));
    let block = facing(DVec3::new(0.3, 0.2, -0.2), DVec3::new(0.6, 0.0, 0.8), 0.25);
    let mut shapes = vec![wall, shape("block", Geometry::Cube { to_world: block }, 1, 0.0)];
    for (i, to_world) in patches().into_iter().enumerate() {
        let radiance = if i == lit { 1.0 } else { 0.0 };
        shapes.push(shape("patch", Geometry::Rectangle { to_world }, 1, radiance));
    }
    scene(vec![diffuse(0.7), diffuse(0.4)], shapes, vec![])
}

pub(super) fn check(engine: &Engine, plan: &Plan) -> Check {
    let (patches, rooms) = (patches(), [room(0), room(1)]);
    let areas = patches.map(|patch| 4.0 * patch.matrix3.x_axis.length_squared());
    // Rays that leave the dark patch evenly and by the cosine: π times their mean is its irradiance.
    let received = |number: u64, lit: usize, tracer: &dyn crate::render::Radiance| -> Moments {
        let patch = patches[1 - lit];
        let frame = patch.matrix3 * patch.matrix3.x_axis.length().recip();
        let ray = |s: &mut dyn Sampler| {
            let (on, dir) = (2.0 * s.next_2d() - 1.0, frame * cosine_hemisphere(s.next_2d()));
            let dir = dir.normalize();
            Ray::new(offset_origin(patch.transform_point3(on.extend(0.0)), frame.z_axis, dir), dir)
        };
        plan.estimate(number, tracer, &rooms[lit], &ray)[0]
    };
    let mut all = Vec::new();
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        for (j, bounces) in [Some(0), Some(1), Some(3), None].into_iter().enumerate() {
            let tracer = engine(settings(strategy, bounces));
            let number = (1000 + 20 * k + 2 * j) as u64;
            let (to_second, to_first) = (received(number, 0, &*tracer), received(number + 1, 1, &*tracer));
            let label = format!("{strategy:?}, {}", reflections(bounces));
            all.push(Comparison::of_two(label, [&to_second, &to_first], [areas[1], areas[0]]));
        }
    }
    compare::check("transport_reciprocity", &all, plan.share)
}
