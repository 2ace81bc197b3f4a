//! A perfectly smooth reflector: one Dirac lobe in the mirror direction.
//!
//! f(wo, wi) |wi.z| = ρ F(wo.z) δ(wi − mirror(wo)),  directional albedo ρ F(wo.z)
//!
//! `rho` is a colour in [0, 1]; F is 1 for the mirror and Fresnel's formula for a conductor of index η + i k. One-sided.
//! # References
//! - Born & Wolf, Principles of Optics, 14.2 (reflection at a metal)

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::fresnel::{self, Fresnel};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Density, Domain, Lobes, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::mirror;

const RHO: Domain = Domain::Colour(0.0, 1.0);

/// A smooth surface that reflects ρ F(wo.z) of the light in the mirror direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularReflector {
    rho: Rgb,
    fresnel: Fresnel,
}

impl SpecularReflector {
    /// A mirror of reflectance `rho` in [0, 1] per channel at every angle.
    pub fn mirror(rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { rho: RHO.check_colour("mirror", "rho", rho.into())?, fresnel: Fresnel::MIRROR })
    }

    /// A polished metal of index `eta` in [1e-3, 1e3] and extinction coefficient `k` in [0, 1e3], relative to the
    /// exterior.
    pub fn conductor(eta: impl Into<Rgb>, k: impl Into<Rgb>) -> Result<Self, ParamError> {
        Self::new(Fresnel::Conductor { eta: eta.into(), k: k.into() })
    }

    /// Any reflectance of the cosine, such as that of a [named metal](super::ior::metal).
    pub fn new(fresnel: Fresnel) -> Result<Self, ParamError> {
        Ok(Self { rho: Rgb::WHITE, fresnel: fresnel.validated("conductor")? })
    }

    /// The same with its reflectance multiplied by `rho` in [0, 1] per channel.
    pub fn with_tint(self, rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        let model = if self.fresnel.is_mirror() { "mirror" } else { "conductor" };
        Ok(Self { rho: RHO.check_colour(model, "rho", rho.into())?, ..self })
    }

    fn reflectance(&self, wo: DVec3) -> Rgb {
        self.rho * self.fresnel.eval(wo.z)
    }
}

impl Bsdf for SpecularReflector {
    fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, _: Uniforms) -> Option<BsdfSample> {
        (wo.z > 0.0).then(|| BsdfSample { wi: mirror(wo), weight: self.reflectance(wo), density: Density::Dirac(1.0) })
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT.union(Lobes::DIRAC)
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        Some(if wo.z > 0.0 { self.reflectance(wo) } else { Rgb::BLACK })
    }

    fn claims_lossless(&self) -> bool {
        self.rho == Rgb::WHITE && self.fresnel.is_mirror()
    }
}

pub(super) const MIRROR: Entry = Entry {
    name: "mirror",
    summary: "perfect mirror, a Dirac lobe of albedo rho",
    params: &[ParamSpec::new("rho", RHO, "reflectance").or("1")],
    examples: &[Example::lawful("mirror"), Example::lawful("mirror:rho=0.9/0.6/0.2")],
    build: |args| Ok(Box::new(SpecularReflector::mirror(args.colour("rho")?)?)),
};

pub(super) const CONDUCTOR: Entry = Entry {
    name: "conductor",
    summary: "polished metal, a Dirac lobe of albedo rho·F(wo.z)",
    params: &[
        ParamSpec::new("eta", fresnel::ETA, "index of refraction").or("0.2"),
        ParamSpec::new("k", fresnel::K, "extinction coefficient").or("3"),
        ParamSpec::new("rho", RHO, "factor on the reflectance").or("1"),
    ],
    examples: &[Example::lawful("conductor:eta=0.1431/0.3749/1.4424,k=3.9831/2.3857/1.6032")],
    build: |args| {
        let metal = SpecularReflector::conductor(args.colour("eta")?, args.colour("k")?)?;
        Ok(Box::new(metal.with_tint(args.colour("rho")?)?))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::assert_total;
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn all_light_leaves_in_the_mirror_direction() {
        let mirror = SpecularReflector::mirror(Rgb::new(0.9, 0.5, 0.1)).unwrap();
        assert_total(&mirror);
        let wo = direction(0.7, 0.3);
        let draw = mirror.sample(wo, Uniforms::new(0.5, 0.5, 0.5)).unwrap();
        assert_eq!(draw.wi, DVec3::new(-wo.x, -wo.y, wo.z));
        assert_eq!((draw.weight, draw.density), (Rgb::new(0.9, 0.5, 0.1), Density::Dirac(1.0)));
        assert!(mirror.sample(-wo, Uniforms::new(0.5, 0.5, 0.5)).is_none());
    }

    #[test]
    fn a_metal_reflects_what_fresnel_says() {
        let metal = SpecularReflector::conductor(0.9582, 6.6902).unwrap().with_tint(0.5).unwrap();
        assert_total(&metal);
        // ((η − 1)² + k²) / ((η + 1)² + k²) at normal incidence; nine digits are given.
        let albedo = metal.albedo(DVec3::Z).unwrap();
        assert!((albedo - Rgb::grey(0.5 * 0.921124967)).0.abs().max_element() <= 5e-10);
    }

    #[test]
    fn what_no_surface_does_is_refused() {
        assert!(SpecularReflector::mirror(1.1).is_err() && SpecularReflector::conductor(0.0, 1.0).is_err());
        let error = SpecularReflector::conductor(1.0, -1.0).unwrap_err();
        assert!(error.to_string().starts_with("conductor: k = -1"), "{error}");
    }
}
