//! Blinn-Phong: a power of the cosine between the normal and the half vector.
//!
//! f = kd + ks C (n·h)ⁿ      [1/sr],  h = (wo + wi) / |wo + wi|
//!
//! The exponent n is in [0, 10⁶]; for lobes of equal width it is about four times Phong's. `kd` [1/sr] is **not** divided
//! by π. C is 1 (`none`), (n+8)/8π (`n+8`, the usual approximation), or (`exact`) the reciprocal of the integral at normal
//! incidence,
//!
//! ∫ (n·h)ⁿ (n·l) dl = 8π (n + 2^(−n/2)) / ((n+2)(n+4))      for v = n,
//!
//! so that the albedo there is exactly ks + π kd. The approximation is (n+8)(n + 2^(−n/2))/((n+2)(n+4)) times too bright:
//! more than 1 for every n > 0, 1.0748 for n = 10. Its examples with ks = 1 therefore break both energy laws. The
//! factors of a microfacet distribution, (n+2)/2π, and of Phong's lobe belong to other integrals.
//!
//! Sampled by a mixture of the cosine hemisphere and reflection about a half vector with density (n+1)/2π (n·h)ⁿ, which
//! makes the density of `wi` that over 4 wo·h. Reflections below the horizon are lost.
//! # References
//! - Blinn 1977, SIGGRAPH (the half vector)
//! - Giesen 2009, Phong normalization factor derivation (the integral at normal incidence)

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::reflect;
use crate::sampling::discrete::pick;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf, power_cosine};

const N: Domain = Domain::Closed(0.0, 1e6);
const KD: Domain = Domain::Colour(0.0, 1e6);
const KS: Domain = Domain::Colour(0.0, 1e6);
const NORM: Domain = Domain::Word(&["none", "exact", "n+8"]);

/// The factor C in front of the power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlinnPhongNorm {
    /// C = 1.
    None,
    /// C = (n+2)(n+4) / (8π (n + 2^(−n/2))): the albedo of the lobe is exactly 1 at normal incidence.
    Exact,
    /// C = (n+8)/8π.
    NPlus8,
}

impl BlinnPhongNorm {
    fn factor(self, n: f64) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Exact => 1.0 / normal_moment(n),
            Self::NPlus8 => (n + 8.0) / (4.0 * TAU),
        }
    }
}

/// ∫ (n·h)ⁿ (n·l) dl over the hemisphere for v = n.
fn normal_moment(n: f64) -> f64 {
    4.0 * TAU * (n + (-0.5 * n).exp2()) / ((n + 2.0) * (n + 4.0))
}

/// (n·h)ⁿ through tan²θ of the unnormalised half vector, which has all digits next to the normal.
fn half_power(half: DVec3, n: f64) -> f64 {
    let tan = half.x.hypot(half.y) / half.z;
    // The bound keeps 0 · ∞ out of n = 0.
    (-0.5 * n * (tan * tan).ln_1p().min(f64::MAX)).exp()
}

/// Blinn-Phong reflection, f = kd + ks C (n·h)ⁿ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlinnPhong {
    n: f64,
    kd: Rgb,
    /// ks C.
    lobe: Rgb,
    /// Sampling weights of the diffuse part and of the lobe.
    parts: [f64; 2],
}

impl BlinnPhong {
    /// Exponent `n` in [0, 10⁶], diffuse value `kd` [1/sr] and lobe strength `ks`, each ≥ 0 per channel.
    pub fn new(n: f64, kd: impl Into<Rgb>, ks: impl Into<Rgb>, norm: BlinnPhongNorm) -> Result<Self, ParamError> {
        let n = N.check("blinn-phong", "n", n)?;
        let kd = KD.check_colour("blinn-phong", "kd", kd.into())?;
        let lobe = KS.check_colour("blinn-phong", "ks", ks.into())? * norm.factor(n);
        let (diffuse, specular) = (PI * kd.mean(), normal_moment(n) * lobe.mean());
        let total = diffuse + specular;
        let parts = if total > 0.0 { [diffuse / total, specular / total] } else { [1.0, 0.0] };
        Ok(Self { n, kd, lobe, parts })
    }
}

impl Bsdf for BlinnPhong {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.kd + self.lobe * half_power(wo + wi, self.n)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        // 4 wo·h = 2 |wo + wi| for unit vectors; the bound matters only where both graze from opposite sides.
        let half = wo + wi;
        let density = (self.n + 1.0) / TAU * half_power(half, self.n) / (2.0 * half.length()).max(1e-290);
        self.parts[0] * cosine_hemisphere_pdf(wi) + self.parts[1] * density
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (part, ..) = pick(&self.parts, u.lobe)?;
        let wi = if part == 0 { cosine_hemisphere(u.dir) } else { reflect(wo, power_cosine(u.dir, self.n)) };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    /// Known at normal incidence only.
    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        if wo.z <= 0.0 {
            return Some(Rgb::BLACK);
        }
        (wo.x == 0.0 && wo.y == 0.0).then(|| self.kd * PI + self.lobe * normal_moment(self.n))
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "blinn-phong",
    summary: "power of the half vector's cosine, f = kd + ks C (n·h)^n",
    params: &[
        ParamSpec::new("n", N, "exponent"),
        ParamSpec::new("kd", KD, "diffuse value in 1/sr, not divided by π").or("0"),
        ParamSpec::new("ks", KS, "strength of the lobe").or("1"),
        ParamSpec::new("norm", NORM, "factor C: 1, exact at normal incidence, or (n+8)/8π"),
    ],
    examples: &[
        Example::lawful("blinn-phong:n=40,kd=0.1,ks=0.6,norm=exact"),
        Example::lawful("blinn-phong:n=1,kd=0,ks=1,norm=exact"),
        Example::lawful("blinn-phong:n=1000,kd=0.02/0.1/0.05,ks=0.6,norm=n+8"),
        Example::lawful("blinn-phong:n=100,kd=0,ks=1,norm=none"),
        Example::lawful("blinn-phong:n=1e6,kd=0,ks=1,norm=exact"),
        // 1.0748 at the normal.
        Example::breaking("blinn-phong:n=10,kd=0,ks=1,norm=n+8", &["energy_eye", "energy_light"]),
        // 1.500671491 at the normal.
        Example::breaking("blinn-phong:n=10,kd=0,ks=1,norm=none", &["energy_eye", "energy_light"]),
    ],
    build: |args| {
        let norm = match args.word("norm")? {
            "exact" => BlinnPhongNorm::Exact,
            "n+8" => BlinnPhongNorm::NPlus8,
            _ => BlinnPhongNorm::None,
        };
        Ok(Box::new(BlinnPhong::new(args.number("n")?, args.colour("kd")?, args.colour("ks")?, norm)?))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::integrate::{Hemisphere, Side};
    use crate::math::sphere::direction;
    use approx::assert_abs_diff_eq;

    fn lobe(n: f64, norm: BlinnPhongNorm) -> BlinnPhong {
        BlinnPhong::new(n, 0.0, 1.0, norm).unwrap()
    }

    #[test]
    fn albedo_at_normal_incidence() {
        for (n, expected) in [(1.0, 2.860284865), (10.0, 1.500671491), (100.0, 0.236922523)] {
            let albedo = lobe(n, BlinnPhongNorm::None).albedo(DVec3::Z).unwrap();
            assert_abs_diff_eq!(albedo.0.x, expected, epsilon = 1e-9);
        }
        for n in [0.0, 1.0, 33.3, 1e4, 1e6] {
            let exact = lobe(n, BlinnPhongNorm::Exact);
            assert_abs_diff_eq!(exact.albedo(DVec3::Z).unwrap().0.x, 1.0, epsilon = 1e-15);
            assert_albedo(&exact, &[1.0], 1e-8);
            assert!(n == 0.0 || lobe(n, BlinnPhongNorm::NPlus8).albedo(DVec3::Z).unwrap().0.x > 1.0);
        }
    }

    #[test]
    fn the_exact_norm_never_gains() {
        for n in [0.3, 1.0, 10.0, 300.0] {
            let exact = lobe(n, BlinnPhongNorm::Exact);
            for degrees in [5.0_f64, 30.0, 60.0, 80.0, 89.0] {
                let wo = direction(degrees.to_radians(), 0.2);
                let albedo = Hemisphere::with_tol(1e-7).albedo(&exact, Side::Eye, wo).value.0.x;
                assert!(albedo <= 1.0 + 1e-7, "n = {n} at {degrees}: {albedo}");
            }
        }
    }

    #[test]
    fn exponent_zero_is_lambert() {
        let flat = lobe(0.0, BlinnPhongNorm::Exact);
        let f = flat.eval(direction(0.3, 0.0), direction(1.2, 2.0));
        assert_abs_diff_eq!(f.0.x, 1.0 / PI, epsilon = 1e-16);
    }

    #[test]
    fn total_and_sampled_exactly() {
        for n in [0.0, 1.0, 50.0, 1e6] {
            let model = BlinnPhong::new(n, 0.1, [0.5, 0.2, 0.0], BlinnPhongNorm::Exact).unwrap();
            assert_total(&model);
            assert_sampled_exactly(&model, &[1.0, 0.5, 0.05]);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        let new = |n, kd: f64, ks: f64| BlinnPhong::new(n, kd, ks, BlinnPhongNorm::None);
        assert!(new(-1.0, 0.0, 1.0).is_err() && new(1.0, f64::NAN, 1.0).is_err() && new(1.0, 0.0, -1.0).is_err());
    }
}
