//! A tree over triangles.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use std::marker::PhantomData;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::aabb::Aabb;
use super::build::{Item, Tree};
use super::bundle;
use super::exact::{Shear, TriangleHit};
use super::few::Few;
use super::kernel::{Lanes, Level, Task, in_huge_pages};
use super::leaves::{Exact, Leaves, Rounded};
use super::nearest::Nearest;
use super::node::{Beam, Node, WIDTH};
use super::probe::Probe;
use super::query::{Frame, Query, Straight, Twist};
use super::walk;
use crate::scene::ray::Ray;

/// Triangles, for rays to be intersected with.
///
/// A hit is that of the f64 test of all triangles, with the least t and, among equals, the least index: the tree and its
/// f32 only rule out what that test would rule out too. A closed mesh has no gaps.
///
/// Triangles with a vertex that is not finite (or beyond 10¹⁵⁰ in size), with an index out of range or with no area are
/// never hit.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    level: Level,
    frame: Frame,
    bounds: Aabb,
    nodes: Vec<Node>,
    root: Option<u32>,
    leaves: Kind,
}

/// What is below the tree's nodes, or instead of them.
#[derive(Clone, Debug)]
enum Kind {
    Few(Few),
    Exact(Exact),
    Rounded(Rounded),
}

/// Coordinates up to this size have products in f64.
const LARGEST: f64 = 1e150;

/// x as f32, not greater and not smaller.
fn outwards(lo: f64, hi: f64) -> (f32, f32) {
    let (near_lo, near_hi) = (lo as f32, hi as f32);
    (
        if f64::from(near_lo) <= lo { near_lo } else { near_lo.next_down() },
        if f64::from(near_hi) >= hi { near_hi } else { near_hi.next_up() },
    )
}

/// A box in the tree's coordinates, rounded outwards.
pub(super) fn item(frame: &Frame, bounds: &Aabb, index: u32) -> Item {
    let (min, max) = (frame.enter(bounds.min), frame.enter(bounds.max));
    let [x, y, z] = [0, 1, 2].map(|k| outwards(min[k], max[k]));
    Item::new([x.0, y.0, z.0], [x.1, y.1, z.1], index)
}

/// The vertices, if they make a triangle that can be hit.
fn vertices(positions: &[DVec3], triangle: [u32; 3]) -> Option<[DVec3; 3]> {
    let [a, b, c] = triangle.map(|index| positions.get(index as usize).copied());
    let v = [a?, b?, c?];
    let sound = v.iter().all(|v| v.abs().max_element() <= LARGEST && !v.is_nan());
    (sound && (v[1] - v[0]).cross(v[2] - v[0]) != DVec3::ZERO).then_some(v)
}

/// The square of a direction's length as a [`Query`] wants it.
const PROPER: Range<f64> = 0.81..1.21;

/// Triangles are gathered in parallel in pieces of this size.
const PIECE: usize = 1 << 14;

impl TriangleBvh {
    /// Builds the tree, in parallel, and the same one on any number of threads.
    ///
    /// `triangles` are indices into `positions`, no more than 2³⁰ of them.
    pub fn build(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        Self::build_at(Level::best(), positions, triangles)
    }

    pub(super) fn build_at(level: Level, positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let piece_bounds = |piece: &[[u32; 3]]| {
            Aabb::around(piece.iter().filter_map(|&triangle| vertices(positions, triangle)).flatten())
        };
        let bounds = triangles.par_chunks(PIECE).map(piece_bounds).reduce(|| Aabb::EMPTY, Aabb::union);
        let frame = Frame::of(&bounds);
        // In place, and those that cannot be hit taken out afterwards: gathering an unknown number would copy all.
        let mut items = in_huge_pages(triangles.len());
        let of_all = triangles.par_iter().enumerate().map(|(index, &triangle)| {
            vertices(positions, triangle).map(|v| item(&frame, &Aabb::around(v), index as u32))
        });
        of_all.map(|item| item.unwrap_or(Item::NONE)).collect_into_vec(&mut items);
        items.retain(Item::is_some);
        let tree = Tree::build(items, WIDTH, level);
        let vertices = |index: u32| triangles[index as usize].map(|vertex| positions[vertex as usize]);
        let few = Few::new(&tree, &frame, vertices).map(Kind::Few);
        let exact = || Exact::new(&tree, &frame, vertices).map(Kind::Exact);
        let leaves = few.or_else(exact).unwrap_or_else(|| Kind::Rounded(Rounded::new(&tree, &frame, vertices)));
        Self { level, frame, bounds, nodes: tree.nodes, root: tree.root, leaves }
    }

    pub(super) fn level(&self) -> Level {
        self.level
    }

    /// The nearest hit with 0 < t < `ray.t_max`.
    ///
    /// None too for a ray that is no ray: one with a coordinate that is NaN or infinite, or with a direction of length 0.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<TriangleHit> {
        self.closest_with::<Straight>(ray)
    }

    /// Whether there is a hit with 0 < t < `ray.t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_with::<Straight>(ray)
    }

    /// With the ray's f32 numbers changed, for tests of what their slack is good for.
    #[inline(always)]
    pub(super) fn closest_with<T: Twist>(&self, ray: &Ray) -> Option<TriangleHit> {
        if PROPER.contains(&ray.dir.length_squared()) {
            return self.level.run(Closest::<T> { tree: self, ray, twist: PhantomData });
        }
        let (unit, length) = normalised(ray)?;
        let hit = self.level.run(Closest::<T> { tree: self, ray: &unit, twist: PhantomData })?;
        Some(TriangleHit { t: hit.t / length, ..hit })
    }

    /// [`Self::closest`] of each ray, at least as many hits as rays: faster for those that go nearly the same way.
    pub fn closest_of_each(&self, rays: &[Ray], hits: &mut [Option<TriangleHit>]) {
        self.closest_of_each_with::<Straight>(rays, hits);
    }

    /// As [`Self::closest_with`].
    pub(super) fn closest_of_each_with<T: Twist>(&self, rays: &[Ray], hits: &mut [Option<TriangleHit>]) {
        for (rays, hits) in rays.chunks(bundle::MOST).zip(hits.chunks_mut(bundle::MOST)) {
            if rays.iter().all(|ray| PROPER.contains(&ray.dir.length_squared())) {
                self.level.run(ClosestOfEach::<T> { tree: self, rays, hits, twist: PhantomData });
            } else {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.closest_with::<T>(ray);
                }
            }
        }
    }

    /// As [`Self::closest_with`].
    #[inline(always)]
    pub(super) fn occluded_with<T: Twist>(&self, ray: &Ray) -> bool {
        if PROPER.contains(&ray.dir.length_squared()) {
            return self.level.run(Occluded::<T> { tree: self, ray, twist: PhantomData });
        }
        normalised(ray)
            .is_some_and(|(unit, _)| self.level.run(Occluded::<T> { tree: self, ray: &unit, twist: PhantomData }))
    }

    /// The box around all triangles that can be hit; empty if there is none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The size of the largest coordinate, for [`offset_origin_within`](crate::scene::ray::offset_origin_within).
    pub fn extent(&self) -> f64 {
        if self.bounds.is_empty() { 0.0 } else { self.bounds.min.abs().max(self.bounds.max.abs()).max_element() }
    }

    /// What the tree occupies.
    pub fn memory_bytes(&self) -> usize {
        let leaves = match &self.leaves {
            Kind::Few(few) => few.memory_bytes(),
            Kind::Exact(leaves) => leaves.memory_bytes(),
            Kind::Rounded(leaves) => leaves.memory_bytes(),
        };
        self.nodes.capacity() * size_of::<Node>() + leaves + size_of::<Self>()
    }
}

/// The same ray with a direction of length 1, and the length that it had; None if that is 0 or not finite.
#[cold]
fn normalised(ray: &Ray) -> Option<(Ray, f64)> {
    let length = ray.dir.length();
    let unit = Ray::up_to(ray.origin, ray.dir / length, ray.t_max * length);
    (length > 0.0 && length.is_finite()).then_some((unit, length))
}

struct Closest<'a, T> {
    tree: &'a TriangleBvh,
    ray: &'a Ray,
    twist: PhantomData<T>,
}

impl<T: Twist> Task for Closest<'_, T> {
    type Output = Option<TriangleHit>;

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) -> Option<TriangleHit> {
        match &self.tree.leaves {
            Kind::Few(few) => few.closest::<T, W>(wide, &self.tree.frame, self.ray),
            Kind::Exact(leaves) => self.below(narrow, leaves),
            Kind::Rounded(leaves) => self.below(narrow, leaves),
        }
    }
}

impl<T: Twist> Closest<'_, T> {
    #[inline(always)]
    fn below<S: Lanes>(self, s: S, leaves: &impl Leaves) -> Option<TriangleHit> {
        let Self { tree, ray, .. } = self;
        let query = Query::new::<T>(s, &tree.frame, ray)?;
        let mut nearest = Nearest::within(query.reach);
        nearest.descend::<T, S>(s, (&tree.nodes, &tree.frame), leaves, tree.root?, (ray, &query));
        nearest.hit(leaves)
    }
}

/// The nearest hits of a bundle of rays of proper length.
struct ClosestOfEach<'a, T> {
    tree: &'a TriangleBvh,
    rays: &'a [Ray],
    hits: &'a mut [Option<TriangleHit>],
    twist: PhantomData<T>,
}

impl<T: Twist> Task for ClosestOfEach<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) {
        match &self.tree.leaves {
            Kind::Few(few) => {
                for (ray, hit) in self.rays.iter().zip(self.hits) {
                    *hit = few.closest::<T, W>(wide, &self.tree.frame, ray);
                }
            }
            Kind::Exact(leaves) => self.below(narrow, wide, leaves),
            Kind::Rounded(leaves) => self.below(narrow, wide, leaves),
        }
    }
}

impl<T: Twist> ClosestOfEach<'_, T> {
    #[inline(always)]
    fn below<N: Lanes, W: Lanes>(self, narrow: N, wide: W, leaves: &impl Leaves) {
        let Self { tree, rays, hits, .. } = self;
        let Some(root) = tree.root else { return hits.fill(None) };
        let mut found = [Nearest::within(0.0); bundle::MOST];
        let of_tree = (&tree.nodes[..], &tree.frame);
        bundle::closest::<T, _, _>((narrow, wide), of_tree, root, leaves, rays, &mut found);
        for (hit, nearest) in hits.iter_mut().zip(&found) {
            *hit = nearest.hit(leaves);
        }
    }
}

struct Occluded<'a, T> {
    tree: &'a TriangleBvh,
    ray: &'a Ray,
    twist: PhantomData<T>,
}

impl<T: Twist> Task for Occluded<'_, T> {
    type Output = bool;

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) -> bool {
        match &self.tree.leaves {
            Kind::Few(few) => few.occluded::<T, W>(wide, &self.tree.frame, self.ray),
            Kind::Exact(leaves) => self.below(narrow, leaves),
            Kind::Rounded(leaves) => self.below(narrow, leaves),
        }
    }
}

impl<T: Twist> Occluded<'_, T> {
    #[inline(always)]
    fn below<S: Lanes>(self, s: S, leaves: &impl Leaves) -> bool {
        let Self { tree, ray, .. } = self;
        let Some(root) = tree.root else { return false };
        let Some(query) = Query::new::<T>(s, &tree.frame, ray) else { return false };
        let beam = Beam::new(s, &query.slabs::<T>(s));
        let probe = Probe::new(s, &query, &leaves.start(s, &query));
        let reach = s.splat(query.reach * leaves.unit());
        walk::any(s, &tree.nodes, root, &beam, query.reach, leaves, |leaf| {
            let tested = leaves.triangles(s, leaf).test(s, &probe);
            let mut candidates = s.bits(tested.candidates(s, reach));
            if candidates == 0 {
                return false;
            }
            if s.bits(tested.certain(s, reach)) != 0 {
                return true;
            }
            while candidates != 0 {
                let lane = candidates.trailing_zeros();
                candidates &= candidates - 1;
                if !ray.is_beside(leaves.triangle(leaf, lane))
                    && Shear::new(s, ray).hit(s, |axis| leaves.row(s, leaf, lane, axis), ray.t_max).is_some()
                {
                    return true;
                }
            }
            false
        })
    }
}
