//! Sobol's sequence with Owen's scrambling, two dimensions at a time.

use glam::DVec2;

use super::hash::{mix, scramble, unit};
use crate::sampling::sampler::Sampler;

/// The first two dimensions of Sobol's sequence, scrambled by Owen's method; for every further dimension or pair the same
/// again in another random order. Of 2^k samples, every elementary interval of a pair has its share exactly.
///
/// # References
/// - Sobol' 1967, On the distribution of points in a cube and the approximate evaluation of integrals
/// - Burley 2020, Practical hash-based Owen scrambling, JCGT 10(4)
#[derive(Clone, Debug)]
pub struct Sobol {
    seed: u64,
    pixel: u64,
    index: u32,
    dimension: u64,
}

impl Sobol {
    /// The sampler of this seed, at sample 0 of pixel 0.
    pub fn new(seed: u64) -> Self {
        let mut sampler = Self { seed, pixel: 0, index: 0, dimension: 0 };
        sampler.begin(0, 0);
        sampler
    }

    /// The shuffled index, its digits reversed: the first dimension of the sequence; and the hash of the dimension.
    #[inline]
    fn next(&mut self) -> (u32, u64) {
        let hash = mix(self.pixel, self.dimension);
        self.dimension += 1;
        // A scrambled index is another order within each block of 2^k, which stays a block.
        (scramble(self.index, hash as u32).reverse_bits(), hash)
    }
}

/// The second dimension of Sobol's sequence: its matrix is Pascal's triangle modulo 2. `fraction` is the reversed index.
#[inline]
fn second_dimension(fraction: u32) -> u32 {
    // Row by row of Pascal's triangle: the product with the matrix by doubling, since binomials modulo 2 are those of the
    // digits (Lucas): C(2m, ·) repeats C(m, ·).
    let mut x = fraction;
    x ^= (x & 0x5555_5555) << 1;
    x ^= (x & 0x3333_3333) << 2;
    x ^= (x & 0x0f0f_0f0f) << 4;
    x ^= (x & 0x00ff_00ff) << 8;
    x ^= (x & 0x0000_ffff) << 16;
    x
}

impl Sampler for Sobol {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        // Beyond 2³² samples another sequence begins.
        self.pixel = mix(mix(self.seed, pixel), sample >> 32);
        self.index = sample as u32;
        self.dimension = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let (fraction, hash) = self.next();
        let x = scramble(fraction, (hash >> 32) as u32);
        unit(x, mix(hash, u64::from(self.index)))
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let (fraction, hash) = self.next();
        let seeds = mix(hash, 1);
        let x = scramble(fraction, seeds as u32);
        let y = scramble(second_dimension(fraction), (seeds >> 32) as u32);
        let below = mix(seeds, u64::from(self.index));
        DVec2::new(unit(x, below), unit(y, below << 32))
    }
}
