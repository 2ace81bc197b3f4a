//! Directions: angles, frames, reflection. The local frame has its normal along +z.

use glam::DVec3;

/// The unit vector at polar angle `theta` from +z and azimuth `phi` from +x, both in radians.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// The unit vector with z = `mu` (clamped to [−1, 1]) and azimuth `phi` from +x in radians.
pub fn direction_mu(mu: f64, phi: f64) -> DVec3 {
    let mu = mu.clamp(-1.0, 1.0);
    let sin_theta = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, mu)
}

/// Polar angle and azimuth of `w`, theta in [0, π], phi in (−π, π].
///
/// `atan2` rather than `acos`: full relative precision next to the pole.
pub fn angles(w: DVec3) -> (f64, f64) {
    (w.x.hypot(w.y).atan2(w.z), w.y.atan2(w.x))
}

/// The direction `w` mirrored about `m`: 2 (w·m) m − w. Both away from the surface, unit length.
pub fn reflect(w: DVec3, m: DVec3) -> DVec3 {
    2.0 * w.dot(m) * m - w
}

/// The direction `w` mirrored about the normal: (−x, −y, z).
pub fn mirror(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, -w.y, w.z)
}

/// `w` mirrored in the tangent plane: (x, y, −z).
pub fn flip(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// The direction into which light along `w` is refracted at the unit normal `m`, w·m ≥ 0, by Snell's law; `eta` is the
/// index of the far side over that of the near side. Unit length; None for total internal reflection.
///
/// With c = w·m it is (c − √(η² − 1 + c²)) / η · m − w / η.
pub fn refract(w: DVec3, m: DVec3, eta: f64) -> Option<DVec3> {
    let c = w.dot(m);
    // From η² − 1 and not from sin²: exact at grazing and for η next to 1.
    let root2 = (eta - 1.0) * (eta + 1.0) + c * c;
    if root2 < 0.0 {
        return None;
    }
    ((c - root2.sqrt()) * m - w).try_normalize()
}

/// The normalised half vector of two directions; the normal where they cancel.
pub fn half_vector(wo: DVec3, wi: DVec3) -> DVec3 {
    (wo + wi).normalize_or(DVec3::Z)
}

/// `w` turned about the normal by `angle` radians.
pub fn rotate_z(w: DVec3, angle: f64) -> DVec3 {
    let (s, c) = angle.sin_cos();
    DVec3::new(c * w.x - s * w.y, s * w.x + c * w.y, w.z)
}

/// An orthonormal basis around the unit vector `w`, as (s, t) with (s, t, w) right-handed.
///
/// `t.z` ≥ 0 is the ascending direction, `s.z` = 0 wherever `w` is not the pole itself.
pub fn basis(w: DVec3) -> (DVec3, DVec3) {
    let r = w.x.hypot(w.y);
    let s = if r > 0.0 { DVec3::new(-w.y / r, w.x / r, 0.0) } else { DVec3::Y };
    (s, w.cross(s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn angles_invert_direction(theta in 1e-9..3.1_f64, phi in -3.1..3.1_f64) {
            let (t, p) = angles(direction(theta, phi));
            prop_assert!((t - theta).abs() <= 1e-15 + 4e-16 * theta, "{t} against {theta}");
            prop_assert!((p - phi).abs() <= 2e-15);
        }

        #[test]
        fn basis_is_right_handed_and_ascends(theta in 0.0..3.1_f64, phi in -3.1..3.1_f64) {
            let w = direction(theta, phi);
            let (s, t) = basis(w);
            prop_assert!((s.cross(t) - w).length() <= 1e-15 * 4.0);
            prop_assert!(s.dot(w).abs() <= 1e-15 && t.dot(w).abs() <= 1e-15);
            prop_assert!(t.z >= -1e-300);
        }
    }

    #[test]
    fn reflection_about_the_normal_is_the_mirror() {
        let w = direction(0.7, 1.1);
        assert_abs_diff_eq!(reflect(w, DVec3::Z), mirror(w), epsilon = 1e-16);
    }

    proptest! {
        #[test]
        fn snells_law_holds_and_the_way_back_is_the_same(theta in 0.0..1.57_f64, phi in 0.0..6.0_f64, eta in 0.4..2.5_f64) {
            let m = direction(0.3, 2.0);
            let wo = direction(theta, phi);
            prop_assume!(wo.dot(m) > 1e-3);
            let sine = wo.cross(m).length();
            let Some(wi) = refract(wo, m, eta) else {
                prop_assert!(sine / eta > 1.0 - 1e-12);
                return Ok(());
            };
            // Tangential components: η of the far side times its sine. Rounding is divided by the small cosine next to
            // the critical angle.
            prop_assert!((wi.cross(m) * eta + wo.cross(m)).length() < 1e-14, "{wi}");
            prop_assert!(wi.dot(m) <= 0.0 && (wi.length() - 1.0).abs() < 1e-15);
            if wi.dot(m) < -1e-3 {
                let back = refract(wi, -m, 1.0 / eta).unwrap();
                prop_assert!((back - wo).length() < 1e-11, "{back} {wo}");
            }
        }
    }

    #[test]
    fn nothing_bends_where_indices_agree() {
        let w = direction(1.5, 1.0);
        assert!((refract(w, DVec3::Z, 1.0).unwrap() + w).length() < 1e-15);
    }
}
