//! Rays, and where a ray that leaves a surface must start.

use glam::DVec3;

/// A ray: origin, unit direction, and the distance up to which it looks (exclusive); hits have 0 < t < t_max.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: DVec3,
    /// Where it goes: a unit vector.
    pub dir: DVec3,
    /// The distance up to which it looks, itself excluded.
    pub t_max: f64,
    /// Triangles that need not be looked at, since the ray starts or ends just off them: being plane, they cannot be met.
    pub(super) beside: [u32; 3],
}

/// The number of no triangle.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

impl Ray {
    /// A ray without end.
    pub const fn new(origin: DVec3, dir: DVec3) -> Self {
        Self::up_to(origin, dir, f64::INFINITY)
    }

    /// A ray that looks as far as `t_max`, exclusive.
    pub const fn up_to(origin: DVec3, dir: DVec3, t_max: f64) -> Self {
        Self { origin, dir, t_max, beside: [NO_TRIANGLE; 3] }
    }

    /// Whether the triangle of this number need not be looked at.
    #[inline]
    pub(super) fn is_beside(&self, triangle: u32) -> bool {
        self.beside.contains(&triangle)
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.dir
    }
}

/// The share of a coordinate's size by which [`offset_origin`] moves: 2⁻⁴⁴.
const OFFSET: f64 = 1.0 / (1_u64 << 44) as f64;

/// Moves a hit point `p` off its surface, to the side of the geometric normal `ng` (a unit vector, either way round)
/// to which `dir` points, so that a ray from there along `dir` does not meet the same plane again.
///
/// For surfaces whose coordinates, and whose ray's origin, are not far larger than `p`; see [`offset_origin_within`].
pub fn offset_origin(p: DVec3, ng: DVec3, dir: DVec3) -> DVec3 {
    offset_origin_within(p, ng, dir, 0.0)
}

/// [`offset_origin`] in a scene of coordinates up to `extent`.
///
/// The step is 2⁻⁴⁴ (|p|₁ + extent) along the normal. What it must exceed, in units of u = 2⁻⁵³ and with s the largest
/// coordinate among those of the ray's origin, of `p` and of the triangle's vertices:
/// - the hit's own distance from the plane. The t of a hit and its barycentric coordinates are such that o + t d and
///   (1 − b1 − b2) v0 + b1 v1 + b2 v2 differ by the rounding of the sheared vertices, at most 2·2u|v − o| ≤ 14 u s, at any
///   angle of incidence. Evaluating the former adds 3 u s (the product t d, the sum), the latter 6 u s.
/// - the error of the next intersection: by the same argument the plane is met at a point that is wrong by no more than
///   14 u s along the normal, so a start that lies higher than this on the proper side gets t < 0.
/// - the rounding of the sum below, 2 u s.
///
/// Together less than 40 u s < 2⁻⁴⁷ s; what remains of 2⁻⁴⁴ is for a normal that is not quite of unit length or not
/// quite normal, for instance because it was rounded too. A hit point far from the plane for its own coordinates, near
/// the origin in a large scene, is why `extent` is there: `TriangleBvh::extent` has it.
pub fn offset_origin_within(p: DVec3, ng: DVec3, dir: DVec3, extent: f64) -> DVec3 {
    let step = OFFSET * (p.x.abs() + p.y.abs() + p.z.abs() + extent);
    p + ng * step.copysign(ng.dot(dir))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_offset_is_to_the_side_of_the_direction_and_scales() {
        let (p, n) = (DVec3::new(3.0, -4.0, 5.0), DVec3::Z);
        for scale in [1e-6, 1.0, 1e6] {
            let up = offset_origin(scale * p, n, DVec3::new(0.6, 0.0, 0.8)) - scale * p;
            let down = offset_origin(scale * p, -n, DVec3::new(0.6, 0.0, -0.8)) - scale * p;
            assert!(up.z > 0.0 && down.z < 0.0 && up.x == 0.0 && down.y == 0.0);
            // 12 · 2⁻⁴⁴ scale, to the rounding of 5 scale.
            assert!((up.z - 12.0 * OFFSET * scale).abs() <= 1e-15 * scale, "{up}");
        }
        assert!(offset_origin_within(DVec3::ZERO, n, n, 1.0).z > 0.0);
    }
}
