//! EON: the energy-preserving Oren-Nayar model, Fujii's lobe plus the light of all further bounces.
//!
//! f = ρ f₁ + ρₘ/π (1 − E(θi)) (1 − E(θo)) / (1 − ⟨E⟩)      [1/sr],  ρₘ = ρ² ⟨E⟩ / (1 − ρ (1 − ⟨E⟩))
//!
//! with f₁, E and ⟨E⟩ of [`Fon`](super::Fon) at unit reflectance. `rho` in [0, 1] is the reflectance of one bounce, per
//! channel: further bounces saturate the colour. `r` in [0, 1] is Fujii's roughness. The albedo is ρ E + ρₘ (1 − E):
//! exactly 1 for ρ = 1, whatever r and the direction are. r = 0 is Lambert.
//! # References
//! - Portsmouth, Kutz & Hill 2024, EON: a practical energy-preserving rough diffuse BRDF, arXiv 2410.18026

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::fon::Lobe;
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;

const RHO: Domain = Domain::Colour(0.0, 1.0);
const R: Domain = Domain::Closed(0.0, 1.0);

/// The energy-preserving Oren-Nayar model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eon {
    rho: Rgb,
    /// ρₘ, the reflectance of all bounces after the first.
    rho_m: Rgb,
    lobe: Lobe,
}

impl Eon {
    /// Reflectance `rho` of one bounce in [0, 1] per channel, Fujii's roughness `r` in [0, 1].
    pub fn new(rho: impl Into<Rgb>, r: f64) -> Result<Self, ParamError> {
        let rho = RHO.check_colour("eon", "rho", rho.into())?;
        let lobe = Lobe::new(R.check("eon", "r", r)?);
        let average = lobe.average();
        let rho_m = rho.map(|rho| rho * rho * average / (1.0 - rho * (1.0 - average)));
        Ok(Self { rho, rho_m, lobe })
    }
}

impl Bsdf for Eon {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.rho * self.lobe.eval(wo, wi) + self.rho_m * (FRAC_1_PI * self.lobe.bounces(wo, wi))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { self.lobe.pdf(wi) } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = self.lobe.draw(u);
        BsdfSample::new(wi, self.eval(wo, wi), self.lobe.pdf(wi))
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        let missing = self.lobe.missing(wo);
        Some(if wo.z > 0.0 { self.rho * (1.0 - missing) + self.rho_m * missing } else { Rgb::BLACK })
    }

    fn claims_lossless(&self) -> bool {
        self.rho == Rgb::WHITE
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "eon",
    summary: "rough diffuse that keeps its energy, Oren-Nayar with all bounces",
    params: &[
        ParamSpec::new("rho", RHO, "reflectance of one bounce").or("0.8"),
        ParamSpec::new("r", R, "Fujii's roughness").or("0.5"),
    ],
    examples: &[
        Example::lawful("eon:rho=0.8,r=1"),
        Example::lawful("eon:rho=1,r=0.5"),
        Example::lawful("eon:rho=0.9/0.5/0.1,r=0.3"),
    ],
    build: |args| Ok(Box::new(Eon::new(args.colour("rho")?, args.number("r")?)?)),
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::super::{Fon, Lambert};
    use super::*;
    use crate::math::sphere::direction;
    use approx::assert_abs_diff_eq;

    #[test]
    fn albedo_of_a_grey() {
        let albedo = Eon::new(0.8, 1.0).unwrap().albedo(direction(45_f64.to_radians(), 1.0)).unwrap();
        assert_abs_diff_eq!(albedo.0.x, 0.766089710, epsilon = 1e-9);
    }

    #[test]
    fn white_is_white() {
        for r in [0.0, 1e-12, 0.4, 1.0] {
            let white = Eon::new(1.0, r).unwrap();
            assert!(white.claims_lossless());
            for degrees in [0.0_f64, 30.0, 80.0, 89.9999] {
                let albedo = white.albedo(direction(degrees.to_radians(), 0.0)).unwrap();
                assert_abs_diff_eq!(albedo.0.x, 1.0, epsilon = 1e-15);
            }
            assert_albedo(&white, &[1.0, 0.7, 0.1], 1e-7);
        }
    }

    #[test]
    fn colour_saturates_and_the_albedo_is_that_of_quadrature() {
        let model = Eon::new([0.9, 0.5, 0.1], 1.0).unwrap();
        assert_albedo(&model, &[1.0, 0.7, 0.1], 1e-7);
        // Further bounces add to the bright channel in greater proportion: albedo is not linear in ρ.
        let (with, without) = (model.albedo(DVec3::Z).unwrap(), Fon::new([0.9, 0.5, 0.1], 1.0).unwrap());
        let gain = with / without.albedo(DVec3::Z).unwrap();
        assert!(gain.0.x > gain.0.y && gain.0.y > gain.0.z && gain.0.z > 1.0, "{gain}");
    }

    #[test]
    fn smooth_is_lambert() {
        let (smooth, lambert) = (Eon::new(0.7, 0.0).unwrap(), Lambert::new(0.7).unwrap());
        for (wo, wi) in [(DVec3::Z, DVec3::Z), (direction(1.5, 0.0), direction(1.4, 0.1))] {
            assert_abs_diff_eq!(smooth.eval(wo, wi), lambert.eval(wo, wi), epsilon = 1e-16);
        }
    }

    #[test]
    fn total_and_sampled_exactly() {
        for r in [0.0, 1.0] {
            let model = Eon::new(0.9, r).unwrap();
            assert_total(&model);
            assert_sampled_exactly(&model, &[1.0, 0.3, 0.01]);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(Eon::new(1.1, 0.3).is_err() && Eon::new(0.5, 1.1).is_err() && Eon::new(0.5, f64::NAN).is_err());
    }
}
