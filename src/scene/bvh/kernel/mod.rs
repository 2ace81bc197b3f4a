//! The one place with `unsafe`: vectors of f32 in three editions, the choice among them, and memory.
//!
//! What is generic over [`Lanes`] is compiled once for each edition, inlined into a function that has the edition's
//! instructions enabled. A value of an edition's type is the proof that the machine has them: only [`Level`] makes one,
//! after asking the machine.
#![allow(unsafe_code, reason = "intrinsics, instructions that not every machine has, slots not yet written")]
#![allow(clippy::inline_always, reason = "an intrinsic that is not inlined costs a call for one instruction")]

use glam::DVec3;

mod memory;
mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use memory::prefetch;
pub(super) use memory::{Stack, in_huge_pages};
use portable::Portable;

/// A vector of `LANES` numbers and what traversal does with it.
pub(super) trait Lanes: Copy {
    /// How many numbers there are in a vector.
    const LANES: usize;
    /// Whether `mul_add` rounds once.
    const FUSED: bool;
    /// A vector.
    type F: Copy;
    /// A truth value for each lane.
    type M: Copy;
    /// The first numbers of a row that has at least `LANES`.
    fn load(self, row: &[f32]) -> Self::F;
    /// Writes to a row that has at least `LANES`.
    fn store(self, v: Self::F, row: &mut [f32]);
    /// The same number in all lanes.
    fn splat(self, x: f32) -> Self::F;
    /// a − b
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b + c
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// a b − c
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The lesser of two numbers; either of them if one is NaN.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The greater of two numbers; either of them if one is NaN.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// The sign bits alone.
    fn sign(self, a: Self::F) -> Self::F;
    /// `a` with its sign flipped where the sign bit of `sign` is set.
    fn flip(self, a: Self::F, sign: Self::F) -> Self::F;
    /// 1 / a to a relative error of 2⁻¹¹.
    fn reciprocal(self, a: Self::F) -> Self::F;
    /// The least of all lanes, none of which may be NaN.
    fn least(self, a: Self::F) -> f32;
    /// `yes` where the mask is true, `no` elsewhere.
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F;
    /// a ≤ b; false for NaN.
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// Asks for all cache lines of something that will be read soon.
    fn prefetch<T>(self, at: &T);
    /// Both.
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    /// Lane i as bit i.
    fn bits(self, a: Self::M) -> u32;
    /// Bit i as lane i.
    fn mask(self, bits: u32) -> Self::M;

    /// Four numbers in f64. The fourth is along for the ride.
    type D: Copy;
    /// Four numbers in f32.
    type H: Copy;
    /// From memory, number by number: if they have just been written one by one, a load of more than one at a time would
    /// have to wait until they have left the store buffer.
    fn quad_of(self, v: &DVec3) -> Self::D;
    /// From an array.
    fn quad(self, x: [f64; 4]) -> Self::D;
    /// The first four of a row that has at least as many.
    fn quad_load(self, row: &[f64]) -> Self::D;
    /// To an array.
    fn quad_array(self, a: Self::D) -> [f64; 4];
    /// The same number in all lanes.
    fn quad_splat(self, x: f64) -> Self::D;
    /// a + b
    fn quad_add(self, a: Self::D, b: Self::D) -> Self::D;
    /// a − b
    fn quad_sub(self, a: Self::D, b: Self::D) -> Self::D;
    /// a b
    fn quad_mul(self, a: Self::D, b: Self::D) -> Self::D;
    /// a / b
    fn quad_div(self, a: Self::D, b: Self::D) -> Self::D;
    /// The greater of two numbers; either of them if one is NaN.
    fn quad_max(self, a: Self::D, b: Self::D) -> Self::D;
    /// The size of `size` with the sign of `sign`.
    fn quad_copysign(self, size: Self::D, sign: Self::D) -> Self::D;
    /// The first three turned round: (y, z, x).
    fn quad_turn(self, a: Self::D) -> Self::D;
    /// Turned twice: (z, x, y).
    fn quad_turn_twice(self, a: Self::D) -> Self::D;
    /// The first.
    fn quad_first(self, a: Self::D) -> f64;
    /// Sign bits: lane i as bit i.
    fn quad_signs(self, a: Self::D) -> u32;
    /// Whether the first three are all ≥ 0, or all ≤ 0.
    fn quad_of_one_sign(self, a: Self::D) -> bool;
    /// From an array, the fourth being 0.
    fn half(self, x: [f32; 3]) -> Self::H;
    /// To an array.
    fn half_array(self, a: Self::H) -> [f32; 4];
    /// Rounded to f32.
    fn narrow(self, a: Self::D) -> Self::H;
    /// As f64.
    fn widen(self, a: Self::H) -> Self::D;
    /// The first, second and third, each in all lanes.
    fn spread(self, a: Self::H) -> [Self::F; 3];
    /// x + y + z, in this order.
    #[inline(always)]
    fn quad_sum(self, a: Self::D) -> Self::D {
        self.quad_add(self.quad_add(a, self.quad_turn(a)), self.quad_turn_twice(a))
    }
}

/// What can be run at any level: the body of a `match` over levels, written once.
pub(super) trait Task {
    /// What comes out.
    type Output;
    /// Does it with vectors of 8 numbers, and with the widest that there are. Must be `#[inline(always)]`.
    fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) -> Self::Output;
}

/// Out of line, as the others are: callers should not be filled with what hardly any machine runs.
#[inline(never)]
fn run_portable<T: Task>(task: T) -> T::Output {
    task.run(Portable, Portable)
}

/// A set of instructions that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Level(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// The instructions that every machine has.
    pub(super) const PORTABLE: Self = Self(Kind::Portable);

    /// The best this machine has.
    pub(super) fn best() -> Self {
        Self::all().into_iter().rev().flatten().next().unwrap_or(Self::PORTABLE)
    }

    /// From the plainest to the best; None where the machine lacks one.
    pub(super) fn all() -> [Option<Self>; 3] {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            let avx512 = avx2
                && is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw");
            [Some(Self::PORTABLE), avx2.then_some(Self(Kind::Avx2)), avx512.then_some(Self(Kind::Avx512))]
        }
        #[cfg(not(target_arch = "x86_64"))]
        [Some(Self::PORTABLE), None, None]
    }

    /// Runs a task with this level's instructions.
    #[inline(always)]
    pub(super) fn run<T: Task>(self, task: T) -> T::Output {
        match self.0 {
            Kind::Portable => run_portable(task),
            // SAFETY: a level other than `Portable` exists only if `all` has found the machine to have its instructions.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { x86::run_avx2(task) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { x86::run_avx512(task) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A result of every operation in every lane.
    struct Everything([[f32; 16]; 3]);

    impl Task for Everything {
        type Output = Vec<Vec<f32>>;
        #[inline(always)]
        fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) -> Vec<Vec<f32>> {
            fn all<S: Lanes>(s: S, rows: &[[f32; 16]; 3]) -> Vec<Vec<f32>> {
                let [a, b, c] = [s.load(&rows[0]), s.load(&rows[1]), s.load(&rows[2])];
                let mask = s.bits(s.and(s.le(a, b), s.mask(s.bits(s.le(b, c)))));
                let results = [
                    s.sub(a, b),
                    s.mul(a, b),
                    s.mul_add(a, b, c),
                    s.mul_sub(a, b, c),
                    s.min(a, b),
                    s.max(a, b),
                    s.flip(a, s.sign(b)),
                    s.select(s.le(a, b), a, c),
                    s.splat(s.least(a)),
                ];
                let mut out: Vec<Vec<f32>> = results
                    .iter()
                    .map(|&v| {
                        let mut row = [0.0; 16];
                        s.store(v, &mut row);
                        row[..8].to_vec()
                    })
                    .collect();
                out.push((0..8).map(|i| f32::from(u8::from(mask >> i & 1 == 1))).collect());
                out
            }
            let narrow = all(narrow, &self.0);
            assert_eq!(narrow, all(wide, &self.0));
            narrow
        }
    }

    #[test]
    fn all_levels_compute_the_same() {
        // Small integers, so that a fused product rounds no differently.
        let row = |k: u8| std::array::from_fn(|i| f32::from((i as u8 * k) % 7) - 3.0);
        let expected = Level::PORTABLE.run(Everything([row(3), row(5), row(2)]));
        for level in Level::all().into_iter().flatten() {
            assert_eq!(level.run(Everything([row(3), row(5), row(2)])), expected, "{level:?}");
        }
    }
}
