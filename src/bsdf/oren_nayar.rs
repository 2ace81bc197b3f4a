//! Oren-Nayar in its qualitative form: a diffuse surface of Lambertian V-grooves, brighter towards the light.
//!
//! f = ρ/π (A + B max(0, cos Δφ) sin α tan β)      [1/sr],  α = max(θi, θo), β = min(θi, θo)
//! A = 1 − ½ σ²/(σ² + 0.33),  B = 0.45 σ²/(σ² + 0.09)
//!
//! `rho` is the grooves' reflectance in [0, 1], `sigma` the standard deviation of their slope *angle* in radians in
//! [0, π/2]. Evaluated without angles: cos Δφ sin α tan β = s / max(cos θi, cos θo) with s = wo.x wi.x + wo.y wi.y, so that
//! normal incidence needs no azimuth. The albedo is ρ (A + B/π G(θ)),
//!
//! G(θ) = sinθ (θ − sinθ cosθ) + ⅔ tanθ (1 − sin³θ),
//!
//! rising to ρ (A + B/2) at grazing. Interreflections are left out (for those see [`Eon`](super::Eon)), and yet A + B/2 is
//! above 1 for 0 < σ < 0.326: the fit gains up to 1.5 % within a few degrees of grazing, though not yet at 80°. An example
//! with ρ = 1 there breaks `energy_eye` and `energy_light`. σ = 0 is Lambert.
//! # References
//! - Oren & Nayar 1994, SIGGRAPH, Generalization of Lambert's reflectance model (the qualitative model)
//! - Fujii, A tiny improvement of Oren-Nayar reflectance model (the form without angles)

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2};

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::warp::{blended_hemisphere, blended_hemisphere_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);
const SIGMA: Domain = Domain::Closed(0.0, FRAC_PI_2);

/// The qualitative Oren-Nayar model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    rho: Rgb,
    a: f64,
    b: f64,
    /// Share of uniform directions among the cosine-weighted: it bounds the weight where both directions graze.
    blend: f64,
}

impl OrenNayar {
    /// Reflectance `rho` in [0, 1] per channel, slope deviation `sigma` in [0, π/2] radians.
    pub fn new(rho: impl Into<Rgb>, sigma: f64) -> Result<Self, ParamError> {
        let rho = RHO.check_colour("oren-nayar", "rho", rho.into())?;
        let s2 = SIGMA.check("oren-nayar", "sigma", sigma)?.powi(2);
        let (a, b) = (1.0 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09));
        Ok(Self { rho, a, b, blend: 0.5 * b / (a + b) })
    }
}

/// sinθi sinθo cos Δφ.
pub(super) fn azimuthal(wo: DVec3, wi: DVec3) -> f64 {
    wo.x * wi.x + wo.y * wi.y
}

/// G(θ) = sinθ (θ − sinθ cosθ) + ⅔ tanθ (1 − sin³θ) of a direction above the horizon, without 0 · ∞ at grazing.
pub(super) fn groove_integral(w: DVec3) -> f64 {
    let (s, c) = (w.x.hypot(w.y), w.z);
    // 1 − sin³ = (1 − sin)(1 + sin + sin²), and 1 − sin = cos² / (1 + sin).
    s * (s.atan2(c) - s * c) + 2.0 / 3.0 * s * c * (1.0 + s + s * s) / (1.0 + s)
}

impl Bsdf for OrenNayar {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        let towards = azimuthal(wo, wi).max(0.0) / wo.z.max(wi.z).max(1e-290);
        self.rho * (FRAC_1_PI * (self.a + self.b * towards))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { blended_hemisphere_pdf(wi, self.blend) } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = blended_hemisphere(u.dir, self.blend);
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        let lit = wo.z > 0.0;
        Some(if lit { self.rho * (self.a + self.b * FRAC_1_PI * groove_integral(wo)) } else { Rgb::BLACK })
    }

    fn claims_lossless(&self) -> bool {
        self.rho == Rgb::WHITE && self.b == 0.0
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "oren-nayar",
    summary: "rough diffuse, the qualitative model of 1994",
    params: &[
        ParamSpec::new("rho", RHO, "reflectance of the grooves").or("0.8"),
        ParamSpec::new("sigma", SIGMA, "standard deviation of the slope angle in radians").or("0.3"),
    ],
    examples: &[
        Example::lawful("oren-nayar:rho=0.8,sigma=0.3"),
        Example::lawful("oren-nayar:rho=1,sigma=0.6"),
        Example::lawful("oren-nayar:rho=1,sigma=0"),
        // A + B/2 = 1.0152.
        Example::breaking("oren-nayar:rho=1,sigma=0.2", &["energy_eye", "energy_light"]),
    ],
    build: |args| Ok(Box::new(OrenNayar::new(args.colour("rho")?, args.number("sigma")?)?)),
};

#[cfg(test)]
mod tests {
    use super::super::Lambert;
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::math::quadrature::adaptive;
    use crate::math::sphere::{direction, direction_mu};
    use approx::assert_abs_diff_eq;

    #[test]
    fn albedo_table() {
        let table = [(0.3, [0.892857143, 0.938176055, 0.991431191]), (0.6, [0.739130435, 0.811640694, 0.896848911])];
        for (sigma, row) in table {
            let model = OrenNayar::new(1.0, sigma).unwrap();
            for (degrees, expected) in [0.0_f64, 45.0, 80.0].into_iter().zip(row) {
                let albedo = model.albedo(direction(degrees.to_radians(), 1.0)).unwrap();
                assert_abs_diff_eq!(albedo.0.x, expected, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn groove_integral_is_its_integral() {
        for mu in [1.0_f64, 0.5, 0.03, 1e-5] {
            // Over azimuth max(0, cosφ) gives 2; what is left has a kink at the fixed cosine.
            let integrand = |z: f64| [((1.0 - z) * (1.0 + z)).sqrt() * z / mu.max(z)];
            let rest = adaptive(integrand, &[0.0, mu, 0.5 + 0.5 * mu, 1.0], 1e-12, 400).value[0];
            let w = direction_mu(mu, 0.2);
            assert_abs_diff_eq!(groove_integral(w), 2.0 * w.x.hypot(w.y) * rest, epsilon = 1e-11);
        }
        assert_abs_diff_eq!(groove_integral(DVec3::X), FRAC_PI_2, epsilon = 1e-15);
    }

    #[test]
    fn albedo_is_that_of_quadrature() {
        for sigma in [0.1, 0.6, 1.5] {
            let model = OrenNayar::new([1.0, 0.5, 0.1], sigma).unwrap();
            assert_albedo(&model, &[1.0, 0.7, 0.1], 1e-7);
        }
    }

    #[test]
    fn small_slopes_gain_at_grazing() {
        let supremum = |sigma| {
            let model = OrenNayar::new(1.0, sigma).unwrap();
            (1..1000).map(|i| model.albedo(direction_mu(1e-3 * f64::from(i), 0.0)).unwrap().0.x).fold(0.0, f64::max)
        };
        assert!(supremum(0.1) > 1.007 && supremum(0.2) > 1.015 && supremum(0.3) > 1.005);
        // A + B/2 = 1 at σ² = 0.02925 / 0.275.
        assert!(supremum(0.33) < 1.0 && supremum(0.6) < 1.0 && supremum(1.5) < 1.0);
    }

    #[test]
    fn no_slope_is_lambert() {
        let (flat, lambert) = (OrenNayar::new(0.7, 0.0).unwrap(), Lambert::new(0.7).unwrap());
        for (a, b) in [(0.0, 0.0), (0.2, 1.5), (1.4, 1.5)] {
            let (wo, wi) = (direction(a, 0.3), direction(b, 0.1));
            assert_abs_diff_eq!(flat.eval(wo, wi), lambert.eval(wo, wi), epsilon = 1e-16);
            assert_abs_diff_eq!(flat.pdf(wo, wi), lambert.pdf(wo, wi), epsilon = 1e-16);
        }
    }

    #[test]
    fn it_brightens_by_the_difference_of_azimuths_not_their_sum() {
        // cos(φi + φo) for cos(φi − φo) would make the surface anisotropic and dark at φi = φo = π/2.
        let model = OrenNayar::new(1.0, 0.5).unwrap();
        let at = |phi: f64| model.eval(direction(1.0, phi), direction(1.2, phi)).0.x;
        assert_abs_diff_eq!(at(0.0), at(FRAC_PI_2), epsilon = 1e-15);
        assert!(at(0.0) > model.eval(direction(1.0, 0.0), direction(1.2, 3.0)).0.x);
    }

    #[test]
    fn total_sampled_exactly_with_bounded_weight() {
        let model = OrenNayar::new(0.9, 1.0).unwrap();
        assert_total(&model);
        assert_sampled_exactly(&model, &[1.0, 0.3, 0.01]);
        // A/(1 − t) + 2B/t, wherever the direction is.
        let bound = 0.9 * (model.a / (1.0 - model.blend) + 2.0 * model.b / model.blend);
        let grazing = direction(FRAC_PI_2 - 1e-6, 0.0);
        for i in 1..1000 {
            let u = Uniforms::new(0.0, 1.0 - 1e-3 * f64::from(i).powi(-3), 0.001);
            let weight = model.sample(grazing, u).unwrap().weight.max_channel();
            assert!(weight <= bound, "{weight} above {bound}");
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(OrenNayar::new(1.1, 0.3).is_err() && OrenNayar::new(0.5, -0.1).is_err());
        assert!(OrenNayar::new(0.5, f64::NAN).is_err() && OrenNayar::new(0.5, 2.0).is_err());
    }
}
