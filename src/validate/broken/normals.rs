//! Microfacets whose distribution of normals and masking do not belong together.

use glam::{DVec2, DVec3};

use crate::bsdf::microfacet::{GgxNormals, Normals};

/// Another distribution's normals, scaled, with a masking of one's own: what [`crate::bsdf::microfacet::Microfacet`]
/// makes of it is a model whose sampler is right and whose f is not.
#[derive(Clone, Copy, Debug)]
pub struct Unmatched<N> {
    /// Where D and the normals drawn are taken from.
    pub normals: N,
    /// What D is multiplied by.
    pub scale: f64,
    /// Λ of a slope width and a direction above the horizon.
    pub lambda: fn(f64, DVec3) -> f64,
}

impl<N: Normals> Normals for Unmatched<N> {
    fn d(&self, m: DVec3) -> f64 {
        self.scale * self.normals.d(m)
    }

    fn lambda(&self, w: DVec3) -> f64 {
        (self.lambda)(self.normals.slope_widths().x, w)
    }

    fn sample_all(&self, u: DVec2) -> DVec3 {
        self.normals.sample_all(u)
    }

    fn slope_widths(&self) -> DVec2 {
        self.normals.slope_widths()
    }

    fn model(&self) -> &'static str {
        self.normals.model()
    }
}

/// Λ = 0: the masking is left out.
pub fn no_masking(_: f64, _: DVec3) -> f64 {
    0.0
}

/// Walter's rational fit of Beckmann's Λ, up to 0.3 % off and with G1 = 1 where that of the distribution is below.
///
/// # References
/// - Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces, EGSR
pub fn rational_beckmann(alpha: f64, w: DVec3) -> f64 {
    let b = w.z / (alpha * w.x.hypot(w.y));
    if b < 1.6 { (1.0 - 1.259 * b + 0.396 * b * b) / (3.535 * b + 2.181 * b * b) } else { 0.0 }
}

/// The fit G1 = c / (c (1 − k) + k), k = (r + 1)² / 8, r = √α, which goes with no distribution.
///
/// # References
/// - Karis 2013, Real Shading in Unreal Engine 4, SIGGRAPH course notes
pub fn remapped_schlick(alpha: f64, w: DVec3) -> f64 {
    let k = (alpha.sqrt() + 1.0).powi(2) / 8.0;
    k * (1.0 / w.z - 1.0)
}

/// The masking that goes with GGX.
pub fn ggx_masking(alpha: f64, w: DVec3) -> f64 {
    GgxNormals::new(alpha, alpha).map_or(0.0, |normals| normals.lambda(w))
}

/// GGX masking of a surface half as rough again as that of D.
pub fn rougher_ggx(alpha: f64, w: DVec3) -> f64 {
    ggx_masking((1.5 * alpha).min(1.0), w)
}
