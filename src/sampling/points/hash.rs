//! Hashes that shuffle and scramble.

use crate::sampling::stream;

pub(super) use stream::unit;

/// A hash of two numbers: SplitMix64's output `b` steps after `a`.
#[inline]
pub(super) fn mix(a: u64, b: u64) -> u64 {
    stream::mix(a.wrapping_add(b.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// A random bijection whose digits depend on those below alone: sums and products of integers carry upwards only.
///
/// With its digits in reversed order, "below" becomes "above": this is Owen's nested uniform scramble of a binary fraction.
/// A digit is flipped or not as the seed and all digits above it say, so points of one elementary interval stay together,
/// and which interval they come to is random at every level.
///
/// # References
/// - Owen 1995, Randomly permuted (t,m,s)-nets and (t,s)-sequences
/// - Laine & Karras 2011, Stratified sampling for stochastic transparency, CGF 30(4)
/// - Burley 2020, Practical hash-based Owen scrambling, JCGT 10(4); constants: Vegdahl 2021
#[inline]
pub(super) fn carried(x: u32, seed: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// A permutation of 0..count, `i` being below `count`: bijections of the next power of two, until they fall below, and a
/// rotation, by which every place is equally likely.
#[inline]
pub(super) fn permuted(i: u32, count: u32, seed: u64) -> u32 {
    let mask = count.next_power_of_two().wrapping_sub(1);
    let bits = mask.count_ones();
    let mut x = i;
    loop {
        // Within the mask, sums, odd factors, and what higher digits flip in lower ones are bijections.
        for round in 0..4_u32 {
            let key = seed.rotate_left(17 * round) as u32;
            x = x.wrapping_add(key) & mask;
            // Not always, or not all permutations of four places would be reached.
            x ^= (x >> (bits / 2).max(1)) & (key >> 20);
            x = x.wrapping_mul((key >> 8) | 1) & mask;
            x ^= x >> (bits / 3).max(1);
        }
        if x < count {
            break;
        }
    }
    let rotation = ((stream::mix(seed) >> 32) * u64::from(count)) >> 32;
    let rotated = u64::from(x) + rotation;
    (if rotated < u64::from(count) { rotated } else { rotated - u64::from(count) }) as u32
}

/// `x`, or the largest number below 1: a sum or division may round up to 1.
#[inline]
pub(super) fn below_one(x: f64) -> f64 {
    x.min(1.0 - f64::EPSILON / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// χ² of the places of the first two of `count` over 40 000 seeds, all ordered pairs being equally likely.
    fn chi2(permuted: &dyn Fn(u32, u32, u64) -> u32, count: u32) -> f64 {
        let mut counts = vec![0.0; (count * count) as usize];
        for seed in 0..40_000 {
            let hash = mix(seed, 3);
            let [a, b] = [0, 1].map(|i| permuted(i, count, hash));
            assert!(a < count && b < count && a != b);
            counts[(a * count + b) as usize] += 1.0;
        }
        let expected = 40_000.0 / f64::from(count * (count - 1));
        let of_different = counts.iter().enumerate().filter(|(k, _)| k / count as usize != k % count as usize);
        of_different.map(|(_, n)| (n - expected) * (n - expected) / expected).sum()
    }

    #[test]
    fn permutations_put_any_two_anywhere() {
        for count in 2..40_u32 {
            let freedom = f64::from(count * (count - 1) - 1);
            // Six standard deviations of χ², whose tail is heavier than a normal one: 1e-6 for the least freedom of 1.
            let bound = freedom + 6.0 * (2.0 * freedom).sqrt() + 16.0;
            let found = chi2(&permuted, count);
            assert!(found < bound, "{count}: {found}, at most {bound}");
            // A rotation alone keeps neighbours together.
            let rotated = |i, count, seed| ((u64::from(i) + seed % u64::from(count)) % u64::from(count)) as u32;
            assert!(count == 2 || chi2(&rotated, count) > bound, "{count}");
        }
        // All places are taken.
        let mut seen = [false; 77];
        (0..77).for_each(|i| seen[permuted(i, 77, 5) as usize] = true);
        assert!(seen.iter().all(|seen| *seen));
    }
}
