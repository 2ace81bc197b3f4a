//! GGX (Trowbridge-Reitz) normals: a sharp peak with long tails.
//!
//! D(m) = 1 / (π αx αy q²),  q = (m.x/αx)² + (m.y/αy)² + m.z²      [1/sr]
//! Λ(w) = (√(1 + a²) − 1) / 2,  a² = (αx² w.x² + αy² w.y²) / w.z²
//!
//! `alpha` in [1e-4, 1] is the width of the distribution of slopes, *not* an artist's roughness; nothing squares it.
//! For α = 1 and F = 1 everything is elementary: correlated f = 1 / (2π (wo.z + wi.z)).
//! # References
//! - Trowbridge & Reitz 1975, JOSA 65; Walter et al. 2007, EGSR; Heitz 2014, JCGT 3(2) (anisotropic Λ)

use glam::{DVec2, DVec3};

use super::{ALPHA, Microfacet, Normals, Sampling, entry};
use crate::bsdf::ParamError;
use crate::bsdf::catalog::{Entry, Example};
use crate::sampling::visible_normals::ggx;

const MODEL: &str = "ggx";

/// The GGX distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxNormals {
    alpha: DVec2,
}

impl GgxNormals {
    /// Slope widths along x and y, each in [1e-4, 1].
    pub fn new(alpha_x: f64, alpha_y: f64) -> Result<Self, ParamError> {
        let x = ALPHA.check(MODEL, "alpha_x", alpha_x)?;
        Ok(Self { alpha: DVec2::new(x, ALPHA.check(MODEL, "alpha_y", alpha_y)?) })
    }
}

impl Normals for GgxNormals {
    #[inline]
    fn d(&self, m: DVec3) -> f64 {
        ggx::density(self.alpha, m)
    }

    fn lambda(&self, w: DVec3) -> f64 {
        let (x, y) = (self.alpha.x * w.x / w.z, self.alpha.y * w.y / w.z);
        let a2 = x * x + y * y;
        // (√(1 + a²) − 1)/2 without the cancellation; infinite at the horizon.
        if a2.is_finite() { 0.5 * a2 / (1.0 + (1.0 + a2).sqrt()) } else { f64::INFINITY }
    }

    #[inline]
    fn projected_area(&self, w: DVec3) -> f64 {
        ggx::projected_area(self.alpha, w)
    }

    fn sample_all(&self, u: DVec2) -> DVec3 {
        ggx::normal(self.alpha, u)
    }

    #[allow(
        clippy::inline_always,
        reason = "a third of the time of a draw by caps: σ(wo) is shared, and no vector passes through memory"
    )]
    #[inline(always)]
    fn sample(&self, by: Sampling, wo: DVec3, u: DVec2) -> DVec3 {
        match by {
            Sampling::Visible => ggx::visible(wo, self.alpha, u),
            Sampling::Caps => ggx::caps(wo, self.alpha, u),
            Sampling::Ndf => ggx::normal(self.alpha, u),
        }
    }

    fn samplings(&self) -> &'static [Sampling] {
        // Caps take two square roots and no frame, disks five: a third less time for the same distribution.
        &[Sampling::Caps, Sampling::Visible, Sampling::Ndf]
    }

    fn slope_widths(&self) -> DVec2 {
        self.alpha
    }

    fn model(&self) -> &'static str {
        MODEL
    }
}

/// The microfacet model with GGX normals.
pub type Ggx = Microfacet<GgxNormals>;

impl Ggx {
    /// Slope width `alpha` in [1e-4, 1] in all directions.
    pub fn new(alpha: f64) -> Result<Self, ParamError> {
        let alpha = ALPHA.check(MODEL, "alpha", alpha)?;
        Self::anisotropic(alpha, alpha)
    }

    /// Slope widths along x and y, each in [1e-4, 1].
    pub fn anisotropic(alpha_x: f64, alpha_y: f64) -> Result<Self, ParamError> {
        Ok(Self::from_normals(GgxNormals::new(alpha_x, alpha_y)?))
    }
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: MODEL,
    summary: "microfacets with GGX normals, f = F D G2 / (4 wo.z wi.z)",
    params: &[
        entry::ALPHA_BOTH,
        entry::ALPHA_X,
        entry::ALPHA_Y,
        entry::G,
        entry::F0,
        entry::ETA,
        entry::K,
        entry::COMPENSATION,
        entry::sampling(&["caps", "visible", "ndf"]),
    ],
    examples: &[
        Example::lawful("ggx:alpha=0.3"),
        Example::lawful("ggx:alpha=0.1"),
        Example::lawful("ggx:alpha=1"),
        Example::lawful("ggx:alpha=0.0001"),
        Example::lawful("ggx:alpha=0.5,g=separable"),
        Example::lawful("ggx:alpha=0.3,sampling=visible"),
        Example::lawful("ggx:alpha=0.3,sampling=ndf"),
        Example::lawful("ggx:alpha_x=0.25,alpha_y=0.5"),
        Example::lawful("ggx:alpha_x=0.02,alpha_y=0.6,sampling=visible"),
        Example::lawful("ggx:alpha=0.2,f0=0.9/0.6/0.2"),
        Example::lawful("ggx:alpha=0.2,eta=1.5"),
        Example::lawful("ggx:alpha=0.2,eta=0.1431/0.3749/1.4424,k=3.9831/2.3857/1.6032"),
        Example::lawful("ggx:alpha=0.6,compensation=kulla-conty"),
        Example::lawful("ggx:alpha=0.4,f0=0.9/0.6/0.2,compensation=kulla-conty"),
        Example::breaking("ggx:alpha=0.5,compensation=turquin", &["reciprocity", "energy_light"]),
    ],
    build: |args| entry::build(args, Ggx::anisotropic(entry::alphas(args)?.x, entry::alphas(args)?.y)?),
};
