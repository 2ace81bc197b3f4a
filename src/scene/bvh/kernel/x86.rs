//! Vectors of AVX2 and of AVX-512.
#![allow(clippy::inline_always, reason = "an intrinsic that is not inlined costs a call for one instruction")]

#[allow(clippy::wildcard_imports, reason = "a page of intrinsics")]
use std::arch::x86_64::*;

use std::ptr::read_volatile;

use glam::DVec3;

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
        fn prefetch<T>(self, at: &T) {
            let first = std::ptr::from_ref(at).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(64) {
                // SAFETY: the address lies within `at`.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(64 * line)) };
            }
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

/// Four numbers in f64, the same for all.
macro_rules! quads {
    () => {
        type D = __m256d;
        type H = __m128;
        #[inline(always)]
        fn quad_of(self, v: &DVec3) -> __m256d {
            // SAFETY: reads through references. Volatile, or the compiler would join them.
            let (x, y, z) = unsafe { (read_volatile(&v.x), read_volatile(&v.y), read_volatile(&v.z)) };
            self.quad([x, y, z, 0.0])
        }
        #[inline(always)]
        fn quad(self, x: [f64; 4]) -> __m256d {
            // SAFETY: `self` proves the instructions, here and below.
            unsafe { _mm256_setr_pd(x[0], x[1], x[2], x[3]) }
        }
        #[inline(always)]
        fn quad_load(self, row: &[f64]) -> __m256d {
            assert!(row.len() >= 4, "a row for every lane");
            // SAFETY: the row is long enough.
            unsafe { _mm256_loadu_pd(row.as_ptr()) }
        }
        #[inline(always)]
        fn quad_array(self, a: __m256d) -> [f64; 4] {
            let mut x = [0.0; 4];
            // SAFETY: there is room for four.
            unsafe { _mm256_storeu_pd(x.as_mut_ptr(), a) };
            x
        }
        #[inline(always)]
        fn quad_splat(self, x: f64) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_set1_pd(x) }
        }
        #[inline(always)]
        fn quad_add(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_add_pd(a, b) }
        }
        #[inline(always)]
        fn quad_sub(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_sub_pd(a, b) }
        }
        #[inline(always)]
        fn quad_mul(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_mul_pd(a, b) }
        }
        #[inline(always)]
        fn quad_div(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_div_pd(a, b) }
        }
        #[inline(always)]
        fn quad_max(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_max_pd(a, b) }
        }
        #[inline(always)]
        fn quad_copysign(self, size: __m256d, sign: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe {
                let mask = _mm256_set1_pd(-0.0);
                _mm256_or_pd(_mm256_andnot_pd(mask, size), _mm256_and_pd(mask, sign))
            }
        }
        #[inline(always)]
        fn quad_turn(self, a: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_permute4x64_pd::<0b11_00_10_01>(a) }
        }
        #[inline(always)]
        fn quad_turn_twice(self, a: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_permute4x64_pd::<0b11_01_00_10>(a) }
        }
        #[inline(always)]
        fn quad_first(self, a: __m256d) -> f64 {
            // SAFETY: as above.
            unsafe { _mm256_cvtsd_f64(a) }
        }
        #[inline(always)]
        fn quad_signs(self, a: __m256d) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_pd(a).cast_unsigned() }
        }
        #[inline(always)]
        fn quad_of_one_sign(self, a: __m256d) -> bool {
            // SAFETY: as above.
            unsafe {
                let zero = _mm256_setzero_pd();
                let positive = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GE_OQ>(a, zero)) & 7;
                let negative = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a, zero)) & 7;
                (positive == 7) | (negative == 7)
            }
        }
        #[inline(always)]
        fn half(self, [x, y, z]: [f32; 3]) -> __m128 {
            // SAFETY: as above.
            unsafe { _mm_setr_ps(x, y, z, 0.0) }
        }
        #[inline(always)]
        fn half_array(self, a: __m128) -> [f32; 4] {
            let mut x = [0.0; 4];
            // SAFETY: there is room for four.
            unsafe { _mm_storeu_ps(x.as_mut_ptr(), a) };
            x
        }
        #[inline(always)]
        fn narrow(self, a: __m256d) -> __m128 {
            // SAFETY: as above.
            unsafe { _mm256_cvtpd_ps(a) }
        }
        #[inline(always)]
        fn widen(self, a: __m128) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_cvtps_pd(a) }
        }
    };
}

impl Lanes for Avx2 {
    quads!();
    #[inline(always)]
    fn spread(self, a: __m128) -> [__m256; 3] {
        // SAFETY: as above.
        unsafe {
            [
                _mm256_broadcastss_ps(a),
                _mm256_broadcastss_ps(_mm_movehdup_ps(a)),
                _mm256_broadcastss_ps(_mm_movehl_ps(a, a)),
            ]
        }
    }
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
    #[inline(always)]
    fn mask(self, bits: u32) -> __m256 {
        // SAFETY: as above.
        unsafe {
            let bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(bit, _mm256_set1_epi32(bits.cast_signed()));
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bit))
        }
    }
}

impl Lanes for Avx512Half {
    quads!();
    #[inline(always)]
    fn spread(self, a: __m128) -> [__m256; 3] {
        Avx2(()).spread(a)
    }
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
    #[inline(always)]
    fn mask(self, bits: u32) -> __mmask8 {
        bits as u8
    }
}

impl Lanes for Avx512 {
    quads!();
    #[inline(always)]
    fn spread(self, a: __m128) -> [__m512; 3] {
        // SAFETY: as above.
        unsafe {
            [
                _mm512_broadcastss_ps(a),
                _mm512_broadcastss_ps(_mm_movehdup_ps(a)),
                _mm512_broadcastss_ps(_mm_movehl_ps(a, a)),
            ]
        }
    }
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
    #[inline(always)]
    fn mask(self, bits: u32) -> __mmask16 {
        bits as u16
    }
}
