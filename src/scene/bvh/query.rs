//! A ray in f32, with the slack that its rounding needs.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;

use super::aabb::Aabb;
use super::kernel::Lanes;
use crate::scene::ray::Ray;

/// The coordinates in which a tree is stored: (p − centre) · scale, no larger than 1 anywhere in it.
///
/// A mesh far from the origin so loses no digits to f32, and no magnitude of coordinates can over- or underflow it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) centre: [f64; 4],
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
        Self { centre: [centre.x, centre.y, centre.z, 0.0], scale: (-exponent).exp2() }
    }

    /// A point in the tree's coordinates.
    #[inline(always)]
    pub(super) fn enter(&self, p: DVec3) -> DVec3 {
        (p - DVec3::new(self.centre[0], self.centre[1], self.centre[2])) * self.scale
    }
}

/// Half a unit in the last place of f32: 2⁻²⁴.
const EPS: f64 = 1.0 / (1_u32 << 24) as f64;

/// Greater than the relative error of any number rounded to f32 and used in one more operation.
const UP: f64 = 4.0 * EPS;

/// What every test needs of a ray, and what triangles need. Distances are in the tree's units.
///
/// With C = v0 − o and e1, e2 the edges at v0: n = e1 × e2, D = n·d, T = n·C, U = (C × d)·e2, V = −(C × d)·e1,
/// W = D − U − V, which are t and the barycentric coordinates after division by D. Let |C|, |o| + |v0| ≤ M,
/// edges ≤ E and |d| ≤ 1.1. In units of EPS: C is wrong by 2 M, d by 1.1, C × d by 2.2 M + 1.1 M from those and by 3.3 M
/// from its own rounding; U and V by 6.6 M E + 1.1 M E + 3.3 M E = 11 M E, the last two for the edge and the sum; D by
/// 10 E² ≤ 20 M E; W by 46 M E; T by 10 M E². A hit has U, V, W of the sign of D, which is itself uncertain if |D| is below
/// its error; then U, V, W are smaller than that too. Hence, with a slack s = 80 EPS M E, a hit has U, V, W ≥ −s after the
/// sign of D is taken out, and by the same token T ≥ −s E and T ≤ D t + s E for t ≤ 2.2 M. Beyond the slack on the other
/// side, a hit is certain.
pub(super) struct Query<S: Lanes> {
    /// The ray's origin as it came.
    pub(super) world: S::D,
    /// The same in the tree's coordinates.
    pub(super) origin: S::D,
    pub(super) dir: S::D,
    /// |o|₁
    size: f64,
    /// Slack of U, V, W for each unit of the longest edge.
    pub(super) slack: f32,
    /// What lies beyond this distance is beyond t_max or beyond the tree.
    pub(super) reach: f32,
}

/// What boxes need of a ray.
///
/// A plane at b of an axis is met at t = b r − o r, r being 1 / d. Where that is between 0 and twice the reach 2.2 M, r
/// rounded to f32 and the result's own rounding change it by no more than 2 EPS · 4.4 M = 9 EPS M, if o r is exact; o r is
/// computed in f64 from the rounded r. Without a fused b r − o r, the product's rounding, at most EPS r as |b| ≤ 1, is
/// added. o r is then made greater by these (for the near plane) or smaller (far) and rounded to f32 on the safe side too.
/// So a near distance is never too large and a far one never too small, where it matters: beyond twice the reach, a far
/// one still is beyond the reach.
///
/// The planes are moved outwards by `LEEWAY` of the largest coordinate besides, so that a box holds what an f64
/// intersection with its contents may call a hit by its own rounding. A component of the direction below 2⁻⁶⁰ is taken
/// as that, which moves a ray by less than the leeway within the tree: no 0 · ∞ arises.
pub(super) struct Slabs<S: Lanes> {
    /// The axes on which the greater of a box's two planes is met first, as bits.
    pub(super) backwards: u32,
    pub(super) scale: S::H,
    pub(super) near_shift: S::H,
    pub(super) far_shift: S::H,
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

impl<S: Lanes> Query<S> {
    /// None if the ray hits nothing: if a number is not finite, the origin is absurdly far, or t_max ≤ 0.
    ///
    /// The length of the direction must lie in [0.9, 1.1].
    #[inline(always)]
    pub(super) fn new<T: Twist>(s: S, frame: &Frame, ray: &Ray) -> Option<Self> {
        let world = s.quad_of(&ray.origin);
        let origin = s.quad_sub(world, s.quad_load(&frame.centre));
        let origin = s.quad_mul(origin, s.quad_splat(frame.scale));
        let size = s.quad_first(s.quad_sum(s.quad_copysign(origin, s.quad_splat(1.0))));
        // The corners of the unit cube have |v| ≤ √3.
        let far = size + 1.7321;
        (size <= FARTHEST && ray.t_max > 0.0).then(|| Self {
            world,
            origin,
            dir: s.quad_of(&ray.dir),
            size,
            slack: (T::TRIANGLES * 80.0 * EPS * far) as f32,
            reach: up((ray.t_max * frame.scale).min(1.2 * far)),
        })
    }

    /// The part for boxes.
    #[inline(always)]
    pub(super) fn slabs<T: Twist>(&self, s: S) -> Slabs<S> {
        let one = s.quad_splat(1.0);
        let size = s.quad_max(s.quad_copysign(self.dir, one), s.quad_splat(TINY));
        let scale = s.narrow(s.quad_div(one, s.quad_copysign(size, self.dir)));
        let exact = s.quad_mul(self.origin, s.widen(scale));
        let of_planes = LEEWAY * (1.0 + self.size) + if S::FUSED { 0.0 } else { 1.01 * EPS };
        let slack = s.quad_mul(s.quad_copysign(s.widen(scale), one), s.quad_splat(T::BOXES * of_planes));
        let slack = s.quad_add(slack, s.quad_splat(T::BOXES * 10.0 * EPS * (self.size + 1.7321)));
        let slack = s.quad_add(slack, s.quad_mul(s.quad_copysign(exact, one), s.quad_splat(T::BOXES * UP)));
        Slabs {
            backwards: s.quad_signs(self.dir),
            scale,
            near_shift: s.narrow(s.quad_add(exact, slack)),
            far_shift: s.narrow(s.quad_sub(exact, slack)),
        }
    }
}

/// Factors of the slack: 1, but for tests of what it is good for.
pub(super) trait Twist {
    const BOXES: f64 = 1.0;
    const TRIANGLES: f64 = 1.0;
}

/// As it should be.
pub(super) struct Straight;

impl Twist for Straight {}
