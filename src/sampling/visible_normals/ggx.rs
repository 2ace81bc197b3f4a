//! GGX (Trowbridge-Reitz) normals, isotropic and anisotropic.
//!
//! D(m) = 1 / (π αx αy q²),  q = (m.x/αx)² + (m.y/αy)² + m.z²      [1/sr]
//! σ(w) = (w.z + s) / 2,     s = √(αx² w.x² + αy² w.y² + w.z²)
//!
//! In the stretched space the microsurface is a sphere, of which the direction v sees the half disk above v plus the
//! half ellipse below, squeezed by v.z.
//! # References
//! - Walter et al. 2007, EGSR (the distribution); Heitz 2018, JCGT 7(4) (visible normals by half disks)
//! - Dupuy & Benyoub 2023, Computer Graphics Forum 42(8) (visible normals by spherical caps)

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::{Stretched, turn, unit, unstretch};
use crate::math::special::sin_cos_turns;

/// D(m) of GGX [1/sr], for `m` of any positive length (only its direction counts). 0 for m.z ≤ 0.
///
/// From components, not from 1 − cos²θ: full relative precision at α = 1e-4.
#[inline]
pub(crate) fn density(alpha: DVec2, m: DVec3) -> f64 {
    // Everything times (αx αy)²: one division is enough.
    let area = alpha.x * alpha.y;
    let (x, y, z2) = (m.x * alpha.y, m.y * alpha.x, m.z * m.z);
    let q = x * x + y * y + z2 * (area * area);
    let length2 = m.x * m.x + m.y * m.y + z2;
    // The second condition holds but for directions so short that their squares underflow.
    if m.z > 0.0 && q > 1e-150 { length2 * length2 * (area * area * area * FRAC_1_PI) / (q * q) } else { 0.0 }
}

/// σ(w), the projected area of the microsurface per area of the surface.
#[inline]
pub(crate) fn projected_area(alpha: DVec2, w: DVec3) -> f64 {
    let (x, y) = (alpha.x * w.x, alpha.y * w.y);
    0.5 * (w.z + (x * x + y * y + w.z * w.z).sqrt())
}

/// Maps the unit square to normals so that p(m) = D(m) m.z. `u` in [0, 1)²; `u.x` = 0 is the surface's own normal.
pub fn ggx_normal(alpha: DVec2, u: DVec2) -> DVec3 {
    unit(normal(alpha, u))
}

/// [`ggx_normal`], not of unit length.
#[inline]
pub(crate) fn normal(alpha: DVec2, u: DVec2) -> DVec3 {
    let (sin, cos) = sin_cos_turns(u.y);
    // The square root of 1 − u.x belongs to z: tan²θ = u.x / (1 − u.x) in the stretched space.
    let r = u.x.sqrt();
    unstretch(DVec3::new(r * cos, r * sin, (1.0 - u.x).sqrt()), alpha)
}

/// D(m) m.z [1/sr].
pub fn ggx_normal_pdf(alpha: DVec2, m: DVec3) -> f64 {
    density(alpha, m) * m.z
}

/// The `u` that [`ggx_normal`] maps to `m`.
pub fn ggx_normal_inv(alpha: DVec2, m: DVec3) -> DVec2 {
    let (x, y) = (m.x / alpha.x, m.y / alpha.y);
    let r2 = x * x + y * y;
    DVec2::new(r2 / (r2 + m.z * m.z), turn(y, x))
}

/// Maps the unit square to the normals that `wo` sees, by Heitz's half disks. `u` in [0, 1)².
///
/// `u.x` = 0 is the normal that faces `wo` in the stretched space.
pub fn ggx_visible(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    unit(visible(wo, alpha, u))
}

/// [`ggx_visible`], not of unit length.
#[inline]
pub(crate) fn visible(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    let Stretched { v, rise, azimuth } = Stretched::new(wo, alpha);
    let (sin, cos) = sin_cos_turns(u.y);
    let r = u.x.sqrt();
    let (t1, y) = (r * cos, r * sin);
    // √(1 − t1²), without waiting for r.
    let q = (1.0 - u.x * (cos * cos)).sqrt();
    let s = 0.5 * (1.0 + v.z);
    let t2 = (1.0 - s) * q + s * y;
    // √(q² − t2²), factored so that nothing cancels at the rim.
    let depth = (s * (q - y) * ((2.0 - s) * q + s * y)).max(0.0).sqrt();
    // The basis of the disk: (−sinφ, cosφ, 0) and its cross product with v, which ascends.
    let side = depth * rise - t2 * v.z;
    let (x, y) = (side * azimuth.x - t1 * azimuth.y, side * azimuth.y + t1 * azimuth.x);
    unstretch(DVec3::new(x, y, (t2 * rise + depth * v.z).max(0.0)), alpha)
}

/// max(wo·m, 0) D(m) / σ(wo) [1/sr].
pub fn ggx_visible_pdf(wo: DVec3, alpha: DVec2, m: DVec3) -> f64 {
    density(alpha, m) * wo.dot(m).max(0.0) / projected_area(alpha, wo)
}

/// The `u` that [`ggx_visible`] maps to `m`.
pub fn ggx_visible_inv(wo: DVec3, alpha: DVec2, m: DVec3) -> DVec2 {
    let Stretched { v, rise, azimuth } = Stretched::new(wo, alpha);
    let n = DVec3::new(m.x / alpha.x, m.y / alpha.y, m.z).normalize_or(DVec3::Z);
    let t1 = n.y * azimuth.x - n.x * azimuth.y;
    let t2 = n.z * rise - (n.x * azimuth.x + n.y * azimuth.y) * v.z;
    let q = ((1.0 - t1) * (1.0 + t1)).max(0.0).sqrt();
    let s = 0.5 * (1.0 + v.z);
    let y = (t2 - (1.0 - s) * q) / s;
    DVec2::new((t1 * t1 + y * y).min(1.0 - f64::EPSILON / 2.0), turn(y, t1))
}

/// Maps the unit square to the normals that `wo` sees, by spherical caps: mirror directions of the stretched `wo` are
/// uniform on the sphere above −v.z. `u` in [0, 1)²; `u.y` = 0 is the cap's pole, where the mirror direction is +z.
pub fn ggx_caps(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    unit(caps(wo, alpha, u))
}

/// [`ggx_caps`], not of unit length.
#[inline]
pub(crate) fn caps(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    let v = DVec3::new(alpha.x * wo.x, alpha.y * wo.y, wo.z);
    let v = v * (1.0 / v.length());
    let (sin, cos) = sin_cos_turns(u.x);
    // The mirror direction c has c.z = 1 − h with h = u.y (1 + v.z), hence sin² = h (2 − h), and c.z + v.z without the
    // cancellation next to −v.z.
    let k = 1.0 + v.z;
    let h = u.y * k;
    let r = (h * (2.0 - h)).sqrt();
    unstretch(DVec3::new(r * cos + v.x, r * sin + v.y, k * (1.0 - u.y)), alpha)
}

/// max(wo·m, 0) D(m) / σ(wo) [1/sr]: that of [`ggx_visible_pdf`].
pub fn ggx_caps_pdf(wo: DVec3, alpha: DVec2, m: DVec3) -> f64 {
    ggx_visible_pdf(wo, alpha, m)
}

/// The `u` that [`ggx_caps`] maps to `m`.
pub fn ggx_caps_inv(wo: DVec3, alpha: DVec2, m: DVec3) -> DVec2 {
    let Stretched { v, .. } = Stretched::new(wo, alpha);
    let n = DVec3::new(m.x / alpha.x, m.y / alpha.y, m.z).normalize_or(DVec3::Z);
    let sum = 2.0 * v.dot(n) * n;
    let u_y = 1.0 - sum.z / (1.0 + v.z);
    DVec2::new(turn(sum.y - v.y, sum.x - v.x), u_y.clamp(0.0, 1.0 - f64::EPSILON / 2.0))
}
