//! Orthonormal frames: between the world and the local space whose +z is the normal.

use glam::DVec3;

/// Three unit vectors (s, t, n), right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local +x.
    pub s: DVec3,
    /// Local +y.
    pub t: DVec3,
    /// Local +z.
    pub n: DVec3,
}

impl Frame {
    /// A frame about the unit vector `n`, continuous but for the hemisphere n.z < 0.
    ///
    /// # References
    /// - Duff et al. 2017, Building an orthonormal basis, revisited, JCGT 6(1)
    #[inline]
    pub fn about(n: DVec3) -> Self {
        let sign = 1.0_f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        let s = DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
        let t = DVec3::new(b, sign + n.y * n.y * a, -n.y);
        Self { s, t, n }
    }

    /// The frame about the unit vector `n` whose s is as near to `tangent` as can be; any frame where that is parallel.
    pub fn with_tangent(n: DVec3, tangent: DVec3) -> Self {
        let across = tangent - n * n.dot(tangent);
        // Below 1e-8 of the tangent's length half of the digits are rounding.
        if across.length_squared() > 1e-16 * tangent.length_squared() {
            let s = across.normalize();
            Self { s, t: n.cross(s), n }
        } else {
            Self::about(n)
        }
    }

    /// A vector of the world in local coordinates.
    #[inline]
    pub fn to_local(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.dot(self.s), w.dot(self.t), w.dot(self.n))
    }

    /// A vector in local coordinates in the world.
    #[inline]
    pub fn to_world(&self, w: DVec3) -> DVec3 {
        self.s * w.x + self.t * w.y + self.n * w.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn frames_are_orthonormal_and_right_handed_everywhere() {
        for i in 0..=64 {
            let n = direction(f64::from(i) / 64.0 * std::f64::consts::PI, f64::from(i) * 0.7);
            for frame in
                [Frame::about(n), Frame::with_tangent(n, DVec3::new(0.3, -1.0, 0.2)), Frame::with_tangent(n, n)]
            {
                // A few roundings of unit vectors.
                assert!((frame.s.cross(frame.t) - n).length() < 4e-15, "{n}");
                let w = DVec3::new(0.3, -0.5, 0.8);
                assert!((frame.to_local(frame.to_world(w)) - w).length() < 4e-15);
            }
        }
    }
}
