//! A model put together from three: what goes wrong when two of them are not the same.

use glam::DVec3;

use crate::bsdf::microfacet::Normals;
use crate::bsdf::{Bsdf, BsdfSample, Lobes, Uniforms};
use crate::math::color::Rgb;

/// f of one model, the density of another, directions drawn from a third; weights are f cos / that density.
#[derive(Clone, Copy, Debug)]
pub struct Chimera<F, P, S> {
    /// What f and all that belongs to it is taken from.
    pub f: F,
    /// What the density is taken from.
    pub pdf: P,
    /// What directions are drawn from.
    pub draws: S,
}

impl<F: Bsdf, P: Bsdf, S: Bsdf> Bsdf for Chimera<F, P, S> {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.f.eval(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.pdf.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let wi = self.draws.sample(wo, u)?.wi;
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    fn lobes(&self) -> Lobes {
        self.f.lobes()
    }

    fn eta(&self) -> f64 {
        self.f.eta()
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        self.f.albedo(wo)
    }

    fn normals(&self) -> Option<&dyn Normals> {
        self.f.normals()
    }
}
