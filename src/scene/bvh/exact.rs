//! The intersection that counts: a ray and a triangle in f64, without a gap between neighbours.
//!
//! The vertices are moved so that the ray starts at the origin, and sheared so that it runs along one axis; the
//! triangle then is hit if it contains the origin of the plane of the other two. Each vertex is rounded by itself, so
//! neighbours see the same two points at the ends of a shared edge. Which side of that edge the origin is on is the sign
//! of fl(ax by) − fl(ay bx): since rounding is monotonic, that sign is never wrong, though it may be 0, and 0 counts as
//! inside for both. So a mesh without holes has none for rays either.
//!
//! # References
//! - Woop, Benthin & Wald 2013, Watertight ray/triangle intersection, JCGT 2(1)
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;

use crate::scene::ray::Ray;

/// The vertices of one triangle, and its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners {
    v: [[f64; 3]; 3],
    /// The triangle's index among those that the tree was built of.
    pub(super) triangle: u32,
}

impl Corners {
    pub(super) fn new(v: [DVec3; 3], triangle: u32) -> Self {
        Self { v: v.map(|v| v.to_array()), triangle }
    }

    /// The vertices.
    pub(super) fn vertices(&self) -> [DVec3; 3] {
        self.v.map(DVec3::from_array)
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// The distance, in lengths of the ray's direction.
    pub t: f64,
    /// The triangle's index among those that the tree was built of.
    pub triangle: u32,
    /// The weight of its second vertex: p = (1 − b1 − b2) v0 + b1 v1 + b2 v2.
    pub b1: f64,
    /// The weight of its third vertex.
    pub b2: f64,
}

impl TriangleHit {
    /// Whether this hit is what a ray sees rather than the other: it is nearer, or as near and of lower index.
    #[inline(always)]
    pub(super) fn before(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && self.triangle < other.triangle)
    }
}

/// A ray as the triangles' test needs it: sheared along the axis on which it advances most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear {
    axes: [usize; 3],
    origin: [f64; 3],
    slope: [f64; 2],
    per_depth: f64,
}

impl Shear {
    /// For a direction that is not zero.
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Self {
        let (origin, dir) = (ray.origin.to_array(), ray.dir.to_array());
        let size = ray.dir.abs();
        let z = if size.x >= size.y { usize::from(size.x < size.z) * 2 } else { 1 + usize::from(size.y < size.z) };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let per_depth = 1.0 / dir[axes[2]];
        Self {
            axes,
            origin: [origin[axes[0]], origin[axes[1]], origin[axes[2]]],
            slope: [dir[axes[0]] * per_depth, dir[axes[1]] * per_depth],
            per_depth,
        }
    }

    /// A vertex in coordinates in which the ray runs from the origin along the third axis.
    #[inline(always)]
    fn see(&self, v: &[f64; 3]) -> [f64; 3] {
        let z = v[self.axes[2]] - self.origin[2];
        let x = (v[self.axes[0]] - self.origin[0]) - self.slope[0] * z;
        let y = (v[self.axes[1]] - self.origin[1]) - self.slope[1] * z;
        [x, y, z]
    }

    /// The hit with 0 < t < `t_max`. No product here may be fused, or the signs at a shared edge would differ.
    #[inline(always)]
    pub(super) fn hit(&self, corners: &Corners, t_max: f64) -> Option<TriangleHit> {
        let (a, b, c) = (self.see(&corners.v[0]), self.see(&corners.v[1]), self.see(&corners.v[2]));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let (least, greatest) = (u.min(v).min(w), u.max(v).max(w));
        let det = u + v + w;
        if !((least >= 0.0 || greatest <= 0.0) && det != 0.0) {
            return None;
        }
        let per_det = 1.0 / det;
        let (b0, b1, b2) = (u * per_det, v * per_det, w * per_det);
        let t = (b0 * a[2] + b1 * b[2] + b2 * c[2]) * self.per_depth;
        (t > 0.0 && t < t_max).then_some(TriangleHit { t, triangle: corners.triangle, b1, b2 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn a_ray_aimed_at_a_point_of_a_triangle_hits_it_there(
            v in prop::array::uniform3(point()), b in (0.01..0.49_f64, 0.01..0.49_f64), from in point()
        ) {
            let target = (1.0 - b.0 - b.1) * v[0] + b.0 * v[1] + b.1 * v[2];
            let (dir, distance) = ((target - from).normalize(), (target - from).length());
            let normal = (v[1] - v[0]).cross(v[2] - v[0]);
            // Slivers and grazing rays amplify rounding without bound; here by less than 1e5.
            prop_assume!(normal.length() > 1e-2 && normal.dot(dir).abs() > 1e-3);
            let hit = Shear::new(&Ray::new(from, dir)).hit(&Corners::new(v, 7), f64::INFINITY);
            let hit = hit.expect("a hit");
            prop_assert!((hit.t - distance).abs() <= 1e-11 && hit.triangle == 7);
            prop_assert!((hit.b1 - b.0).abs() <= 1e-11 && (hit.b2 - b.1).abs() <= 1e-11, "{hit:?}");
            prop_assert!(Shear::new(&Ray::new(from, -dir)).hit(&Corners::new(v, 7), f64::INFINITY).is_none());
            prop_assert!(Shear::new(&Ray::new(from, dir)).hit(&Corners::new(v, 7), hit.t).is_none(), "t_max is exclusive");
        }
    }

    /// How many of `count` rays aimed at random points of the edge of two triangles pass between them.
    fn leaks(count: u64, hits: impl Fn(&Ray, &[DVec3; 3]) -> bool) -> u64 {
        let mut rng = stream(3, 1, 4);
        let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * uniform(&mut rng) - 1.0));
        let mut leaked = 0;
        for _ in 0..count {
            let (a, b, c, d, from) = (point(), point(), point(), point(), 3.0 * point());
            let mid = 0.5 * (a + b);
            // Wings on opposite sides of the edge, seen by the ray: a fold could be missed on its outside, rightly.
            let side = |p: DVec3| (a - from).cross(b - from).dot(p - from);
            if side(c) * side(d) >= 0.0 {
                continue;
            }
            let ray = Ray::new(from, (mid + 0.3 * (b - a) - from).normalize());
            leaked += u64::from(!hits(&ray, &[a, b, c]) && !hits(&ray, &[b, a, d]));
        }
        leaked
    }

    /// Möller and Trumbore's test, which rounds each triangle's edges in its own way.
    fn by_two_edges(ray: &Ray, v: &[DVec3; 3]) -> bool {
        let (e1, e2, s) = (v[1] - v[0], v[2] - v[0], ray.origin - v[0]);
        let p = ray.dir.cross(e2);
        let (b1, q) = (s.dot(p) / e1.dot(p), s.cross(e1));
        let b2 = ray.dir.dot(q) / e1.dot(p);
        b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 && e2.dot(q) / e1.dot(p) > 0.0
    }

    #[test]
    fn no_ray_passes_between_neighbours() {
        let ours = |ray: &Ray, v: &[DVec3; 3]| Shear::new(ray).hit(&Corners::new(*v, 0), f64::INFINITY).is_some();
        assert_eq!(leaks(100_000, ours), 0);
        assert!(leaks(100_000, by_two_edges) > 0, "a test that leaks must be seen to leak");
    }

    #[test]
    fn degenerate_triangles_and_planes_along_the_ray_are_not_hit() {
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        let point = Corners::new([DVec3::X; 3], 0);
        let along = Corners::new([DVec3::X, 2.0 * DVec3::X, DVec3::new(1.5, 1.0, 0.0)], 0);
        assert!(Shear::new(&ray).hit(&point, f64::INFINITY).is_none());
        assert!(Shear::new(&ray).hit(&along, f64::INFINITY).is_none());
    }
}
