//! `strategies`: the mean colour of the Cornell box, by every strategy, pairwise.

use glam::DVec2;

use super::Engine;
use super::compare::{self, Comparison, Plan};
use super::rooms::{STRATEGIES, named, settings};
use crate::math::sum::Moments;
use crate::validate::Check;

pub(super) fn check(engine: &Engine, plan: &Plan) -> Check {
    let scene = named("cornell-original", &[]);
    let size = DVec2::new(scene.film().width as f64, scene.film().height as f64);
    let found: Vec<[Moments; 3]> = STRATEGIES
        .into_iter()
        .enumerate()
        .map(|(k, strategy)| {
            let tracer = engine(settings(strategy, None));
            plan.estimate(900 + k as u64, &*tracer, &scene, &|s| scene.camera_ray(size * s.next_2d(), DVec2::ZERO))
        })
        .collect();
    let mut all = Vec::new();
    for (i, a) in found.iter().enumerate() {
        for (j, b) in found.iter().enumerate().skip(i + 1) {
            for (channel, colour) in ["red", "green", "blue"].into_iter().enumerate() {
                let label = format!("{:?} and {:?}, {colour}", STRATEGIES[i], STRATEGIES[j]);
                all.push(Comparison::of_two(label, [&a[channel], &b[channel]], [1.0, 1.0]));
            }
        }
    }
    compare::check("strategies", &all, plan.share)
}
