//! The hemisphere about +z: uniform, cosine-weighted, and a blend of both.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec2, DVec3};

use super::{cylindrical, turn, uniform_sphere, uniform_sphere_inv};

/// Maps the unit square to the hemisphere so that p(w) = 1 / 2π.
///
/// `u` in [0, 1)². The pole is `u.x = 0`. Inverse: [`uniform_hemisphere_inv`].
pub fn uniform_hemisphere(u: DVec2) -> DVec3 {
    let z = 1.0 - u.x;
    cylindrical((u.x * (1.0 + z)).sqrt(), z, u.y)
}

/// 1 / 2π [1/sr] above the horizon, 0 below.
pub fn uniform_hemisphere_pdf(w: DVec3) -> f64 {
    if w.z > 0.0 { 1.0 / TAU } else { 0.0 }
}

/// The `u` that [`uniform_hemisphere`] maps to `w`.
pub fn uniform_hemisphere_inv(w: DVec3) -> DVec2 {
    DVec2::new((w.x * w.x + w.y * w.y) / (1.0 + w.z), turn(w.x, w.y))
}

/// Maps the unit square to the hemisphere so that p(w) = cosθ / π.
///
/// `u` in [0, 1)². The pole is `u.x = 0`. Inverse: [`cosine_hemisphere_inv`].
pub fn cosine_hemisphere(u: DVec2) -> DVec3 {
    // 1 − u.x, not 1 − r²: exact near the horizon, where r² has already been rounded.
    cylindrical(u.x.sqrt(), (1.0 - u.x).sqrt(), u.y)
}

/// cosθ / π [1/sr] above the horizon, 0 below.
pub fn cosine_hemisphere_pdf(w: DVec3) -> f64 {
    w.z.max(0.0) * FRAC_1_PI
}

/// The `u` that [`cosine_hemisphere`] maps to `w`.
pub fn cosine_hemisphere_inv(w: DVec3) -> DVec2 {
    DVec2::new(w.x * w.x + w.y * w.y, turn(w.x, w.y))
}

/// Maps the unit square to the hemisphere about the unit vector `n` so that p(w) = n·w / π: the direction of n + s, with s
/// the point of [`uniform_sphere`], which is the same for every `n`.
///
/// Close `n` thus give close directions everywhere, as no frame about `n` does. By the theorem of the inscribed angle w halves
/// the angle between n and s, so that |∂w/∂s| = 1 / (4 n·w). `u` in [0, 1)²; at s = −n, where there is no direction, NaN.
/// Inverse: [`cosine_about_inv`].
#[inline]
pub fn cosine_about(n: DVec3, u: DVec2) -> DVec3 {
    (n + uniform_sphere(u)).normalize()
}

/// n·w / π [1/sr] above the horizon of `n`, 0 below.
#[inline]
pub fn cosine_about_pdf(n: DVec3, w: DVec3) -> f64 {
    n.dot(w).max(0.0) * FRAC_1_PI
}

/// The `u` that [`cosine_about`] maps to `w`.
pub fn cosine_about_inv(n: DVec3, w: DVec3) -> DVec2 {
    uniform_sphere_inv(2.0 * n.dot(w) * w - n)
}

/// Maps the unit square to the hemisphere so that p(w) = (1 − t) cosθ / π + t / 2π, for `t` in [0, 1].
///
/// For functions that are nearly, but not boundedly, cosine-weighted at the horizon. `u` in [0, 1)². The pole is
/// `u.x = 0`. Inverse: [`blended_hemisphere_inv`].
pub fn blended_hemisphere(u: DVec2, t: f64) -> DVec3 {
    // (1 − t) z² + t z = 1 − u.x, solved for z and for 1 − z, both without a cancellation.
    let root = (t * t + 4.0 * (1.0 - t) * (1.0 - u.x)).sqrt();
    let z = 2.0 * (1.0 - u.x) / (t + root);
    let below_pole = 2.0 * u.x / (2.0 - t + root);
    cylindrical((below_pole * (1.0 + z)).sqrt(), z, u.y)
}

/// (1 − t) cosθ / π + t / 2π [1/sr] above the horizon, 0 below.
pub fn blended_hemisphere_pdf(w: DVec3, t: f64) -> f64 {
    if w.z > 0.0 { ((1.0 - t) * w.z + 0.5 * t) * FRAC_1_PI } else { 0.0 }
}

/// The `u` that [`blended_hemisphere`] maps to `w`.
pub fn blended_hemisphere_inv(w: DVec3, t: f64) -> DVec2 {
    let s2 = w.x * w.x + w.y * w.y;
    DVec2::new((1.0 - t) * s2 + t * s2 / (1.0 + w.z), turn(w.x, w.y))
}

#[cfg(test)]
mod tests {
    use super::super::law::{density_is_the_jacobian, inverse_returns, square};
    use super::*;
    use crate::math::sum::Neumaier;
    use proptest::prelude::*;

    /// Mean of g over the midpoints of an N × 8 grid of the unit square, whose error is O(N⁻²) for smooth g.
    fn mean(map: impl Fn(DVec2) -> DVec3, g: impl Fn(DVec3) -> DVec3) -> DVec3 {
        const N: u32 = 20_000;
        let axis = |axis: usize| {
            let values = (0..N).flat_map(|i| (0..8).map(move |j| (f64::from(i), f64::from(j))));
            let sum: Neumaier =
                values.map(|(i, j)| g(map(DVec2::new((i + 0.5) / f64::from(N), (j + 0.5) / 8.0)))[axis]).collect();
            sum.value() / f64::from(8 * N)
        };
        DVec3::new(axis(0), axis(1), axis(2))
    }

    #[test]
    fn moments_are_those_of_the_density() {
        // √u at the ends of the interval costs the midpoint rule N^−1.5 = 4e-7.
        let close = |a: DVec3, b: DVec3| assert!((a - b).abs().max_element() <= 1e-6, "{a} against {b}");
        let squares = |w: DVec3| w * w;
        close(mean(uniform_hemisphere, |w| w), DVec3::new(0.0, 0.0, 0.5));
        close(mean(uniform_hemisphere, squares), DVec3::splat(1.0 / 3.0));
        close(mean(cosine_hemisphere, |w| w), DVec3::new(0.0, 0.0, 2.0 / 3.0));
        close(mean(cosine_hemisphere, squares), DVec3::new(0.25, 0.25, 0.5));
        let blend = |u| blended_hemisphere(u, 0.3);
        close(mean(blend, |w| w), DVec3::new(0.0, 0.0, 0.7 * 2.0 / 3.0 + 0.3 * 0.5));
    }

    #[test]
    fn the_blend_ends_in_its_parts() {
        for u in [DVec2::new(0.0, 0.3), DVec2::new(0.7, 0.9), DVec2::new(1.0 - f64::EPSILON / 2.0, 0.1)] {
            assert!(blended_hemisphere(u, 0.0).abs_diff_eq(cosine_hemisphere(u), 4e-16));
            assert!(blended_hemisphere(u, 1.0).abs_diff_eq(uniform_hemisphere(u), 4e-16));
        }
    }

    proptest! {
        #[test]
        fn densities_are_jacobians(u in square(), t in 0.0..1.0_f64) {
            density_is_the_jacobian(u, uniform_hemisphere, uniform_hemisphere_pdf(uniform_hemisphere(u)))?;
            density_is_the_jacobian(u, cosine_hemisphere, cosine_hemisphere_pdf(cosine_hemisphere(u)))?;
            let blend = |u| blended_hemisphere(u, t);
            density_is_the_jacobian(u, blend, blended_hemisphere_pdf(blend(u), t))?;
        }

        #[test]
        fn the_cosine_about_any_normal(u in square(), v in square()) {
            let n = uniform_sphere(v);
            let map = |u| cosine_about(n, u);
            let w = map(u);
            // Near its horizon the map stretches without bound, the direction by the roundings of n + s.
            prop_assume!(n.dot(w) > 0.1);
            density_is_the_jacobian(u, map, cosine_about_pdf(n, w))?;
            prop_assert!(density_is_the_jacobian(u, map, 1.01 * cosine_about_pdf(n, w)).is_err());
            inverse_returns(u, w, cosine_about_inv(n, w), 1e-13)?;
        }

        #[test]
        fn a_density_without_its_cosine_is_caught(u in square()) {
            prop_assume!(u.x > 0.05 && u.x < 0.74 || u.x > 0.76);
            prop_assert!(density_is_the_jacobian(u, cosine_hemisphere, 1.0 / TAU).is_err());
        }

        #[test]
        fn inverses(x in 1e-9..1.0_f64, y in 0.0..1.0_f64, t in 0.0..1.0_f64) {
            let u = DVec2::new(x, y);
            let (a, b, c) = (uniform_hemisphere(u), cosine_hemisphere(u), blended_hemisphere(u, t));
            inverse_returns(u, a, uniform_hemisphere_inv(a), 1e-15)?;
            inverse_returns(u, b, cosine_hemisphere_inv(b), 1e-15)?;
            inverse_returns(u, c, blended_hemisphere_inv(c, t), 1e-15)?;
        }
    }
}
