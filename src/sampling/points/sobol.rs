//! Sobol's sequence with Owen's scrambling, two dimensions at a time.

use glam::DVec2;

use super::hash::{carried, mix, unit};
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
    /// The number of the sample there, its digits reversed.
    inverse: u32,
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
        let mut sampler = Self { seed, over_pixels: None, sequence: 0, inverse: 0, dimension: 0 };
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

    /// The sample's number in the order of the next dimension, and the hash of that. Reversed, its digits are the first
    /// dimension of the sequence.
    #[inline]
    fn next(&mut self) -> (u32, u64) {
        let hash = mix(self.sequence, self.dimension);
        self.dimension += 1;
        // Another order within each block of 2^k, which stays a block.
        (carried(self.inverse, hash as u32).reverse_bits(), hash)
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

/// The number whose reversed digits are the second dimension of Sobol's sequence; the matrix of that is Pascal's triangle
/// modulo 2.
#[inline]
fn second_dimension(number: u32) -> u32 {
    // Row by row of Pascal's triangle: the product with the matrix by doubling, since binomials modulo 2 are those of the
    // digits (Lucas): C(2m, ·) repeats C(m, ·).
    let mut x = number;
    x ^= (x >> 1) & 0x5555_5555;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^ (x >> 16)
}

impl Sampler for Sobol {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        let (sequence, number) = match self.over_pixels {
            // Beyond 2³² samples another sequence begins.
            None => (mix(pixel, sample >> 32), sample as u32),
            Some(over_pixels) => over_pixels.place(pixel, sample),
        };
        self.sequence = mix(self.seed, sequence);
        self.inverse = number.reverse_bits();
        self.dimension = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let (number, hash) = self.next();
        let x = carried(number, (hash >> 32) as u32).reverse_bits();
        unit(u64::from(x) << 32 | mix(hash, u64::from(self.inverse)) >> 32)
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let (number, hash) = self.next();
        let seeds = mix(hash, 1);
        let x = carried(number, seeds as u32);
        let y = carried(second_dimension(number), (seeds >> 32) as u32);
        // Both at once: the lower half of the one becomes the upper half of the other.
        let both = (u64::from(y) << 32 | u64::from(x)).reverse_bits();
        // What is below the 32 digits of the sequence is random.
        let below = mix(seeds, u64::from(self.inverse));
        DVec2::new(unit(both & !0xffff_ffff | below >> 32), unit(both << 32 | below & 0xffff_ffff))
    }
}
