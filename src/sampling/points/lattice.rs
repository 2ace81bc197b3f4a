//! A rank-1 lattice sequence with random shifts.

use glam::DVec2;

use super::hash::{carried, mix, unit};
use crate::sampling::sampler::Sampler;

/// The pairs of 2^k samples are the points (i, z i) / 2^k modulo 1 of a lattice that is moved as a whole by a random shift;
/// single dimensions are an even grid, moved likewise. Sample i of the sequence has the radical inverse φ(i) in base 2 and
/// z φ(i) modulo 1, so that every 2^k consecutive samples are such a lattice.
///
/// Three pairs after each other, such as those of a pixel, of a light and of a direction, share one order of the samples up
/// to factors: any two of them are a lattice in four dimensions, each pair being the same lattice as alone. The next three
/// pairs have another order, and so has every single dimension.
///
/// For few samples its points keep more distance than those of a scrambled net, and it costs a third of one: a few products
/// and sums of integers.
///
/// # References
/// - Cranley & Patterson 1976, Randomization of number theoretic methods for multiple integration, SIAM J. Numer. Anal. 13(6)
/// - Hickernell, Hong, L'Écuyer & Lemieux 2000, Extensible lattice sequences for quasi-Monte Carlo quadrature, SIAM J. Sci.
///   Comput. 22(3)
#[derive(Clone, Debug)]
pub struct Lattice {
    seed: u64,
    sequence: u64,
    /// The radical inverse of the sample's number, as 32 digits.
    inverse: u32,
    dimension: u64,
    /// The radical inverse of the sample's place in the order of these pairs.
    order: u32,
    /// Which one of them is next.
    turn: usize,
}

/// z. Found by extending the best generators modulo 2^k digit by digit: for 2^3 to 2^32 points the square of the least
/// distance is at least .495 of a hexagonal lattice's, 2 / (√3 N), which no lattice of N points exceeds.
const GENERATOR: u32 = 0xf320_4613;

/// Factors of pairs that share an order. Found by trying all modulo 2^13: for 2^4 to 2^13 points, the least distance in the four
/// dimensions of any two pairs is at least .53 of that of the densest lattice, 2^(1/4) N^(-1/4).
const FACTORS: [u32; 3] = [1, 0x7fa2_200b, 0xd4cd_20d9];

impl Lattice {
    /// The sampler of this seed, at sample 0 of pixel 0.
    pub fn new(seed: u64) -> Self {
        let mut sampler = Self { seed, sequence: 0, inverse: 0, dimension: 0, order: 0, turn: 0 };
        sampler.begin(0, 0);
        sampler
    }

    /// The hash of the next dimension.
    #[inline]
    fn next(&mut self) -> u64 {
        let hash = mix(self.sequence, self.dimension);
        self.dimension += 1;
        hash
    }

    /// The radical inverse of the sample's place in a random order: the first digits of a number are the last of its
    /// inverse, from which sums and products carry to those above. So a block of 2^k stays a block.
    #[inline]
    fn shuffled(&self, hash: u64) -> u32 {
        carried(self.inverse, hash as u32)
    }
}

/// A fraction of 32 digits, moved by a shift of 64, modulo 1.
#[inline]
fn shifted(fraction: u32, shift: u64) -> f64 {
    unit((u64::from(fraction) << 32).wrapping_add(shift))
}

impl Sampler for Lattice {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        // Beyond 2³² samples another sequence begins.
        self.sequence = mix(self.seed, mix(pixel, sample >> 32));
        self.inverse = (sample as u32).reverse_bits();
        (self.dimension, self.turn) = (0, 0);
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let hash = self.next();
        // The order takes the lower half of the hash, so the upper one is free for the shift's first digits.
        shifted(self.shuffled(hash), hash)
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let hash = self.next();
        if self.turn == 0 {
            self.order = self.shuffled(hash);
        }
        let point = self.order.wrapping_mul(FACTORS[self.turn]);
        self.turn = (self.turn + 1) % FACTORS.len();
        let shift = mix(hash, 1);
        DVec2::new(shifted(point, shift), shifted(point.wrapping_mul(GENERATOR), shift.rotate_left(32)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The square of the shortest distance of two points of the lattice (i, z i) modulo `n`, by Gauss's reduction of its
    /// basis (1, z), (0, n).
    fn shortest(z: i128, n: i128) -> i128 {
        let dot = |a: [i128; 2], b: [i128; 2]| a[0] * b[0] + a[1] * b[1];
        let (mut long, mut short) = ([0, n], [1, z]);
        loop {
            if dot(long, long) < dot(short, short) {
                std::mem::swap(&mut long, &mut short);
            }
            let length = dot(short, short);
            // Nearest whole number of times that the short one fits into the long one.
            let times = (2 * dot(long, short) + length).div_euclid(2 * length);
            if times == 0 {
                return length;
            }
            long = [long[0] - times * short[0], long[1] - times * short[1]];
            if dot(long, long) == length {
                return length;
            }
        }
    }

    #[test]
    fn the_shortest_distance_is_that_of_the_closest_pair() {
        for (z, n) in [(5, 13), (7, 32), (1, 10), (27, 64), (13, 34_i128)] {
            let around = |x: i128| x.min(n - x);
            let squares = (1..n).map(|i| around(i).pow(2) + around(i * z % n).pow(2));
            assert_eq!(shortest(z, n), squares.min().unwrap(), "{z}, {n}");
        }
    }

    #[test]
    fn every_power_of_two_has_a_good_lattice() {
        let of_hexagonal = |z: u32, k: u32| {
            let n = 1_i128 << k;
            shortest(i128::from(z) % n, n) as f64 / (n as f64 * 2.0 / 3_f64.sqrt())
        };
        assert!((3..=32).all(|k| of_hexagonal(GENERATOR, k) >= 0.495));
        // One that is good for 2^32 points alone: the golden ratio.
        assert!((3..=32).any(|k| of_hexagonal(0x9e37_79b1, k) < 0.495));
    }

    /// The least distance of 2^k points (i, z i, a i, a z i) / 2^k modulo 1, as a share of that of the densest lattice.
    fn distance_in_four_dimensions(a: u32, k: u32) -> f64 {
        let n = 1_u32 << k;
        let around = |x: u32| f64::from((x % n).min(n - x % n));
        let square = |i: u32| {
            let j = i.wrapping_mul(a);
            [i, i.wrapping_mul(GENERATOR), j, j.wrapping_mul(GENERATOR)].map(|x| around(x).powi(2)).iter().sum::<f64>()
        };
        let least = (1..=n / 2).map(square).fold(f64::INFINITY, f64::min).sqrt() / f64::from(n);
        least / (2.0 / f64::from(n)).powf(0.25)
    }

    #[test]
    fn two_pairs_that_share_an_order_are_a_good_lattice_in_four_dimensions() {
        // 1/a modulo 2^32 by Newton's iteration, which doubles the digits that are right; a is right to 3.
        let inverse = |a: u32| (0..4).fold(a, |x, _| x.wrapping_mul(2_u32.wrapping_sub(a.wrapping_mul(x))));
        let [one, a, b] = FACTORS;
        assert_eq!(one, 1);
        for ratio in [a, b, b.wrapping_mul(inverse(a))] {
            for k in 4..=13 {
                let share = distance_in_four_dimensions(ratio, k);
                assert!(share >= 0.53, "{ratio:#x}, 2^{k}: {share}");
            }
        }
        assert!((4..=13).any(|k| distance_in_four_dimensions(3, k) < 0.3), "a factor of no merit");
    }
}
