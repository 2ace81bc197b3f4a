//! Hashes that shuffle and scramble.

use crate::sampling::stream;

/// A hash of two numbers: SplitMix64's output `b` steps after `a`.
#[inline]
pub(super) fn mix(a: u64, b: u64) -> u64 {
    stream::mix(a.wrapping_add(b.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// Owen's nested uniform scramble of a binary fraction: a digit is flipped or not as the seed and all digits above it
/// say. So points of one elementary interval stay together, and which interval they come to is random at every level.
///
/// In reversed order, "above" becomes "below", and sums and products of integers carry upwards only: each of the steps is
/// a bijection whose digits depend on those below alone.
///
/// # References
/// - Owen 1995, Randomly permuted (t,m,s)-nets and (t,s)-sequences
/// - Laine & Karras 2011, Stratified sampling for stochastic transparency, CGF 30(4)
/// - Burley 2020, Practical hash-based Owen scrambling, JCGT 10(4); constants: Vegdahl 2021
#[inline]
pub(super) fn scramble(fraction: u32, seed: u32) -> u32 {
    let x = fraction.reverse_bits();
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    (x ^ x.wrapping_mul(0x53a2_2864)).reverse_bits()
}

/// A permutation of 0..count, `i` being below `count`: bijections of the next power of two, until they fall below.
#[inline]
pub(super) fn permuted(i: u32, count: u32, seed: u64) -> u32 {
    let mask = count.next_power_of_two().wrapping_sub(1);
    let bits = mask.count_ones().max(1);
    let (a, b) = (seed as u32, (seed >> 32) as u32);
    let mut x = i;
    loop {
        // Odd factors, sums and shifts to the right within the mask are bijections, each.
        for round in 0..3_u32 {
            let key = a.rotate_left(11 * round) ^ b.wrapping_mul(2 * round + 1);
            x = (x ^ key) & mask;
            x = x.wrapping_mul(0x9e37_79b1 ^ (key << 1)) & mask;
            x ^= x >> (bits / 2 + 1).min(31);
            x = x.wrapping_add(key >> 7) & mask;
        }
        if x < count {
            return x;
        }
    }
}

/// The fraction of 32 binary digits, with the lower ones from a hash: uniform in [0, 1) to 53 digits.
#[inline]
pub(super) fn unit(digits: u32, below: u64) -> f64 {
    stream::unit(u64::from(digits) << 32 | below >> 32)
}
