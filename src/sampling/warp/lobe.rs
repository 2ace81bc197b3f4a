//! Cosine-power lobes: about the normal, and about any axis (the Phong lobe about the mirror direction).
//!
//! cosⁿ with n up to 10⁶ and beyond is taken from 1 − cos (or sin²), never from the cosine, which next to the axis has
//! no digits left for it.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{cylindrical, turn};
use crate::math::special::inc_beta_half;
use crate::math::sphere::basis;

/// cosⁿ of the angle between `w` and +z; 0 from the horizon down. `n` ≥ 0.
pub fn cosine_power(w: DVec3, n: f64) -> f64 {
    if w.z > 0.0 { (n * ln_cosine(w)).exp() } else { 0.0 }
}

/// ln cosθ of a direction above the horizon, to full relative precision also next to the pole.
fn ln_cosine(w: DVec3) -> f64 {
    let s2 = w.x * w.x + w.y * w.y;
    if s2 < 0.5 { 0.5 * (-s2).ln_1p() } else { w.z.ln() }
}

/// max(0, w·axis)ⁿ for unit vectors and `n` ≥ 0, symmetric in its two vectors.
pub fn lobe_power(w: DVec3, axis: DVec3, n: f64) -> f64 {
    let below = below_axis(w, axis);
    if below < 1.0 { (n * (-below).ln_1p()).exp() } else { 0.0 }
}

/// 1 − w·axis = |w − axis|² / 2 of unit vectors: an error of their lengths enters only squared.
fn below_axis(w: DVec3, axis: DVec3) -> f64 {
    0.5 * (w - axis).length_squared()
}

/// Maps the unit square to the hemisphere so that p(w) = (n+1)/2π cosⁿθ, for `n` ≥ 0.
///
/// `u` in [0, 1)². The pole is `u.x = 0`. Inverse: [`power_cosine_inv`].
pub fn power_cosine(u: DVec2, n: f64) -> DVec3 {
    let ln_z = (-u.x).ln_1p() / (n + 1.0);
    let z = ln_z.exp();
    cylindrical((-ln_z.exp_m1() * (1.0 + z)).sqrt(), z, u.y)
}

/// (n+1)/2π cosⁿθ [1/sr] above the horizon, 0 below.
pub fn power_cosine_pdf(w: DVec3, n: f64) -> f64 {
    (n + 1.0) / TAU * cosine_power(w, n)
}

/// The `u` that [`power_cosine`] maps to `w`.
pub fn power_cosine_inv(w: DVec3, n: f64) -> DVec2 {
    DVec2::new(-((n + 1.0) * ln_cosine(w)).exp_m1(), turn(w.x, w.y))
}

/// Maps the unit square to the half space about the unit vector `axis` so that p(w) = (n+1)/2π max(0, w·axis)ⁿ.
///
/// `u` in [0, 1)². The axis is `u.x = 0`. A share of [`phong_lobe_above`] lies above the horizon of +z; the map knows
/// nothing of it, and the caller counts the rest as lost draws. Inverse: [`phong_lobe_inv`].
/// # References
/// - Lafortune & Willems 1994, Using the modified Phong reflectance model for physically based rendering
pub fn phong_lobe(u: DVec2, n: f64, axis: DVec3) -> DVec3 {
    let local = power_cosine(u, n);
    let (s, t) = basis(axis);
    s * local.x + t * local.y + axis * local.z
}

/// (n+1)/2π max(0, w·axis)ⁿ [1/sr], on the whole sphere.
pub fn phong_lobe_pdf(w: DVec3, n: f64, axis: DVec3) -> f64 {
    (n + 1.0) / TAU * lobe_power(w, axis, n)
}

/// The `u` that [`phong_lobe`] maps to `w`.
///
/// In a lobe of width n^(−1/2) a direction's roundings are √n times larger: errors ≤ 1e-15 √n (√(n / u.x) for `u.y`).
pub fn phong_lobe_inv(w: DVec3, n: f64, axis: DVec3) -> DVec2 {
    let (s, t) = basis(axis);
    let below = below_axis(w, axis).min(1.0);
    DVec2::new(-((n + 1.0) * (-below).ln_1p()).exp_m1(), turn(w.dot(s), w.dot(t)))
}

/// The share of the lobe's density above the horizon: 1 − ½ I_{sin²θ}((n+1)/2, 1/2) for an axis at θ ≤ 90° from +z.
///
/// 1/2 at θ = 90° for every n.
pub fn phong_lobe_above(n: f64, axis: DVec3) -> f64 {
    let half = 0.5 * inc_beta_half(0.5 * (n + 1.0), axis.x * axis.x + axis.y * axis.y, axis.z * axis.z);
    if axis.z >= 0.0 { 1.0 - half } else { half }
}

#[cfg(test)]
mod tests {
    use super::super::law::{density_is_the_jacobian, inverse_returns, square};
    use super::*;
    use crate::math::sphere::direction;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    #[test]
    fn share_above_the_horizon() {
        let at = |degrees: f64| direction(degrees.to_radians(), 0.4);
        assert_abs_diff_eq!(phong_lobe_above(10.0, at(60.0)), 0.959067884417, epsilon = 1e-12);
        assert_abs_diff_eq!(phong_lobe_above(1.0, at(60.0)), 0.75, epsilon = 1e-15);
        for n in [0.0, 1.0, 1e3, 1e6] {
            assert_abs_diff_eq!(phong_lobe_above(n, DVec3::X), 0.5, epsilon = 1e-15);
            assert_eq!(phong_lobe_above(n, DVec3::Z), 1.0);
        }
    }

    #[test]
    fn the_share_above_is_what_the_map_gives() {
        const SIDE: u32 = 1000;
        let (n, axis) = (10.0, direction(1.2, 0.0));
        let cells = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (f64::from(i), f64::from(j))));
        let above =
            cells.filter(|&(i, j)| phong_lobe(DVec2::new(i + 0.5, j + 0.5) / f64::from(SIDE), n, axis).z > 0.0).count();
        // Cells cut by the horizon, some 3 · SIDE of SIDE², err by chance: SIDE^−1.5 times a small factor.
        assert_abs_diff_eq!(above as f64 / f64::from(SIDE * SIDE), phong_lobe_above(n, axis), epsilon = 2e-4);
    }

    proptest! {
        #[test]
        fn densities_are_jacobians(u in square(), log_n in -1.0..3.0_f64, theta in 0.0..1.5_f64) {
            let (n, axis) = (10_f64.powf(log_n), direction(theta, 0.7));
            density_is_the_jacobian(u, |u| power_cosine(u, n), power_cosine_pdf(power_cosine(u, n), n))?;
            let lobe = |u| phong_lobe(u, n, axis);
            density_is_the_jacobian(u, lobe, phong_lobe_pdf(lobe(u), n, axis))?;
            // The densities of two close exponents cross at u.x = 1 − 1/e.
            prop_assume!((u.x - 0.632).abs() > 0.01);
            prop_assert!(density_is_the_jacobian(u, lobe, phong_lobe_pdf(lobe(u), n + 0.01 * (n + 1.0), axis)).is_err());
        }

        #[test]
        fn inverses(x in 1e-4..0.9999_f64, y in 0.0..1.0_f64, log_n in -1.0..6.0_f64, theta in 0.0..1.5_f64) {
            let (u, n, axis) = (DVec2::new(x, y), 10_f64.powf(log_n), direction(theta, 0.7));
            let (w, l) = (power_cosine(u, n), phong_lobe(u, n, axis));
            inverse_returns(u, w, power_cosine_inv(w, n), 4e-15)?;
            let tol = 1e-15 * (1.0 + (n / x).sqrt());
            let back = phong_lobe_inv(l, n, axis);
            // The seam at u.y = 0 may be crossed by a rounding.
            let seam = DVec2::new(back.x - x, (back.y - y + 0.5).rem_euclid(1.0) - 0.5);
            prop_assert!(seam.abs().max_element() <= tol, "{back} against {u}, n = {n}");
        }

        #[test]
        fn powers_are_powers(n in 0.0..50.0_f64, theta in 0.01..1.55_f64) {
            let w = direction(theta, 2.0);
            let plain = theta.cos().powf(n);
            prop_assert!((cosine_power(w, n) - plain).abs() <= 1e-14);
            prop_assert!((lobe_power(w, DVec3::Z, n) - plain).abs() <= 1e-14);
        }
    }

    #[test]
    fn a_power_of_a_million_keeps_its_digits() {
        let (theta, n): (f64, f64) = (1e-3, 1e6);
        // cosⁿθ = exp(n ln cosθ), ln cosθ = −θ²/2 − θ⁴/12 − …: the next term is 2e-14.
        let expected = (-n * (theta * theta / 2.0 + theta.powi(4) / 12.0)).exp();
        let w = direction(theta, 0.3);
        assert!((cosine_power(w, n) / expected - 1.0).abs() <= 1e-13);
        assert!((lobe_power(w, DVec3::Z, n) / expected - 1.0).abs() <= 1e-13);
        assert!((w.z.powf(n) / expected - 1.0).abs() > 1e-12, "the plain power must fail, or this test shows nothing");
    }
}
