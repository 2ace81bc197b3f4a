//! Phong's lobe about the mirror direction, in the forms in which it is taught and used.
//!
//! f = kd + ks C max(0, v·r)ⁿ              [1/sr]      (`divide = false`)
//! f = kd + ks C max(0, v·r)ⁿ / (n·l)      [1/sr]      (`divide = true`)
//!
//! r is the mirror image of the light direction l, v the direction to the eye: v·r = 2 (n·l)(n·v) − l·v is symmetric.
//! l is `wi` and v is `wo`; n is both the normal and, as a number in [0, 10⁶], the exponent. `kd` [1/sr] is the diffuse
//! value itself and is **not** divided by π. C is 1 (`none`), (n+1)/2π or (n+2)/2π: no choice is the natural one, so
//! none is the default.
//!
//! With Bₙ = ∫ cosⁿφ dφ over (−π/2, π/2) and I the regularised incomplete beta function, for all angles θ of v,
//!
//! T(θ) = ∫ (v·r)ⁿ dl       = 2π/(n+1) [1 − ½ I(sin²θ; (n+1)/2, ½)]
//! A(θ) = ∫ (v·r)ⁿ (n·l) dl = 2π/(n+2) {cosθ [1 − ½ I(sin²θ; n/2, ½)] + Bₙ sinⁿθ / 2π}
//!
//! and the albedo is π kd + ks C A, or π kd + ks C T with the division. A is largest at the normal, so the first form
//! keeps energy if and only if π kd + 2π C ks / (n+2) ≤ 1. The second is not reciprocal (f(v,l)/f(l,v) = n·v / n·l), and
//! with the *light* fixed its albedo π kd + ks C A(θ)/cosθ grows without bound at grazing, for every ks > 0: it gains
//! energy, though the eye's furnace never shows it for C = (n+1)/2π. Hence its examples break `reciprocity` and
//! `energy_light`, and with C = (n+2)/2π also `energy_eye`, where it reaches (n+2)/(n+1).
//!
//! Sampled by a mixture of the cosine hemisphere and the lobe about the mirror direction of `wo`, in proportion to
//! π kd and ks C 2π/(n+1). Draws of the lobe below the horizon are lost.
//! # References
//! - Phong 1975, Communications of the ACM 18(6)
//! - Lewis 1994, Making shaders more physically plausible (energy and reciprocity of both forms)
//! - Lafortune & Willems 1994, Using the modified Phong reflectance model for physically based rendering (C = (n+2)/2π)
//! - Arvo 1995, Applications of irradiance tensors (moments of cosⁿ over spherical polygons, hence T and A)

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::math::special::{inc_beta_half, wallis};
use crate::math::sphere::mirror;
use crate::sampling::discrete::pick;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf, lobe_power, phong_lobe, phong_lobe_pdf};

const N: Domain = Domain::Closed(0.0, 1e6);
const KD: Domain = Domain::Colour(0.0, 1e6);
const KS: Domain = Domain::Colour(0.0, 1e6);
const NORM: Domain = Domain::Word(&["none", "n+1", "n+2"]);
const DIVIDE: Domain = Domain::Word(&["false", "true"]);

/// The factor C in front of Phong's power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhongNorm {
    /// C = 1.
    None,
    /// C = (n+1)/2π: the density of directions about the lobe's axis.
    DensityNPlus1,
    /// C = (n+2)/2π: albedo 1 at the normal.
    AlbedoNPlus2,
}

impl PhongNorm {
    /// C for the exponent `n`.
    fn factor(self, n: f64) -> f64 {
        match self {
            Self::None => 1.0,
            Self::DensityNPlus1 => (n + 1.0) / TAU,
            Self::AlbedoNPlus2 => (n + 2.0) / TAU,
        }
    }
}

/// Phong's reflection, f = kd + ks C (v·r)ⁿ, without or with a division by n·l.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    n: f64,
    kd: Rgb,
    /// ks C.
    lobe: Rgb,
    divide: bool,
    /// Sampling weights of the diffuse part and of the lobe.
    parts: [f64; 2],
}

impl Phong {
    /// Exponent `n` in [0, 10⁶], diffuse value `kd` [1/sr] and lobe strength `ks`, each ≥ 0 per channel.
    pub fn new(n: f64, kd: impl Into<Rgb>, ks: impl Into<Rgb>, norm: PhongNorm) -> Result<Self, ParamError> {
        let n = N.check("phong", "n", n)?;
        let kd = KD.check_colour("phong", "kd", kd.into())?;
        let lobe = KS.check_colour("phong", "ks", ks.into())? * norm.factor(n);
        let (diffuse, specular) = (PI * kd.mean(), TAU / (n + 1.0) * lobe.mean());
        let total = diffuse + specular;
        let parts = if total > 0.0 { [diffuse / total, specular / total] } else { [1.0, 0.0] };
        Ok(Self { n, kd, lobe, divide: false, parts })
    }

    /// The second form: the lobe divided by n·l. It breaks reciprocity and gains energy, and is here to show it.
    pub fn with_division(self, divide: bool) -> Self {
        Self { divide, ..self }
    }
}

impl Bsdf for Phong {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        let power = lobe_power(wi, mirror(wo), self.n);
        // Keeps the quotient finite at grazing angles that no sampler makes.
        let scale = if self.divide { power / wi.z.max(1e-290) } else { power };
        self.kd + self.lobe * scale
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        self.parts[0] * cosine_hemisphere_pdf(wi) + self.parts[1] * phong_lobe_pdf(wi, self.n, mirror(wo))
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (part, ..) = pick(&self.parts, u.lobe)?;
        let wi = if part == 0 { cosine_hemisphere(u.dir) } else { phong_lobe(u.dir, self.n, mirror(wo)) };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        if wo.z <= 0.0 {
            return Some(Rgb::BLACK);
        }
        let moment = if self.divide { phong_t(self.n, wo) } else { phong_a(self.n, wo) };
        Some(self.kd * PI + self.lobe * moment)
    }
}

/// T = ∫ max(0, v·r)ⁿ dl over the upper hemisphere of l \[sr\], for `v` above the horizon and `n` ≥ 0.
pub fn phong_t(n: f64, v: DVec3) -> f64 {
    let hidden = 0.5 * inc_beta_half(0.5 * (n + 1.0), v.x * v.x + v.y * v.y, v.z * v.z);
    TAU / (n + 1.0) * (1.0 - hidden)
}

/// A = ∫ max(0, v·r)ⁿ (n·l) dl over the upper hemisphere of l \[sr\], for `v` above the horizon and `n` ≥ 0.
pub fn phong_a(n: f64, v: DVec3) -> f64 {
    let (s2, c2) = (v.x * v.x + v.y * v.y, v.z * v.z);
    // sinⁿθ through whichever of sin² and cos² is small.
    let sine_power = if c2 < 0.5 { (0.5 * n * (-c2).ln_1p()).exp() } else { s2.powf(0.5 * n) };
    let seen = 1.0 - 0.5 * inc_beta_half(0.5 * n, s2, c2);
    TAU / (n + 2.0) * (v.z * seen + wallis(n) * sine_power / TAU)
}

pub(super) const ENTRY: Entry = Entry {
    name: "phong",
    summary: "Phong's lobe, f = kd + ks C (v·r)^n, or with the lobe divided by n·l",
    params: &[
        ParamSpec::new("n", N, "exponent"),
        ParamSpec::new("kd", KD, "diffuse value in 1/sr, not divided by π").or("0"),
        ParamSpec::new("ks", KS, "strength of the lobe").or("1"),
        ParamSpec::new("norm", NORM, "factor C: 1, (n+1)/2π or (n+2)/2π"),
        ParamSpec::new("divide", DIVIDE, "whether the lobe is divided by n·l").or("false"),
    ],
    examples: &[
        Example::lawful("phong:n=10,kd=0.1,ks=0.6,norm=n+2"),
        Example::lawful("phong:n=1,kd=0,ks=1,norm=n+2"),
        Example::lawful("phong:n=100,kd=0.05/0.1/0.02,ks=0.6,norm=n+1"),
        Example::lawful("phong:n=20,kd=0,ks=1,norm=none"),
        Example::lawful("phong:n=1e6,kd=0,ks=1,norm=n+2"),
        // 2π/(n+2) > 1 for n < 2π − 2.
        Example::breaking("phong:n=3,kd=0,ks=1,norm=none", &["energy_eye", "energy_light"]),
        Example::breaking("phong:n=100,kd=0,ks=1,norm=n+1,divide=true", &["reciprocity", "energy_light"]),
        Example::breaking("phong:n=10,kd=0,ks=1,norm=n+2,divide=true", &["reciprocity", "energy_eye", "energy_light"]),
    ],
    build: |args| {
        let norm = match args.word("norm")? {
            "n+1" => PhongNorm::DensityNPlus1,
            "n+2" => PhongNorm::AlbedoNPlus2,
            _ => PhongNorm::None,
        };
        let model = Phong::new(args.number("n")?, args.colour("kd")?, args.colour("ks")?, norm)?;
        Ok(Box::new(model.with_division(args.word("divide")? == "true")))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::integrate::{Hemisphere, Side};
    use crate::math::quadrature::adaptive;
    use crate::math::sphere::{direction, direction_mu};
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    fn at(degrees: f64) -> DVec3 {
        direction(degrees.to_radians(), 0.3)
    }

    fn lobe(n: f64, norm: PhongNorm) -> Phong {
        Phong::new(n, 0.0, 1.0, norm).unwrap()
    }

    fn grey(albedo: Option<Rgb>) -> f64 {
        albedo.unwrap().0.x
    }

    #[test]
    fn albedo_of_the_energy_normalised_lobe() {
        // Closed forms confirmed by an independent quadrature, 12 digits.
        let table = [
            (1.0, [0.880842779579, 0.608997781044, 0.409945253589, 0.327084567079]),
            (5.0, [0.866253576462, 0.519406835538, 0.269290802610, 0.178620736528]),
            (10.0, [0.866028525256, 0.504735946655, 0.228056292549, 0.131960432253]),
            (100.0, [0.866025403784, 0.500000000612, 0.175232623516, 0.049125363960]),
        ];
        for (n, row) in table {
            let phong = lobe(n, PhongNorm::AlbedoNPlus2);
            assert_abs_diff_eq!(grey(phong.albedo(DVec3::Z)), 1.0, epsilon = 1e-15);
            for (degrees, expected) in [30.0, 60.0, 80.0, 89.0].into_iter().zip(row) {
                assert_abs_diff_eq!(grey(phong.albedo(at(degrees))), expected, epsilon = 1e-12);
            }
        }
        let horizon = |n| (n + 2.0) / TAU * phong_a(n, DVec3::X);
        assert_abs_diff_eq!(horizon(1.0), 1.0 / PI, epsilon = 1e-15);
        assert_abs_diff_eq!(horizon(5.0), 0.169765272631, epsilon = 1e-12);
        assert_abs_diff_eq!(horizon(10.0), 0.123046875, epsilon = 1e-15);
        assert_abs_diff_eq!(horizon(100.0), 0.039794618694, epsilon = 1e-12);
    }

    #[test]
    fn average_albedo() {
        for (n, expected) in [(1.0, 0.737402197), (10.0, 0.673502604), (100.0, 0.666926762)] {
            let phong = lobe(n, PhongNorm::AlbedoNPlus2);
            let integrand = |mu: f64| [2.0 * mu * grey(phong.albedo(direction_mu(mu, 0.0)))];
            let average = adaptive(integrand, &[0.0, 0.1, 1.0], 1e-11, 200).value[0];
            assert_abs_diff_eq!(average, expected, epsilon = 1e-9);
        }
    }

    #[test]
    fn a_needle_darkens_like_the_cosine() {
        let phong = lobe(1e6, PhongNorm::AlbedoNPlus2);
        for degrees in [0.0, 30.0, 60.0, 85.0] {
            // The correction is of the order of the lobe's tail below the horizon, e^(−n cos²θ / 2) and less.
            assert_abs_diff_eq!(grey(phong.albedo(at(degrees))), at(degrees).z, epsilon = 1e-14);
        }
        assert_relative_eq!(phong_a(1e6, DVec3::X), wallis(1e6) / (1e6 + 2.0), max_relative = 1e-14);
    }

    #[test]
    fn closed_forms_agree_with_quadrature() {
        let mus = [1.0, 0.7, 0.2, 0.03];
        // Along the crease where the lobe ends, with an infinite slope for n < 1, quadrature says unresolved below these.
        for (n, tol) in [(0.5, 1e-5), (1.0, 1e-6), (7.3, 1e-7), (400.0, 1e-7)] {
            for norm in [PhongNorm::None, PhongNorm::DensityNPlus1, PhongNorm::AlbedoNPlus2] {
                let phong = Phong::new(n, [0.1, 0.0, 0.2], [0.3, 0.2, 0.6], norm).unwrap();
                assert_albedo(&phong, &mus, tol);
                assert_albedo(&phong.with_division(true), &mus, tol);
            }
        }
        assert_albedo(&lobe(1e6, PhongNorm::AlbedoNPlus2), &mus, 1e-7);
    }

    #[test]
    fn quadrature_is_right_where_it_claims_to_be() {
        let hemisphere = |tol| Hemisphere { tol, max_evals: 400_000 };
        let mut resolved = 0;
        for n in [0.5, 1.0, 3.0] {
            let phong = lobe(n, PhongNorm::DensityNPlus1).with_division(true);
            for mu in [1.0, 0.7, 0.2, 0.03, 0.003] {
                let wo = direction_mu(mu, 0.4);
                for tol in [1e-5, 1e-6, 1e-7, 1e-8] {
                    let a = hemisphere(tol).albedo(&phong, Side::Eye, wo);
                    let gap = (a.value.0.x - grey(phong.albedo(wo))).abs();
                    assert!(
                        !a.resolved || gap <= tol,
                        "n = {n}, μ = {mu}, tol {tol:e}: off by {gap:e}, said {:e}",
                        a.error
                    );
                    resolved += u32::from(a.resolved);
                }
            }
        }
        assert!(resolved >= 30, "an integrator that resolves nothing is never wrong: {resolved} of 60");
    }

    proptest! {
        #[test]
        fn recurrences_in_the_exponent(log_n in 0.0..5.9_f64, degrees in 0.0..90.0_f64) {
            // A_n = [n cosθ T_{n−1} + B_n sinⁿθ]/(n+2); T_m = [(m−1) T_{m−2} + cosθ sin^{m−1}θ B_{m−1}]/(m+1).
            let (n, v) = (1.0 + 10_f64.powf(log_n), at(degrees));
            let sine = (v.x * v.x + v.y * v.y).sqrt();
            let a = (n * v.z * phong_t(n - 1.0, v) + wallis(n) * sine.powf(n)) / (n + 2.0);
            // sinⁿ by the plain power loses n roundings.
            let tol = 4e-15 + 2e-16 * n;
            prop_assert!((phong_a(n, v) - a).abs() <= tol * phong_a(n, v));
            let t = ((n - 1.0) * phong_t(n - 2.0, v) + v.z * sine.powf(n - 1.0) * wallis(n - 1.0)) / (n + 1.0);
            prop_assert!((phong_t(n, v) - t).abs() <= 4.0 * tol * phong_t(n, v));
        }

        #[test]
        fn albedo_falls_with_the_angle(log_n in -2.0..6.0_f64, a in 0.0..90.0_f64, b in 0.0..90.0_f64) {
            let n = 10_f64.powf(log_n);
            prop_assert!(phong_a(n, at(a.min(b))) >= phong_a(n, at(a.max(b))) * (1.0 - 1e-13));
        }

        #[test]
        fn first_form_is_reciprocal_and_the_second_is_off_by_the_cosines(
            a in 0.0..89.0_f64, b in 0.0..89.0_f64, phi in 0.0..TAU,
        ) {
            let (v, l) = (at(a), direction(b.to_radians(), phi));
            let phong = lobe(5.0, PhongNorm::DensityNPlus1);
            prop_assert_eq!(phong.eval(v, l), phong.eval(l, v));
            let divided = phong.with_division(true);
            let (forth, back) = (divided.eval(v, l).0.x, divided.eval(l, v).0.x);
            prop_assert!((forth * l.z - back * v.z).abs() <= 1e-15);
        }
    }

    #[test]
    fn exponent_zero_is_the_half_space_about_the_mirror_direction() {
        for degrees in [0.0_f64, 20.0, 70.0, 90.0] {
            let v = at(degrees);
            assert_abs_diff_eq!(phong_t(0.0, v), 2.0 * (PI - degrees.to_radians()), epsilon = 1e-14);
            assert_abs_diff_eq!(phong_a(0.0, v), PI * (1.0 + v.z) / 2.0, epsilon = 1e-14);
            assert_abs_diff_eq!(phong_t(1.0, v), PI * (1.0 + v.z) / 2.0, epsilon = 1e-14);
        }
        assert_total(&lobe(0.0, PhongNorm::None));
    }

    #[test]
    fn seed_forms_conserve_exactly_when_they_should() {
        // Un-normalised: gains below n = 2π − 2 = 4.283185, loses above.
        assert!(grey(lobe(4.28, PhongNorm::None).albedo(DVec3::Z)) > 1.0);
        assert!(grey(lobe(4.29, PhongNorm::None).albedo(DVec3::Z)) < 1.0);
        // Divided, n+1: exactly 1 at the normal and never more from the eye's side.
        let divided = lobe(100.0, PhongNorm::DensityNPlus1).with_division(true);
        assert_abs_diff_eq!(grey(divided.albedo(DVec3::Z)), 1.0, epsilon = 1e-15);
        assert!((0..=90).all(|degrees| grey(divided.albedo(at(f64::from(degrees)))) <= 1.0));
        // Divided, n+2: (n+2)/(n+1) already at the normal.
        let gaining = lobe(10.0, PhongNorm::AlbedoNPlus2).with_division(true);
        assert_abs_diff_eq!(grey(gaining.albedo(DVec3::Z)), 12.0 / 11.0, epsilon = 1e-15);
    }

    #[test]
    fn the_divided_form_gains_with_the_light_fixed() {
        let divided = lobe(100.0, PhongNorm::DensityNPlus1).with_division(true);
        for (degrees, expected) in [(80.0, 0.999231), (85.0, 1.109007), (89.0, 2.787223)] {
            let closed = 101.0 / TAU * phong_a(100.0, at(degrees)) / at(degrees).z;
            assert_abs_diff_eq!(closed, expected, epsilon = 5e-7);
            let light = Hemisphere::with_tol(1e-8).albedo(&divided, Side::Light, at(degrees));
            assert!(light.resolved);
            assert_abs_diff_eq!(light.value.0.x, closed, epsilon = 1e-7);
        }
        // The first angle at which the light's albedo passes 1.
        for (n, degrees) in [(1.0, 70.34), (100.0, 80.16)] {
            let light = |d: f64| (n + 1.0) / TAU * phong_a(n, at(d)) / at(d).z;
            assert!(light(degrees - 0.01) < 1.0 && light(degrees + 0.01) > 1.0, "n = {n}");
        }
    }

    #[test]
    fn total_and_sampled_exactly() {
        for n in [0.5, 1.0, 30.0, 1e6] {
            for divide in [false, true] {
                let phong = Phong::new(n, 0.1, [0.5, 0.2, 0.0], PhongNorm::AlbedoNPlus2).unwrap();
                let phong = phong.with_division(divide);
                assert_total(&phong);
                assert_sampled_exactly(&phong, &[1.0, 0.5, 0.05]);
            }
        }
        let black = Phong::new(10.0, 0.0, 0.0, PhongNorm::None).unwrap();
        assert_total(&black);
        assert_sampled_exactly(&black, &[0.5]);
    }

    #[test]
    fn invalid_parameters_are_refused() {
        let new = |n, kd: f64, ks: f64| Phong::new(n, kd, ks, PhongNorm::None);
        assert!(new(-1.0, 0.0, 1.0).is_err() && new(f64::NAN, 0.0, 1.0).is_err() && new(1e9, 0.0, 1.0).is_err());
        assert!(new(1.0, -0.1, 1.0).is_err() && new(1.0, 0.0, f64::INFINITY).is_err());
    }
}
