//! A model of reflection whose light is multiplied by a colour.

use glam::DVec3;

use crate::bsdf::{Bsdf, BsdfSample, Lobes, Uniforms};
use crate::math::color::Rgb;

/// `model` times `tint` ≥ 0: what some formats call a specular reflectance, which is no law of nature.
#[derive(Debug)]
pub(super) struct Tinted<B> {
    pub(super) model: B,
    pub(super) tint: Rgb,
}

impl<B: Bsdf> Bsdf for Tinted<B> {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.model.eval(wo, wi) * self.tint
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.model.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let draw = self.model.sample(wo, u)?;
        Some(BsdfSample { weight: draw.weight * self.tint, ..draw })
    }

    fn lobes(&self) -> Lobes {
        self.model.lobes()
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        self.model.albedo(wo).map(|albedo| albedo * self.tint)
    }
}
