//! Snell's law, and the two sides of an interface.
//!
//! With m the normal on the side of `wo`, c = wo·m and η the index of the far side over that of the near side,
//! wi = (c − √(η² − 1 + c²)) / η · m − wo / η; no direction where the root is not real: total internal reflection.
//! # References
//! - Born & Wolf, Principles of Optics, 1.5

use glam::DVec3;

use super::Domain;

/// The domain of a relative index of refraction: far beyond any known material, and its square is harmless.
pub(super) const ETA: Domain = Domain::Closed(1e-3, 1e3);

/// The index of the far side over that of the near side, for a direction on the near side, from that of the interior
/// (z < 0) over the exterior.
#[inline]
pub(super) fn relative(eta: f64, w: DVec3) -> f64 {
    if w.z < 0.0 { 1.0 / eta } else { eta }
}

/// `w` mirrored in the tangent plane.
#[inline]
pub(super) fn flip(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// The direction into which light along `wo` is refracted at the unit normal `m`, wo·m ≥ 0, unit length; None for total
/// internal reflection.
#[inline]
pub(super) fn refract(wo: DVec3, m: DVec3, eta: f64) -> Option<DVec3> {
    let c = wo.dot(m);
    // From η² − 1 and not from sin²: exact at grazing and for η next to 1.
    let root2 = (eta - 1.0) * (eta + 1.0) + c * c;
    if root2 < 0.0 {
        return None;
    }
    ((c - root2.sqrt()) * m - wo).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::direction;
    use proptest::prelude::*;

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
