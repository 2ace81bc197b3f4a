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
    over_pixels: Option<OverPixels>,
    /// The hash of all that has a sequence of its own.
    sequence: u64,
    index: u32,
    dimension: u64,
}

/// One sequence for many pixels along Morton's curve: the samples of a pixel are a net, those of 4 or 16 neighbours too,
/// so what one has too much, its neighbours have too little, and noise is of high frequency.
#[derive(Clone, Copy, Debug)]
struct OverPixels {
    /// Pixels in a row.
    width: u64,
    /// The samples of a pixel are 2 to this.
    log2_samples: u32,
    /// Columns, and rows, of the squares of pixels that share a sequence: 2 to this.
    log2_side: u32,
}

impl Sobol {
    /// The sampler of this seed, at sample 0 of pixel 0. Each pixel has a sequence of its own.
    pub fn new(seed: u64) -> Self {
        let mut sampler = Self { seed, over_pixels: None, sequence: 0, index: 0, dimension: 0 };
        sampler.begin(0, 0);
        sampler
    }

    /// The same for images so many pixels wide, with so many samples of a pixel: blue noise over the pixels. Numbers of
    /// samples that are no powers of two leave gaps in what neighbours share.
    ///
    /// # References
    /// - Ahmed & Wonka 2020, Screen-space blue-noise diffusion of Monte Carlo sampling error, ACM TOG 39(6)
    pub fn over_pixels(seed: u64, samples: u64, width: u64) -> Self {
        // Of the 32 digits of an index, at least 8 are for 16 x 16 pixels.
        let log2_samples = samples.clamp(1, 1 << 24).next_power_of_two().ilog2();
        let over_pixels = OverPixels { width: width.max(1), log2_samples, log2_side: (32 - log2_samples) / 2 };
        let mut sampler = Self { over_pixels: Some(over_pixels), ..Self::new(seed) };
        sampler.begin(0, 0);
        sampler
    }

    /// The shuffled index, its digits reversed: the first dimension of the sequence; and the hash of the dimension.
    #[inline]
    fn next(&mut self) -> (u32, u64) {
        let hash = mix(self.sequence, self.dimension);
        self.dimension += 1;
        // A scrambled index is another order within each block of 2^k, which stays a block.
        (scramble(self.index, hash as u32).reverse_bits(), hash)
    }
}

impl OverPixels {
    /// Which sequence a pixel's sample belongs to, and its number there.
    #[inline]
    fn place(self, pixel: u64, sample: u64) -> (u64, u32) {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let within = |place: u64| spread((place & ((1 << self.log2_side) - 1)) as u32);
        let morton = within(x) | within(y) << 1;
        let square = (y >> self.log2_side) << 32 | x >> self.log2_side;
        let (round, number) = (sample >> self.log2_samples, sample & ((1 << self.log2_samples) - 1));
        // Shifted in 64 bits: a shift by all 32 would be too far.
        (mix(square, round), (u64::from(morton) << self.log2_samples | number) as u32)
    }
}

/// Puts a zero before each of the 16 lower digits.
#[inline]
fn spread(x: u32) -> u32 {
    let x = (x | x << 8) & 0x00ff_00ff;
    let x = (x | x << 4) & 0x0f0f_0f0f;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
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
        let (sequence, index) = match self.over_pixels {
            // Beyond 2³² samples another sequence begins.
            None => (mix(pixel, sample >> 32), sample as u32),
            Some(over_pixels) => over_pixels.place(pixel, sample),
        };
        self.sequence = mix(self.seed, sequence);
        self.index = index;
        self.dimension = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let (fraction, hash) = self.next();
        let x = scramble(fraction, (hash >> 32) as u32);
        unit(x, below(hash, self.index))
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let (fraction, hash) = self.next();
        let x = scramble(fraction, (hash >> 32) as u32);
        // The third seed that the hash has to give: its halves together, multiplied by an odd number.
        let y = scramble(second_dimension(fraction), ((hash >> 16) as u32).wrapping_mul(0x9e37_79b1));
        let below = below(hash, self.index);
        DVec2::new(unit(x, below), unit(y, below << 32))
    }
}

/// Digits below the 32 of the sequence, of either coordinate.
#[inline]
fn below(hash: u64, index: u32) -> u64 {
    // The product's upper half depends on all digits of its factors.
    let product = (hash ^ u64::from(index)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    (product ^ product >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93)
}
