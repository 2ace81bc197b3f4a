//! The first test of triangles: in f32, many at a time, wrong on one side only.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;

use super::kernel::Lanes;
use super::query::Query;

/// A [`Query`]'s part for triangles, with every number in all lanes.
pub(super) struct Probe<S: Lanes> {
    origin: [S::F; 3],
    /// What the origin's rounding left out.
    rest: [S::F; 3],
    dir: [S::F; 3],
    /// Slack of U, V, W for each unit of the longest edge.
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

/// What no edge at the first vertex of some triangles exceeds, and no less than what keeps its square and the square's
/// rounding among the numbers of f32, in triangles no larger than `size`.
pub(super) fn longest_edge(triangles: &[[DVec3; 3]], size: f64) -> f32 {
    let edges = triangles.iter().flat_map(|v| [v[1] - v[0], v[2] - v[0]]);
    let longest = edges.fold(0.0_f64, |longest, edge| longest.max(edge.length_squared())).sqrt();
    (longest * (1.0 + 1e-6)).max(1e-12 * size) as f32
}

/// Three rows from lane `from` on. Not by `array::map`, whose closure the compiler may leave without the level's
/// instructions.
#[inline(always)]
pub(super) fn load3<S: Lanes, const N: usize>(s: S, rows: &[[f32; N]; 3], from: usize) -> [S::F; 3] {
    [s.load(&rows[0][from..]), s.load(&rows[1][from..]), s.load(&rows[2][from..])]
}

#[inline(always)]
pub(super) fn cross<S: Lanes>(s: S, a: [S::F; 3], b: [S::F; 3]) -> [S::F; 3] {
    let part = |i: usize, j: usize| s.mul_sub(a[i], b[j], s.mul(a[j], b[i]));
    [part(1, 2), part(2, 0), part(0, 1)]
}

#[inline(always)]
fn dot<S: Lanes>(s: S, a: [S::F; 3], b: [S::F; 3]) -> S::F {
    s.mul_add(a[0], b[0], s.mul_add(a[1], b[1], s.mul(a[2], b[2])))
}

impl<S: Lanes> Probe<S> {
    /// For triangles in the tree's coordinates.
    #[inline(always)]
    pub(super) fn new(s: S, query: &Query<S>) -> Self {
        Self::from(s, query, query.origin, query.slack)
    }

    /// For triangles in the coordinates in which the ray has this origin, with this slack.
    #[inline(always)]
    pub(super) fn from(s: S, query: &Query<S>, origin: S::D, slack: f32) -> Self {
        let rounded = s.narrow(origin);
        let rest = s.narrow(s.quad_sub(origin, s.widen(rounded)));
        Self { origin: s.spread(rounded), rest: s.spread(rest), dir: s.spread(s.narrow(query.dir)), slack }
    }

    /// C of [`Query`]: the first vertices as seen from the ray's origin.
    #[inline(always)]
    pub(super) fn see(&self, s: S, v0: [S::F; 3]) -> [S::F; 3] {
        let see = |k: usize| s.sub(s.sub(v0[k], self.origin[k]), self.rest[k]);
        [see(0), see(1), see(2)]
    }

    /// Tests triangles given by C, e1, e2 and n of [`Query`], no edge being longer than `longest`.
    #[inline(always)]
    pub(super) fn test(
        &self,
        s: S,
        c: [S::F; 3],
        e1: [S::F; 3],
        e2: [S::F; 3],
        n: [S::F; 3],
        longest: f32,
    ) -> Tested<S> {
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
