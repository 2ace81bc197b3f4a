//! What bounds many rays at once.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::kernel::Lanes;
use super::node::Node;

/// Straight lines below the distances at which any ray of a bundle meets a box's near planes, and above those of the far
/// planes: one test of a box for all rays, that no box fails which one of them enters.
///
/// A ray meets the plane at b of an axis at t = b r − s, a straight line over b. The least of many such lines is concave,
/// and so lies above its chord from b = −1 to b = 1, between which all boxes are; the greatest lies below its chord. The
/// chords are exact where the rays' own origin is outside of [−1, 1], and all have it in common. They are moved by 2⁻¹⁹ of
/// |r| + |s|, which is four times the rounding of both tests.
pub(super) struct Fan<S: Lanes> {
    /// Index of the near plane on each axis.
    near: [usize; 3],
    /// Slope and negative height at 0 of the lines of near planes, axis by axis.
    below: [[S::F; 2]; 3],
    /// The same for far planes.
    above: [[S::F; 2]; 3],
    /// No ray reaches farther.
    reach: S::F,
}

/// In units of |r| + |s|.
const SLACK: f32 = 1.0 / (1_u32 << 19) as f32;

/// The numbers of a bundle's rays that boxes need, of all that go `backwards` along the same axes.
pub(super) struct Spokes<'a, const N: usize> {
    pub(super) scale: &'a [[f32; N]; 3],
    pub(super) near_shift: &'a [[f32; N]; 3],
    pub(super) far_shift: &'a [[f32; N]; 3],
    pub(super) reach: &'a [f32; N],
    pub(super) backwards: u32,
    /// Which of the numbers count.
    pub(super) rays: u32,
}

impl<S: Lanes> Fan<S> {
    /// Around these rays, of which there is at least one.
    #[inline(always)]
    pub(super) fn around<W: Lanes, const N: usize>((s, w): (S, W), of: &Spokes<N>) -> Self {
        let mut least = w.splat(f32::INFINITY);
        for from in (0..N).step_by(W::LANES) {
            let reach = w.sub(w.splat(0.0), w.load(&of.reach[from..]));
            least = w.min(least, w.select(w.mask(of.rays >> from), reach, w.splat(f32::INFINITY)));
        }
        let backwards = of.backwards as usize;
        Self {
            near: [backwards & 1, backwards >> 1 & 1, backwards >> 2 & 1],
            below: lines((s, w), of.scale, of.near_shift, of.rays, 1.0),
            above: lines((s, w), of.scale, of.far_shift, of.rays, -1.0),
            reach: s.splat(-w.least(least)),
        }
    }

    /// The children that some of the rays may enter.
    #[inline(always)]
    pub(super) fn enter(&self, s: S, node: &Node) -> u32 {
        let near = |k: usize| {
            let [scale, shift] = self.below[k];
            s.mul_sub(s.load(node.plane(k, self.near[k])), scale, shift)
        };
        let far = |k: usize| {
            let [scale, shift] = self.above[k];
            s.mul_sub(s.load(node.plane(k, self.near[k] ^ 1)), scale, shift)
        };
        let enter = s.max(s.max(near(0), near(1)), s.max(near(2), s.splat(0.0)));
        let leave = s.min(s.min(far(0), far(1)), s.min(far(2), self.reach));
        s.bits(s.le(enter, leave))
    }
}

/// Slope and negative height of a line on each axis: below the rays' distances for a `sign` of 1, above them for −1.
#[inline(always)]
fn lines<S: Lanes, W: Lanes, const N: usize>(
    (s, w): (S, W),
    scale: &[[f32; N]; 3],
    shift: &[[f32; N]; 3],
    rays: u32,
    sign: f32,
) -> [[S::F; 2]; 3] {
    let mut lines = [[s.splat(0.0); 2]; 3];
    for axis in 0..3 {
        let [low, high] = ends(w, &scale[axis], &shift[axis], rays, sign);
        lines[axis] = [s.splat(sign * 0.5 * (high - low)), s.splat(sign * -0.5 * (high + low))];
    }
    lines
}

/// The least of sign · (b r − s) at b = −1 and at b = 1, with slack.
#[inline(always)]
fn ends<W: Lanes>(w: W, r: &[f32], s: &[f32], rays: u32, sign: f32) -> [f32; 2] {
    let (zero, one, sign, slack) = (w.splat(0.0), w.splat(1.0), w.splat(sign), w.splat(-SLACK));
    let (mut low, mut high) = (w.splat(f32::INFINITY), w.splat(f32::INFINITY));
    for from in (0..r.len()).step_by(W::LANES) {
        let (r, s, mask) = (w.load(&r[from..]), w.load(&s[from..]), w.mask(rays >> from));
        let (sum, difference) = (w.mul_add(one, r, s), w.sub(r, s));
        let size = w.max(w.max(sum, w.sub(zero, sum)), w.max(difference, w.sub(zero, difference)));
        let moved = w.mul(slack, size);
        let of_low = w.sub(moved, w.mul(sign, sum));
        let of_high = w.mul_add(sign, difference, moved);
        low = w.min(low, w.select(mask, of_low, w.splat(f32::INFINITY)));
        high = w.min(high, w.select(mask, of_high, w.splat(f32::INFINITY)));
    }
    [w.least(low), w.least(high)]
}
