//! Beckmann normals: Gaussian slopes, as of a surface whose height is a Gaussian random field.
//!
//! D(m) = exp(−tan²) / (π αx αy cos⁴θ),  tan² = ((m.x/αx)² + (m.y/αy)²) / m.z²      [1/sr]
//! Λ(w) = (erf b − 1) / 2 + exp(−b²) / (2 b √π),  b = w.z / √(αx² w.x² + αy² w.y²)
//!
//! `alpha` in [1e-4, 1] is √2 times the standard deviation of the slopes. Λ is the exact form: the rational fit in wide
//! use is off by 0.3 % and lets G1 exceed 1.
//! # References
//! - Beckmann & Spizzichino 1963; Smith 1967, IEEE TAP 15(5) (masking of a Gaussian surface)
//! - Walter et al. 2007, EGSR (D and Λ, and the rational fit); Heitz 2014, JCGT 3(2) (anisotropic b)

use std::f64::consts::FRAC_2_SQRT_PI;

use glam::{DVec2, DVec3};
use libm::erfc;

use super::{ALPHA, Microfacet, Normals, Sampling, entry};
use crate::bsdf::ParamError;
use crate::bsdf::catalog::{Entry, Example};
use crate::sampling::visible_normals::beckmann;

const MODEL: &str = "beckmann";

/// The Beckmann distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeckmannNormals {
    alpha: DVec2,
}

impl BeckmannNormals {
    /// Slope widths along x and y, each in [1e-4, 1].
    pub fn new(alpha_x: f64, alpha_y: f64) -> Result<Self, ParamError> {
        let x = ALPHA.check(MODEL, "alpha_x", alpha_x)?;
        Ok(Self { alpha: DVec2::new(x, ALPHA.check(MODEL, "alpha_y", alpha_y)?) })
    }
}

/// Λ as a function of b > 0, to full relative precision.
fn lambda_of(b: f64) -> f64 {
    let gauss = (-b * b).exp() * (0.25 * FRAC_2_SQRT_PI);
    if b < 1.0 {
        // The positive term is at least 1.3 times the negative one: two binary digits are lost at most.
        return gauss / b - 0.5 * erfc(b);
    }
    // √π exp(b²) erfc(b) = 1/(b + t), t = (1/2)/(b + 1/(b + (3/2)/(b + …))): the two terms differ by
    // exp(−b²) t / (2 √π b (b + t)). The depth gives 16 digits (found by 40-digit arithmetic).
    let depth = 16 + (200.0 / (b * b)) as u32;
    let t = (1..=depth).rev().fold(0.0, |t, k| 0.5 * f64::from(k) / (b + t));
    gauss * t / (b * (b + t))
}

impl Normals for BeckmannNormals {
    #[inline]
    fn d(&self, m: DVec3) -> f64 {
        beckmann::density(self.alpha, m)
    }

    fn lambda(&self, w: DVec3) -> f64 {
        let (x, y) = (self.alpha.x * w.x, self.alpha.y * w.y);
        lambda_of(w.z / (x * x + y * y).sqrt())
    }

    #[inline]
    fn projected_area(&self, w: DVec3) -> f64 {
        beckmann::projected_area(self.alpha, w)
    }

    fn sample_all(&self, u: DVec2) -> DVec3 {
        beckmann::normal(self.alpha, u)
    }

    #[inline]
    fn sample(&self, by: Sampling, wo: DVec3, u: DVec2) -> DVec3 {
        match by {
            Sampling::Visible | Sampling::Caps => beckmann::visible(wo, self.alpha, u),
            Sampling::Ndf => beckmann::normal(self.alpha, u),
        }
    }

    fn samplings(&self) -> &'static [Sampling] {
        &[Sampling::Visible, Sampling::Ndf]
    }

    fn slope_widths(&self) -> DVec2 {
        self.alpha
    }

    fn model(&self) -> &'static str {
        MODEL
    }
}

/// The microfacet model with Beckmann normals.
pub type Beckmann = Microfacet<BeckmannNormals>;

impl Beckmann {
    /// Slope width `alpha` in [1e-4, 1] in all directions.
    pub fn new(alpha: f64) -> Result<Self, ParamError> {
        let alpha = ALPHA.check(MODEL, "alpha", alpha)?;
        Self::anisotropic(alpha, alpha)
    }

    /// Slope widths along x and y, each in [1e-4, 1].
    pub fn anisotropic(alpha_x: f64, alpha_y: f64) -> Result<Self, ParamError> {
        Ok(Self::from_normals(BeckmannNormals::new(alpha_x, alpha_y)?))
    }
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: MODEL,
    summary: "microfacets with Beckmann normals (Gaussian slopes), f = F D G2 / (4 wo.z wi.z)",
    params: &[
        entry::ALPHA_BOTH,
        entry::ALPHA_X,
        entry::ALPHA_Y,
        entry::G,
        entry::F0,
        entry::ETA,
        entry::K,
        entry::COMPENSATION,
        entry::sampling(&["visible", "ndf"]),
    ],
    examples: &[
        Example::lawful("beckmann:alpha=0.3"),
        Example::lawful("beckmann:alpha=1"),
        Example::lawful("beckmann:alpha=0.0001"),
        Example::lawful("beckmann:alpha=0.5,g=separable"),
        Example::lawful("beckmann:alpha=0.3,sampling=ndf"),
        Example::lawful("beckmann:alpha_x=0.1,alpha_y=0.5"),
        Example::lawful("beckmann:alpha=0.2,eta=1.5"),
        Example::lawful("beckmann:alpha=0.8,compensation=kulla-conty"),
        Example::breaking("beckmann:alpha=0.8,compensation=turquin", &["reciprocity", "energy_light"]),
    ],
    build: |args| entry::build(args, Beckmann::anisotropic(entry::alphas(args)?.x, entry::alphas(args)?.y)?),
};
