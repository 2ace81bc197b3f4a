//! Maps from the unit square to directions, as triples `x`, `x_pdf`, `x_inv`.
//!
//! Every map takes `u` in [0, 1)², has its pole (or centre) at `u.x = 0` and turns with `u.y`, so that close `u` give
//! close directions. Densities are per steradian, 0 outside the support; inverses take any direction of the support.

mod disk;
mod hemisphere;
mod lobe;
mod sphere;

pub use disk::{concentric_disk, concentric_disk_inv, concentric_disk_pdf};
pub use hemisphere::{
    blended_hemisphere, blended_hemisphere_inv, blended_hemisphere_pdf, cosine_about, cosine_about_inv,
    cosine_about_pdf, cosine_hemisphere, cosine_hemisphere_inv, cosine_hemisphere_pdf, uniform_hemisphere,
    uniform_hemisphere_inv, uniform_hemisphere_pdf,
};
pub use lobe::{
    cosine_power, lobe_power, phong_lobe, phong_lobe_above, phong_lobe_inv, phong_lobe_pdf, power_cosine,
    power_cosine_inv, power_cosine_pdf,
};
pub use sphere::{
    uniform_cone, uniform_cone_inv, uniform_cone_pdf, uniform_sphere, uniform_sphere_inv, uniform_sphere_pdf,
};

use std::f64::consts::TAU;

use glam::DVec3;

use crate::math::special::sin_cos_turns;

/// The direction of height `z` and distance `r` from the axis, `turn` full turns from +x.
fn cylindrical(r: f64, z: f64, turn: f64) -> DVec3 {
    let (sin_phi, cos_phi) = sin_cos_turns(turn);
    DVec3::new(r * cos_phi, r * sin_phi, z)
}

/// The azimuth of (x, y) as a fraction of a full turn, in [0, 1).
fn turn(x: f64, y: f64) -> f64 {
    let t = y.atan2(x) / TAU;
    if t < 0.0 { (t + 1.0).min(1.0 - f64::EPSILON / 2.0) } else { t.abs() }
}

#[cfg(test)]
mod law {
    //! The two laws of every triple.

    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    /// Points of the open unit square, away from its edge by what a finite difference needs.
    pub(super) fn square() -> impl Strategy<Value = DVec2> {
        (0.01..0.99_f64, 0.01..0.99_f64).prop_map(|(x, y)| DVec2::new(x, y))
    }

    /// p(x(u)) |∂x/∂u₁ × ∂x/∂u₂| = 1 by central differences.
    pub(super) fn density_is_the_jacobian(
        u: DVec2,
        map: impl Fn(DVec2) -> DVec3,
        pdf: f64,
    ) -> Result<(), TestCaseError> {
        let h = 1e-5;
        let difference = |e: DVec2| (map(u + e * h) - map(u - e * h)) / (2.0 * h);
        let area = difference(DVec2::X).cross(difference(DVec2::Y)).length();
        // h² times a third derivative over the first, ≤ 1e4 a hundredth from the edge; 1e-16 / h of rounding.
        prop_assert!((pdf * area - 1.0).abs() <= 2e-6, "u = {u}: density {pdf} times area {area}");
        Ok(())
    }

    /// |x_inv(x(u)) − u| ≤ tol, and the direction has unit length.
    pub(super) fn inverse_returns(u: DVec2, w: DVec3, inverse: DVec2, tol: f64) -> Result<(), TestCaseError> {
        prop_assert!((w.length() - 1.0).abs() <= 4e-16, "length {}", w.length());
        prop_assert!((inverse - u).abs().max_element() <= tol, "{inverse} against {u}");
        Ok(())
    }
}
