//! The shifted gamma distribution: a microfacet model fitted to measured materials, each channel by itself.
//!
//! f = (ρ_d + ρ_s F D G₁(θ_i) G₁(θ_o) / (cosθ_i cosθ_o)) / π      [1/sr]
//!
//! - D = κ e^(−x) / (π x^p cos⁴θ_h), x = α + tan²θ_h / α; κ = α^(p−1) / Γ(1 − p, α) makes ∫ D cosθ_h dh = 1
//! - F = f₀ − f₁ cosθ_d + (1 − f₀)(1 − cosθ_d)⁵, a fit that may leave [0, 1]; below 0 it counts as 0
//! - G₁(θ) = 1 + λ (1 − exp(c max(θ − θ₀, 0)^k)), clamped to [0, 1], θ in radians
//!
//! There is no factor 1/4: ρ_s has taken it up. Reciprocal, but nothing in a fit keeps its energy: next to grazing, where no
//! measurement held it, the lobe over cosθ_i cosθ_o may reflect more than it receives.
//! # References
//! - Bagher, Soler & Holzschuch 2012, Accurate fitting of measured reflectances using a Shifted Gamma micro-facet
//!   distribution, CGF 31(4), with its supplemental table of parameters

use std::f64::consts::{FRAC_1_PI, PI};
use std::path::Path;

use glam::DVec3;

use super::fits_csv::{FitsCsv, Row};
use super::half_table::HalfTable;
use crate::bsdf::catalog::Entry;
use crate::bsdf::half_vector::HalfVector;
use crate::bsdf::subject::{ParamSpec, SubjectError};
use crate::bsdf::{Bsdf, BsdfSample, Domain, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::angles;

/// The parameters of one material, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SgdParams {
    /// Diffuse reflectance ρ_d ≥ 0.
    pub rho_d: Rgb,
    /// Scale of the lobe ρ_s ≥ 0; not a reflectance.
    pub rho_s: Rgb,
    /// Width α of the distribution.
    pub alpha: Rgb,
    /// Exponent p of the distribution's power law.
    pub p: Rgb,
    /// f₀ of the Fresnel term.
    pub f0: Rgb,
    /// f₁ of the Fresnel term.
    pub f1: Rgb,
    /// Normalisation κ of the distribution.
    pub kap: Rgb,
    /// λ of the masking term.
    pub lambda: Rgb,
    /// c of the masking term.
    pub c: Rgb,
    /// k of the masking term.
    pub k: Rgb,
    /// θ₀ of the masking term, in radians.
    pub theta0: Rgb,
}

/// A reflection model of the shifted gamma distribution.
#[derive(Clone, Debug)]
pub struct Sgd {
    params: SgdParams,
    sampler: HalfTable,
}

impl Sgd {
    /// ρ_d, ρ_s, κ, λ, c ≥ 0, α in [1e-8, 1e3], p and k in [0, 1e4], f₀, f₁ and θ₀ within ±1e4.
    pub fn new(params: SgdParams) -> Result<Self, ParamError> {
        let SgdParams { rho_d, rho_s, alpha, p, f0, f1, kap, lambda, c, k, theta0 } = params;
        let (scale, any) = (Domain::Colour(0.0, 1e100), Domain::Colour(-1e4, 1e4));
        for (name, value) in [("rhoD", rho_d), ("rhoS", rho_s), ("kap", kap), ("lambda", lambda), ("c", c)] {
            scale.check_colour("sgd", name, value)?;
        }
        Domain::Colour(1e-8, 1e3).check_colour("sgd", "alpha", alpha)?;
        for (name, value) in [("p", p), ("k", k)] {
            Domain::Colour(0.0, 1e4).check_colour("sgd", name, value)?;
        }
        for (name, value) in [("f0", f0), ("f1", f1), ("theta0", theta0)] {
            any.check_colour("sgd", name, value)?;
        }
        // The hemispherical mean 2 ∫ F mu dmu of the Fresnel term weighs the channels of the sampled distribution.
        let fresnel = f0 - f1 * (2.0 / 3.0) + (Rgb::WHITE - f0) * (1.0 / 21.0);
        let weight = rho_s * fresnel.map(|f| f.max(0.0)) * (1.0 / 3.0);
        let sampler = HalfTable::new(alpha.min_channel(), rho_d.mean(), |tan2| {
            (0..3).map(|i| weight.0[i] * distribution(kap.0[i], alpha.0[i], p.0[i], tan2)).sum()
        });
        Ok(Self { params, sampler })
    }

    /// The `material` of the table of fits at `path`.
    pub fn load(path: &Path, material: &str) -> Result<Self, SubjectError> {
        let csv = FitsCsv::read(path)?;
        Self::from_row(&csv, csv.find(material)?)
    }

    /// The material in one row of a table.
    pub(super) fn from_row(csv: &FitsCsv, row: &Row) -> Result<Self, SubjectError> {
        let colour = |name: &str| csv.colour(row, name);
        let params = SgdParams {
            rho_d: colour("rhoD")?,
            rho_s: colour("rhoS")?,
            alpha: colour("alpha")?,
            p: colour("p")?,
            f0: colour("f0")?,
            f1: colour("f1")?,
            kap: colour("kap")?,
            lambda: colour("lambda")?,
            c: colour("c")?,
            k: colour("k")?,
            theta0: colour("theta0")?,
        };
        Self::new(params).map_err(|error| csv.error(row, error))
    }

    fn masking(&self, channel: usize, theta: f64) -> f64 {
        let SgdParams { lambda, c, k, theta0, .. } = self.params;
        let beyond = (theta - theta0.0[channel]).max(0.0);
        // Beyond e⁷⁰⁰ the masking is total, and a λ of 0 must not meet an infinity.
        let growth = (c.0[channel] * beyond.powf(k.0[channel])).min(700.0).exp_m1();
        (1.0 - lambda.0[channel] * growth).clamp(0.0, 1.0)
    }
}

/// D(θ_h) [1/sr].
fn distribution(kap: f64, alpha: f64, p: f64, tan2: f64) -> f64 {
    let x = alpha + tan2 / alpha;
    let decay = (-x).exp();
    // 1 / cos⁴ = (1 + tan²)², which the decay has long beaten where it overflows.
    if decay > 0.0 { (kap / PI * decay * x.powf(-p) * (1.0 + tan2).powi(2)).min(f64::MAX) } else { 0.0 }
}

impl Bsdf for Sgd {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let Some(h) = HalfVector::new(wo, wi) else { return Rgb::BLACK };
        let SgdParams { rho_d, rho_s, alpha, p, f0, f1, kap, .. } = self.params;
        let (tan2, schlick) = (h.tan2(), (1.0 - h.cos_d).powi(5));
        let (theta_o, theta_i) = (angles(wo).0, angles(wi).0);
        let channel = |i: usize| {
            let fresnel = (f0.0[i] - h.cos_d * f1.0[i] + schlick * (1.0 - f0.0[i])).max(0.0);
            let g = self.masking(i, theta_o) * self.masking(i, theta_i);
            let d = distribution(kap.0[i], alpha.0[i], p.0[i], tan2);
            let lobe = rho_s.0[i] * fresnel * d * g / wo.z / wi.z;
            // An overflow is the only way to leave the range: nothing here is NaN or negative.
            (rho_d.0[i] + lobe.min(1e200)) * FRAC_1_PI
        };
        Rgb::new(channel(0), channel(1), channel(2))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.sampler.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        self.sampler.sample(self, wo, u)
    }
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: "sgd",
    summary: "shifted gamma distribution fitted to a measured material (Bagher et al. 2012)",
    params: &[
        ParamSpec::new("file", Domain::Text, "CSV of fits: one material a row, columns rhoD_r … theta0_b"),
        ParamSpec::new("material", Domain::Text, "the name of a row"),
    ],
    examples: &[],
    build: |args| Ok(Box::new(Sgd::load(Path::new(args.text("file")?), args.text("material")?)?)),
};
