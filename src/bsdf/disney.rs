//! Disney's principled model of 2012: one diffuse base, a metallic or dielectric lobe, sheen and a clearcoat.
//!
//! f = (1 − metallic) (c/π lerp(f_d, f_ss, subsurface) + f_sheen) + D_s F_s G_s + clearcoat/4 D_c F_c G_c      [1/sr]
//!
//! with w = (1 − cosθ_d)⁵, W(θ) = (1 − cosθ)⁵, lum = 0.3 r + 0.6 g + 0.1 b, c = `base_color`, tint = c / lum(c), r = `roughness`:
//! - f_d = Π lerp(1, ½ + 2 r cos²θ_d, W(θ)) over θ_i and θ_o
//! - f_ss = 1.25 (Π lerp(1, r cos²θ_d, W(θ)) (1/(cosθ_i + cosθ_o) − ½) + ½), after Hanrahan and Krueger
//! - f_sheen = w `sheen` lerp(1, tint, `sheen_tint`)
//! - D_s: anisotropic GGX of slope widths r²/a and r² a, a = √(1 − 0.9 `anisotropic`), neither below 0.001
//! - F_s = lerp(f₀, 1, w), f₀ = lerp(0.08 `specular` lerp(1, tint, `specular_tint`), c, `metallic`)
//! - D_c = (α² − 1) / (π ln α² (1 + (α² − 1) cos²θ_h)), α = lerp(0.1, 0.001, `clearcoat_gloss`); F_c = lerp(0.04, 1, w)
//! - G = g(θ_i) g(θ_o), g(θ) = 1 / (cosθ + √(α_g² + (1 − α_g²) cos²θ)), Smith's masking over 2 cosθ, with the widened
//!   α_g = (½ + r/2)² for G_s and α_g = ¼ for G_c
//!
//! `roughness` is Burley's, in [0, 1]; the slope width is its square. `base_color` is linear, so that the published default
//! (0.82, 0.67, 0.16), given for a display, is its 2.2nd power here. Nothing in the model keeps its energy: the diffuse
//! term alone reflects more than it receives at grazing views for a rough white base.
//!
//! Sampled as a mixture of a cosine lobe (base and sheen), visible normals of D_s, and half vectors by D_c cosθ_h. Their
//! probabilities depend on wo alone, through the Fresnel factors at θ_o; that of D_s never falls below the mean of its F.
//! # References
//! - Burley 2012, Physically-Based Shading at Disney, SIGGRAPH course notes
//! - Dupuy & Benyoub 2023, Sampling Visible GGX Normals with Spherical Caps, CGF 42(8)

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DVec2, DVec3};

use super::catalog::{Entry, Example};
use super::half_vector::HalfVector;
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::discrete;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

const UNIT: Domain = Domain::Closed(0.0, 1.0);
const COLOUR: Domain = Domain::Colour(0.0, 1.0);
/// The published floor of the slope widths.
const MIN_ALPHA: f64 = 0.001;
/// The slope width of the clearcoat's masking.
const CLEARCOAT_ALPHA_G: f64 = 0.25;

/// The parameters of the principled model, each in [0, 1]. The default is the published one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisneyParams {
    /// Colour of the base, linear.
    pub base_color: Rgb,
    /// From Burley's diffuse term to that of Hanrahan and Krueger.
    pub subsurface: f64,
    /// From dielectric to metal.
    pub metallic: f64,
    /// Specular reflectance of the dielectric at normal incidence, in units of 0.08.
    pub specular: f64,
    /// From a white to a tinted dielectric reflection.
    pub specular_tint: f64,
    /// Burley's roughness: the square root of the slope width.
    pub roughness: f64,
    /// From round to elongated highlights, the longer along x.
    pub anisotropic: f64,
    /// Amount of grazing retro-reflection of cloth.
    pub sheen: f64,
    /// From a white to a tinted sheen.
    pub sheen_tint: f64,
    /// Amount of the second, dielectric lobe.
    pub clearcoat: f64,
    /// From a satin to a glossy clearcoat.
    pub clearcoat_gloss: f64,
}

impl Default for DisneyParams {
    fn default() -> Self {
        Self {
            base_color: Rgb::new(0.82, 0.67, 0.16).map(|x| x.powf(2.2)),
            subsurface: 0.0,
            metallic: 0.0,
            specular: 0.5,
            specular_tint: 0.0,
            roughness: 0.5,
            anisotropic: 0.0,
            sheen: 0.0,
            sheen_tint: 0.5,
            clearcoat: 0.0,
            clearcoat_gloss: 1.0,
        }
    }
}

/// The principled model of Burley 2012.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disney {
    params: DisneyParams,
    alpha: DVec2,
    alpha_g: f64,
    clearcoat_alpha: f64,
    f0: Rgb,
    sheen: Rgb,
}

impl Disney {
    /// Every parameter in [0, 1].
    pub fn new(params: DisneyParams) -> Result<Self, ParamError> {
        let p = params;
        COLOUR.check_colour("disney", "base_color", p.base_color)?;
        for (name, value) in [
            ("subsurface", p.subsurface),
            ("metallic", p.metallic),
            ("specular", p.specular),
            ("specular_tint", p.specular_tint),
            ("roughness", p.roughness),
            ("anisotropic", p.anisotropic),
            ("sheen", p.sheen),
            ("sheen_tint", p.sheen_tint),
            ("clearcoat", p.clearcoat),
            ("clearcoat_gloss", p.clearcoat_gloss),
        ] {
            UNIT.check("disney", name, value)?;
        }
        let luminance = p.base_color.0.dot(DVec3::new(0.3, 0.6, 0.1));
        let tint = if luminance > 0.0 { p.base_color / luminance } else { Rgb::WHITE };
        let (aspect, alpha) = ((1.0 - 0.9 * p.anisotropic).sqrt(), p.roughness * p.roughness);
        Ok(Self {
            params,
            alpha: DVec2::new(alpha / aspect, alpha * aspect).max(DVec2::splat(MIN_ALPHA)),
            alpha_g: (0.5 + 0.5 * p.roughness).powi(2),
            clearcoat_alpha: lerp(0.1, 0.001, p.clearcoat_gloss),
            f0: mix(mix(Rgb::WHITE, tint, p.specular_tint) * (0.08 * p.specular), p.base_color, p.metallic),
            sheen: mix(Rgb::WHITE, tint, p.sheen_tint) * p.sheen,
        })
    }

    /// The base without the sheen, for a white base: lerp(f_d, f_ss, subsurface) / π.
    fn diffuse(&self, h: HalfVector, cos_o: f64, cos_i: f64) -> f64 {
        let DisneyParams { roughness, subsurface, .. } = self.params;
        let retro = roughness * h.cos_d * h.cos_d;
        let (w_o, w_i) = (schlick(cos_o), schlick(cos_i));
        let both = |grazing: f64| lerp(1.0, grazing, w_o) * lerp(1.0, grazing, w_i);
        let flat = 1.25 * (both(retro) * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
        lerp(both(0.5 + 2.0 * retro), flat, subsurface) * FRAC_1_PI
    }

    /// D_s [1/sr].
    fn specular_d(&self, h: HalfVector) -> f64 {
        let peak = 1.0 / (PI * self.alpha.x * self.alpha.y);
        // 1 + Σ (slope/α)² is at least 1/cos² / max(α, 1)², so that squares are taken of moderate numbers only.
        let shape = h.cos_h * h.cos_h * (1.0 + (h.slope / self.alpha).length_squared());
        peak / (shape * shape)
    }

    /// D_c [1/sr]; α < 1 always.
    fn clearcoat_d(&self, h: HalfVector) -> f64 {
        let a2 = self.clearcoat_alpha * self.clearcoat_alpha;
        // 1 + (α² − 1) cos² = cos² (tan² + α²), without the cancellation.
        (a2 - 1.0) / (PI * a2.ln() * h.cos_h * h.cos_h * (h.tan2() + a2))
    }

    /// The density of directions reflected off the visible normals of D_s.
    fn specular_pdf(&self, wo: DVec3, h: HalfVector) -> f64 {
        // G1 / cosθ_o = 2 / (cosθ_o + √(cos²θ_o + α_x² x² + α_y² y²))
        self.specular_d(h) / (2.0 * (wo.z + (self.alpha.extend(1.0) * wo).length()))
    }

    /// How often base, D_s and D_c are drawn, up to a common factor: rough guesses of their albedos at `mu`.
    fn lobe_weights(&self, mu: f64) -> [f64; 3] {
        let DisneyParams { metallic, clearcoat, base_color, .. } = self.params;
        let fresnel = |f0: f64| lerp(f0, 1.0, schlick(mu).max(1.0 / 21.0));
        let base = (1.0 - metallic) * (base_color.mean() + 0.25 * self.sheen.mean());
        [base, fresnel(self.f0.mean()), 0.25 * clearcoat * fresnel(0.04)]
    }

    /// The slope of a normal of D_s visible from `wo`.
    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec2 {
        let w = (self.alpha.extend(1.0) * wo).normalize_or(DVec3::Z);
        // A uniform cap around −w.z: z = (1 − u)(1 + w.z) − w.z, in terms that stay exact next to the pole.
        let up = 1.0 + w.z;
        let (below, above) = (u.x * up, (1.0 - u.x) * up + (w.x * w.x + w.y * w.y) / up);
        let (sin, cos) = (TAU * u.y).sin_cos();
        let radius = (below * above).max(0.0).sqrt();
        let m = DVec2::new(radius * cos + w.x, radius * sin + w.y);
        self.alpha * m / ((1.0 - u.x) * up)
    }

    /// The slope of a half vector with density D_c cosθ_h.
    fn sample_clearcoat(&self, u: DVec2) -> DVec2 {
        let a2 = self.clearcoat_alpha * self.clearcoat_alpha;
        // cos² = (1 − α^(2(1−u))) / (1 − α²) and sin² = α² (α^(−2u) − 1) / (1 − α²).
        let tan2 = a2 * (-u.x * a2.ln()).exp_m1() / -((1.0 - u.x) * a2.ln()).exp_m1();
        let (sin, cos) = (TAU * u.y).sin_cos();
        tan2.max(0.0).sqrt() * DVec2::new(cos, sin)
    }
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    a + (b - a) * t
}

/// (1 − cosθ)⁵.
fn schlick(cos: f64) -> f64 {
    (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

/// Smith's G1 of GGX over 2 cosθ.
fn masking(cos: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    1.0 / (cos + (a2 + (1.0 - a2) * cos * cos).sqrt())
}

impl Bsdf for Disney {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let Some(h) = HalfVector::new(wo, wi) else { return Rgb::BLACK };
        let DisneyParams { base_color, metallic, clearcoat, .. } = self.params;
        let w = schlick(h.cos_d);
        let base = (base_color * self.diffuse(h, wo.z, wi.z) + self.sheen * w) * (1.0 - metallic);
        let g = masking(wo.z, self.alpha_g) * masking(wi.z, self.alpha_g);
        let coat_g = masking(wo.z, CLEARCOAT_ALPHA_G) * masking(wi.z, CLEARCOAT_ALPHA_G);
        let coat = 0.25 * clearcoat * lerp(0.04, 1.0, w) * coat_g * self.clearcoat_d(h);
        base + mix(self.f0, Rgb::WHITE, w) * (g * self.specular_d(h)) + Rgb::grey(coat)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let Some(h) = HalfVector::new(wo, wi) else { return 0.0 };
        let [base, specular, coat] = self.lobe_weights(wo.z);
        let coat_pdf = self.clearcoat_d(h) * h.cos_h / (4.0 * h.cos_d);
        let sum = base * cosine_hemisphere_pdf(wi) + specular * self.specular_pdf(wo, h) + coat * coat_pdf;
        sum / (base + specular + coat)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (lobe, _, _) = discrete::pick(&self.lobe_weights(wo.z), u.lobe)?;
        let wi = match lobe {
            0 => cosine_hemisphere(u.dir),
            1 => HalfVector::reflect(wo, self.sample_visible(wo, u.dir)),
            _ => HalfVector::reflect(wo, self.sample_clearcoat(u.dir)),
        };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "disney",
    summary: "principled: diffuse base, metallic or dielectric lobe, sheen, clearcoat (Burley 2012)",
    params: &[
        ParamSpec::new("base_color", COLOUR, "linear colour of the base").or("0.646/0.414/0.018"),
        ParamSpec::new("subsurface", UNIT, "Burley's diffuse (0) to Hanrahan-Krueger (1)").or("0"),
        ParamSpec::new("metallic", UNIT, "dielectric (0) to metal (1)").or("0"),
        ParamSpec::new("specular", UNIT, "dielectric reflectance at normal incidence over 0.08").or("0.5"),
        ParamSpec::new("specular_tint", UNIT, "white (0) to base-coloured (1) dielectric reflection").or("0"),
        ParamSpec::new("roughness", UNIT, "square root of the slope width").or("0.5"),
        ParamSpec::new("anisotropic", UNIT, "round (0) to elongated (1) highlight").or("0"),
        ParamSpec::new("sheen", UNIT, "amount of sheen").or("0"),
        ParamSpec::new("sheen_tint", UNIT, "white (0) to base-coloured (1) sheen").or("0.5"),
        ParamSpec::new("clearcoat", UNIT, "amount of clearcoat").or("0"),
        ParamSpec::new("clearcoat_gloss", UNIT, "satin (0) to glossy (1) clearcoat").or("1"),
    ],
    examples: &[
        Example::lawful("disney"),
        Example::lawful("disney:metallic=1,roughness=0.3,anisotropic=0.8"),
        Example::lawful("disney:base_color=0.5/0.2/0.1,subsurface=0.5,specular_tint=0.5,sheen=1,clearcoat=1"),
        Example::breaking("disney:base_color=1,roughness=1", &["energy_eye", "energy_light"]),
    ],
    build: |args| {
        Ok(Box::new(Disney::new(DisneyParams {
            base_color: args.colour("base_color")?,
            subsurface: args.number("subsurface")?,
            metallic: args.number("metallic")?,
            specular: args.number("specular")?,
            specular_tint: args.number("specular_tint")?,
            roughness: args.number("roughness")?,
            anisotropic: args.number("anisotropic")?,
            sheen: args.number("sheen")?,
            sheen_tint: args.number("sheen_tint")?,
            clearcoat: args.number("clearcoat")?,
            clearcoat_gloss: args.number("clearcoat_gloss")?,
        })?))
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::contract;
    use crate::math::sphere::{direction, direction_mu};
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    fn make(change: impl FnOnce(&mut DisneyParams)) -> Disney {
        let mut params = DisneyParams::default();
        change(&mut params);
        Disney::new(params).unwrap()
    }

    #[test]
    fn white_diffuse_base_has_burleys_albedo() {
        // Independent quadrature of the formula, six digits; at mu = 1 it is 41/42 + 5r/84.
        for (roughness, table) in [
            (1.0, [1.555563, 1.537952, 1.380126, 1.193435, 1.056904, 1.035714]),
            (0.0, [0.490531, 0.512017, 0.687975, 0.860363, 0.960938, 0.976190]),
        ] {
            let disney = make(|p| p.roughness = roughness);
            for (mu, expected) in [0.001, 0.01, 0.1, 0.25, 0.5, 1.0].into_iter().zip(table) {
                let wo = direction_mu(mu, 0.2);
                let diffuse = |wi| HalfVector::new(wo, wi).map_or(0.0, |h| disney.diffuse(h, wo.z, wi.z) * wi.z);
                let found = contract::hemisphere(wo, 1e-8, diffuse);
                assert!((found - expected).abs() < 1e-6, "r {roughness}, mu {mu}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn the_distributions_are_normalised() {
        let disney = make(|p| (p.roughness, p.anisotropic, p.clearcoat_gloss) = (0.7, 0.9, 0.4));
        // ∫ D cosθ dm: with wo = n the half vector of (n, w) runs over the cone of 45 degrees, so m itself is taken as h.
        let at = |m: DVec3| HalfVector { slope: DVec2::new(m.x / m.z, m.y / m.z), cos_h: m.z, cos_d: 1.0 };
        for d in [Disney::specular_d, Disney::clearcoat_d] {
            let total = contract::hemisphere(DVec3::Z, 1e-9, |m| d(&disney, at(m)) * m.z);
            assert_abs_diff_eq!(total, 1.0, epsilon = 1e-9);
        }
    }

    #[test]
    fn metal_agrees_with_the_formula_in_angles() {
        let disney = make(|p| (p.metallic, p.roughness) = (1.0, 0.6));
        let (wo, wi) = (direction(0.5, 0.2), direction(0.9, 2.0));
        let h = (wo + wi).normalize();
        let (a, ag) = (0.36_f64, (0.5 + 0.3_f64).powi(2));
        let d = a * a / (PI * ((a * a - 1.0) * h.z * h.z + 1.0).powi(2));
        let g1 = |c: f64| 2.0 * c / (c + (ag * ag + (1.0 - ag * ag) * c * c).sqrt());
        let fresnel = |f0: f64| f0 + (1.0 - f0) * (1.0 - wo.dot(h)).powi(5);
        let lobe = d * g1(wo.z) * g1(wi.z) / (4.0 * wo.z * wi.z);
        let expected = DisneyParams::default().base_color.map(fresnel) * lobe;
        assert_relative_eq!(disney.eval(wo, wi), expected, max_relative = 1e-13);
    }

    #[test]
    fn sampler_draws_from_its_pdf() {
        let all = make(|p| {
            (p.subsurface, p.sheen, p.clearcoat, p.clearcoat_gloss) = (0.5, 1.0, 1.0, 0.2);
            (p.anisotropic, p.metallic) = (0.9, 0.3);
        });
        let metal = make(|p| (p.metallic, p.roughness, p.anisotropic) = (1.0, 1.0, 1.0));
        for disney in [all, metal, make(|p| p.base_color = Rgb::BLACK)] {
            for mu in [1.0, 0.6, 0.05] {
                // The discrepancy of the points at the horizon's edge.
                contract::assert_draws_follow_pdf(&disney, direction_mu(mu, 0.6), 2e-4);
            }
        }
    }

    #[test]
    fn total_on_edges() {
        contract::assert_total(&make(|_| ()));
        contract::assert_total(&make(|p| {
            (p.roughness, p.clearcoat, p.sheen, p.subsurface) = (0.0, 1.0, 1.0, 1.0);
        }));
        contract::assert_total(&make(|p| (p.metallic, p.anisotropic, p.roughness) = (1.0, 1.0, 1.0)));
        contract::assert_total(&make(|p| (p.base_color, p.specular) = (Rgb::BLACK, 0.0)));
    }

    #[test]
    fn parameters_outside_the_unit_interval_are_rejected() {
        assert!(Disney::new(DisneyParams { sheen: 1.1, ..DisneyParams::default() }).is_err());
        assert!(Disney::new(DisneyParams { base_color: Rgb::grey(f64::NAN), ..DisneyParams::default() }).is_err());
    }
}
