//! Ashikhmin-Shirley: an anisotropic Phong lobe over a diffuse term that takes what the lobe leaves.
//!
//! f_s = √((nu+1)(nv+1)) / (8π) · cosθ_h^(nu cos²φ_h + nv sin²φ_h) · F(cosθ_d) / (cosθ_d max(cosθ_i, cosθ_o))      [1/sr]
//!
//! f_d = 28 rd / (23π) · (1 − rs) (1 − (1 − cosθ_i/2)⁵) (1 − (1 − cosθ_o/2)⁵)      [1/sr]
//!
//! F(c) = rs + (1 − rs)(1 − c)⁵ (Schlick). `nu`, `nv` ≥ 0 are exponents along x and y; `rd`, `rs` reflectances in [0, 1].
//! The diffuse part alone has the directional albedo rd (1 − rs)(1 − (1 − cosθ_o/2)⁵).
//!
//! Sampled as a mixture of a cosine lobe and of half vectors with density
//! p(h) = √((nu+1)(nv+1)) / (2π) · cosθ_h^(nu cos²φ + nv sin²φ), ∫ p dh = 1 over the hemisphere, so that
//! p(wi) = p(h) / (4 cosθ_d). The lobes are picked in proportion to the diffuse albedo and to the larger of F(cosθ_o) and
//! the mean of F, rs + (1 − rs)/21: at normal incidence rs = 0 still reflects off the mirror direction.
//! # References
//! - Ashikhmin & Shirley 2000, An Anisotropic Phong BRDF Model, J. Graphics Tools 5(2)

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::catalog::{Entry, Example};
use super::half_vector::HalfVector;
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::discrete;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

const NAME: &str = "ashikhmin-shirley";
/// Beyond 1e8 the lobe is narrower than the rounding of directions at grazing views.
const EXPONENT: Domain = Domain::Closed(0.0, 1e8);
const REFLECTANCE: Domain = Domain::Colour(0.0, 1.0);

/// The anisotropic Phong model of Ashikhmin and Shirley with its coupled diffuse term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AshikhminShirley {
    nu: f64,
    nv: f64,
    rd: Rgb,
    rs: Rgb,
}

impl AshikhminShirley {
    /// Exponents `nu`, `nv` in [0, 1e8], diffuse and specular reflectance `rd`, `rs` in [0, 1].
    pub fn new(nu: f64, nv: f64, rd: impl Into<Rgb>, rs: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self {
            nu: EXPONENT.check(NAME, "nu", nu)?,
            nv: EXPONENT.check(NAME, "nv", nv)?,
            rd: REFLECTANCE.check_colour(NAME, "rd", rd.into())?,
            rs: REFLECTANCE.check_colour(NAME, "rs", rs.into())?,
        })
    }

    fn fresnel(&self, cos: f64) -> Rgb {
        self.rs + (Rgb::WHITE - self.rs) * (1.0 - cos).max(0.0).powi(5)
    }

    /// The directional albedo of the diffuse part.
    fn diffuse_albedo(&self, mu: f64) -> Rgb {
        self.rd * (Rgb::WHITE - self.rs) * coupling(mu)
    }

    /// The density p(h) of half vectors [1/sr].
    fn half_vector_pdf(&self, h: HalfVector) -> f64 {
        let (nu1, nv1) = (self.nu + 1.0, self.nv + 1.0);
        let tan2 = h.tan2();
        let exponent = if tan2 > 0.0 {
            let (x, y) = (h.slope.x / tan2.sqrt(), h.slope.y / tan2.sqrt());
            self.nu * (x * x) + self.nv * (y * y)
        } else {
            0.0
        };
        // cosᵉ = exp(−e/2 ln(1 + tan²)): cos itself is 1 to all digits where e is large.
        (nu1 * nv1).sqrt() / TAU * (-0.5 * exponent * tan2.ln_1p()).exp()
    }

    /// The slope of a half vector drawn with density [`Self::half_vector_pdf`].
    ///
    /// The paper maps one quadrant of azimuths and mirrors it into the others; atan2 makes that one continuous map.
    fn sample_slope(&self, u: DVec2) -> DVec2 {
        let (nu1, nv1) = (self.nu + 1.0, self.nv + 1.0);
        let (sin, cos) = (TAU * u.x).sin_cos();
        let azimuth = DVec2::new(nv1.sqrt() * cos, nu1.sqrt() * sin).normalize_or(DVec2::X);
        let exponent = nu1 * azimuth.x * azimuth.x + nv1 * azimuth.y * azimuth.y;
        // cos = (1 − u)^(1/(e+1)), hence tan² = cos⁻² − 1.
        let tan2 = (-2.0 * (-u.y).ln_1p() / exponent).exp_m1();
        azimuth * tan2.sqrt()
    }

    /// How often the diffuse and the specular lobe are drawn, up to a common factor.
    fn lobe_weights(&self, mu: f64) -> [f64; 2] {
        let mean = self.rs + (Rgb::WHITE - self.rs) * (1.0 / 21.0);
        [self.diffuse_albedo(mu).mean(), self.fresnel(mu).mean().max(mean.mean())]
    }
}

/// 1 − (1 − mu/2)⁵, without the cancellation at small mu.
fn coupling(mu: f64) -> f64 {
    -(5.0 * (-0.5 * mu.min(1.0)).ln_1p()).exp_m1()
}

impl Bsdf for AshikhminShirley {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let Some(h) = HalfVector::new(wo, wi) else { return Rgb::BLACK };
        let diffuse = self.rd * (Rgb::WHITE - self.rs) * (28.0 / (23.0 * PI) * coupling(wo.z) * coupling(wi.z));
        let lobe = self.half_vector_pdf(h) / 4.0 / h.cos_d / wo.z.max(wi.z);
        diffuse + self.fresnel(h.cos_d) * lobe.min(f64::MAX)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let Some(h) = HalfVector::new(wo, wi) else { return 0.0 };
        let [diffuse, specular] = self.lobe_weights(wo.z);
        let lobe = (self.half_vector_pdf(h) / (4.0 * h.cos_d)).min(f64::MAX);
        let cosine = cosine_hemisphere_pdf(wi);
        // As a step from one density to the other: no product overflows.
        cosine + (lobe - cosine) * (specular / (diffuse + specular))
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (lobe, _, _) = discrete::pick(&self.lobe_weights(wo.z), u.lobe)?;
        let wi = match lobe {
            0 => cosine_hemisphere(u.dir),
            _ => HalfVector::reflect(wo, self.sample_slope(u.dir)),
        };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: NAME,
    summary: "anisotropic Phong lobe with a coupled diffuse term (Ashikhmin & Shirley 2000)",
    params: &[
        ParamSpec::new("nu", EXPONENT, "exponent along x").or("100"),
        ParamSpec::new("nv", EXPONENT, "exponent along y").or("100"),
        ParamSpec::new("rd", REFLECTANCE, "diffuse reflectance").or("0.5"),
        ParamSpec::new("rs", REFLECTANCE, "specular reflectance at normal incidence").or("0.05"),
    ],
    examples: &[
        Example::lawful("ashikhmin-shirley:nu=100,nv=100,rd=0.5,rs=0.05"),
        Example::lawful("ashikhmin-shirley:nu=10,nv=1000,rd=0.2,rs=0.8"),
    ],
    build: |args| {
        let (nu, nv) = (args.number("nu")?, args.number("nv")?);
        Ok(Box::new(AshikhminShirley::new(nu, nv, args.colour("rd")?, args.colour("rs")?)?))
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::contract;
    use crate::math::sphere::{direction_mu, mirror, rotate_z};
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    fn model(nu: f64, nv: f64, rd: f64, rs: f64) -> AshikhminShirley {
        AshikhminShirley::new(nu, nv, rd, rs).unwrap()
    }

    #[test]
    fn diffuse_part_has_the_albedo_of_the_closed_form() {
        let m = model(10.0, 10.0, 0.8, 0.25);
        let specular = AshikhminShirley { rd: Rgb::BLACK, ..m };
        for mu in [1.0, 0.5, 0.1, 0.01] {
            let wo = direction_mu(mu, 0.4);
            let diffuse = contract::hemisphere(wo, 1e-12, |wi| (m.eval(wo, wi) - specular.eval(wo, wi)).0.x * wi.z);
            // Rd (1 − Rs)(1 − (1 − mu/2)^5)
            let exact = 0.8 * 0.75 * (1.0 - (1.0 - mu / 2.0_f64).powi(5));
            // The tolerance of the quadrature itself.
            assert_abs_diff_eq!(diffuse, exact, epsilon = 1e-12);
        }
        assert_relative_eq!(m.diffuse_albedo(1.0).0.x, 0.8 * 0.75 * 31.0 / 32.0, max_relative = 1e-14);
    }

    #[test]
    fn sampler_draws_from_its_pdf() {
        for (m, mu) in [
            (model(20.0, 5.0, 0.5, 0.3), 0.8),
            (model(0.0, 30.0, 0.0, 0.3), 0.3),
            (model(50.0, 50.0, 0.9, 0.0), 1.0),
            (model(4.0, 60.0, 0.1, 0.9), 0.05),
        ] {
            // The grid's error at the horizon's edge.
            contract::assert_draws_follow_pdf(&m, direction_mu(mu, 0.6), 2e-4);
        }
    }

    #[test]
    fn total_on_edges_for_every_exponent() {
        for (nu, nv) in [(0.0, 0.0), (1e6, 1e6), (1e8, 0.0), (3.0, 1e4)] {
            contract::assert_total(&model(nu, nv, 0.5, 0.0));
            contract::assert_total(&model(nu, nv, 0.0, 0.0));
        }
    }

    #[test]
    fn full_precision_at_an_exponent_of_a_million() {
        // Slope 1e-3 along x, view at the pole: h = (1e-3, 0, 1) / sqrt(1 + 1e-6), so that
        // p(h) = (nu+1)/(2π) exp(−nu/2 ln(1 + 1e-6)) and ln(1 + x) = x − x²/2 + x³/3.
        let m = model(1e6, 1e6, 0.0, 1.0);
        let wi = HalfVector::reflect(DVec3::Z, DVec2::new(1e-3, 0.0));
        let ln: f64 = 1e-6 - 0.5e-12 + 1e-18 / 3.0;
        let p_h = (1e6 + 1.0) / TAU * (-0.5e6 * ln).exp();
        let cos_d = 1.0 / (1.0_f64 + 1e-6).sqrt();
        // The exponent is 0.5 and the slope is good to one rounding of wi.x / 2e-3, about 1e-16.
        assert_relative_eq!(m.pdf(DVec3::Z, wi), p_h / (4.0 * cos_d), max_relative = 1e-13);
        assert_relative_eq!(m.eval(DVec3::Z, wi).0.x, p_h / (4.0 * cos_d), max_relative = 1e-13);
    }

    #[test]
    fn reciprocal_and_not_blind_to_its_axes() {
        let m = model(3.0, 200.0, 0.4, 0.2);
        let (a, b) = (direction_mu(0.3, 0.2), direction_mu(0.7, 2.9));
        assert_relative_eq!(m.eval(a, b).0.x, m.eval(b, a).0.x, max_relative = 1e-14);
        // The long axis of the highlight is x: turning the pair about the normal must change the value.
        let quarter = std::f64::consts::FRAC_PI_2;
        let off = rotate_z(mirror(a), 0.2);
        assert!(m.eval(a, off) != m.eval(rotate_z(a, quarter), rotate_z(off, quarter)));
        let turned = model(200.0, 3.0, 0.4, 0.2);
        assert_relative_eq!(
            m.eval(a, off).0.x,
            turned.eval(rotate_z(a, quarter), rotate_z(off, quarter)).0.x,
            max_relative = 1e-12
        );
    }

    #[test]
    fn constructor_rejects_negative_exponents() {
        assert!(AshikhminShirley::new(-1.0, 1.0, 0.5, 0.5).is_err());
        assert!(AshikhminShirley::new(1.0, 1.0, 0.5, 1.5).is_err());
    }
}
