//! Stratified samples: one in each cell of a grid, in random order.

use glam::DVec2;

use super::hash::{mix, permuted};
use crate::sampling::sampler::Sampler;
use crate::sampling::stream::unit;

/// Of N samples, one in each of N intervals of every single dimension, and one in each cell of a grid of every pair. Where
/// N is no square, the grid has a few cells more, which stay empty at random. Samples beyond N begin another grid.
///
/// # References
/// - Cook 1986, Stochastic sampling in computer graphics, ACM TOG 5(1)
#[derive(Clone, Debug)]
pub struct Jittered {
    seed: u64,
    /// Samples of a grid, its columns and its rows.
    samples: u32,
    columns: u32,
    rows: u32,
    pixel: u64,
    index: u32,
    dimension: u64,
}

impl Jittered {
    /// The sampler of this seed for so many samples of a pixel, at sample 0 of pixel 0.
    pub fn new(seed: u64, samples: u64) -> Self {
        // Larger grids bring nothing that f32 images could show, and their cells fit into 32 bits.
        let samples = samples.clamp(1, 1 << 30) as u32;
        let columns = f64::from(samples).sqrt().ceil() as u32;
        let rows = samples.div_ceil(columns);
        let mut sampler = Self { seed, samples, columns, rows, pixel: 0, index: 0, dimension: 0 };
        sampler.begin(0, 0);
        sampler
    }

    /// The hash of the next dimension.
    #[inline]
    fn next(&mut self) -> u64 {
        self.dimension += 1;
        mix(self.pixel, self.dimension)
    }
}

impl Sampler for Jittered {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        let samples = u64::from(self.samples);
        self.pixel = mix(mix(self.seed, pixel), sample / samples);
        self.index = (sample % samples) as u32;
        self.dimension = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let hash = self.next();
        let cell = permuted(self.index, self.samples, hash);
        let within = unit(mix(hash, u64::from(self.index)));
        below_one((f64::from(cell) + within) / f64::from(self.samples))
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let hash = self.next();
        let cell = permuted(self.index, self.columns * self.rows, hash);
        let within = mix(hash, u64::from(self.index));
        let column = f64::from(cell % self.columns) + unit(within);
        let row = f64::from(cell / self.columns) + unit(mix(within, 1));
        DVec2::new(below_one(column / f64::from(self.columns)), below_one(row / f64::from(self.rows)))
    }
}

/// A division may round up to 1.
#[inline]
fn below_one(x: f64) -> f64 {
    x.min(1.0 - f64::EPSILON / 2.0)
}
