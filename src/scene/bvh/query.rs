//! A ray in f32, with the slack that its rounding needs.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;

use super::aabb::Aabb;
use crate::scene::ray::Ray;

/// The coordinates in which a tree is stored: (p − centre) · scale, no larger than 1 anywhere in it.
///
/// A mesh far from the origin so loses no digits to f32, and no magnitude of coordinates can over- or underflow it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) centre: DVec3,
    /// A power of 2, so that scaling is exact.
    pub(super) scale: f64,
}

impl Frame {
    /// For what lies in a box of finite size.
    pub(super) fn of(bounds: &Aabb) -> Self {
        let centre = if bounds.is_empty() { DVec3::ZERO } else { bounds.centre() };
        let size = (bounds.max - centre).max(centre - bounds.min).max_element();
        // Sizes down to 2^−1000, so that the scale is finite; a single point has size 0.
        let exponent = if size > 0.0 { size.log2().ceil().clamp(-1000.0, 1000.0) } else { 0.0 };
        Self { centre, scale: (-exponent).exp2() }
    }

    /// A point in the tree's coordinates.
    #[inline(always)]
    pub(super) fn enter(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }
}

/// Half a unit in the last place of f32: 2⁻²⁴.
const EPS: f64 = 1.0 / (1_u32 << 24) as f64;

/// Greater than the relative error of any number rounded to f32 and used in one more operation.
const UP: f64 = 4.0 * EPS;

/// What traversal needs of a ray. Distances are in the tree's units.
///
/// # Boxes
/// A plane at b of an axis is met at t = (b − o) / d. With r the reciprocal of d, rounded to f32 after being made smaller by
/// 8 EPS (for the near plane) or larger (far), b r − o r is (b − o) r, wrong by a relative 8 EPS on the safe side, if o r is
/// exact; that is computed in f64 and rounded to f32 on the safe side too. A near distance is then never too large and a far
/// one never too small, as long as they are positive; and negative ones mean the same whatever their size. Without a
/// fused b r − o r, the product's own rounding, no more than EPS r as |b| ≤ 1, is added.
///
/// The planes are moved outwards by `LEEWAY` of the largest coordinate besides, so that a box holds what an f64
/// intersection with its contents may call a hit by its own rounding. A component of the direction below 2⁻⁶⁰ is taken
/// as that, which moves a ray by less than the leeway within the tree: no 0 · ∞ arises.
///
/// # Triangles
/// With C = v0 − o and e1, e2 the edges at v0: n = e1 × e2, D = n·d, T = n·C, U = (C × d)·e2, V = −(C × d)·e1,
/// W = D − U − V, which are t and the barycentric coordinates after division by D. Let |C|, |o| + |v0| ≤ M,
/// edges ≤ E and |d| ≤ 1.1. In units of EPS: C is wrong by 2 M, d by 1.1, C × d by 2.2 M + 1.1 M from those and by 3.3 M from its
/// own rounding; U and V by 6.6 M E + 1.1 M E + 3.3 M E = 11 M E, the last two for the edge and the sum; D by 10 E² ≤ 20 M E;
/// W by 46 M E; T by 10 M E². A hit has U, V, W of the sign of D, which is itself uncertain if |D| is below its error;
/// then U, V, W are smaller than that too. Hence, with a slack s = 80 EPS M E, a hit has U, V, W ≥ −s after the sign of D
/// is taken out, and by the same token T ≥ −s E and T ≤ D t + s E for t ≤ 2.2 M. Beyond the slack on the other side, a hit is
/// certain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    /// For each axis, which of a box's two planes is met first: 1 for the greater.
    pub(super) near: [usize; 3],
    pub(super) near_scale: [f32; 3],
    pub(super) near_shift: [f32; 3],
    pub(super) far_scale: [f32; 3],
    pub(super) far_shift: [f32; 3],
    pub(super) origin: [f32; 3],
    pub(super) dir: [f32; 3],
    /// Slack of U, V, W for each unit of the longest edge.
    pub(super) slack: f32,
    /// What lies beyond this distance is beyond t_max or beyond the tree.
    pub(super) reach: f32,
}

/// How far boxes are moved outwards, in units of the largest coordinate: 2⁻⁴⁵, 2⁸ roundings of f64.
const LEEWAY: f64 = 1.0 / (1_u64 << 45) as f64;

/// The smallest component of a direction: 2⁻⁶⁰.
const TINY: f64 = 1.0 / (1_u64 << 60) as f64;

/// Farther from a tree than 2⁶⁰ of its sizes, f64 cannot tell one part of it from another; nothing is hit.
const FARTHEST: f64 = (1_u64 << 60) as f64;

/// x ≥ 0 as f32, not smaller.
#[inline(always)]
pub(super) fn up(x: f64) -> f32 {
    (x * (1.0 + UP)) as f32
}

impl Query {
    /// None if the ray hits nothing: if a number is not finite, the origin is absurdly far, or t_max ≤ 0.
    ///
    /// The length of the direction must lie in [0.9, 1.1] or be NaN.
    #[inline(always)]
    pub(super) fn new(fused: bool, frame: &Frame, ray: &Ray) -> Option<Self> {
        let origin = frame.enter(ray.origin);
        let size = origin.x.abs() + origin.y.abs() + origin.z.abs();
        if !(size <= FARTHEST && ray.t_max > 0.0 && ray.dir.is_finite()) {
            return None;
        }
        // The corners of the unit cube have |v| ≤ √3.
        let reach = size + 1.7321;
        let dir =
            DVec3::select(ray.dir.abs().cmplt(DVec3::splat(TINY)), DVec3::splat(TINY), ray.dir.abs()).copysign(ray.dir);
        let scale = dir.recip();
        let near_scale = (scale * (1.0 - 2.0 * UP)).as_vec3();
        let far_scale = (scale * (1.0 + 2.0 * UP)).as_vec3();
        let leeway = LEEWAY * (1.0 + size) + if fused { 0.0 } else { 1.01 * EPS };
        let shift = |scale: DVec3, outwards: f64| {
            let exact = origin * scale;
            (exact + outwards * (leeway * scale.abs() + UP * exact.abs())).as_vec3().to_array()
        };
        Some(Self {
            near: [usize::from(dir.x < 0.0), usize::from(dir.y < 0.0), usize::from(dir.z < 0.0)],
            near_scale: near_scale.to_array(),
            near_shift: shift(near_scale.as_dvec3(), 1.0),
            far_scale: far_scale.to_array(),
            far_shift: shift(far_scale.as_dvec3(), -1.0),
            origin: origin.as_vec3().to_array(),
            dir: ray.dir.as_vec3().to_array(),
            slack: (80.0 * EPS * reach) as f32,
            reach: up((ray.t_max * frame.scale).min(1.2 * reach)),
        })
    }
}
