//! Mistakes in the density and the weight: the directions drawn are the original's.

use std::f64::consts::TAU;

use glam::DVec3;

use super::flaw::flaws;
use crate::bsdf::{BsdfSample, Density, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::{half_vector, mirror};

flaws! {
    /// Forgets the 1 / (4 wo·m) of the map from half vectors to directions.
    WrongJacobian() {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            self.0.pdf(wo, wi) * 4.0 * wo.dot(half_vector(wo, wi))
        }
    }

    /// The density times a constant.
    ScaledPdf(f64) {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            self.0.pdf(wo, wi) * self.1
        }
    }

    /// Takes wo for wi and wi for wo in the density.
    FlippedPdf() {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            self.0.pdf(wi, wo)
        }
    }

    /// Claims the uniform density of the hemisphere.
    UniformPdf() {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            if wo.z > 0.0 && wi.z > 0.0 { 1.0 / TAU } else { 0.0 }
        }
    }

    /// Multiplies the density by Schlick's Fresnel factor, as if absorbed light were not drawn.
    FresnelInPdf(f64) {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            let away = 1.0 - wo.dot(half_vector(wo, wi));
            self.0.pdf(wo, wi) * (self.1 + (1.0 - self.1) * away.powi(5))
        }
    }

    /// Puts the masking of V-cavities into the density of normals drawn with Smith's.
    VCavityPdf() {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            let Some(normals) = self.0.normals() else { return 0.0 };
            let (m, smith) = (half_vector(wo, wi), normals.g1(wo));
            let cavity = (2.0 * m.z * wo.z / wo.dot(m)).min(1.0);
            if smith > 0.0 && wo.dot(m) > 0.0 { self.0.pdf(wo, wi) * cavity / smith } else { 0.0 }
        }
    }

    /// Puts a density into the sample that differs from pdf() by a factor.
    DensityOff(f64) {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            Some(BsdfSample { density: Density::SolidAngle(self.0.pdf(wo, s.wi) * self.1), ..s })
        }
    }

    /// The weight times a constant.
    WeightOff(f64) {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            self.0.sample(wo, u).map(|s| BsdfSample { weight: s.weight * self.1, ..s })
        }
    }

    /// The weight f / density, without the cosine.
    MissingCosine() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            self.0.sample(wo, u).map(|s| BsdfSample { weight: s.weight / s.wi.z, ..s })
        }
    }

    /// The weight with cosθ + 10⁻⁴, "to be safe".
    ClampedCosine() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            self.0.sample(wo, u).map(|s| BsdfSample { weight: s.weight * ((s.wi.z + 1e-4) / s.wi.z), ..s })
        }
    }

    /// One draw in ten thousand has a thousand times its weight.
    RareHugeWeight() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let factor = if u.lobe < 1e-4 { 1e3 } else { 1.0 };
            self.0.sample(wo, u).map(|s| BsdfSample { weight: s.weight * factor, ..s })
        }
    }

    /// The weight of the mirror direction, whatever was drawn.
    StaleWeight() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let wi = mirror(wo);
            let weight: Rgb = self.0.eval(wo, wi) * (wi.z / self.0.pdf(wo, wi));
            self.0.sample(wo, u).map(|s| BsdfSample { weight, ..s })
        }
    }
}
