//! Where the random numbers of a path come from.

use std::fmt;

use glam::DVec2;

use super::points::{Halton, Jittered, Lattice, Sobol};
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

/// The samplers by name. See [`points`](super::points) for what each is good for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// [`Independent`].
    Independent,
    /// [`Jittered`].
    Jittered,
    /// [`Jittered::multi`].
    MultiJittered,
    /// [`Halton`].
    Halton,
    /// [`Lattice`]: what images are rendered with unless another is asked for.
    #[default]
    Lattice,
    /// [`Sobol`].
    Sobol,
    /// [`Sobol::over_pixels`].
    BlueSobol,
}

/// Numbers of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// All.
    Any,
    /// 1, 4, 9, …
    Squares,
    /// 1, 2, 4, …
    PowersOfTwo,
}

impl Counts {
    /// Whether this is one of them.
    pub fn contains(self, samples: u64) -> bool {
        match self {
            Self::Any => true,
            Self::Squares => samples.isqrt().pow(2) == samples,
            Self::PowersOfTwo => samples.is_power_of_two(),
        }
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Any => "any number",
            Self::Squares => "squares",
            Self::PowersOfTwo => "powers of two",
        })
    }
}

impl SamplerKind {
    /// All, with their names.
    pub const ALL: &[(&str, Self)] = &[
        ("independent", Self::Independent),
        ("jittered", Self::Jittered),
        ("multi-jittered", Self::MultiJittered),
        ("halton", Self::Halton),
        ("lattice", Self::Lattice),
        ("sobol", Self::Sobol),
        ("blue-sobol", Self::BlueSobol),
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }

    /// Whether consecutive samples of one pixel complement each other, be they few or many.
    pub fn is_sequence(self) -> bool {
        matches!(self, Self::Halton | Self::Lattice | Self::Sobol | Self::BlueSobol)
    }

    /// The numbers of samples with which it is at its best.
    pub fn good_counts(self) -> Counts {
        match self {
            Self::Independent | Self::Halton => Counts::Any,
            Self::Jittered | Self::MultiJittered => Counts::Squares,
            Self::Lattice | Self::Sobol | Self::BlueSobol => Counts::PowersOfTwo,
        }
    }

    /// The sampler of this seed, for so many samples of a pixel, and so many pixels in a row.
    pub fn sampler(self, seed: u64, samples: u64, width: u64) -> AnySampler {
        match self {
            Self::Independent => AnySampler::Independent(Independent::new(seed)),
            Self::Jittered => AnySampler::Jittered(Jittered::new(seed, samples)),
            Self::MultiJittered => AnySampler::Jittered(Jittered::multi(seed, samples)),
            Self::Halton => AnySampler::Halton(Halton::new(seed, samples)),
            Self::Lattice => AnySampler::Lattice(Lattice::new(seed)),
            Self::Sobol => AnySampler::Sobol(Sobol::new(seed)),
            Self::BlueSobol => AnySampler::Sobol(Sobol::over_pixels(seed, samples, width)),
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
    /// A sequence in many bases.
    Halton(Halton),
    /// A lattice.
    Lattice(Lattice),
    /// A scrambled net.
    Sobol(Sobol),
}

/// The same call to the sampler that it is.
macro_rules! of_any {
    ($any:expr, $sampler:ident => $call:expr) => {
        match $any {
            AnySampler::Independent($sampler) => $call,
            AnySampler::Jittered($sampler) => $call,
            AnySampler::Halton($sampler) => $call,
            AnySampler::Lattice($sampler) => $call,
            AnySampler::Sobol($sampler) => $call,
        }
    };
}

impl Sampler for AnySampler {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        of_any!(self, sampler => sampler.begin(pixel, sample));
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        of_any!(self, sampler => sampler.next_1d())
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        of_any!(self, sampler => sampler.next_2d())
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

    #[test]
    fn good_counts_are_those_of_the_name() {
        let first = |counts: Counts| (1..20).filter(|&n| counts.contains(n)).collect::<Vec<_>>();
        assert_eq!(first(Counts::Squares), [1, 4, 9, 16]);
        assert_eq!(first(Counts::PowersOfTwo), [1, 2, 4, 8, 16]);
        assert_eq!(first(Counts::Any).len(), 19);
        assert_eq!(SamplerKind::Jittered.good_counts().to_string(), "squares");
    }
}
