//! The model of glTF: a diffuse base under a dielectric reflection, or a metal, or something between.
//!
//! f = (1 − F) (1 − m) c / π + F D V, F = f0 + (1 − f0)(1 − wo·h)⁵, f0 = 0.04 (1 − m) + c m      [1/sr]
//!
//! with the base colour c, the metallic share m, and GGX normals of slope width α = roughness², correlated masking. Drawn is
//! the reflection, among visible normals, with the probability of its albedo at f0, or else the cosine. Bright bases that are
//! no metals gain a few percent of energy near grazing: the specification wants it so.
//! # References
//! - Khronos Group 2021, glTF 2.0 specification, appendix B.3.5 (this combination)

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::bsdf::{Bsdf, BsdfSample, Fresnel, Ggx, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

/// The reflectance of a dielectric of index 1.5 at normal incidence.
const DIELECTRIC: f64 = 0.04;
/// The narrowest slopes that the microfacet model takes.
const LEAST_ALPHA: f64 = 1e-4;

/// The metallic-roughness model at one point.
#[derive(Clone, Debug)]
pub(super) struct MetallicRoughness {
    /// (1 − m) c.
    diffuse: Rgb,
    f0: Rgb,
    specular: Ggx,
    /// The probability of the reflection.
    share: f64,
}

impl MetallicRoughness {
    /// A base colour in [0, 1] per channel, a metallic share and a roughness in [0, 1]. Roughness near 0 becomes 0.01.
    pub(super) fn new(base: Rgb, metallic: f64, roughness: f64) -> Result<Self, ParamError> {
        let f0 = Rgb::grey(DIELECTRIC * (1.0 - metallic)) + base * metallic;
        let alpha = (roughness * roughness).max(LEAST_ALPHA);
        let specular = Ggx::new(alpha)?.with_fresnel(Fresnel::Schlick { f0 })?;
        let diffuse = base * (1.0 - metallic);
        let (bright, dark) = (f0.mean(), (Rgb::WHITE - f0).mean() * diffuse.mean());
        let share = if dark > 0.0 { bright / (bright + dark) } else { 1.0 };
        Ok(Self { diffuse, f0, specular, share })
    }
}

impl Bsdf for MetallicRoughness {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return Rgb::BLACK;
        }
        // wo·h = |wo + wi| / 2 for unit vectors.
        let cosine = 0.5 * (wo + wi).length();
        let passed = Rgb::WHITE - Fresnel::Schlick { f0: self.f0 }.eval(cosine);
        self.specular.eval(wo, wi) + self.diffuse * passed * FRAC_1_PI
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return 0.0;
        }
        self.share * self.specular.pdf(wo, wi) + (1.0 - self.share) * cosine_hemisphere_pdf(wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        Some(wo).filter(|wo| wo.z > 0.0)?;
        let wi = if u.lobe < self.share { self.specular.sample(wo, u)?.wi } else { cosine_hemisphere(u.dir) };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::direction;
    use crate::validate::{Effort, Outcome, Suite};

    #[test]
    fn it_is_lawful_but_for_energy() {
        for (metallic, roughness) in [(0.0, 0.5), (0.4, 0.3), (1.0, 0.7)] {
            let model = MetallicRoughness::new(Rgb::new(0.9, 0.5, 0.1), metallic, roughness).unwrap();
            let sheet = Suite { effort: Effort::Quick, ..Suite::default() }.run(&model);
            // F is that of the half vector: near grazing the base is lit by what the reflection has taken, and bright ones
            // gain some percent. So says the specification.
            let kept = metallic == 1.0;
            for check in sheet.checks.iter().filter(|check| kept || !check.name.starts_with("energy")) {
                assert_eq!(check.outcome, Outcome::Pass, "{metallic} {roughness}: {check:#?}");
            }
        }
    }

    #[test]
    fn ends_are_what_the_specification_says() {
        let (wo, wi) = (direction(0.4, 0.3), direction(0.7, 2.0));
        let base = Rgb::new(0.9, 0.5, 0.1);
        let metal = MetallicRoughness::new(base, 1.0, 0.5).unwrap();
        let ggx = Ggx::new(0.25).unwrap().with_fresnel(Fresnel::Schlick { f0: base }).unwrap();
        assert!((metal.eval(wo, wi) - ggx.eval(wo, wi)).0.length() < 1e-15);
        let black = MetallicRoughness::new(Rgb::BLACK, 0.0, 0.5).unwrap();
        let white = MetallicRoughness::new(Rgb::WHITE, 0.0, 0.5).unwrap();
        let h = (wo + wi).normalize();
        let f = 0.04 + 0.96 * (1.0 - wo.dot(h)).powi(5);
        assert!(((white.eval(wo, wi) - black.eval(wo, wi)).0.x - (1.0 - f) * FRAC_1_PI).abs() < 1e-14);
    }
}
