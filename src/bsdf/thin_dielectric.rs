//! A thin slab of glass in air, such as a window pane: light passes straight through or is mirrored.
//!
//! With F the reflectance of one face, all orders of internal reflection add up to R = F + (1 − F)² F / (1 − F²) =
//! 2F / (1 + F). Lobes: ρ R in the mirror direction, τ (1 − R) straight on. Nothing is displaced or polarised.
//!
//! `eta` is the index of the slab over that of its surroundings, the same on both sides.
//! # References
//! - Stokes 1862, Proc. Royal Society 11, On the intensity of the light reflected from or transmitted through a pile of
//!   plates

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::dielectric::{REFLECT, TRANSMIT, Tints};
use super::refraction::ETA;
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Density, Lobes, ParamError, Uniforms, fresnel};
use crate::math::color::Rgb;
use crate::math::sphere::mirror;

/// A thin dielectric slab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Index of the slab over that of its surroundings. Not [`Bsdf::eta`], which is 1: both sides are alike.
    eta: f64,
    tints: Tints,
}

impl ThinDielectric {
    /// Index of refraction `eta` in [1e-3, 1e3] of the slab over that of its surroundings.
    pub fn new(eta: f64) -> Result<Self, ParamError> {
        Ok(Self { eta: ETA.check("thin-dielectric", "eta", eta)?, tints: Tints::NONE })
    }

    /// The same with factors on what is reflected and what is transmitted, in [0, 1] per channel.
    pub fn with_tints(self, reflect: impl Into<Rgb>, transmit: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { tints: Tints::new("thin-dielectric", reflect.into(), transmit.into())?, ..self })
    }

    /// The share that all orders of reflection return.
    fn reflected(&self, wo: DVec3) -> f64 {
        let f = fresnel::dielectric(self.eta, wo.z.abs());
        2.0 * f / (1.0 + f)
    }
}

impl Bsdf for ThinDielectric {
    fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        // The tangent plane, and NaN, see neither side.
        Some(wo.z).filter(|z| z.abs() > 0.0)?;
        let reflected = self.reflected(wo);
        Some(if u.lobe < reflected {
            BsdfSample { wi: mirror(wo), weight: self.tints.reflect, density: Density::Dirac(reflected) }
        } else {
            BsdfSample { wi: -wo, weight: self.tints.transmit, density: Density::Dirac(1.0 - reflected) }
        })
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT.union(Lobes::TRANSMIT).union(Lobes::DIRAC)
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        let reflected = self.reflected(wo);
        Some(self.tints.reflect * reflected + self.tints.transmit * (1.0 - reflected))
    }

    fn claims_lossless(&self) -> bool {
        self.tints == Tints::NONE
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "thin-dielectric",
    summary: "window pane: mirrors 2F/(1 + F), lets the rest pass straight",
    params: &[
        ParamSpec::new("eta", ETA, "index of refraction of the slab over its surroundings").or("1.5"),
        REFLECT,
        TRANSMIT,
    ],
    examples: &[
        Example::lawful("thin-dielectric:eta=1.5"),
        Example::lawful("thin-dielectric:eta=1.33,reflect=0.5,transmit=0.9/0.8/0.7"),
    ],
    build: |args| {
        let pane = ThinDielectric::new(args.number("eta")?)?;
        Ok(Box::new(pane.with_tints(args.colour("reflect")?, args.colour("transmit")?)?))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::assert_total;
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn the_series_of_internal_reflections_is_summed() {
        let pane = ThinDielectric::new(1.5).unwrap();
        assert_total(&pane);
        for wo in [DVec3::Z, direction(1.0, 0.3), direction(2.0, 0.3)] {
            let f = fresnel::dielectric(1.5, wo.z.abs());
            // Enters, is reflected 2k + 1 times inside, leaves.
            let series: f64 = f + (0..200).map(|k| (1.0 - f).powi(2) * f.powi(2 * k + 1)).sum::<f64>();
            let reflected = pane.sample(wo, Uniforms::new(0.0, 0.5, 0.5)).unwrap();
            let Density::Dirac(p) = reflected.density else { panic!() };
            assert!((p - series).abs() < 1e-14 && reflected.wi == mirror(wo));
            let passed = pane.sample(wo, Uniforms::new(0.99, 0.5, 0.5)).unwrap();
            assert_eq!((passed.wi, passed.density), (-wo, Density::Dirac(1.0 - p)));
        }
    }
}
