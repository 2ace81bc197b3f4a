//! Beckmann normals, isotropic and anisotropic.
//!
//! D(m) = exp(−tan²) / (π αx αy cos⁴θ),  tan² = ((m.x/αx)² + (m.y/αy)²) / m.z²      [1/sr]
//! σ(w) = w.z (1 + erf b) / 2 + r exp(−b²) / (2 √π),   r = √(αx² w.x² + αy² w.y²),  b = w.z / r
//!
//! Slopes are Gaussian. In the stretched space, seen from v = (s, 0, c), the slope across the view is an independent
//! Gaussian and the slope x along it has the distribution function C(x) / C(b),
//!
//! C(x) = ∫ (c − t s) exp(−t²) / √π dt over t < x  = c erfc(−x) / 2 + s exp(−x²) / (2 √π),  x ≤ b = c / s,
//!
//! whose terms are all positive. It is inverted by safeguarded Halley steps to the last digits: no table, no fit.
//! # References
//! - Beckmann & Spizzichino 1963; Walter et al. 2007, EGSR (D as a distribution of microfacet normals)
//! - Heitz & d'Eon 2014, EGSR: importance sampling microfacet-based BSDFs using the distribution of visible normals

use std::f64::consts::{FRAC_1_PI, FRAC_2_SQRT_PI};

use glam::{DVec2, DVec3};
// statrs has erfc to 1e-11 only, but its inverse to the last digits.
use libm::erfc;
use statrs::function::erf::erfc_inv;

use super::{Stretched, turn, unit, unstretch};
use crate::math::special::sin_cos_turns;

/// 1 / (2 √π)
const HALF_FRAC_1_SQRT_PI: f64 = 0.25 * FRAC_2_SQRT_PI;
/// Beyond this many standard slopes lies less than 2⁻⁶⁰ of any of the distributions.
const LARGEST_SLOPE: f64 = 7.0;
/// The smallest and largest probability that is inverted: half a step inside of [0, 1).
const SMALLEST_U: f64 = f64::EPSILON / 4.0;

/// D(m) of Beckmann [1/sr], for `m` of any positive length (only its direction counts). 0 for m.z ≤ 0.
#[inline]
pub(crate) fn density(alpha: DVec2, m: DVec3) -> f64 {
    let (x, y, z2) = (m.x / alpha.x, m.y / alpha.y, m.z * m.z);
    let tan2 = (x * x + y * y) / z2;
    // exp(−745) is the smallest number there is; beyond, and for NaN of 0/0, 1/cos⁴ may overflow.
    if m.z > 0.0 && tan2 < 745.0 {
        let secant2 = 1.0 + (m.x * m.x + m.y * m.y) / z2;
        (-tan2).exp() * secant2 * secant2 * FRAC_1_PI / (alpha.x * alpha.y)
    } else {
        0.0
    }
}

/// σ(w), the projected area of the microsurface per area of the surface.
#[inline]
pub(crate) fn projected_area(alpha: DVec2, w: DVec3) -> f64 {
    let (x, y) = (alpha.x * w.x, alpha.y * w.y);
    cumulative(w.z, (x * x + y * y).sqrt(), f64::INFINITY)
}

/// C(x) for the direction (s, 0, c), of any length; C(b) = σ for x ≥ b.
#[inline]
fn cumulative(c: f64, s: f64, x: f64) -> f64 {
    // From here on exp(−x²) < 2⁻⁵³ is not seen in 1.
    const ALL: f64 = 6.1;
    let x = if x * s >= c { c / s } else { x };
    if x > ALL { c.max(0.0) } else { 0.5 * c * erfc(-x) + s * (-x * x).exp() * HALF_FRAC_1_SQRT_PI }
}

/// Maps the unit square to normals so that p(m) = D(m) m.z. `u` in [0, 1)²; `u.x` = 0 is the surface's own normal.
pub fn beckmann_normal(alpha: DVec2, u: DVec2) -> DVec3 {
    unit(normal(alpha, u))
}

/// [`beckmann_normal`], not of unit length.
pub(crate) fn normal(alpha: DVec2, u: DVec2) -> DVec3 {
    let (sin, cos) = sin_cos_turns(u.y);
    let tan = (-(-u.x).ln_1p()).sqrt();
    unstretch(DVec3::new(tan * cos, tan * sin, 1.0), alpha)
}

/// D(m) m.z [1/sr].
pub fn beckmann_normal_pdf(alpha: DVec2, m: DVec3) -> f64 {
    density(alpha, m) * m.z
}

/// The `u` that [`beckmann_normal`] maps to `m`.
pub fn beckmann_normal_inv(alpha: DVec2, m: DVec3) -> DVec2 {
    let (x, y) = (m.x / alpha.x, m.y / alpha.y);
    DVec2::new((-(-(x * x + y * y) / (m.z * m.z)).exp_m1()).min(1.0 - f64::EPSILON / 2.0), turn(y, x))
}

/// Maps the unit square to the normals that `wo` sees. `u` in [0, 1)²: `u.x` gives the slope along the view, the
/// steepest facets towards `wo` first, and `u.y` the slope across it.
pub fn beckmann_visible(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    unit(visible(wo, alpha, u))
}

/// [`beckmann_visible`], not of unit length.
pub(crate) fn visible(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    let Stretched { v, rise: s, azimuth } = Stretched::new(wo, alpha);
    let along = slope_along(v.z, s, u.x);
    let across = gaussian_slope(u.y);
    // The facet with slopes (x, y) has the normal (−x, −y, 1).
    let x = azimuth.x * along - azimuth.y * across;
    let y = azimuth.y * along + azimuth.x * across;
    unstretch(DVec3::new(-x, -y, 1.0), alpha)
}

/// max(wo·m, 0) D(m) / σ(wo) [1/sr].
pub fn beckmann_visible_pdf(wo: DVec3, alpha: DVec2, m: DVec3) -> f64 {
    density(alpha, m) * wo.dot(m).max(0.0) / projected_area(alpha, wo)
}

/// The `u` that [`beckmann_visible`] maps to `m`.
pub fn beckmann_visible_inv(wo: DVec3, alpha: DVec2, m: DVec3) -> DVec2 {
    let Stretched { v, rise: s, azimuth } = Stretched::new(wo, alpha);
    let (x, y) = (-m.x / (alpha.x * m.z), -m.y / (alpha.y * m.z));
    let (along, across) = (azimuth.x * x + azimuth.y * y, azimuth.x * y - azimuth.y * x);
    let u_x = cumulative(v.z, s, along) / cumulative(v.z, s, f64::INFINITY);
    DVec2::new(u_x, 0.5 * erfc(-across)).min(DVec2::splat(1.0 - f64::EPSILON / 2.0))
}

/// The y with erfc(−y) / 2 = u.
fn gaussian_slope(u: f64) -> f64 {
    // 1 − u is exact for the upper half.
    let (tail, sign) = if u < 0.5 { (u, -1.0) } else { (1.0 - u, 1.0) };
    sign * erfc_inv(2.0 * tail.max(SMALLEST_U))
}

/// The x with C(x) = u C(b), for the unit direction (s, 0, c).
///
/// Below the middle, Halley's method (Newton's with the second derivative) runs on h = ln C, which is concave; above, on
/// h = √(C(b) − C), nearly straight up to the end at b where C itself is flat. Steps that leave the bracket halve it.
fn slope_along(c: f64, s: f64, u: f64) -> f64 {
    /// Enough to halve the first bracket, 14 wide, down to neighbouring numbers.
    const MAX_STEPS: u32 = 64;
    /// The error after a step is of the order of its third power: after one of this size, no digit is left to gain.
    const LAST_STEP: f64 = 2e-6;
    let whole = cumulative(c, s, f64::INFINITY);
    let u = u.max(SMALLEST_U);
    let (target, rest) = (u * whole, ((1.0 - u) * whole).sqrt());
    let (mut low, mut high) = (-LARGEST_SLOPE, if LARGEST_SLOPE * s >= c { c / s } else { LARGEST_SLOPE });
    let mut x = high.min(1.0) - 0.75;
    for _ in 0..MAX_STEPS {
        let gauss = (-x * x).exp() * (0.5 * FRAC_2_SQRT_PI);
        let value = 0.5 * (c * erfc(-x) + s * gauss);
        if value < target {
            low = x;
        } else {
            high = x;
        }
        // C' and C''.
        let (d1, d2) = ((c - x * s) * gauss, -(s + 2.0 * x * (c - x * s)) * gauss);
        let (h, h1, h2) = if u < 0.5 {
            let slope = d1 / value;
            ((value / target).ln(), slope, d2 / value - slope * slope)
        } else {
            let left = (whole - value).max(0.0).sqrt();
            let slope = -0.5 * d1 / left;
            (left - rest, slope, -(0.5 * d2 + slope * slope) / left)
        };
        let halley = x - 2.0 * h * h1 / (2.0 * h1 * h1 - h * h2);
        // Also catches the NaN and infinities of a flat end.
        let inside = low < halley && halley < high;
        let next = if inside { halley } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        if step <= if inside { LAST_STEP } else { f64::EPSILON } {
            return next;
        }
        x = next;
    }
    x
}
