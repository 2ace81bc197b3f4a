//! Lambert: light leaves in all directions alike.
//!
//! f = ρ / π      [1/sr],  directional albedo ρ
//!
//! `rho` is the reflectance in [0, 1], per channel. Sampled by the cosine; the weight is ρ, so its variance is 0
//! in a white furnace.
//! # References
//! - Lambert 1760, Photometria

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Density, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);

/// The Lambertian reflector, f = ρ / π. The default is black.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lambert {
    rho: Rgb,
}

impl Lambert {
    /// Reflectance `rho` in [0, 1] per channel.
    pub fn new(rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { rho: RHO.check_colour("lambert", "rho", rho.into())? })
    }

    /// The reflectance.
    pub fn rho(&self) -> Rgb {
        self.rho
    }
}

impl Bsdf for Lambert {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z > 0.0 && wi.z > 0.0 { self.rho * FRAC_1_PI } else { Rgb::BLACK }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { cosine_hemisphere_pdf(wi) } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let wi = cosine_hemisphere(u.dir);
        (wo.z > 0.0 && wi.z > 0.0).then(|| BsdfSample {
            wi,
            weight: self.rho,
            density: Density::SolidAngle(cosine_hemisphere_pdf(wi)),
        })
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        Some(if wo.z > 0.0 { self.rho } else { Rgb::BLACK })
    }

    fn claims_lossless(&self) -> bool {
        self.rho == Rgb::WHITE
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "lambert",
    summary: "perfectly diffuse, f = rho/π",
    params: &[ParamSpec::new("rho", RHO, "reflectance").or("0.8")],
    examples: &[Example::lawful("lambert:rho=0.8"), Example::lawful("lambert:rho=1")],
    build: |args| Ok(Box::new(Lambert::new(args.colour("rho")?)?)),
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn constructor_rejects_what_no_surface_reflects() {
        assert!(Lambert::new(1.01).is_err() && Lambert::new(-0.1).is_err() && Lambert::new(f64::NAN).is_err());
    }

    #[test]
    fn one_sided() {
        let lambert = Lambert::new(0.5).unwrap();
        let (up, down) = (direction(0.3, 0.0), direction(2.5, 0.0));
        assert!(lambert.eval(up, down).is_black() && lambert.eval(down, up).is_black());
        assert!(lambert.sample(down, Uniforms::new(0.5, 0.5, 0.5)).is_none());
    }
}
