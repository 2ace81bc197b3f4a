//! Eight boxes, and eight triangles, side by side: what one vector instruction works on.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::{DVec3, Vec4};

use super::kernel::Lanes;
use super::query::{Query, Slabs};

/// How many children a node and how many triangles a leaf has.
pub(super) const WIDTH: usize = 8;

/// Set in a child that is a leaf; the other bits are its index, among leaves or among nodes.
pub(super) const LEAF: u32 = 1 << 31;

/// The boxes of eight children and where these are.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// For each axis, the least and the greatest coordinates. An absent child has them the wrong way round.
    planes: [[[f32; WIDTH]; 2]; 3],
    /// A child: see [`LEAF`].
    pub(super) child: [u32; WIDTH],
}

impl Node {
    /// Without children.
    pub(super) const EMPTY: Self =
        Self { planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3], child: [LEAF; WIDTH] };

    /// Puts a child into a lane.
    pub(super) fn set(&mut self, lane: usize, lo: Vec4, hi: Vec4, child: u32) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = lo[axis];
            self.planes[axis][1][lane] = hi[axis];
        }
        self.child[lane] = child;
    }
}

/// [`Slabs`] with every number in all lanes.
pub(super) struct Beam<S: Lanes> {
    near: [usize; 3],
    scale: [S::F; 3],
    near_shift: [S::F; 3],
    far_shift: [S::F; 3],
}

impl<S: Lanes> Beam<S> {
    #[inline(always)]
    pub(super) fn new(s: S, slabs: &Slabs<S>) -> Self {
        let backwards = slabs.backwards as usize;
        Self {
            near: [backwards & 1, backwards >> 1 & 1, backwards >> 2 & 1],
            scale: s.spread(slabs.scale),
            near_shift: s.spread(slabs.near_shift),
            far_shift: s.spread(slabs.far_shift),
        }
    }

    /// Distances at which the ray enters the boxes, and which boxes it passes through before `reach`.
    #[inline(always)]
    pub(super) fn enter(&self, s: S, node: &Node, reach: S::F) -> (S::F, u32) {
        let near = |k: usize| {
            let row = &node.planes[k][self.near[k] & 1];
            s.mul_sub(s.load(row), self.scale[k], self.near_shift[k])
        };
        let far = |k: usize| {
            let row = &node.planes[k][(self.near[k] & 1) ^ 1];
            s.mul_sub(s.load(row), self.scale[k], self.far_shift[k])
        };
        let enter = s.max(s.max(near(0), near(1)), s.max(near(2), s.splat(0.0)));
        let leave = s.min(s.min(far(0), far(1)), s.min(far(2), reach));
        (enter, s.bits(s.le(enter, leave)))
    }
}

/// Eight triangles in f32, and where their vertices in f64 begin.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// First vertices, then the edges from there to the second and to the third. Absent triangles are at NaN, and so
    /// are never hit.
    rows: [[[f32; WIDTH]; 3]; 3],
    /// No edge is longer: E of [`Query`].
    longest: f32,
    /// The index of the first of them among the tree's triangles.
    pub(super) first: u32,
}

impl Block {
    /// Of triangles in the tree's coordinates, at most eight, that begin at `first` in the tree's order.
    pub(super) fn new(triangles: &[[DVec3; 3]], first: u32) -> Self {
        let mut block = Self { rows: [[[f32::NAN; WIDTH]; 3]; 3], longest: longest_edge(triangles), first };
        for (lane, v) in triangles.iter().enumerate() {
            for (row, vector) in block.rows.iter_mut().zip([v[0], v[1] - v[0], v[2] - v[0]]) {
                for axis in 0..3 {
                    row[axis][lane] = vector[axis] as f32;
                }
            }
        }
        block
    }

    /// Tests the triangles.
    #[inline(always)]
    pub(super) fn test<S: Lanes>(&self, s: S, probe: &Probe<S>) -> Tested<S> {
        let [v0, e1, e2] = &self.rows;
        let (v0, e1, e2) = (load3(s, v0, 0), load3(s, e1, 0), load3(s, e2, 0));
        probe.test(s, v0, e1, e2, cross(s, e1, e2), self.longest)
    }
}

/// What no edge at the first vertex of some triangles exceeds, and no less than what keeps its square and the square's
/// rounding among the normal numbers of f32.
pub(super) fn longest_edge(triangles: &[[DVec3; 3]]) -> f32 {
    let edges = triangles.iter().flat_map(|v| [v[1] - v[0], v[2] - v[0]]);
    let longest = edges.fold(0.0_f64, |longest, edge| longest.max(edge.length_squared())).sqrt();
    (longest * (1.0 + 1e-6)).max(1e-15) as f32
}

/// A [`Query`]'s part for triangles, with every number in all lanes.
pub(super) struct Probe<S: Lanes> {
    origin: [S::F; 3],
    dir: [S::F; 3],
    slack: f32,
}

/// Eight or sixteen triangles after their test: U, V, W, T and D of [`Query`], with the sign of D taken out.
pub(super) struct Tested<S: Lanes> {
    /// The least of U, V, W.
    inside: S::F,
    /// T.
    depth: S::F,
    /// |D|.
    det: S::F,
    /// The slack of `inside`.
    slack: S::F,
    /// The slack of `depth`.
    depth_slack: S::F,
}

/// Three rows from lane `from` on. Not by `array::map`, whose closure the compiler may leave without the level's
/// instructions.
#[inline(always)]
pub(super) fn load3<S: Lanes, const N: usize>(s: S, rows: &[[f32; N]; 3], from: usize) -> [S::F; 3] {
    [s.load(&rows[0][from..]), s.load(&rows[1][from..]), s.load(&rows[2][from..])]
}

#[inline(always)]
fn cross<S: Lanes>(s: S, a: [S::F; 3], b: [S::F; 3]) -> [S::F; 3] {
    let part = |i: usize, j: usize| s.mul_sub(a[i], b[j], s.mul(a[j], b[i]));
    [part(1, 2), part(2, 0), part(0, 1)]
}

#[inline(always)]
fn dot<S: Lanes>(s: S, a: [S::F; 3], b: [S::F; 3]) -> S::F {
    s.mul_add(a[0], b[0], s.mul_add(a[1], b[1], s.mul(a[2], b[2])))
}

impl<S: Lanes> Probe<S> {
    #[inline(always)]
    pub(super) fn new(s: S, query: &Query<S>) -> Self {
        Self { origin: query.origin(s), dir: query.dir(s), slack: query.slack }
    }

    /// Tests triangles given by their first vertices, the edges from there and their normals e1 × e2, no edge being longer
    /// than `longest`.
    #[inline(always)]
    pub(super) fn test(
        &self,
        s: S,
        v0: [S::F; 3],
        e1: [S::F; 3],
        e2: [S::F; 3],
        n: [S::F; 3],
        longest: f32,
    ) -> Tested<S> {
        let c = [s.sub(v0[0], self.origin[0]), s.sub(v0[1], self.origin[1]), s.sub(v0[2], self.origin[2])];
        let moment = cross(s, c, self.dir);
        let det = dot(s, n, self.dir);
        let sign = s.sign(det);
        let det = s.flip(det, sign);
        let u = s.flip(dot(s, moment, e2), sign);
        let minus_v = s.flip(dot(s, moment, e1), sign);
        let depth = s.flip(dot(s, n, c), sign);
        let w = s.sub(det, s.sub(u, minus_v));
        let inside = s.min(w, s.min(u, s.flip(minus_v, s.splat(-0.0))));
        let slack = self.slack * longest;
        Tested { inside, depth, det, slack: s.splat(slack), depth_slack: s.splat(slack * longest) }
    }
}

impl<S: Lanes> Tested<S> {
    /// Which may be hit before `reach`; none that is hit is missing.
    #[inline(always)]
    pub(super) fn candidates(&self, s: S, reach: S::F) -> S::M {
        let minus = |x| s.flip(x, s.splat(-0.0));
        let inside = s.le(minus(self.slack), self.inside);
        let ahead = s.le(minus(self.depth_slack), self.depth);
        let near = s.le(self.depth, s.mul_add(self.det, reach, self.depth_slack));
        s.and(s.and(inside, ahead), near)
    }

    /// Which are hit before `reach` for certain.
    #[inline(always)]
    pub(super) fn certain(&self, s: S, reach: S::F) -> S::M {
        let inside = s.le(self.slack, self.inside);
        let ahead = s.le(self.depth_slack, self.depth);
        let near = s.le(self.depth, s.mul_sub(self.det, reach, self.depth_slack));
        s.and(s.and(inside, ahead), near)
    }

    /// A distance that no hit is nearer than, if it is a hit: (T − slack) / (D + slack), for D is no more uncertain than U.
    #[inline(always)]
    pub(super) fn no_nearer_than(&self, s: S) -> S::F {
        let minus_one = s.splat(-1.0);
        let depth = s.max(s.sub(self.depth, self.depth_slack), s.splat(0.0));
        let det = s.mul_sub(self.slack, minus_one, self.det);
        // The reciprocal is good to 2⁻¹¹.
        s.mul(depth, s.mul(s.reciprocal(det), s.splat(-1.0 + 1.0 / 1024.0)))
    }
}
