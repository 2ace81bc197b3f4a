//! Rendering: estimators of the radiance along a ray, and the film that collects it.

pub mod checkpoint;
pub mod film;
pub mod furnace;
pub mod path;
pub mod probe;
pub mod progressive;
pub mod provenance;

use crate::math::color::Rgb;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{Ray, Scene};

/// An estimator of the radiance that arrives along a ray: every algorithm of light transport is one.
pub trait Radiance: Sync {
    /// One sample of the radiance that arrives at the ray's origin against its direction [W/(sr m²)].
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb;

    /// The same for many samples, each with its own random numbers: an estimator may go on with one of them while another
    /// waits for the machine.
    fn radiances(&self, scene: &Scene, samples: &mut [Sample]) {
        for Sample { ray, sampler, radiance } in samples {
            *radiance = self.radiance(scene, *ray, sampler);
        }
    }
}

/// One sample of the radiance along a ray.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The ray against which the radiance arrives.
    pub ray: Ray,
    /// The random numbers that are left for it.
    pub sampler: Independent,
    /// The radiance, once it is known.
    pub radiance: Rgb,
}

impl Sample {
    /// Along this ray, not known yet.
    pub fn new(ray: Ray, sampler: Independent) -> Self {
        Self { ray, sampler, radiance: Rgb::BLACK }
    }
}

/// So many samples at once are enough for [`Radiance::radiances`] to do its best, and still fit into a core's own memory.
pub const WAVE: usize = 64;
