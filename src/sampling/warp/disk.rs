//! The unit disk.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};

use glam::DVec2;

/// Maps the unit square to the unit disk, uniformly, so that concentric squares become concentric circles.
///
/// `u` in [0, 1)²; the centre is (1/2, 1/2). Areas keep their shape better than in polar coordinates, which stratified
/// points want. Inverse: [`concentric_disk_inv`].
/// # References
/// - Shirley & Chiu 1997, Journal of Graphics Tools 2(3)
pub fn concentric_disk(u: DVec2) -> DVec2 {
    let DVec2 { x: a, y: b } = 2.0 * u - DVec2::ONE;
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (r, phi) = if a.abs() > b.abs() { (a, FRAC_PI_4 * (b / a)) } else { (b, FRAC_PI_2 - FRAC_PI_4 * (a / b)) };
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec2::new(r * cos_phi, r * sin_phi)
}

/// 1 / π per unit area within the disk, 0 outside.
pub fn concentric_disk_pdf(p: DVec2) -> f64 {
    // The rim is allowed the roundings of the map.
    if p.length_squared() <= 1.0 + 8.0 * f64::EPSILON { FRAC_1_PI } else { 0.0 }
}

/// The `u` that [`concentric_disk`] maps to `p`.
pub fn concentric_disk_inv(p: DVec2) -> DVec2 {
    let r = p.length();
    if r == 0.0 {
        return DVec2::splat(0.5);
    }
    let centred = if p.x.abs() > p.y.abs() {
        let a = r.copysign(p.x);
        DVec2::new(a, a * (p.y / p.x).atan() / FRAC_PI_4)
    } else {
        let b = r.copysign(p.y);
        DVec2::new(b * (p.x / p.y).atan() / FRAC_PI_4, b)
    };
    (0.5 * (centred + DVec2::ONE)).clamp(DVec2::ZERO, DVec2::splat(1.0 - f64::EPSILON / 2.0))
}

#[cfg(test)]
mod tests {
    use super::super::law::{density_is_the_jacobian, square};
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use proptest::prelude::*;
    use rand_distr::{Distribution, UnitDisc};

    #[test]
    fn second_moments_agree_with_rand_distr() {
        const N: u32 = 50_000;
        let mut rng = stream(2, 0, 0);
        let moments = |p: DVec2| [p.x * p.x, p.x * p.y, p.y * p.y];
        let (mut ours, mut theirs) = ([0.0; 3], [0.0; 3]);
        for _ in 0..N {
            let p = concentric_disk(DVec2::new(uniform(&mut rng), uniform(&mut rng)));
            let q: [f64; 2] = UnitDisc.sample(&mut rng);
            for (k, (a, b)) in moments(p).into_iter().zip(moments(DVec2::from_array(q))).enumerate() {
                ours[k] += a / f64::from(N);
                theirs[k] += b / f64::from(N);
            }
        }
        for k in 0..3 {
            // Variance of x² on the disk is 1/16, of xy 1/24: five standard errors of a difference.
            assert!((ours[k] - theirs[k]).abs() <= 5.0 * (2.0 / 16.0 / f64::from(N)).sqrt(), "{ours:?} {theirs:?}");
        }
        assert!((ours[0] - 0.25).abs() <= 5.0 * (1.0 / 16.0 / f64::from(N)).sqrt());
    }

    proptest! {
        #[test]
        fn density_is_jacobian(u in square()) {
            // The map has creases on the diagonals of the square.
            let c = (u - DVec2::splat(0.5)).abs();
            prop_assume!((c.x - c.y).abs() > 1e-3 && c.max_element() > 1e-2);
            density_is_the_jacobian(u, |u| concentric_disk(u).extend(0.0), concentric_disk_pdf(concentric_disk(u)))?;
        }

        #[test]
        fn inverse(x in 1e-9..1.0_f64, y in 0.0..1.0_f64) {
            let u = DVec2::new(x, y);
            let p = concentric_disk(u);
            prop_assert!(concentric_disk_pdf(p) > 0.0);
            prop_assert!((concentric_disk_inv(p) - u).abs().max_element() <= 1e-15);
        }
    }

    #[test]
    fn centre_and_corner() {
        assert_eq!(concentric_disk(DVec2::splat(0.5)), DVec2::ZERO);
        assert_eq!(concentric_disk_inv(DVec2::ZERO), DVec2::splat(0.5));
        assert!((concentric_disk(DVec2::ZERO).length() - 1.0).abs() <= 1e-15);
    }
}
