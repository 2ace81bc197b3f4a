//! Rendering: estimators of the radiance along a ray, and the film that collects it.

pub mod checkpoint;
pub mod film;
pub mod filter;
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

    /// The same with independent numbers: an estimator that is compiled together with this sampler draws them without a
    /// call each.
    fn radiance_independent(&self, scene: &Scene, ray: Ray, sampler: &mut Independent) -> Rgb {
        self.radiance(scene, ray, sampler)
    }
}
