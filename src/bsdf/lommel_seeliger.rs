//! Lommel-Seeliger: single scattering in a half space of dust, the moon's flat disc.
//!
//! f = ρ / (2π (cosθi + cosθo))      [1/sr],  directional albedo ρ (1 − μ ln(1 + 1/μ)),  μ = cosθo
//!
//! `rho` in [0, 1] scales it so that ρ = 1 is, to the last digit, the single-scattering GGX lobe of α = 1 and F = 1 with
//! height-correlated masking: one pointwise oracle for D, G₂ and the Jacobian. In the astronomers' form
//! w / (4π (cosθi + cosθo)) with isotropic grains of single-scattering albedo w ≤ 1 this is w = 2ρ, so dust has ρ ≤ 1/2.
//! The albedo is ρ at grazing and ρ (1 − ln 2) at the normal; its hemispherical average is ρ 4/3 (1 − ln 2).
//!
//! Sampled uniformly: the weight ρ cosθi / (cosθi + cosθo) never exceeds ρ.
//! # References
//! - Seeliger 1888; Hapke 2012, Theory of Reflectance and Emittance Spectroscopy (the Lommel-Seeliger law)

use std::f64::consts::TAU;

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{uniform_hemisphere, uniform_hemisphere_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);

/// The Lommel-Seeliger law, f = ρ / (2π (cosθi + cosθo)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LommelSeeliger {
    rho: Rgb,
}

impl LommelSeeliger {
    /// `rho` in [0, 1] per channel: the albedo at grazing, half the grains' single-scattering albedo.
    pub fn new(rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { rho: RHO.check_colour("lommel-seeliger", "rho", rho.into())? })
    }
}

impl Bsdf for LommelSeeliger {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        // The bound keeps f finite where both directions are in the surface to within the smallest numbers.
        self.rho / (TAU * (wo.z + wi.z).max(1e-290))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { uniform_hemisphere_pdf(wi) } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = uniform_hemisphere(u.dir);
        BsdfSample::new(wi, self.eval(wo, wi), uniform_hemisphere_pdf(wi))
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        // ln(1 + 1/μ) as a difference: 1/μ overflows for the smallest μ.
        let mu = wo.z;
        Some(if mu > 0.0 { self.rho * (1.0 - mu * (mu.ln_1p() - mu.ln())) } else { Rgb::BLACK })
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "lommel-seeliger",
    summary: "single scattering of dust, f = rho / (2π (cosθi + cosθo))",
    params: &[ParamSpec::new("rho", RHO, "albedo at grazing; w/2 of the grains' albedo w").or("1")],
    examples: &[Example::lawful("lommel-seeliger"), Example::lawful("lommel-seeliger:rho=0.5/0.3/0.1")],
    build: |args| Ok(Box::new(LommelSeeliger::new(args.colour("rho")?)?)),
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::integrate::{Hemisphere, Side};
    use crate::math::sphere::direction_mu;
    use approx::assert_abs_diff_eq;

    #[test]
    fn albedo_table_of_the_alpha_1_oracle() {
        let model = LommelSeeliger::new(1.0).unwrap();
        for (mu, expected) in [(0.1, 0.760210473), (0.5, 0.450693856), (1.0, 0.306852819440)] {
            let albedo = model.albedo(direction_mu(mu, 0.5)).unwrap();
            assert_abs_diff_eq!(albedo.0.x, expected, epsilon = 1e-9);
        }
        let average = Hemisphere::with_tol(1e-8).average(&model, Side::Eye);
        assert_abs_diff_eq!(average.value.0.x, 0.409137092587, epsilon = 1e-8);
    }

    #[test]
    fn albedo_is_that_of_quadrature() {
        let model = LommelSeeliger::new([1.0, 0.5, 0.1]).unwrap();
        assert_albedo(&model, &[1.0, 0.7, 0.1, 1e-3], 1e-7);
        assert_abs_diff_eq!(model.albedo(direction_mu(1e-300, 0.0)).unwrap().0.x, 1.0, epsilon = 1e-15);
    }

    #[test]
    fn total_sampled_exactly_with_bounded_weight() {
        let model = LommelSeeliger::new(0.9).unwrap();
        assert_total(&model);
        assert_sampled_exactly(&model, &[1.0, 0.3, 0.01]);
        let grazing = direction_mu(1e-12, 0.0);
        for x in [0.0, 0.5, 1.0 - f64::EPSILON / 2.0] {
            assert!(model.sample(grazing, Uniforms::new(0.0, x, 0.5)).unwrap().weight.max_channel() <= 0.9 + 1e-15);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(LommelSeeliger::new(1.1).is_err() && LommelSeeliger::new(f64::NAN).is_err());
    }
}
