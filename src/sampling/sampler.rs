//! Where the random numbers of a path come from.

use std::fmt;

use glam::DVec2;

use super::points::{Jittered, Sobol};
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

    /// The sampler of the same seed, at this sample of this pixel.
    #[inline]
    #[must_use]
    pub fn of(&self, pixel: u64, sample: u64) -> Self {
        Self::at(self.seed, pixel, sample)
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

/// The samplers by name. See [`points`](super::points) for what each is good for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// [`Independent`].
    #[default]
    Independent,
    /// [`Jittered`].
    Jittered,
    /// [`Sobol`].
    Sobol,
}

impl SamplerKind {
    /// All, with their names.
    pub const ALL: &[(&str, Self)] =
        &[("independent", Self::Independent), ("jittered", Self::Jittered), ("sobol", Self::Sobol)];

    /// The sampler of this seed, for so many samples of a pixel.
    pub fn sampler(self, seed: u64, samples: u64) -> AnySampler {
        match self {
            Self::Independent => AnySampler::Independent(Independent::new(seed)),
            Self::Jittered => AnySampler::Jittered(Jittered::new(seed, samples)),
            Self::Sobol => AnySampler::Sobol(Sobol::new(seed)),
        }
    }
}

/// A sampler of any kind.
#[derive(Clone, Debug)]
pub enum AnySampler {
    /// Independent numbers.
    Independent(Independent),
    /// A grid.
    Jittered(Jittered),
    /// A scrambled net.
    Sobol(Sobol),
}

impl Sampler for AnySampler {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        match self {
            Self::Independent(sampler) => sampler.begin(pixel, sample),
            Self::Jittered(sampler) => sampler.begin(pixel, sample),
            Self::Sobol(sampler) => sampler.begin(pixel, sample),
        }
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        match self {
            Self::Independent(sampler) => sampler.next_1d(),
            Self::Jittered(sampler) => sampler.next_1d(),
            Self::Sobol(sampler) => sampler.next_1d(),
        }
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        match self {
            Self::Independent(sampler) => sampler.next_2d(),
            Self::Jittered(sampler) => sampler.next_2d(),
            Self::Sobol(sampler) => sampler.next_2d(),
        }
    }
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
