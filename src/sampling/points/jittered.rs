//! Stratified samples: one in each cell of a grid, in random order.

use glam::DVec2;

use super::hash::{below_one, mix, permuted};
use crate::sampling::sampler::Sampler;
use crate::sampling::stream::unit;

/// Of N samples, one in each of N intervals of every single dimension, and one in each cell of a grid of every pair. Where
/// N is no square, the grid has a few cells more, which stay empty at random. Samples beyond N begin another grid.
///
/// If multi-jittered, each of the N intervals of either dimension of a pair has one sample, too: the samples of a column
/// of cells share its width among them, in random order, and so do those of a row.
///
/// # References
/// - Cook 1986, Stochastic sampling in computer graphics, ACM TOG 5(1)
/// - Chiu, Shirley & Wang 1994, Multi-jittered sampling, Graphics Gems IV
#[derive(Clone, Debug)]
pub struct Jittered {
    seed: u64,
    multi: bool,
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
        let mut sampler = Self { seed, multi: false, samples, columns, rows, pixel: 0, index: 0, dimension: 0 };
        sampler.begin(0, 0);
        sampler
    }

    /// The same, multi-jittered.
    pub fn multi(seed: u64, samples: u64) -> Self {
        Self { multi: true, ..Self::new(seed, samples) }
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
        let (column, row) = (cell % self.columns, cell / self.columns);
        let (mut x, mut y) = (unit(within), unit(mix(within, 1)));
        if self.multi {
            let [columns, rows] = [self.columns, self.rows];
            let among = |place, count, line| permuted(place, count, mix(hash, line));
            x = (f64::from(among(row, rows, 1 + u64::from(column))) + x) / f64::from(rows);
            // A row's number is complemented, so that no row has the order of a column.
            y = (f64::from(among(column, columns, !u64::from(row))) + y) / f64::from(columns);
        }
        let share = |place: u32, within: f64, count: u32| below_one((f64::from(place) + within) / f64::from(count));
        DVec2::new(share(column, x, self.columns), share(row, y, self.rows))
    }
}
