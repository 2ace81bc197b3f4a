//! Vectors for machines without AVX2, and for the tests to compare with.
#![allow(clippy::inline_always, reason = "as for the other editions")]

use glam::DVec3;

use super::Lanes;

/// Eight numbers in an array, for the compiler to make of what it can.
#[derive(Clone, Copy)]
pub(super) struct Portable;

#[inline(always)]
fn each(f: impl Fn(usize) -> f32) -> [f32; 8] {
    [f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)]
}

#[inline(always)]
fn four(f: impl Fn(usize) -> f64) -> [f64; 4] {
    [f(0), f(1), f(2), f(3)]
}

impl Lanes for Portable {
    const LANES: usize = 8;
    const FUSED: bool = false;
    type F = [f32; 8];
    type M = [bool; 8];
    #[inline(always)]
    fn load(self, row: &[f32]) -> [f32; 8] {
        each(|i| row[i])
    }
    #[inline(always)]
    fn store(self, v: [f32; 8], row: &mut [f32]) {
        row[..8].copy_from_slice(&v);
    }
    #[inline(always)]
    fn splat(self, x: f32) -> [f32; 8] {
        [x; 8]
    }
    #[inline(always)]
    fn sub(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn mul_add(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        each(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    fn mul_sub(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        each(|i| a[i] * b[i] - c[i])
    }
    #[inline(always)]
    fn min(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn sign(self, a: [f32; 8]) -> [f32; 8] {
        each(|i| f32::from_bits(a[i].to_bits() & 0x8000_0000))
    }
    #[inline(always)]
    fn flip(self, a: [f32; 8], sign: [f32; 8]) -> [f32; 8] {
        each(|i| f32::from_bits(a[i].to_bits() ^ sign[i].to_bits()))
    }
    #[inline(always)]
    fn reciprocal(self, a: [f32; 8]) -> [f32; 8] {
        each(|i| 1.0 / a[i])
    }
    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}
    #[inline(always)]
    fn least(self, a: [f32; 8]) -> f32 {
        a.into_iter().fold(f32::INFINITY, f32::min)
    }
    #[inline(always)]
    fn select(self, mask: [bool; 8], yes: [f32; 8], no: [f32; 8]) -> [f32; 8] {
        each(|i| if mask[i] { yes[i] } else { no[i] })
    }
    #[inline(always)]
    fn le(self, a: [f32; 8], b: [f32; 8]) -> [bool; 8] {
        std::array::from_fn(|i| a[i] <= b[i])
    }
    #[inline(always)]
    fn and(self, a: [bool; 8], b: [bool; 8]) -> [bool; 8] {
        std::array::from_fn(|i| a[i] & b[i])
    }
    type D = [f64; 4];
    type H = [f32; 4];
    #[inline(always)]
    fn quad_of(self, v: &DVec3) -> [f64; 4] {
        [v.x, v.y, v.z, 0.0]
    }
    #[inline(always)]
    fn quad(self, x: [f64; 4]) -> [f64; 4] {
        x
    }
    #[inline(always)]
    fn quad_load(self, row: &[f64]) -> [f64; 4] {
        [row[0], row[1], row[2], row[3]]
    }
    #[inline(always)]
    fn quad_array(self, a: [f64; 4]) -> [f64; 4] {
        a
    }
    #[inline(always)]
    fn quad_splat(self, x: f64) -> [f64; 4] {
        [x; 4]
    }
    #[inline(always)]
    fn quad_add(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        four(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn quad_sub(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        four(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn quad_mul(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        four(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn quad_div(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        four(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn quad_max(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        four(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn quad_copysign(self, size: [f64; 4], sign: [f64; 4]) -> [f64; 4] {
        four(|i| size[i].copysign(sign[i]))
    }
    #[inline(always)]
    fn quad_turn(self, a: [f64; 4]) -> [f64; 4] {
        [a[1], a[2], a[0], a[3]]
    }
    #[inline(always)]
    fn quad_turn_twice(self, a: [f64; 4]) -> [f64; 4] {
        [a[2], a[0], a[1], a[3]]
    }
    #[inline(always)]
    fn quad_first(self, a: [f64; 4]) -> f64 {
        a[0]
    }
    #[inline(always)]
    fn quad_signs(self, a: [f64; 4]) -> u32 {
        a.iter().enumerate().fold(0, |bits, (i, x)| bits | u32::from(x.is_sign_negative()) << i)
    }
    #[inline(always)]
    fn quad_of_one_sign(self, [x, y, z, _]: [f64; 4]) -> bool {
        (x >= 0.0 && y >= 0.0 && z >= 0.0) || (x <= 0.0 && y <= 0.0 && z <= 0.0)
    }
    #[inline(always)]
    fn half(self, [x, y, z]: [f32; 3]) -> [f32; 4] {
        [x, y, z, 0.0]
    }
    #[inline(always)]
    fn half_array(self, a: [f32; 4]) -> [f32; 4] {
        a
    }
    #[inline(always)]
    fn narrow(self, a: [f64; 4]) -> [f32; 4] {
        [a[0] as f32, a[1] as f32, a[2] as f32, a[3] as f32]
    }
    #[inline(always)]
    fn widen(self, a: [f32; 4]) -> [f64; 4] {
        four(|i| f64::from(a[i]))
    }
    #[inline(always)]
    fn spread(self, a: [f32; 4]) -> [[f32; 8]; 3] {
        [[a[0]; 8], [a[1]; 8], [a[2]; 8]]
    }
    #[inline(always)]
    fn bits(self, a: [bool; 8]) -> u32 {
        a.iter().enumerate().fold(0, |bits, (i, &lane)| bits | u32::from(lane) << i)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> [bool; 8] {
        std::array::from_fn(|i| bits >> i & 1 == 1)
    }
}
