//! Rays that go nearly the same way, together through the tree: a box or a triangle is fetched once and tested with many
//! rays at a time, and what to do next is decided once for all of them.
//!
//! Where only a few rays of a bundle enter a box, they go on below it one by one. So a bundle of rays that have nothing
//! in common costs little more than the rays alone.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::fan::{Fan, Spokes};
use super::kernel::Lanes;
use super::leaves::Leaves;
use super::nearest::Nearest;
use super::node::{LEAF, Node, WIDTH};
use super::probe::{Probe, Triangles, load3};
use super::query::{Frame, Query, Twist};
use crate::scene::ray::Ray;

/// Rays of a bundle, at most.
pub(super) const MOST: usize = 32;

/// So many rays are faster one by one: a node costs a bundle about as much as three of them.
const FEW: u32 = 3;

/// The rays' numbers for boxes and triangles, side by side; of vectors, axis by axis.
#[repr(C, align(64))]
struct Bundle {
    scale: [[f32; MOST]; 3],
    near_shift: [[f32; MOST]; 3],
    far_shift: [[f32; MOST]; 3],
    reach: [f32; MOST],
    origin: [[f32; MOST]; 3],
    rest: [[f32; MOST]; 3],
    dir: [[f32; MOST]; 3],
    /// The signs of the directions.
    backwards: [u32; MOST],
    /// The greatest of all.
    slack: f32,
}

/// A box that is still to be looked at, the least distance at which a ray enters it, and the rays that do.
#[derive(Clone, Copy)]
struct Waiting {
    t: f32,
    child: u32,
    rays: u32,
}

/// Finds the nearest hit of up to [`MOST`] rays, whose lengths are as [`Query::new`] wants them.
#[inline(always)]
pub(super) fn closest<T: Twist, N: Lanes, W: Lanes>(
    (n, w): (N, W),
    (nodes, frame): (&[Node], &Frame),
    root: u32,
    leaves: &impl Leaves,
    rays: &[Ray],
    found: &mut [Nearest; MOST],
) {
    let (mut bundle, mut left) = Bundle::of::<T, N>(n, frame, leaves, rays);
    for (nearest, reach) in found.iter_mut().zip(bundle.reach) {
        *nearest = Nearest::within(reach);
    }
    let mut stack: Vec<Waiting> = Vec::with_capacity(64);
    while left != 0 {
        let backwards = bundle.backwards[left.trailing_zeros() as usize % MOST];
        let alike = (0..MOST).fold(0, |all, i| all | u32::from(bundle.backwards[i] == backwards) << i) & left;
        left &= !alike;
        let fan = bundle.fan::<T, N, W>((n, w), backwards, alike);
        stack.push(Waiting { t: 0.0, child: root, rays: alike });
        while let Some(Waiting { t, child, rays: entering }) = stack.pop() {
            let active = bundle.reaching(w, t, entering);
            if active.count_ones() <= FEW {
                let mut active = active;
                while active != 0 {
                    let i = active.trailing_zeros() as usize % MOST;
                    active &= active - 1;
                    if let Some(query) = Query::new::<T>(n, frame, &rays[i]) {
                        found[i].descend::<T, N>(n, (nodes, frame), leaves, child, (&rays[i], &query));
                        bundle.reach[i] = found[i].reach;
                    }
                }
            } else if child & LEAF == 0 {
                let first = stack.len();
                let node = &nodes[child as usize];
                bundle.enter(w, (node, fan.enter(n, node)), backwards, active, &mut stack);
                stack[first..].sort_unstable_by(|a, b| b.t.total_cmp(&a.t));
            } else {
                let leaf = child ^ LEAF;
                let triangles = Apart::of(n, &leaves.triangles(n, leaf));
                for lane in 0..triangles.count() {
                    let one = triangles.of_lane(w, lane);
                    let mut candidates = bundle.candidates(w, &one, leaves.unit(), active);
                    while candidates != 0 {
                        let i = candidates.trailing_zeros() as usize % MOST;
                        candidates &= candidates - 1;
                        found[i].look_at(n, frame, leaves, &rays[i], leaf, lane as u32);
                        bundle.reach[i] = found[i].reach;
                    }
                }
            }
        }
    }
}

impl Bundle {
    /// The rays' numbers, and which of the rays may hit anything.
    #[inline(always)]
    fn of<T: Twist, N: Lanes>(n: N, frame: &Frame, leaves: &impl Leaves, rays: &[Ray]) -> (Self, u32) {
        let zero = [[0.0; MOST]; 3];
        let mut bundle = Self {
            scale: zero,
            near_shift: zero,
            far_shift: zero,
            reach: [0.0; MOST],
            origin: zero,
            rest: zero,
            dir: zero,
            backwards: [0; MOST],
            slack: 0.0,
        };
        let mut able = 0;
        for (i, ray) in rays.iter().take(MOST).enumerate() {
            let Some(query) = Query::new::<T>(n, frame, ray) else { continue };
            let slabs = query.slabs::<T>(n);
            put(n, slabs.scale, &mut bundle.scale, i);
            put(n, slabs.near_shift, &mut bundle.near_shift, i);
            put(n, slabs.far_shift, &mut bundle.far_shift, i);
            bundle.backwards[i] = slabs.backwards;
            let start = leaves.start(n, &query);
            let [origin, rest, dir] = start.rounded(n, &query);
            put(n, origin, &mut bundle.origin, i);
            put(n, rest, &mut bundle.rest, i);
            put(n, dir, &mut bundle.dir, i);
            bundle.slack = bundle.slack.max(start.slack);
            bundle.reach[i] = query.reach;
            able |= 1 << i;
        }
        (bundle, able)
    }

    /// Those of some rays that reach as far as `t`.
    #[inline(always)]
    fn reaching<W: Lanes>(&self, w: W, t: f32, of: u32) -> u32 {
        let t = w.splat(t);
        let mut reaching = 0;
        for from in (0..MOST).step_by(W::LANES) {
            reaching |= w.bits(w.le(t, w.load(&self.reach[from..]))) << from;
        }
        reaching & of
    }

    /// What bounds some rays, all of which go `backwards` along the same axes.
    #[inline(always)]
    fn fan<T: Twist, N: Lanes, W: Lanes>(&self, kernels: (N, W), backwards: u32, rays: u32) -> Fan<N> {
        let Self { scale, near_shift, far_shift, reach, .. } = self;
        Fan::around::<T, W>(kernels, &Spokes { scale, near_shift, far_shift, reach, backwards, rays })
    }

    /// Pushes those of a node's children whose boxes are entered by some of the `active` rays, all of which go `backwards`
    /// along the same axes.
    #[inline(always)]
    fn enter<W: Lanes>(
        &self,
        w: W,
        (node, mut children): (&Node, u32),
        backwards: u32,
        active: u32,
        stack: &mut Vec<Waiting>,
    ) {
        while children != 0 {
            let lane = children.trailing_zeros() as usize % WIDTH;
            children &= children - 1;
            let ([near, far], child) = node.child_of(lane, backwards);
            let (mut rays, mut least) = (0, w.splat(f32::INFINITY));
            for from in (0..MOST).step_by(W::LANES) {
                let scale = load3(w, &self.scale, from);
                let enter = meet(w, near, scale, load3(w, &self.near_shift, from));
                let leave = meet(w, far, scale, load3(w, &self.far_shift, from));
                let entered = w.max(w.max(enter[0], enter[1]), w.max(enter[2], w.splat(0.0)));
                let left = w.min(w.min(leave[0], leave[1]), w.min(leave[2], w.load(&self.reach[from..])));
                let mask = w.and(w.le(entered, left), w.mask(active >> from));
                least = w.min(least, w.select(mask, entered, w.splat(f32::INFINITY)));
                rays |= w.bits(mask) << from;
            }
            if rays != 0 {
                stack.push(Waiting { t: w.least(least), child, rays });
            }
        }
    }

    /// The `active` rays that may hit a triangle before their reach, which is to be multiplied by `unit`; none that does is
    /// missing.
    #[inline(always)]
    fn candidates<W: Lanes>(&self, w: W, triangle: &Triangles<W>, unit: f32, active: u32) -> u32 {
        let mut candidates = 0;
        for from in (0..MOST).step_by(W::LANES) {
            let asked = active >> from;
            if asked.trailing_zeros() as usize >= W::LANES {
                continue;
            }
            let start = [load3(w, &self.origin, from), load3(w, &self.rest, from), load3(w, &self.dir, from)];
            let probe = Probe::of_lanes(start, self.slack);
            let reach = w.mul(w.load(&self.reach[from..]), w.splat(unit));
            candidates |= w.bits(triangle.test(w, &probe).candidates(w, reach)) << from;
        }
        candidates & active
    }
}

/// Writes the vector of ray `i`.
#[inline(always)]
fn put<S: Lanes>(s: S, v: S::H, rows: &mut [[f32; MOST]; 3], i: usize) {
    let v = s.half_array(v);
    for axis in 0..3 {
        rows[axis][i] = v[axis];
    }
}

/// The distances at which rays meet the three planes through a corner of a box.
#[inline(always)]
fn meet<S: Lanes>(s: S, corner: [f32; 3], scale: [S::F; 3], shift: [S::F; 3]) -> [S::F; 3] {
    [
        s.mul_sub(s.splat(corner[0]), scale[0], shift[0]),
        s.mul_sub(s.splat(corner[1]), scale[1], shift[1]),
        s.mul_sub(s.splat(corner[2]), scale[2], shift[2]),
    ]
}

/// One column, each number in all lanes.
#[inline(always)]
fn splat3<S: Lanes>(s: S, rows: &[[f32; WIDTH]; 3], column: usize) -> [S::F; 3] {
    [s.splat(rows[0][column]), s.splat(rows[1][column]), s.splat(rows[2][column])]
}

/// The triangles of a leaf, one by one.
struct Apart {
    rows: [[[f32; WIDTH]; 3]; 4],
    longest: f32,
}

impl Apart {
    #[inline(always)]
    fn of<N: Lanes>(n: N, triangles: &Triangles<N>) -> Self {
        let mut rows = [[[0.0; WIDTH]; 3]; 4];
        for (row, vectors) in rows.iter_mut().zip([triangles.v0, triangles.e1, triangles.e2, triangles.n]) {
            for axis in 0..3 {
                n.store(vectors[axis], &mut row[axis]);
            }
        }
        Self { rows, longest: triangles.longest }
    }

    /// How many there are.
    #[inline(always)]
    fn count(&self) -> usize {
        self.rows[0][0].iter().take_while(|x| !x.is_nan()).count()
    }

    /// One of them in all lanes.
    #[inline(always)]
    fn of_lane<W: Lanes>(&self, w: W, lane: usize) -> Triangles<W> {
        let [v0, e1, e2, n] = &self.rows;
        Triangles {
            v0: splat3(w, v0, lane),
            e1: splat3(w, e1, lane),
            e2: splat3(w, e2, lane),
            n: splat3(w, n, lane),
            longest: self.longest,
        }
    }
}
