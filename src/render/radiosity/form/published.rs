//! Factors of rectangles that are published, and the rectangles: what several kernels are tested against.
//!
//! # References
//! - Howell, A catalog of radiation heat transfer configuration factors, C-11 and C-14 (15 digits of their closed forms)

use glam::DVec3;

use crate::render::radiosity::polygon::Polygon;

pub(super) fn rectangle(corner: DVec3, x: DVec3, y: DVec3) -> Polygon {
    Polygon::new(vec![corner, corner + x, corner + x + y, corner + y]).unwrap()
}

/// Aligned rectangles of sides `x`, `y` at distance 1.
pub(super) fn facing(x: f64, y: f64) -> [Polygon; 2] {
    let a = rectangle(DVec3::ZERO, DVec3::X * x, DVec3::Y * y);
    [a, rectangle(DVec3::Z, DVec3::Y * y, DVec3::X * x)]
}

/// A floor of depth `w` and a wall of height `h` with a common edge of length 1.
pub(super) fn hinged(w: f64, h: f64) -> [Polygon; 2] {
    [rectangle(DVec3::ZERO, DVec3::X * w, DVec3::Y), rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z * h)]
}

/// x, y and F from one to the other of [`facing`].
pub(super) const FACING: [(f64, f64, f64); 6] = [
    (1.0, 1.0, 0.199824895698387),
    (2.0, 2.0, 0.415253283577147),
    (0.5, 0.5, 0.068589588818552),
    (1.0, 2.0, 0.285875384850715),
    (10.0, 10.0, 0.826994522397257),
    (0.1, 0.1, 0.003162056838758),
];

/// w, h and F from the floor to the wall of [`hinged`].
pub(super) const HINGED: [(f64, f64, f64); 5] = [
    (1.0, 1.0, 0.200043776075403),
    (2.0, 1.0, 0.116426301397681),
    (1.0, 2.0, 0.232852602795362),
    (0.5, 1.0, 0.292373358211427),
    (3.0, 2.0, 0.107796009555352),
];
