//! Rendering: estimators of the radiance along a ray, and the film that collects it.

pub mod checkpoint;
pub mod film;
pub mod furnace;
pub mod path;
pub mod photon;
pub mod probe;
pub mod progressive;
pub mod provenance;
pub mod radiosity;

use crate::math::color::Rgb;
use crate::sampling::points::Lattice;
use crate::sampling::sampler::{AnySampler, Independent, Sampler};
use crate::scene::{Ray, Scene};

/// An estimator of the radiance that arrives along a ray: every algorithm of light transport is one.
pub trait Radiance: Sync {
    /// One sample of the radiance that arrives at the ray's origin against its direction [W/(sr m²)].
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb;

    /// The same for many samples, each with its own random numbers: an estimator may go on with one of them while another
    /// waits for the machine.
    fn radiances(&self, scene: &Scene, samples: Samples) {
        match samples {
            Samples::Independent(samples) => one_by_one(self, scene, samples),
            Samples::Lattice(samples) => one_by_one(self, scene, samples),
            Samples::Any(samples) => one_by_one(self, scene, samples),
        }
    }
}

fn one_by_one<S: Sampler>(radiance: &(impl Radiance + ?Sized), scene: &Scene, samples: &mut [Sample<S>]) {
    for Sample { ray, sampler, radiance: found } in samples {
        *found = radiance.radiance(scene, *ray, sampler);
    }
}

/// One sample of the radiance along a ray.
#[derive(Clone, Debug)]
pub struct Sample<S> {
    /// The ray against which the radiance arrives.
    pub ray: Ray,
    /// The random numbers that are left for it.
    pub sampler: S,
    /// The radiance, once it is known.
    pub radiance: Rgb,
}

impl<S> Sample<S> {
    /// Along this ray, not known yet.
    pub fn new(ray: Ray, sampler: S) -> Self {
        Self { ray, sampler, radiance: Rgb::BLACK }
    }
}

/// Samples with one kind of numbers. Those that images are mostly made of are known to the compiler: a choice at every
/// number costs a path tracer a tenth of its time.
#[derive(Debug)]
pub enum Samples<'a> {
    /// Independent numbers.
    Independent(&'a mut [Sample<Independent>]),
    /// Lattices.
    Lattice(&'a mut [Sample<Lattice>]),
    /// Any.
    Any(&'a mut [Sample<AnySampler>]),
}

impl<'a> From<&'a mut [Sample<Independent>]> for Samples<'a> {
    fn from(samples: &'a mut [Sample<Independent>]) -> Self {
        Self::Independent(samples)
    }
}

impl<'a> From<&'a mut [Sample<Lattice>]> for Samples<'a> {
    fn from(samples: &'a mut [Sample<Lattice>]) -> Self {
        Self::Lattice(samples)
    }
}

impl<'a> From<&'a mut [Sample<AnySampler>]> for Samples<'a> {
    fn from(samples: &'a mut [Sample<AnySampler>]) -> Self {
        Self::Any(samples)
    }
}

/// So many samples at once are enough for [`Radiance::radiances`] to do its best, and still fit into a core's own memory.
pub const WAVE: usize = 64;
