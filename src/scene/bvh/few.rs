//! So few triangles that testing them all is faster than choosing among them.
//!
//! A tree's every step is a branch that no predictor knows. Sixteen triangles take a vector of AVX-512 about twenty cycles,
//! about what one wrong guess costs.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;

use super::build::Tree;
use super::exact::{Corners, Shear, TriangleHit};
use super::kernel::Lanes;
use super::probe::{Probe, Start, Triangles, load3, longest_edge};
use super::query::{Frame, Query, Twist, up};
use crate::scene::ray::Ray;

/// The widest vector's lanes.
const LANES: usize = 16;

/// Up to four vectors; their lanes are the bits of a u64.
const MOST: usize = 4;

/// Sixteen triangles in f32.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Batch {
    /// First vertices, the edges from there to the second and third, and their cross product. Absent triangles are at NaN.
    rows: [[[f32; LANES]; 3]; 4],
    longest: f32,
}

/// All triangles, in the order of the tree's.
#[derive(Clone, Debug)]
pub(super) struct Few {
    batches: Vec<Batch>,
    corners: Vec<Corners>,
    /// Of each triangle by its index, its lane's bit; 0 for those that cannot be hit.
    bit_of: Vec<u64>,
}

impl Few {
    /// None if they are too many.
    pub(super) fn new(tree: &Tree, frame: &Frame, vertices: impl Fn(u32) -> [DVec3; 3] + Sync) -> Option<Self> {
        if tree.items.len() > MOST * LANES {
            return None;
        }
        let corners = Corners::of_tree(tree, vertices);
        let triangles: Vec<[DVec3; 3]> = corners.iter().map(|t| t.vertices().map(|v| frame.enter(v))).collect();
        let batch = |triangles: &[[DVec3; 3]]| {
            let mut rows = [[[f32::NAN; LANES]; 3]; 4];
            for (lane, v) in triangles.iter().enumerate() {
                let (e1, e2) = (v[1] - v[0], v[2] - v[0]);
                for (row, vector) in rows.iter_mut().zip([v[0], e1, e2, e1.cross(e2)]) {
                    for axis in 0..3 {
                        row[axis][lane] = vector[axis] as f32;
                    }
                }
            }
            Batch { rows, longest: longest_edge(triangles, 1.0) }
        };
        let mut bit_of = vec![0; corners.iter().map(|t| t.triangle() as usize + 1).max().unwrap_or(0)];
        for (lane, corners) in corners.iter().enumerate() {
            bit_of[corners.triangle() as usize] = 1 << lane;
        }
        Some(Self { batches: triangles.chunks(LANES).map(batch).collect(), corners, bit_of })
    }

    /// What they occupy.
    pub(super) fn memory_bytes(&self) -> usize {
        self.batches.capacity() * size_of::<Batch>()
            + self.corners.capacity() * size_of::<Corners>()
            + self.bit_of.capacity() * size_of::<u64>()
    }

    /// The triangles just off which the ray neither starts nor ends.
    #[inline(always)]
    fn not_beside(&self, ray: &Ray) -> u64 {
        let bit = |triangle: u32| self.bit_of.get(triangle as usize).copied().unwrap_or(0);
        let [a, b, c] = ray.beside;
        !(bit(a) | bit(b) | bit(c))
    }

    /// The nearest hit.
    #[inline(always)]
    pub(super) fn closest<T: Twist, S: Lanes>(&self, s: S, frame: &Frame, ray: &Ray) -> Option<TriangleHit> {
        let query = Query::new::<T>(s, frame, ray)?;
        let probe = Probe::new(s, &query, &Start { origin: query.origin, slack: query.slack });
        let reach = s.splat(query.reach);
        let far = s.splat(f32::INFINITY);
        let mut bounds = Bounds([[f32::INFINITY; LANES]; MOST]);
        let mut least = far;
        let allowed = self.not_beside(ray);
        let mut candidates = 0_u64;
        for (at, batch) in self.batches.iter().take(MOST).enumerate() {
            for from in (0..LANES).step_by(S::LANES) {
                let tested = batch.triangles(s, from).test(s, &probe);
                let mask = s.and(tested.candidates(s, reach), s.mask((allowed >> (at * LANES + from)) as u32));
                let bound = s.select(mask, tested.no_nearer_than(s), far);
                least = s.min(least, bound);
                s.store(bound, &mut bounds.0[at][from..]);
                candidates |= u64::from(s.bits(mask)) << (at * LANES + from);
            }
        }
        if candidates == 0 {
            return None;
        }
        let shear = Shear::new(s, ray);
        let mut best: Option<TriangleHit> = None;
        let nearest = candidates & bounds.within(s, s.least(least), self.batches.len());
        // No bound is NaN as long as there is slack; without, all are asked.
        let mut next = if nearest == 0 { candidates } else { nearest }.trailing_zeros();
        loop {
            candidates &= !(1 << next);
            let corners = &self.corners[next as usize];
            if let Some(place) = shear.hit(s, |axis| corners.row(s, axis), ray.t_max) {
                let hit = place.of(corners.triangle());
                if best.as_ref().is_none_or(|best| hit.before(best)) {
                    candidates &= bounds.within(s, up(hit.t * frame.scale), self.batches.len());
                    best = Some(hit);
                }
            }
            if candidates == 0 {
                return best;
            }
            next = bounds.nearest(candidates);
        }
    }

    /// Whether there is a hit.
    #[inline(always)]
    pub(super) fn occluded<T: Twist, S: Lanes>(&self, s: S, frame: &Frame, ray: &Ray) -> bool {
        let Some(query) = Query::new::<T>(s, frame, ray) else { return false };
        let probe = Probe::new(s, &query, &Start { origin: query.origin, slack: query.slack });
        let reach = s.splat(query.reach);
        let allowed = self.not_beside(ray);
        let (mut candidates, mut certain) = (0_u64, 0);
        for (at, batch) in self.batches.iter().take(MOST).enumerate() {
            for from in (0..LANES).step_by(S::LANES) {
                let tested = batch.triangles(s, from).test(s, &probe);
                candidates |= u64::from(s.bits(tested.candidates(s, reach))) << (at * LANES + from);
                certain |= s.bits(tested.certain(s, reach));
            }
        }
        // What is certain is not beside the ray.
        candidates &= allowed;
        if certain != 0 || candidates == 0 {
            return certain != 0;
        }
        let shear = Shear::new(s, ray);
        while candidates != 0 {
            let next = candidates.trailing_zeros();
            candidates &= candidates - 1;
            let corners = &self.corners[next as usize];
            if shear.hit(s, |axis| corners.row(s, axis), ray.t_max).is_some() {
                return true;
            }
        }
        false
    }
}

impl Batch {
    /// The triangles of a vector that begins at lane `from`.
    #[inline(always)]
    fn triangles<S: Lanes>(&self, s: S, from: usize) -> Triangles<S> {
        let [v0, e1, e2, n] = &self.rows;
        let (v0, e1, e2, n) = (load3(s, v0, from), load3(s, e1, from), load3(s, e2, from), load3(s, n, from));
        Triangles { v0, e1, e2, n, longest: self.longest }
    }
}

/// Of each triangle, a distance that its hit is not nearer than.
#[repr(align(64))]
struct Bounds([[f32; LANES]; MOST]);

impl Bounds {
    /// Which are no greater than `limit`, among the first `batches`.
    #[inline(always)]
    fn within<S: Lanes>(&self, s: S, limit: f32, batches: usize) -> u64 {
        let limit = s.splat(limit);
        let mut all = 0;
        for (at, row) in self.0.iter().take(batches).enumerate() {
            for from in (0..LANES).step_by(S::LANES) {
                all |= u64::from(s.bits(s.le(s.load(&row[from..]), limit))) << (at * LANES + from);
            }
        }
        all
    }

    /// Which of some is least.
    #[inline(always)]
    fn nearest(&self, mut among: u64) -> u32 {
        let bound = |at: u32| self.0[at as usize / LANES % MOST][at as usize % LANES];
        let mut nearest = among.trailing_zeros() & 63;
        while among != 0 {
            let at = among.trailing_zeros();
            among &= among - 1;
            if bound(at) < bound(nearest) {
                nearest = at;
            }
        }
        nearest
    }
}
