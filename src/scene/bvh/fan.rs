//! What bounds many rays at once.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::bundle::MOST;
use super::kernel::Lanes;
use super::node::Node;
use super::query::Twist;

/// Straight lines below the distances at which any ray of a bundle meets a box's near planes, and above those of the far
/// planes: one test of a box for all rays, that no box fails which one of them enters.
///
/// A ray meets the plane at b of an axis at t = b r − s, a straight line over b. The least of many such lines is concave,
/// and so lies above its chord from b = −1 to b = 1, between which all boxes are; the greatest lies below its chord. The
/// chords are exact where the rays' own origin is outside of [−1, 1], and all have it in common.
///
/// In units of 2⁻²⁴ (|r| + |s|), the ends of a chord are wrong by 2, its slope and height by 3 each, a distance from these by 8,
/// and that of a ray, if products are rounded, by 4. So the chords are moved by 32.
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
pub(super) struct Spokes<'a> {
    pub(super) scale: &'a [[f32; MOST]; 3],
    pub(super) near_shift: &'a [[f32; MOST]; 3],
    pub(super) far_shift: &'a [[f32; MOST]; 3],
    pub(super) reach: &'a [f32; MOST],
    pub(super) backwards: u32,
    /// Which of the numbers count.
    pub(super) rays: u32,
}

impl<S: Lanes> Fan<S> {
    /// Around these rays, of which there is at least one.
    #[inline(always)]
    pub(super) fn around<T: Twist, W: Lanes>((s, w): (S, W), of: &Spokes) -> Self {
        let mut least = w.splat(f32::INFINITY);
        for from in (0..MOST).step_by(W::LANES) {
            let reach = w.sub(w.splat(0.0), w.load(&of.reach[from..]));
            least = w.min(least, w.select(w.mask(of.rays >> from), reach, w.splat(f32::INFINITY)));
        }
        let backwards = of.backwards as usize;
        Self {
            near: [backwards & 1, backwards >> 1 & 1, backwards >> 2 & 1],
            below: lines::<T, _, _>((s, w), of.scale, of.near_shift, of.rays, 1.0),
            above: lines::<T, _, _>((s, w), of.scale, of.far_shift, of.rays, -1.0),
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
fn lines<T: Twist, S: Lanes, W: Lanes>(
    (s, w): (S, W),
    scale: &[[f32; MOST]; 3],
    shift: &[[f32; MOST]; 3],
    rays: u32,
    sign: f32,
) -> [[S::F; 2]; 3] {
    let mut lines = [[s.splat(0.0); 2]; 3];
    for axis in 0..3 {
        let [low, high] = ends::<T, _>(w, &scale[axis], &shift[axis], rays, sign);
        lines[axis] = [s.splat(sign * 0.5 * (high - low)), s.splat(sign * -0.5 * (high + low))];
    }
    lines
}

/// The least of sign · (b r − s) at b = −1 and at b = 1, with slack.
#[inline(always)]
fn ends<T: Twist, W: Lanes>(w: W, r: &[f32], s: &[f32], rays: u32, sign: f32) -> [f32; 2] {
    let (zero, one, sign, slack) = (w.splat(0.0), w.splat(1.0), w.splat(sign), w.splat(-SLACK * T::BOXES as f32));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{Stream, stream, uniform};
    use crate::scene::bvh::kernel::{Level, Task};
    use crate::scene::bvh::query::Straight;
    use glam::{DVec3, Vec4};
    use std::marker::PhantomData;

    #[derive(Clone)]
    struct Case {
        scale: [[f32; MOST]; 3],
        shift: [[f32; MOST]; 3],
        reach: [f32; MOST],
        backwards: u32,
        rays: u32,
        node: Node,
    }

    /// Children that the fan lets in, and those that a ray enters.
    struct Both<'a, T>(&'a Case, PhantomData<T>);

    impl<T: Twist> Task for Both<'_, T> {
        type Output = (u32, u32);

        #[inline(always)]
        fn run<N: Lanes, W: Lanes>(self, n: N, w: W) -> (u32, u32) {
            let Case { scale, shift, reach, backwards, rays, node } = self.0;
            let (backwards, rays) = (*backwards, *rays);
            let spokes = Spokes { scale, near_shift: shift, far_shift: shift, reach, backwards, rays };
            let mut entered = 0;
            for lane in 0..8 {
                let ([near, far], _) = node.child_of(lane, backwards);
                for from in (0..MOST).step_by(W::LANES) {
                    let (mut enter, mut leave) = (w.splat(0.0), w.load(&reach[from..]));
                    for k in 0..3 {
                        let (r, s) = (w.load(&scale[k][from..]), w.load(&shift[k][from..]));
                        enter = w.max(enter, w.mul_sub(w.splat(near[k]), r, s));
                        leave = w.min(leave, w.mul_sub(w.splat(far[k]), r, s));
                    }
                    let hit = w.bits(w.le(enter, leave)) & rays >> from;
                    entered |= u32::from(hit != 0) << lane;
                }
            }
            (Fan::around::<T, W>((n, w), &spokes).enter(n, node), entered)
        }
    }

    fn signed(rng: &mut Stream) -> f64 {
        2.0 * uniform(rng) - 1.0
    }

    /// Rays around one, some from the same point, in a node whose boxes are met by one of them or lie anywhere.
    fn case(seed: u64) -> Case {
        let rng = &mut stream(seed, 0, 0);
        let mut point = |size: f64| size * DVec3::new(signed(rng), signed(rng), signed(rng));
        let (origin, first) = (point(3.0), point(1.0).normalize());
        let some = 10_f64.powf(-3.0 - 3.0 * point(1.0).x);
        // Where all rays are one, the lines are as near as they can be to what they bound.
        let (spread, apart) = [(some, 1e-3), (some, 0.0), (0.0, 0.0)][seed as usize % 3];
        let rays: [(DVec3, DVec3); MOST] =
            std::array::from_fn(|_| (origin + point(apart), (first + point(spread)).normalize()));
        let of = |f: &dyn Fn(usize, usize) -> f64| [0, 1, 2].map(|k| std::array::from_fn(|i| f(i, k) as f32));
        let backwards = |dir: DVec3| dir.is_negative_bitmask() & 7;
        let mut node = Node::EMPTY;
        for lane in 0..7 {
            let (from, dir) = rays[lane * 4];
            let near = if lane < 4 { from + (from.length() + point(1.0).x) * dir } else { point(1.0) };
            let size = 10_f64.powf(-4.0 - 3.0 * point(1.0).x) * f64::from(u8::from(lane % 4 != 0));
            let far = near + size * point(1.0).abs();
            let corner = |p: DVec3| p.clamp(DVec3::NEG_ONE, DVec3::ONE).as_vec3().extend(0.0);
            let (lo, hi): (Vec4, Vec4) = (corner(near), corner(far));
            node.set(lane, lo, hi, lane as u32);
        }
        Case {
            scale: of(&|i, k| 1.0 / rays[i].1[k]),
            shift: of(&|i, k| rays[i].0[k] / rays[i].1[k]),
            reach: std::array::from_fn(|i| if i % 8 == 0 { 3.0 } else { 9.0 }),
            backwards: backwards(first),
            rays: (0..MOST).fold(0, |all, i| all | u32::from(backwards(rays[i].1) == backwards(first)) << i),
            node,
        }
    }

    /// Boxes that a ray enters and the fan does not let in; boxes that no ray enters, and how many of them the fan keeps out.
    fn judge<T: Twist>(level: Level) -> [u32; 3] {
        let mut sums = [0; 3];
        for seed in 0..20_000 {
            let case = case(seed);
            if case.rays == 0 {
                continue;
            }
            let (kept, entered) = level.run(Both::<T>(&case, PhantomData));
            let counts = [entered & !kept, 0x7f & !entered, 0x7f & !entered & !kept].map(u32::count_ones);
            assert_eq!(kept >> 7, 0, "an absent child");
            for (sum, count) in sums.iter_mut().zip(counts) {
                *sum += count;
            }
        }
        sums
    }

    struct NoSlack;

    impl Twist for NoSlack {
        const BOXES: f64 = 0.0;
    }

    #[test]
    fn what_a_ray_enters_is_let_in_and_little_else() {
        for level in Level::all().into_iter().flatten() {
            let [missing, others, kept_out] = judge::<Straight>(level);
            assert_eq!(missing, 0, "{level:?}");
            // Worth its price where it spares more rays' tests than not.
            assert!(kept_out > others / 2, "{level:?}: {kept_out} of {others}");
            assert!(judge::<NoSlack>(level)[0] > 0, "{level:?}: the test does not see that slack is needed");
        }
    }
}
