//! The whole sphere, and a cone of directions about +z.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{cylindrical, turn};

/// Maps the unit square to the sphere so that p(w) = 1 / 4π.
///
/// `u` in [0, 1)². The pole is `u.x = 0`. Inverse: [`uniform_sphere_inv`].
pub fn uniform_sphere(u: DVec2) -> DVec3 {
    cylindrical(2.0 * (u.x * (1.0 - u.x)).sqrt(), 1.0 - 2.0 * u.x, u.y)
}

/// 1 / 4π [1/sr].
pub fn uniform_sphere_pdf() -> f64 {
    0.5 / TAU
}

/// The `u` that [`uniform_sphere`] maps to `w`.
pub fn uniform_sphere_inv(w: DVec3) -> DVec2 {
    DVec2::new(0.5 * below_pole(w), turn(w.x, w.y))
}

/// Maps the unit square to the cone of half-angle `half_angle` about +z, uniformly.
///
/// `u` in [0, 1)², `half_angle` in (0, π] radians: 1 − cos is taken as 2 sin²(g/2), so that cones of any size keep all
/// digits. The axis is `u.x = 0`. Inverse: [`uniform_cone_inv`].
pub fn uniform_cone(u: DVec2, half_angle: f64) -> DVec3 {
    let below_pole = u.x * height(half_angle);
    cylindrical((below_pole * (2.0 - below_pole)).sqrt(), 1.0 - below_pole, u.y)
}

/// 1 / (2π (1 − cos g)) [1/sr] within the half-angle g, 0 outside.
pub fn uniform_cone_pdf(w: DVec3, half_angle: f64) -> f64 {
    let height = height(half_angle);
    // The rim is allowed the roundings of the map, so that no draw falls outside.
    if below_pole(w) <= height * (1.0 + 8.0 * f64::EPSILON) { 1.0 / (TAU * height) } else { 0.0 }
}

/// The `u` that [`uniform_cone`] maps to `w`.
pub fn uniform_cone_inv(w: DVec3, half_angle: f64) -> DVec2 {
    DVec2::new(below_pole(w) / height(half_angle), turn(w.x, w.y))
}

/// 1 − cos g without its cancellation.
fn height(half_angle: f64) -> f64 {
    let s = (0.5 * half_angle).sin();
    2.0 * s * s
}

/// 1 − w.z without its cancellation.
fn below_pole(w: DVec3) -> f64 {
    if w.z > 0.0 { (w.x * w.x + w.y * w.y) / (1.0 + w.z) } else { 1.0 - w.z }
}

#[cfg(test)]
mod tests {
    use super::super::law::{density_is_the_jacobian, inverse_returns, square};
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use proptest::prelude::*;
    use rand_distr::{Distribution, UnitSphere};
    use std::f64::consts::PI;

    /// The Kolmogorov-Smirnov distance of two samples of equal size.
    fn distance(mut a: Vec<f64>, mut b: Vec<f64>) -> f64 {
        a.sort_by(f64::total_cmp);
        b.sort_by(f64::total_cmp);
        let (mut i, mut worst) = (0, 0.0_f64);
        for (j, &x) in b.iter().enumerate() {
            while i < a.len() && a[i] <= x {
                i += 1;
            }
            worst = worst.max((i as f64 - j as f64).abs() / a.len() as f64);
        }
        worst
    }

    #[test]
    fn the_sphere_agrees_with_rand_distr() {
        const N: usize = 20_000;
        let mut rng = stream(1, 0, 0);
        let ours: Vec<DVec3> =
            (0..N).map(|_| uniform_sphere(DVec2::new(uniform(&mut rng), uniform(&mut rng)))).collect();
        let theirs: Vec<[f64; 3]> = (0..N).map(|_| UnitSphere.sample(&mut rng)).collect();
        let oblique = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        let project = |g: DVec3| ours.iter().map(|w| w.dot(g)).collect::<Vec<_>>();
        let reference = theirs.iter().map(|&w| DVec3::from_array(w).dot(oblique)).collect::<Vec<_>>();
        // Smirnov: P(D > 2.3 √(2/N)) = 2 exp(−2 · 2.3²) = 5e-5.
        let bound = 2.3 * (2.0 / N as f64).sqrt();
        assert!(distance(project(oblique), reference.clone()) <= bound);
        let half: Vec<f64> = project(oblique).iter().map(|x| x.abs()).collect();
        assert!(distance(half, reference) > bound, "the comparison has lost its power");
    }

    proptest! {
        #[test]
        fn densities_are_jacobians(u in square(), g in 0.1..PI) {
            density_is_the_jacobian(u, uniform_sphere, uniform_sphere_pdf())?;
            density_is_the_jacobian(u, |u| uniform_cone(u, g), uniform_cone_pdf(uniform_cone(u, g), g))?;
        }

        #[test]
        fn inverses(x in 1e-9..1.0_f64, y in 0.0..1.0_f64, log_g in -12.0..0.49_f64) {
            let (u, g) = (DVec2::new(x, y), 10_f64.powf(log_g));
            let (w, c) = (uniform_sphere(u), uniform_cone(u, g));
            inverse_returns(u, w, uniform_sphere_inv(w), 1e-15)?;
            inverse_returns(u, c, uniform_cone_inv(c, g), 2e-15)?;
            prop_assert!(uniform_cone_pdf(c, g) > 0.0);
        }

        #[test]
        fn nothing_outside_the_cone(log_g in -12.0..0.0_f64, phi in 0.0..TAU) {
            let g = 10_f64.powf(log_g);
            let outside = cylindrical((g * 1.000_001).sin(), (g * 1.000_001).cos(), phi / TAU);
            prop_assert_eq!(uniform_cone_pdf(outside, g), 0.0);
        }
    }

    #[test]
    fn cone_of_a_right_angle_is_the_hemisphere() {
        let density = uniform_cone_pdf(DVec3::Z, 0.5 * PI);
        assert!((density * TAU - 1.0).abs() <= 1e-15);
    }
}
