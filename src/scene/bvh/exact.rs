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
use rayon::prelude::*;

use super::build::Tree;
use super::kernel::{Lanes, in_huge_pages};
use crate::scene::ray::Ray;

/// The vertices of one triangle, and its number: x of the three, y, z, and the number in the low bits of something near 1.
///
/// Rows of four overlap, so the fourth of the last is read along; as a plain integer it would be a denormal number,
/// which processors are slow with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners([f64; 10]);

impl Corners {
    pub(super) fn new([a, b, c]: [DVec3; 3], triangle: u32) -> Self {
        let number = f64::from_bits(1.0_f64.to_bits() | u64::from(triangle));
        Self([a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z, number])
    }

    /// The vertices.
    pub(super) fn vertices(&self) -> [DVec3; 3] {
        let v = &self.0;
        [DVec3::new(v[0], v[3], v[6]), DVec3::new(v[1], v[4], v[7]), DVec3::new(v[2], v[5], v[8])]
    }

    /// Of all triangles of a tree, in its order.
    pub(super) fn of_tree(tree: &Tree, vertices: impl Fn(u32) -> [DVec3; 3] + Sync) -> Vec<Self> {
        let mut corners = in_huge_pages(tree.items.len());
        let of_item = tree.items.par_iter().map(|item| Self::new(vertices(item.index()), item.index()));
        of_item.collect_into_vec(&mut corners);
        corners
    }

    /// A coordinate of the three vertices.
    #[inline(always)]
    pub(super) fn row<S: Lanes>(&self, s: S, axis: usize) -> S::D {
        s.quad_load(&self.0[3 * axis..][..4])
    }

    /// The triangle's index among those that the tree was built of.
    #[inline(always)]
    pub(super) fn triangle(&self) -> u32 {
        self.0[9].to_bits() as u32
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

/// A [`TriangleHit`] without its triangle.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) t: f64,
    b1: f64,
    b2: f64,
}

impl Place {
    /// The hit of a triangle.
    #[inline(always)]
    pub(super) fn of(self, triangle: u32) -> TriangleHit {
        TriangleHit { t: self.t, triangle, b1: self.b1, b2: self.b2 }
    }
}

/// A ray as the triangles' test needs it: sheared along the axis on which it advances most.
pub(super) struct Shear<S: Lanes> {
    axes: [usize; 3],
    origin: [S::D; 3],
    slope: [S::D; 2],
    per_depth: f64,
}

impl<S: Lanes> Shear<S> {
    /// For a direction that is not zero.
    #[inline(always)]
    pub(super) fn new(s: S, ray: &Ray) -> Self {
        let (o, d) = (ray.origin, ray.dir);
        let (origin, dir) = ([o.x, o.y, o.z, 0.0], [d.x, d.y, d.z, 0.0]);
        let size = ray.dir.abs();
        // Products instead of branches, which random directions would make wrong half of the time, and the axes from a word
        // of three rather than from a table in memory.
        let z = (1 + usize::from(size.z > size.y)) * usize::from(size.y.max(size.z) > size.x);
        let axes = [(0b00_10_01 >> (2 * z)) & 3, (0b01_00_10 >> (2 * z)) & 3, z];
        let per_depth = 1.0 / dir[axes[2]];
        Self {
            axes,
            origin: [s.quad_splat(origin[axes[0]]), s.quad_splat(origin[axes[1]]), s.quad_splat(origin[axes[2]])],
            slope: [s.quad_splat(dir[axes[0]] * per_depth), s.quad_splat(dir[axes[1]] * per_depth)],
            per_depth,
        }
    }

    /// The hit with 0 < t < `t_max` of the triangle whose vertices have the coordinates `row(axis)`. No product here may be fused, or the signs at a shared edge would differ.
    #[inline(always)]
    pub(super) fn hit(&self, s: S, row: impl Fn(usize) -> S::D, t_max: f64) -> Option<Place> {
        let z = s.quad_sub(row(self.axes[2]), self.origin[2]);
        let x = s.quad_sub(s.quad_sub(row(self.axes[0]), self.origin[0]), s.quad_mul(self.slope[0], z));
        let y = s.quad_sub(s.quad_sub(row(self.axes[1]), self.origin[1]), s.quad_mul(self.slope[1], z));
        // The edge from the third vertex to the second, from the first to the third, from the second to the first.
        let edges = s.quad_sub(
            s.quad_mul(s.quad_turn_twice(x), s.quad_turn(y)),
            s.quad_mul(s.quad_turn_twice(y), s.quad_turn(x)),
        );
        let det = s.quad_sum(edges);
        if !(s.quad_of_one_sign(edges) & (s.quad_first(det) != 0.0)) {
            return None;
        }
        let weights = s.quad_div(edges, det);
        let t = s.quad_first(s.quad_sum(s.quad_mul(weights, z))) * self.per_depth;
        let [_, b1, b2, _] = s.quad_array(weights);
        (t > 0.0 && t < t_max).then_some(Place { t, b1, b2 })
    }
}

/// The hit of one triangle, by plain arithmetic.
#[cfg(test)]
pub(super) fn hit(ray: &Ray, v: [DVec3; 3], triangle: u32) -> Option<TriangleHit> {
    struct One<'a>(&'a Ray, Corners);
    impl super::kernel::Task for One<'_> {
        type Output = Option<TriangleHit>;
        fn run<N: Lanes, W: Lanes>(self, s: N, _: W) -> Option<TriangleHit> {
            let place = Shear::new(s, self.0).hit(s, |axis| self.1.row(s, axis), self.0.t_max)?;
            Some(place.of(self.1.triangle()))
        }
    }
    super::kernel::Level::PORTABLE.run(One(ray, Corners::new(v, triangle)))
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
            let at = hit(&Ray::new(from, dir), v, 7);
            let at = at.expect("a hit");
            prop_assert!((at.t - distance).abs() <= 1e-11 && at.triangle == 7);
            prop_assert!((at.b1 - b.0).abs() <= 1e-11 && (at.b2 - b.1).abs() <= 1e-11, "{at:?}");
            prop_assert!(hit(&Ray::new(from, -dir), v, 7).is_none());
            prop_assert!(hit(&Ray::up_to(from, dir, at.t), v, 7).is_none(), "t_max is exclusive");
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
        let ours = |ray: &Ray, v: &[DVec3; 3]| hit(ray, *v, 0).is_some();
        assert_eq!(leaks(100_000, ours), 0);
        assert!(leaks(100_000, by_two_edges) > 0, "a test that leaks must be seen to leak");
    }

    #[test]
    fn degenerate_triangles_and_planes_along_the_ray_are_not_hit() {
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        assert!(hit(&ray, [DVec3::X; 3], 0).is_none());
        assert!(hit(&ray, [DVec3::X, 2.0 * DVec3::X, DVec3::new(1.5, 1.0, 0.0)], 0).is_none());
    }
}
