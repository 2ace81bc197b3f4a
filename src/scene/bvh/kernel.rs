//! The one place with `unsafe`: vectors of f32 in three editions, the choice among them, and the stack of a traversal.
//!
//! What is generic over [`Lanes`] is compiled once for each edition, inlined into a function that has the edition's
//! instructions enabled. A value of an edition's type is the proof that the machine has them: only [`Level`] makes one,
//! after asking the machine.
#![allow(
    unsafe_code,
    reason = "intrinsics, functions for instructions that not every machine has, and raw stack slots"
)]
#![allow(clippy::inline_always, reason = "an intrinsic that is not inlined costs a call for one instruction")]

use std::mem::MaybeUninit;

use super::portable::Portable;

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
    /// Both.
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    /// Lane i as bit i.
    fn bits(self, a: Self::M) -> u32;
}

/// What can be run at any level: the body of a `match` over levels, written once.
pub(super) trait Task {
    /// What comes out.
    type Output;
    /// Does it with vectors of 8 numbers, and with the widest that there are. Must be `#[inline(always)]`.
    fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) -> Self::Output;
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
            Kind::Portable => task.run(Portable, Portable),
            // SAFETY: a level other than `Portable` exists only if `all` has found the machine to have its instructions.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { x86::run_avx2(task) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { x86::run_avx512(task) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    #[allow(clippy::wildcard_imports, reason = "a page of intrinsics")]
    use std::arch::x86_64::*;

    use super::{Lanes, Task};

    /// # Safety
    /// The machine must have the instructions enabled here.
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) unsafe fn run_avx2<T: Task>(task: T) -> T::Output {
        task.run(Avx2(()), Avx2(()))
    }

    /// # Safety
    /// The machine must have the instructions enabled here.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) unsafe fn run_avx512<T: Task>(task: T) -> T::Output {
        task.run(Avx512Half(()), Avx512(()))
    }

    /// Eight numbers in a register of AVX2. Its existence proves that the machine has AVX2 and FMA.
    #[derive(Clone, Copy)]
    pub(super) struct Avx2(());

    /// Eight numbers, with AVX-512's masks. Its existence proves that the machine has AVX-512 F, VL, DQ and BW.
    #[derive(Clone, Copy)]
    pub(super) struct Avx512Half(());

    /// Sixteen numbers. Its existence proves the same.
    #[derive(Clone, Copy)]
    pub(super) struct Avx512(());

    /// The methods that are one intrinsic each.
    macro_rules! plain {
        ($f:ty, $lanes:literal, $load:ident, $store:ident, $splat:ident, $sub:ident, $mul:ident, $mul_add:ident,
         $mul_sub:ident, $min:ident, $max:ident, $and:ident, $xor:ident) => {
            const LANES: usize = $lanes;
            const FUSED: bool = true;
            type F = $f;
            #[inline(always)]
            fn load(self, row: &[f32]) -> $f {
                assert!(row.len() >= $lanes, "a row for every lane");
                // SAFETY: the row is long enough; `self` proves the instructions.
                unsafe { $load(row.as_ptr()) }
            }
            #[inline(always)]
            fn store(self, v: $f, row: &mut [f32]) {
                assert!(row.len() >= $lanes, "a row for every lane");
                // SAFETY: the row is long enough; `self` proves the instructions.
                unsafe { $store(row.as_mut_ptr(), v) }
            }
            #[inline(always)]
            fn splat(self, x: f32) -> $f {
                // SAFETY: `self` proves the instructions, here and below.
                unsafe { $splat(x) }
            }
            #[inline(always)]
            fn sub(self, a: $f, b: $f) -> $f {
                // SAFETY: as above.
                unsafe { $sub(a, b) }
            }
            #[inline(always)]
            fn mul(self, a: $f, b: $f) -> $f {
                // SAFETY: as above.
                unsafe { $mul(a, b) }
            }
            #[inline(always)]
            fn mul_add(self, a: $f, b: $f, c: $f) -> $f {
                // SAFETY: as above.
                unsafe { $mul_add(a, b, c) }
            }
            #[inline(always)]
            fn mul_sub(self, a: $f, b: $f, c: $f) -> $f {
                // SAFETY: as above.
                unsafe { $mul_sub(a, b, c) }
            }
            #[inline(always)]
            fn min(self, a: $f, b: $f) -> $f {
                // SAFETY: as above.
                unsafe { $min(a, b) }
            }
            #[inline(always)]
            fn max(self, a: $f, b: $f) -> $f {
                // SAFETY: as above.
                unsafe { $max(a, b) }
            }
            #[inline(always)]
            fn sign(self, a: $f) -> $f {
                // SAFETY: as above.
                unsafe { $and(a, $splat(-0.0)) }
            }
            #[inline(always)]
            fn flip(self, a: $f, sign: $f) -> $f {
                // SAFETY: as above.
                unsafe { $xor(a, sign) }
            }
        };
    }

    impl Lanes for Avx2 {
        plain!(
            __m256,
            8,
            _mm256_loadu_ps,
            _mm256_storeu_ps,
            _mm256_set1_ps,
            _mm256_sub_ps,
            _mm256_mul_ps,
            _mm256_fmadd_ps,
            _mm256_fmsub_ps,
            _mm256_min_ps,
            _mm256_max_ps,
            _mm256_and_ps,
            _mm256_xor_ps
        );
        type M = __m256;
        #[inline(always)]
        fn reciprocal(self, a: __m256) -> __m256 {
            // SAFETY: `self` proves the instructions, here and below.
            unsafe { _mm256_rcp_ps(a) }
        }
        #[inline(always)]
        fn least(self, a: __m256) -> f32 {
            // SAFETY: as above.
            unsafe {
                let four = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
                let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
            }
        }
        #[inline(always)]
        fn select(self, mask: __m256, yes: __m256, no: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_blendv_ps(no, yes, mask) }
        }
        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(a, b) }
        }
        #[inline(always)]
        fn and(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_and_ps(a, b) }
        }
        #[inline(always)]
        fn bits(self, a: __m256) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(a).cast_unsigned() }
        }
    }

    impl Lanes for Avx512Half {
        plain!(
            __m256,
            8,
            _mm256_loadu_ps,
            _mm256_storeu_ps,
            _mm256_set1_ps,
            _mm256_sub_ps,
            _mm256_mul_ps,
            _mm256_fmadd_ps,
            _mm256_fmsub_ps,
            _mm256_min_ps,
            _mm256_max_ps,
            _mm256_and_ps,
            _mm256_xor_ps
        );
        type M = __mmask8;
        #[inline(always)]
        fn reciprocal(self, a: __m256) -> __m256 {
            // SAFETY: `self` proves the instructions, here and below.
            unsafe { _mm256_rcp14_ps(a) }
        }
        #[inline(always)]
        fn least(self, a: __m256) -> f32 {
            // SAFETY: as above.
            unsafe {
                let four = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
                let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
            }
        }
        #[inline(always)]
        fn select(self, mask: __mmask8, yes: __m256, no: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_mask_blend_ps(mask, no, yes) }
        }
        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> __mmask8 {
            // SAFETY: as above.
            unsafe { _mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b) }
        }
        #[inline(always)]
        fn and(self, a: __mmask8, b: __mmask8) -> __mmask8 {
            a & b
        }
        #[inline(always)]
        fn bits(self, a: __mmask8) -> u32 {
            u32::from(a)
        }
    }

    impl Lanes for Avx512 {
        plain!(
            __m512,
            16,
            _mm512_loadu_ps,
            _mm512_storeu_ps,
            _mm512_set1_ps,
            _mm512_sub_ps,
            _mm512_mul_ps,
            _mm512_fmadd_ps,
            _mm512_fmsub_ps,
            _mm512_min_ps,
            _mm512_max_ps,
            _mm512_and_ps,
            _mm512_xor_ps
        );
        type M = __mmask16;
        #[inline(always)]
        fn reciprocal(self, a: __m512) -> __m512 {
            // SAFETY: `self` proves the instructions, here and below.
            unsafe { _mm512_rcp14_ps(a) }
        }
        #[inline(always)]
        fn least(self, a: __m512) -> f32 {
            // SAFETY: as above.
            unsafe { _mm512_reduce_min_ps(a) }
        }
        #[inline(always)]
        fn select(self, mask: __mmask16, yes: __m512, no: __m512) -> __m512 {
            // SAFETY: as above.
            unsafe { _mm512_mask_blend_ps(mask, no, yes) }
        }
        #[inline(always)]
        fn le(self, a: __m512, b: __m512) -> __mmask16 {
            // SAFETY: as above.
            unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b) }
        }
        #[inline(always)]
        fn and(self, a: __mmask16, b: __mmask16) -> __mmask16 {
            a & b
        }
        #[inline(always)]
        fn bits(self, a: __mmask16) -> u32 {
            u32::from(a)
        }
    }
}

/// What waits to be visited: a child, and the distance at which the ray enters its box.
#[derive(Clone, Copy)]
pub(super) struct Waiting {
    /// The distance, in the units of the tree.
    pub(super) t: f32,
    /// The child.
    pub(super) child: u32,
}

/// The children that a traversal has put off; its slots are not written before they are used.
pub(super) struct Stack {
    slots: [MaybeUninit<Waiting>; Self::SLOTS],
    used: usize,
}

impl Stack {
    /// Seven siblings on each level of the deepest tree that the builder makes, with room to spare.
    pub(super) const SLOTS: usize = 192;

    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { slots: [MaybeUninit::uninit(); Self::SLOTS], used: 0 }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, waiting: Waiting) {
        self.slots[self.used].write(waiting);
        self.used += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<Waiting> {
        self.used = self.used.checked_sub(1)?;
        // SAFETY: slots below the former `used` have been written by `push`.
        Some(unsafe { self.slots[self.used].assume_init() })
    }

    /// Orders the topmost `count` so that the nearest comes off first.
    #[inline(always)]
    pub(super) fn sort_top(&mut self, count: usize) {
        let first = self.used - count;
        for end in first + 1..self.used {
            // SAFETY: slots below `used` have been written by `push`.
            let moved = unsafe { self.slots[end].assume_init() };
            let mut at = end;
            while at > first {
                // SAFETY: as above.
                let before = unsafe { self.slots[at - 1].assume_init() };
                if before.t >= moved.t {
                    break;
                }
                self.slots[at].write(before);
                at -= 1;
            }
            self.slots[at].write(moved);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stack_gives_the_nearest_first() {
        let mut stack = Stack::new();
        for (child, t) in [(0, 9.0), (1, 3.0), (2, 1.0), (3, 2.0), (4, 2.0)] {
            stack.push(Waiting { t, child });
        }
        stack.sort_top(4);
        let popped: Vec<u32> = std::iter::from_fn(|| stack.pop()).map(|w| w.child).collect();
        assert_eq!(popped, [2, 4, 3, 1, 0]);
    }

    /// A result of every operation in every lane.
    struct Everything([[f32; 16]; 3]);

    impl Task for Everything {
        type Output = Vec<Vec<f32>>;
        #[inline(always)]
        fn run<N: Lanes, W: Lanes>(self, narrow: N, wide: W) -> Vec<Vec<f32>> {
            fn all<S: Lanes>(s: S, rows: &[[f32; 16]; 3]) -> Vec<Vec<f32>> {
                let [a, b, c] = [s.load(&rows[0]), s.load(&rows[1]), s.load(&rows[2])];
                let mask = s.bits(s.and(s.le(a, b), s.le(b, c)));
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
