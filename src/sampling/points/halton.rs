//! Halton's sequence, scrambled.

use glam::DVec2;

use super::hash::{below_one, mix, permuted};
use crate::sampling::sampler::Sampler;
use crate::sampling::stream::unit;

/// Dimension d of sample i is the radical inverse of i in the base of the d-th prime, with Owen's nested scrambling: the
/// permutation of a digit is drawn anew for every prefix of digits above it. Of N samples every interval [k, k + 1) / bʲ
/// has its share to within one, in each dimension, and every box of such intervals of bases b and c to within one for
/// each b^j c^k consecutive samples. Pairs of large bases are filled slowly, so late dimensions gain little. Samples
/// beyond N begin another sequence.
///
/// # References
/// - Halton 1964, Algorithm 247: Radical-inverse quasi-random point sequence, CACM 7(12)
/// - Owen 2017, A randomized Halton algorithm in R, arXiv 1706.02808
#[derive(Clone, Debug)]
pub struct Halton {
    seed: u64,
    samples: u32,
    pixel: u64,
    index: u32,
    dimension: usize,
}

/// The bases. Dimensions beyond begin anew with 2, the samples being in another order.
const PRIMES: [u32; 64] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97, 101, 103, 107, 109,
    113, 127, 131, 137, 139, 149, 151, 157, 163, 167, 173, 179, 181, 191, 193, 197, 199, 211, 223, 227, 229, 233, 239,
    241, 251, 257, 263, 269, 271, 277, 281, 283, 293, 307, 311,
];

impl Halton {
    /// The sampler of this seed for so many samples of a pixel, at sample 0 of pixel 0.
    pub fn new(seed: u64, samples: u64) -> Self {
        let samples = samples.clamp(1, 1 << 30) as u32;
        let mut sampler = Self { seed, samples, pixel: 0, index: 0, dimension: 0 };
        sampler.begin(0, 0);
        sampler
    }
}

impl Sampler for Halton {
    fn begin(&mut self, pixel: u64, sample: u64) {
        let samples = u64::from(self.samples);
        self.pixel = mix(mix(self.seed, pixel), sample / samples);
        self.index = (sample % samples) as u32;
        self.dimension = 0;
    }

    fn next_1d(&mut self) -> f64 {
        let (round, base) = (self.dimension / PRIMES.len(), PRIMES[self.dimension % PRIMES.len()]);
        let index = match round {
            0 => self.index,
            _ => permuted(self.index, self.samples, mix(self.pixel, !(round as u64))),
        };
        let hash = mix(self.pixel, self.dimension as u64);
        self.dimension += 1;
        scrambled_inverse(index, base, self.samples, hash)
    }

    fn next_2d(&mut self) -> DVec2 {
        let x = self.next_1d();
        DVec2::new(x, self.next_1d())
    }
}

/// The digits of `index` < `count` in `base`, the lowest first, scrambled, as a fraction. What is below the digits that
/// any index up to `count` has is random.
fn scrambled_inverse(index: u32, base: u32, count: u32, hash: u64) -> f64 {
    let (mut rest, mut reach) = (index, 1_u64);
    let (mut inverse, mut prefix) = (0_u64, hash);
    while reach < u64::from(count) {
        let digit = permuted(rest % base, base, prefix);
        inverse = inverse * u64::from(base) + u64::from(digit);
        reach *= u64::from(base);
        // By the digit before it was scrambled: either tells the prefixes apart.
        prefix = mix(prefix, u64::from(rest % base) + 1);
        rest /= base;
    }
    below_one((inverse as f64 + unit(prefix)) / reach as f64)
}
