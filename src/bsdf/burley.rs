//! Burley's diffuse lobe (Disney 2012): darker rims when smooth, brighter when rough.
//!
//! f = ρ/π (1 + (F₉₀ − 1)(1 − cosθi)⁵) (1 + (F₉₀ − 1)(1 − cosθo)⁵)      [1/sr]
//! F₉₀ = 1/2 + 2 roughness cos²θd,  2 cos²θd = 1 + wi·wo
//!
//! `rho` in [0, 1] is the base colour, `roughness` in [0, 1] Burley's own. The model is reciprocal, but an empirical fit
//! that does not keep energy: f is a polynomial in the cosines, and so is its albedo, in closed form below. At the normal
//! it is ρ (41/42 + 5 roughness/84), above 1 for ρ = 1 and roughness > 0.4; at grazing it gains up to 56 %. Examples with
//! such parameters break `energy_eye` and `energy_light`.
//! # References
//! - Burley 2012, Physically-based shading at Disney, SIGGRAPH course notes (the diffuse model)

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);
const ROUGHNESS: Domain = Domain::Closed(0.0, 1.0);

/// Burley's diffuse model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burley {
    rho: Rgb,
    roughness: f64,
}

impl Burley {
    /// Base colour `rho` in [0, 1] per channel, Burley's `roughness` in [0, 1].
    pub fn new(rho: impl Into<Rgb>, roughness: f64) -> Result<Self, ParamError> {
        let rho = RHO.check_colour("burley", "rho", rho.into())?;
        Ok(Self { rho, roughness: ROUGHNESS.check("burley", "roughness", roughness)? })
    }
}

/// 2 ∫ c^(k+1) (1 − c)⁵ dc over [0, 1] for k = 0, 1, 2.
const MOMENTS: [f64; 3] = [1.0 / 21.0, 1.0 / 84.0, 1.0 / 252.0];

/// (1 − μ)⁵, also for a μ that rounding has put above 1.
fn schlick_weight(mu: f64) -> f64 {
    (1.0 - mu).max(0.0).powi(5)
}

impl Bsdf for Burley {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        let excess = self.roughness * (1.0 + wo.dot(wi)).max(0.0) - 0.5;
        let rim = |w: DVec3| 1.0 + excess * schlick_weight(w.z);
        self.rho * (FRAC_1_PI * rim(wi) * rim(wo))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { cosine_hemisphere_pdf(wi) } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = cosine_hemisphere(u.dir);
        BsdfSample::new(wi, self.eval(wo, wi), cosine_hemisphere_pdf(wi))
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        if wo.z <= 0.0 {
            return Some(Rgb::BLACK);
        }
        // F₉₀ − 1 = q + r (μ c + sinθo sinθi cosφ): the average over φ keeps its square's mean r² sin²θo sin²θi / 2. What
        // is left are moments of the free cosine.
        let [m0, m1, m2] = MOMENTS;
        let (r, q, mu) = (self.roughness, self.roughness - 0.5, wo.z);
        let sin2 = wo.x * wo.x + wo.y * wo.y;
        let free = q * m0 + r * mu * m1;
        let fixed = q + r * mu * (2.0 / 3.0);
        let both = q * q * m0 + 2.0 * q * r * mu * m1 + r * r * mu * mu * m2 + 0.5 * r * r * sin2 * (m0 - m2);
        Some(self.rho * (1.0 + free + schlick_weight(mu) * (fixed + both)))
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "burley",
    summary: "diffuse lobe of the Disney model of 2012; gains energy when rough",
    params: &[
        ParamSpec::new("rho", RHO, "base colour").or("0.8"),
        ParamSpec::new("roughness", ROUGHNESS, "Burley's roughness").or("0.5"),
    ],
    examples: &[
        Example::lawful("burley:rho=0.8,roughness=0.5"),
        Example::lawful("burley:rho=1,roughness=0"),
        Example::lawful("burley:rho=0.6/0.3/0.1,roughness=1"),
        Example::breaking("burley:rho=1,roughness=0.5", &["energy_eye", "energy_light"]),
        Example::breaking("burley:rho=1,roughness=1", &["energy_eye", "energy_light"]),
    ],
    build: |args| Ok(Box::new(Burley::new(args.colour("rho")?, args.number("roughness")?)?)),
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::math::quadrature::adaptive;
    use crate::math::sphere::direction_mu;
    use approx::assert_abs_diff_eq;

    fn albedo(roughness: f64, mu: f64) -> f64 {
        Burley::new(1.0, roughness).unwrap().albedo(direction_mu(mu, 0.2)).unwrap().0.x
    }

    #[test]
    fn albedo_table() {
        let mus = [0.001, 0.01, 0.1, 0.25, 0.5, 1.0];
        let rough = [1.555563, 1.537952, 1.380126, 1.193435, 1.056904, 1.035714];
        let smooth = [0.490531, 0.512017, 0.687975, 0.860363, 0.960938, 0.976190];
        for (i, mu) in mus.into_iter().enumerate() {
            assert_abs_diff_eq!(albedo(1.0, mu), rough[i], epsilon = 5e-7);
            assert_abs_diff_eq!(albedo(0.0, mu), smooth[i], epsilon = 5e-7);
        }
        for r in [0.0, 0.4, 0.7] {
            assert_abs_diff_eq!(albedo(r, 1.0), 41.0 / 42.0 + 5.0 * r / 84.0, epsilon = 1e-15);
        }
        for (r, expected) in [(1.0, 1.065169), (0.0, 0.952948)] {
            let average = adaptive(|mu: f64| [2.0 * mu * albedo(r, mu)], &[0.0, 1.0], 1e-10, 100).value[0];
            assert_abs_diff_eq!(average, expected, epsilon = 5e-7);
        }
    }

    #[test]
    fn albedo_is_that_of_quadrature() {
        for r in [0.0, 0.37, 1.0] {
            assert_albedo(&Burley::new([1.0, 0.5, 0.1], r).unwrap(), &[1.0, 0.7, 0.1, 1e-3], 1e-8);
        }
    }

    #[test]
    fn gains_when_rough_and_not_when_smooth() {
        let supremum = |r: f64| (1..=1000).map(|i| albedo(r, f64::from(i) * 1e-3)).fold(0.0, f64::max);
        assert!(supremum(0.0) < 1.0 && supremum(0.3) < 1.0);
        assert!(supremum(0.5) > 1.005 && supremum(1.0) > 1.55);
    }

    #[test]
    fn total_and_sampled_exactly() {
        for r in [0.0, 1.0] {
            let model = Burley::new(0.9, r).unwrap();
            assert_total(&model);
            assert_sampled_exactly(&model, &[1.0, 0.3, 0.01]);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(Burley::new(1.1, 0.3).is_err() && Burley::new(0.5, 1.1).is_err() && Burley::new(0.5, -0.1).is_err());
    }
}
