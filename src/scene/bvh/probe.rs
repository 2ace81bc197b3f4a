//! The first test of triangles: in f32, many at a time, wrong on one side only.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;

use super::kernel::Lanes;
use super::query::Query;

/// A [`Query`]'s part for triangles: a ray in every lane, the same one or others.
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

/// Where a ray starts in the coordinates of some triangles, and the slack that its U, V, W have there for each unit of the
/// longest edge.
pub(super) struct Start<S: Lanes> {
    pub(super) origin: S::D,
    pub(super) slack: f32,
}

impl<S: Lanes> Start<S> {
    /// Origin, what its rounding leaves out, and direction in f32.
    #[inline(always)]
    pub(super) fn rounded(&self, s: S, query: &Query<S>) -> [S::H; 3] {
        let origin = s.narrow(self.origin);
        [origin, s.narrow(s.quad_sub(self.origin, s.widen(origin))), s.narrow(query.dir)]
    }
}

impl<S: Lanes> Probe<S> {
    /// One ray in all lanes.
    #[inline(always)]
    pub(super) fn new(s: S, query: &Query<S>, start: &Start<S>) -> Self {
        let [origin, rest, dir] = start.rounded(s, query);
        Self::of_lanes([s.spread(origin), s.spread(rest), s.spread(dir)], start.slack)
    }

    /// Rays side by side: their [`Start::rounded`], and the greatest slack of any.
    #[inline(always)]
    pub(super) fn of_lanes([origin, rest, dir]: [[S::F; 3]; 3], slack: f32) -> Self {
        Self { origin, rest, dir, slack }
    }
}

/// Triangles by what their test needs: the first vertex, the edges from there, and these edges' cross product.
pub(super) struct Triangles<S: Lanes> {
    pub(super) v0: [S::F; 3],
    pub(super) e1: [S::F; 3],
    pub(super) e2: [S::F; 3],
    pub(super) n: [S::F; 3],
    /// No edge is longer.
    pub(super) longest: f32,
}

impl<S: Lanes> Triangles<S> {
    /// Lane by lane, a triangle with a ray.
    #[inline(always)]
    pub(super) fn test(&self, s: S, probe: &Probe<S>) -> Tested<S> {
        let see = |k: usize| s.sub(s.sub(self.v0[k], probe.origin[k]), probe.rest[k]);
        // C of [`Query`].
        let c = [see(0), see(1), see(2)];
        let moment = cross(s, c, probe.dir);
        let det = dot(s, self.n, probe.dir);
        let sign = s.sign(det);
        let det = s.flip(det, sign);
        let u = s.flip(dot(s, moment, self.e2), sign);
        let minus_v = s.flip(dot(s, moment, self.e1), sign);
        let depth = s.flip(dot(s, self.n, c), sign);
        let w = s.sub(det, s.sub(u, minus_v));
        let inside = s.min(w, s.min(u, s.flip(minus_v, s.splat(-0.0))));
        let slack = probe.slack * self.longest;
        Tested { inside, depth, det, slack: s.splat(slack), depth_slack: s.splat(slack * self.longest) }
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
