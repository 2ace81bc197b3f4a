//! Where the random numbers of a path come from.

use std::fmt;

use glam::DVec2;

use super::stream::{Stream, Uniforms, stream, uniform};

/// A source of uniform numbers in [0, 1) for the dimensions of one sample of one pixel after the other.
pub trait Sampler: fmt::Debug {
    /// Starts the given sample of the given pixel: what follows depends on nothing but the two and the seed.
    fn begin(&mut self, pixel: u64, sample: u64);

    /// The number of the next dimension.
    fn next_1d(&mut self) -> f64;

    /// The numbers of the next two dimensions, which belong together.
    fn next_2d(&mut self) -> DVec2 {
        let x = self.next_1d();
        DVec2::new(x, self.next_1d())
    }

    /// The uniforms of one draw from a [`Bsdf`](crate::bsdf::Bsdf).
    fn next_uniforms(&mut self) -> Uniforms {
        let lobe = self.next_1d();
        Uniforms { lobe, dir: self.next_2d() }
    }
}

/// Independent numbers: each sample of each pixel has its own random stream.
#[derive(Clone, Debug)]
pub struct Independent {
    seed: u64,
    rng: Stream,
}

impl Independent {
    /// The sampler of this seed, at sample 0 of pixel 0.
    pub fn new(seed: u64) -> Self {
        Self::at(seed, 0, 0)
    }

    /// The sampler of this seed, at this sample of this pixel.
    #[inline]
    pub fn at(seed: u64, pixel: u64, sample: u64) -> Self {
        Self { seed, rng: stream(seed, pixel, sample) }
    }
}

impl Sampler for Independent {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        self.rng = stream(self.seed, pixel, sample);
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        uniform(&mut self.rng)
    }
}

/// The samplers by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// [`Independent`].
    #[default]
    Independent,
}

impl SamplerKind {
    /// All, with their names.
    pub const ALL: &[(&str, Self)] = &[("independent", Self::Independent)];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_depends_on_seed_pixel_and_number_alone() {
        let draw = |seed, pixel, sample| {
            let mut sampler = Independent::new(seed);
            sampler.next_1d();
            sampler.begin(pixel, sample);
            sampler.next_2d()
        };
        assert_eq!(draw(1, 2, 3), draw(1, 2, 3));
        assert!(draw(1, 2, 3) != draw(2, 2, 3) && draw(1, 2, 3) != draw(1, 3, 3) && draw(1, 2, 3) != draw(1, 2, 4));
    }
}
