//! Points of a disk and of its rim.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::math::frame::Frame;

/// Points of a rim.
pub(super) const SPOKES: u32 = 8;
/// Points of a disk.
pub(super) const POINTS: u32 = 64;

/// [`SPOKES`] points of the circle about `n`.
pub(super) fn rim(centre: DVec3, n: DVec3, radius: f64) -> impl Iterator<Item = DVec3> {
    let frame = Frame::about(n);
    (0..SPOKES).map(move |i| {
        let (sin, cos) = (TAU * (f64::from(i) + 0.5) / f64::from(SPOKES)).sin_cos();
        centre + frame.to_world(DVec3::new(cos, sin, 0.0)) * radius
    })
}

/// [`POINTS`] points of the disk about `n`, for equal areas each: a sunflower, turned by the golden angle.
pub(super) fn disk(centre: DVec3, n: DVec3, radius: f64) -> impl Iterator<Item = DVec3> {
    let frame = Frame::about(n);
    (0..POINTS).map(move |i| {
        let r = radius * ((f64::from(i) + 0.5) / f64::from(POINTS)).sqrt();
        let at = DVec2::from_angle(f64::from(i) * PI * (3.0 - 5.0_f64.sqrt())) * r;
        centre + frame.to_world(at.extend(0.0))
    })
}
