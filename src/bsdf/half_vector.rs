//! The half vector of two directions in the form that keeps its digits: slopes instead of angles.
//!
//! With s = wo + wi: slope (s.x, s.y) / s.z, cosθ_h = s.z / |s|, cosθ_d = wo·h = |s| / 2. Next to the mirror direction
//! 1 − cos²θ_h has lost all digits where the slope has lost none.

use glam::{DVec2, DVec3};

use crate::math::sphere::reflect;

/// A cosine up to here counts as the horizon: beyond it values in 1 / cos² leave the range of double precision.
const HORIZON: f64 = 1e-100;

/// The half vector h of two directions above the horizon.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfVector {
    /// (h.x, h.y) / h.z = tanθ_h (cosφ_h, sinφ_h).
    pub(super) slope: DVec2,
    /// cosθ_h = h.z.
    pub(super) cos_h: f64,
    /// cosθ_d = wo·h = wi·h.
    pub(super) cos_d: f64,
}

impl HalfVector {
    /// None unless both directions lie above the horizon by more than [`HORIZON`].
    pub(super) fn new(wo: DVec3, wi: DVec3) -> Option<Self> {
        if !(wo.z > HORIZON && wi.z > HORIZON) {
            return None;
        }
        let s = wo + wi;
        let length = s.length();
        // |s| is never 0, since s.z > 0; wo·h from the dot product would be where both graze the horizon face to face.
        Some(Self { slope: DVec2::new(s.x, s.y) / s.z, cos_h: (s.z / length).min(1.0), cos_d: (0.5 * length).min(1.0) })
    }

    /// tan²θ_h.
    pub(super) fn tan2(self) -> f64 {
        self.slope.length_squared()
    }

    /// The direction into which `wo` is reflected by the half vector of slope `slope`.
    pub(super) fn reflect(wo: DVec3, slope: DVec2) -> DVec3 {
        reflect(wo, slope.extend(1.0).normalize_or(DVec3::Z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn agrees_with_the_angles_and_inverts_the_reflection() {
        let (wo, slope) = (direction(0.7, 0.3), DVec2::new(0.1, -0.2));
        let wi = HalfVector::reflect(wo, slope);
        let h = HalfVector::new(wo, wi).unwrap();
        let m = (wo + wi).normalize();
        // Each side carries a few roundings of numbers near 1.
        assert!((h.slope - slope).length() < 1e-15);
        assert!((h.cos_h - m.z).abs() < 1e-15 && (h.cos_d - m.dot(wo)).abs() < 1e-15);
    }

    #[test]
    fn stays_finite_at_the_horizon() {
        let wo = DVec3::new(1.0, 0.0, 1e-99);
        for wi in [wo, DVec3::new(-1.0, 0.0, 1e-99), DVec3::new(0.0, 1.0, 1e-8)] {
            let h = HalfVector::new(wo, wi).unwrap();
            assert!(h.tan2().is_finite() && h.cos_d > 0.0 && h.cos_h.is_finite());
        }
    }
}
