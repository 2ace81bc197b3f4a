//! The ABC model: a microfacet distribution with a power-law tail, fitted to measured materials.
//!
//! f = k_D / π + F D G / (π cosθ_i cosθ_o)      [1/sr]
//!
//! - D = A / (1 + B (1 − cosθ_h))^C, A per channel: not normalised, A has taken up all factors
//! - F(cosθ_d), the Fresnel reflectance of a dielectric of index `ior` for unpolarised light
//! - G = min(1, 2 cosθ_h cosθ_o / cosθ_d, 2 cosθ_h cosθ_i / cosθ_d), the V-cavities of Cook and Torrance
//!
//! Reciprocal; nothing in a fit keeps its energy.
//! # References
//! - Löw, Kronander, Ynnerman & Unger 2012, BRDF Models for Accurate and Efficient Rendering of Glossy Surfaces, ACM TOG 31(1)
//! - Cook & Torrance 1982, A Reflectance Model for Computer Graphics, ACM TOG 1(1) (F and G)

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

/// A reflection model of Löw et al.
#[derive(Clone, Debug)]
pub struct Abc {
    k_d: Rgb,
    a: Rgb,
    b: f64,
    c: f64,
    ior: f64,
    sampler: HalfTable,
}

impl Abc {
    /// Diffuse reflectance `k_d` ≥ 0, height `a` ≥ 0, sharpness `b` in [1e-6, 1e12], fall-off `c` in [0, 1e3] and index of
    /// refraction `ior` in [1, 1e4].
    pub fn new(k_d: impl Into<Rgb>, a: impl Into<Rgb>, b: f64, c: f64, ior: f64) -> Result<Self, ParamError> {
        let scale = Domain::Colour(0.0, 1e100);
        let k_d = scale.check_colour("abc", "kD", k_d.into())?;
        let a = scale.check_colour("abc", "A", a.into())?;
        let b = Domain::Closed(1e-6, 1e12).check("abc", "B", b)?;
        let c = Domain::Closed(0.0, 1e3).check("abc", "C", c)?;
        let ior = Domain::Closed(1.0, 1e4).check("abc", "ior", ior)?;
        // F at 60 degrees stands for its mean: it only weighs the lobe against the diffuse part.
        let weight = a.mean() * fresnel(0.5, ior);
        // 1 − cosθ ≈ tan²/2, so that the peak ends where B tan² = 2.
        let sampler = HalfTable::new((2.0 / b).sqrt(), k_d.mean(), |tan2| {
            weight * shape(b, c, tan2, (1.0 + tan2).sqrt().recip())
        });
        Ok(Self { k_d, a, b, c, ior, sampler })
    }

    /// The `material` of the table of fits at `path`.
    pub fn load(path: &Path, material: &str) -> Result<Self, SubjectError> {
        let csv = FitsCsv::read(path)?;
        Self::from_row(&csv, csv.find(material)?)
    }

    /// The material in one row of a table.
    pub(super) fn from_row(csv: &FitsCsv, row: &Row) -> Result<Self, SubjectError> {
        let number = |name: &str| csv.number(row, name);
        let (k_d, a) = (csv.colour(row, "kD")?, csv.colour(row, "A")?);
        Self::new(k_d, a, number("B")?, number("C")?, number("ior")?).map_err(|error| csv.error(row, error))
    }
}

/// (1 + B (1 − cosθ))^−C, with 1 − cosθ = sin²θ / (1 + cosθ).
fn shape(b: f64, c: f64, tan2: f64, cos: f64) -> f64 {
    let versine = tan2 * cos * cos / (1.0 + cos);
    (-c * (b * versine).ln_1p()).exp()
}

/// The Fresnel reflectance at a dielectric of relative index `ior` ≥ 1, in the form of Cook and Torrance.
fn fresnel(cos: f64, ior: f64) -> f64 {
    let g = ((ior - 1.0) * (ior + 1.0) + cos * cos).sqrt();
    // g − c = (ior² − 1) / (g + c): no cancellation at an index next to 1.
    let difference = (ior - 1.0) * (ior + 1.0) / (g + cos);
    let ratio = (cos * (g + cos) - 1.0) / (cos * difference + 1.0);
    (0.5 * (difference / (g + cos)).powi(2) * (1.0 + ratio * ratio)).min(1.0)
}

impl Bsdf for Abc {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let Some(h) = HalfVector::new(wo, wi) else { return Rgb::BLACK };
        let g = (2.0 * h.cos_h * wo.z.min(wi.z) / h.cos_d).min(1.0);
        let lobe = fresnel(h.cos_d, self.ior) * shape(self.b, self.c, h.tan2(), h.cos_h) * g / wo.z / wi.z / PI;
        self.k_d * FRAC_1_PI + (self.a * lobe).map(|f| f.min(1e200))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.sampler.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        self.sampler.sample(self, wo, u)
    }
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: "abc",
    summary: "power-law microfacets fitted to a measured material (Löw et al. 2012)",
    params: &[
        ParamSpec::new("file", Domain::Text, "CSV of fits: one material a row, columns kD_r … ior"),
        ParamSpec::new("material", Domain::Text, "the name of a row"),
    ],
    examples: &[],
    build: |args| Ok(Box::new(Abc::load(Path::new(args.text("file")?), args.text("material")?)?)),
};
