//! Blinn normals: a power of the cosine.
//!
//! D(m) = (n + 2) / (2π) cosⁿθ      [1/sr]
//! σ(w) = cosθ (1 − I/2) + B sinⁿθ / (2π),  Λ = σ / cosθ − 1 = B sinⁿθ / (2π cosθ) − I/2
//!
//! with I = I_{sin²θ}(n/2, 1/2) the regularised incomplete beta function and B = √π Γ((n+1)/2) / Γ(n/2+1): σ is the
//! integral of (n + 2)/(2π) (m.z)ⁿ max(w·m, 0), a Phong lobe seen from a plane tilted by θ, which has this closed form
//! for every real n. So masking is Smith's own and not one borrowed from Beckmann.
//!
//! `n` in (0, 10⁷]. For large n it is Beckmann's distribution with α² = 2 / (n + 2).
//! # References
//! - Blinn 1977, SIGGRAPH; Walter et al. 2007, EGSR (this normalisation, ∫ D cosθ = 1)
//! - Arvo 1995, SIGGRAPH: applications of irradiance tensors (integrals of cosine powers over half spaces)

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Microfacet, Normals, entry};
use crate::bsdf::catalog::{Entry, Example};
use crate::bsdf::subject::ParamSpec;
use crate::bsdf::{Domain, ParamError};
use crate::math::special::{inc_beta_half, sin_cos_turns, wallis};

const MODEL: &str = "blinn";
/// Below 1e-3 the lobe is uniform to a thousandth, above 1e7 it is narrower than any α of the other models.
const N: Domain = Domain::Closed(1e-3, 1e7);

/// The Blinn distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlinnNormals {
    n: f64,
    /// B / 2π
    grazing: f64,
}

impl BlinnNormals {
    /// Exponent `n` in [1e-3, 1e7].
    pub fn new(n: f64) -> Result<Self, ParamError> {
        let n = N.check(MODEL, "n", n)?;
        Ok(Self { n, grazing: wallis(n) / TAU })
    }

    /// cosⁿ of the angle whose squared sine is `sin2` and squared cosine `cos2`, up to a common factor.
    fn power(&self, sin2: f64, cos2: f64) -> f64 {
        (-0.5 * self.n * (sin2 / cos2).ln_1p()).exp()
    }
}

impl Normals for BlinnNormals {
    fn d(&self, m: DVec3) -> f64 {
        let cos2 = m.z * m.z;
        if m.z > 0.0 && cos2 > 0.0 { (self.n + 2.0) / TAU * self.power(m.x * m.x + m.y * m.y, cos2) } else { 0.0 }
    }

    fn lambda(&self, w: DVec3) -> f64 {
        (self.projected_area(w) / w.z - 1.0).max(0.0)
    }

    fn projected_area(&self, w: DVec3) -> f64 {
        let (sin2, cos2) = (w.x * w.x + w.y * w.y, w.z * w.z);
        if sin2 <= 0.0 {
            return w.z;
        }
        // Both terms are positive: I ≤ 1.
        let inner = inc_beta_half(0.5 * self.n, sin2, cos2);
        w.z * (1.0 - 0.5 * inner) + self.grazing * self.power(cos2, sin2)
    }

    fn sample_all(&self, u: DVec2) -> DVec3 {
        let (sin, cos) = sin_cos_turns(u.y);
        // cosθ = (1 − u)^(1/(n+2)), and tan²θ = 1/cos²θ − 1 without its cancellation.
        let log_cos = (-u.x).ln_1p() / (self.n + 2.0);
        let (z, tan) = (log_cos.exp(), (-2.0 * log_cos).exp_m1().sqrt());
        DVec3::new(z * tan * cos, z * tan * sin, z)
    }

    fn slope_widths(&self) -> DVec2 {
        DVec2::splat((2.0 / (self.n + 2.0)).sqrt())
    }

    fn model(&self) -> &'static str {
        MODEL
    }
}

/// The microfacet model with Blinn normals.
pub type Blinn = Microfacet<BlinnNormals>;

impl Blinn {
    /// Exponent `n` in [1e-3, 1e7].
    pub fn new(n: f64) -> Result<Self, ParamError> {
        Ok(Self::from_normals(BlinnNormals::new(n)?))
    }
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: MODEL,
    summary: "microfacets with Blinn normals, D = (n + 2)/2π cosⁿ, and their own Smith masking",
    params: &[
        ParamSpec::new("n", N, "exponent of the cosine"),
        entry::G,
        entry::F0,
        entry::ETA,
        entry::K,
        entry::COMPENSATION,
        entry::sampling(&["ndf"]),
    ],
    examples: &[
        Example::lawful("blinn:n=50"),
        Example::lawful("blinn:n=2"),
        Example::lawful("blinn:n=1000000"),
        Example::lawful("blinn:n=10,g=separable,eta=1.5"),
        Example::lawful("blinn:n=5,compensation=kulla-conty"),
    ],
    build: |args| entry::build(args, Blinn::new(args.number("n")?)?),
};
