//! Fujii's Oren-Nayar: rough diffuse reflection without the dark rings of the qualitative model.
//!
//! f = ρ/π A (1 + r s/t)      [1/sr],  s = wi·wo − cosθi cosθo,  t = max(cosθi, cosθo) for s > 0, else 1
//! A = 1/(1 + c₁ r),  c₁ = 1/2 − 2/(3π)
//!
//! `rho` in [0, 1] is the reflectance, `r` in [0, 1] Fujii's roughness, a number of its own and no angle; r = 0 is Lambert.
//! With G(θ) = sinθ (θ − sinθ cosθ) + ⅔ tanθ (1 − sin³θ) the albedo is ρ E,
//!
//! E(θ) = A + (r A/π)(G(θ) − ⅔ sinθ),  hemispherical average ⟨E⟩ = A (1 + c₂ r),  c₂ = 2/3 − 28/(15π),
//!
//! at most 1 and 1 only at grazing: the energy of further bounces is missing, [`Eon`](super::Eon) gives it back.
//! # References
//! - Fujii, A tiny improvement of Oren-Nayar reflectance model
//! - Portsmouth, Kutz & Hill 2024, arXiv 2410.18026 (the albedo and its average)

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::oren_nayar::{azimuthal, groove_integral};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{blended_hemisphere, blended_hemisphere_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);
const R: Domain = Domain::Closed(0.0, 1.0);

/// c₁ of A = 1/(1 + c₁ r).
pub(super) const C1: f64 = 0.5 - 2.0 / (3.0 * PI);
/// c₂ of <E> = A (1 + c₂ r).
pub(super) const C2: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// The lobe of unit reflectance, shared by [`Fon`] and [`Eon`](super::Eon).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lobe {
    r: f64,
    a: f64,
    /// Share of uniform directions among the cosine-weighted: it bounds the weight where both directions graze.
    blend: f64,
}

impl Lobe {
    pub(super) fn new(r: f64) -> Self {
        Self { r, a: 1.0 / (1.0 + C1 * r), blend: 0.5 * r / (1.0 + r) }
    }

    /// f [1/sr] for two directions above the horizon.
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        let s = azimuthal(wo, wi);
        let t = if s > 0.0 { wo.z.max(wi.z).max(1e-290) } else { 1.0 };
        // s ≥ −1 but for its rounding.
        FRAC_1_PI * self.a * (1.0 + self.r * s / t).max(0.0)
    }

    /// 1 − E(θ) = A r (c₁ − (G − ⅔ sinθ)/π), without the cancellation at small r; 0 at grazing.
    pub(super) fn missing(&self, w: DVec3) -> f64 {
        let g = FRAC_1_PI * (groove_integral(w) - 2.0 / 3.0 * w.x.hypot(w.y));
        (self.a * self.r * (C1 - g)).max(0.0)
    }

    /// <E>.
    pub(super) fn average(&self) -> f64 {
        self.a * (1.0 + C2 * self.r)
    }

    /// (1 − E(θi)) (1 − E(θo)) / (1 − <E>), 0 at r = 0.
    pub(super) fn bounces(&self, wo: DVec3, wi: DVec3) -> f64 {
        let average_missing = self.a * self.r * (C1 - C2);
        if average_missing > 0.0 { self.missing(wo) * (self.missing(wi) / average_missing) } else { 0.0 }
    }

    pub(super) fn pdf(&self, wi: DVec3) -> f64 {
        blended_hemisphere_pdf(wi, self.blend)
    }

    pub(super) fn draw(&self, u: Uniforms) -> DVec3 {
        blended_hemisphere(u.dir, self.blend)
    }
}

/// Fujii's Oren-Nayar model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fon {
    rho: Rgb,
    lobe: Lobe,
}

impl Fon {
    /// Reflectance `rho` in [0, 1] per channel, Fujii's roughness `r` in [0, 1].
    pub fn new(rho: impl Into<Rgb>, r: f64) -> Result<Self, ParamError> {
        let rho = RHO.check_colour("fon", "rho", rho.into())?;
        Ok(Self { rho, lobe: Lobe::new(R.check("fon", "r", r)?) })
    }
}

impl Bsdf for Fon {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z > 0.0 && wi.z > 0.0 { self.rho * self.lobe.eval(wo, wi) } else { Rgb::BLACK }
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
        Some(if wo.z > 0.0 { self.rho * (1.0 - self.lobe.missing(wo)) } else { Rgb::BLACK })
    }

    fn claims_lossless(&self) -> bool {
        self.rho == Rgb::WHITE && self.lobe.r == 0.0
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "fon",
    summary: "rough diffuse, Fujii's Oren-Nayar without further bounces",
    params: &[
        ParamSpec::new("rho", RHO, "reflectance").or("0.8"),
        ParamSpec::new("r", R, "Fujii's roughness").or("0.5"),
    ],
    examples: &[Example::lawful("fon:rho=0.8,r=0.5"), Example::lawful("fon:rho=1,r=1")],
    build: |args| Ok(Box::new(Fon::new(args.colour("rho")?, args.number("r")?)?)),
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::math::quadrature::adaptive;
    use crate::math::sphere::{direction, direction_mu};
    use approx::assert_abs_diff_eq;

    #[test]
    fn albedo_table() {
        let rough = Fon::new(1.0, 1.0).unwrap();
        for (degrees, expected) in [(0.0_f64, 0.776522067), (45.0, 0.816407865), (80.0, 0.954442051)] {
            let albedo = rough.albedo(direction(degrees.to_radians(), 1.0)).unwrap();
            assert_abs_diff_eq!(albedo.0.x, expected, epsilon = 1e-9);
        }
    }

    #[test]
    fn average_albedo() {
        assert_abs_diff_eq!(Lobe::new(1.0).average(), 0.832810764, epsilon = 1e-9);
        for r in [0.0, 0.01, 0.5, 1.0] {
            let lobe = Lobe::new(r);
            let integrand = |mu: f64| [2.0 * mu * (1.0 - lobe.missing(direction_mu(mu, 0.0)))];
            let average = adaptive(integrand, &[0.0, 0.1, 1.0], 1e-11, 200).value[0];
            assert_abs_diff_eq!(average, lobe.average(), epsilon = 1e-10);
        }
    }

    #[test]
    fn albedo_is_that_of_quadrature() {
        for r in [0.0, 1e-9, 0.3, 1.0] {
            assert_albedo(&Fon::new([1.0, 0.5, 0.1], r).unwrap(), &[1.0, 0.7, 0.1], 1e-7);
        }
    }

    #[test]
    fn total_and_sampled_exactly() {
        for r in [0.0, 1.0] {
            let model = Fon::new(0.9, r).unwrap();
            assert_total(&model);
            assert_sampled_exactly(&model, &[1.0, 0.3, 0.01]);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(Fon::new(1.1, 0.3).is_err() && Fon::new(0.5, 1.1).is_err() && Fon::new(0.5, f64::NAN).is_err());
    }
}
