//! Microfacet models: a distribution of visible normals, Smith masking, Fresnel reflection.

use std::fmt;

use glam::{DVec2, DVec3};

/// A distribution of microfacet normals with its Smith masking function, in the local frame (n = +z).
pub trait Normals: fmt::Debug + Send + Sync {
    /// D(m) [1/sr], with ∫ D(m) m.z dm = 1 over the hemisphere; 0 for m.z ≤ 0.
    fn d(&self, m: DVec3) -> f64;

    /// Smith's Λ(w) ≥ 0 for w.z > 0, so that G1 = 1 / (1 + Λ).
    fn lambda(&self, w: DVec3) -> f64;

    /// The masking function G1(w) in [0, 1]; 0 for w.z ≤ 0. It is the share of normals seen from `w` that is not hidden.
    fn g1(&self, w: DVec3) -> f64 {
        if w.z > 0.0 { 1.0 / (1.0 + self.lambda(w)) } else { 0.0 }
    }

    /// Draws a normal with density D(m) m.z.
    fn sample_all(&self, u: DVec2) -> DVec3;
}
