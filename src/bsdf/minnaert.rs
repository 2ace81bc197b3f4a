//! Minnaert's law of limb darkening.
//!
//! f = ρ (k+1)/2π (cosθi cosθo)^(k−1)      [1/sr],  directional albedo ρ cos^(k−1)θo
//!
//! `rho` in [0, 1] is the reflectance at normal incidence: that is what the factor (k+1)/2π is chosen for, and k = 1 is
//! then Lambert. `k` in [1, 100] is the limb darkening. Minnaert also used k < 1 for the full moon; there both f and the
//! albedo grow without bound at grazing, so that no normalisation keeps energy, and such k are refused.
//!
//! Sampled by (k+1)/2π cosᵏθi: the weight is the albedo, so its variance is 0 in a white furnace.
//! # References
//! - Minnaert 1941, Astrophysical Journal 93, The reciprocity principle in lunar photometry

use std::f64::consts::TAU;

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{cosine_power, power_cosine, power_cosine_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);
const K: Domain = Domain::Closed(1.0, 100.0);

/// Minnaert's model, normalised to albedo ρ at normal incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minnaert {
    rho: Rgb,
    k: f64,
}

impl Minnaert {
    /// Reflectance `rho` at normal incidence in [0, 1] per channel, limb darkening `k` in [1, 100].
    pub fn new(rho: impl Into<Rgb>, k: f64) -> Result<Self, ParamError> {
        let rho = RHO.check_colour("minnaert", "rho", rho.into())?;
        Ok(Self { rho, k: K.check("minnaert", "k", k)? })
    }
}

impl Bsdf for Minnaert {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        let darkening = cosine_power(wo, self.k - 1.0) * cosine_power(wi, self.k - 1.0);
        self.rho * ((self.k + 1.0) / TAU * darkening)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { power_cosine_pdf(wi, self.k) } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = power_cosine(u.dir, self.k);
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        Some(self.rho * cosine_power(wo, self.k - 1.0))
    }

    fn claims_lossless(&self) -> bool {
        self.rho == Rgb::WHITE && self.k == 1.0
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "minnaert",
    summary: "limb darkening, f = rho (k+1)/2π (cosθi cosθo)^(k−1)",
    params: &[
        ParamSpec::new("rho", RHO, "reflectance at normal incidence").or("0.8"),
        ParamSpec::new("k", K, "limb darkening, 1 is none").or("1.5"),
    ],
    examples: &[
        Example::lawful("minnaert:rho=0.8,k=1.5"),
        Example::lawful("minnaert:rho=1,k=1"),
        Example::lawful("minnaert:rho=1,k=4"),
    ],
    build: |args| Ok(Box::new(Minnaert::new(args.colour("rho")?, args.number("k")?)?)),
};

#[cfg(test)]
mod tests {
    use super::super::Lambert;
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::math::sphere::direction;
    use approx::assert_abs_diff_eq;

    #[test]
    fn albedo_is_that_of_quadrature_and_rho_at_the_normal() {
        for k in [1.0, 1.5, 7.0, 100.0] {
            let model = Minnaert::new([1.0, 0.5, 0.1], k).unwrap();
            assert_eq!(model.albedo(DVec3::Z).unwrap(), Rgb::new(1.0, 0.5, 0.1));
            assert_albedo(&model, &[1.0, 0.7, 0.1, 1e-3], 1e-8);
        }
    }

    #[test]
    fn without_darkening_it_is_lambert() {
        let (flat, lambert) = (Minnaert::new(0.7, 1.0).unwrap(), Lambert::new(0.7).unwrap());
        let (wo, wi) = (direction(1.5, 0.0), direction(1.4, 0.1));
        assert_abs_diff_eq!(flat.eval(wo, wi), lambert.eval(wo, wi), epsilon = 1e-16);
        assert_abs_diff_eq!(flat.pdf(wo, wi), lambert.pdf(wo, wi), epsilon = 1e-16);
    }

    #[test]
    fn every_weight_is_the_albedo() {
        let model = Minnaert::new(0.9, 3.3).unwrap();
        let wo = direction(1.0, 0.3);
        for (x, y) in [(0.0, 0.1), (0.5, 0.6), (1.0 - f64::EPSILON / 2.0, 0.9)] {
            let weight = model.sample(wo, Uniforms::new(0.0, x, y)).unwrap().weight;
            assert_abs_diff_eq!(weight, model.albedo(wo).unwrap(), epsilon = 1e-13);
        }
    }

    #[test]
    fn total_and_sampled_exactly() {
        for k in [1.0, 2.5, 100.0] {
            let model = Minnaert::new(0.9, k).unwrap();
            assert_total(&model);
            assert_sampled_exactly(&model, &[1.0, 0.3, 0.01]);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(Minnaert::new(1.1, 1.0).is_err() && Minnaert::new(0.5, 0.9).is_err());
        assert!(Minnaert::new(0.5, f64::INFINITY).is_err());
    }
}
