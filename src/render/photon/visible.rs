//! Photons behind a wall that stands on the same floor: what keeps its light from leaking through.
//!
//! Eight spokes from the point reach the corners of an octagon around the disk. Where all are free, and the room around is
//! convex, the disk lies in it; else each photon is asked for by a ray of its own.

use std::f64::consts::PI;

use glam::DVec3;

use super::area::{Outline, SAME};
use super::disk::{SPOKES, disk, rim};
use crate::scene::{Ray, Scene, Surface};

/// Whether nothing stands between the point and any point of the octagon around the disk. `n` is the side.
pub(super) fn is_open(scene: &Scene, p: DVec3, n: DVec3, radius: f64) -> bool {
    let from = scene.lifted(p, n);
    let reach = radius / (PI / f64::from(SPOKES)).cos();
    rim(from, n, reach).all(|to| is_clear(scene, from, to, n))
}

/// Whether a photon at `q` with normal `m` is seen from the point.
pub(super) fn sees(scene: &Scene, (p, n): (DVec3, DVec3), (q, m): (DVec3, DVec3)) -> bool {
    is_clear(scene, scene.lifted(p, n), scene.lifted(q, m), n)
}

/// The share of the disk's surface that is seen.
pub(super) fn share(scene: &Scene, surface: &Surface, n: DVec3, radius: f64, outline: &Outline) -> f64 {
    let (mut inside, mut seen) = (0_u32, 0_u32);
    for q in disk(surface.p, n, radius) {
        if outline.holds(scene, surface, radius, q) {
            inside += 1;
            seen += u32::from(sees(scene, (surface.p, n), (q, n)));
        }
    }
    // A photon was seen, so that something is.
    if inside == 0 { 1.0 } else { f64::from(seen.max(1)) / f64::from(inside) }
}

/// Whether nothing is in the way but the surface itself, where it is curved.
fn is_clear(scene: &Scene, from: DVec3, to: DVec3, n: DVec3) -> bool {
    let way = to - from;
    let distance = way.length();
    if distance <= 0.0 {
        return true;
    }
    scene.intersect(&Ray::up_to(from, way / distance, distance)).is_none_or(|met| met.ng.dot(n).abs() > SAME)
}
