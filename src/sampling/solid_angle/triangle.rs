//! The solid angle of a triangle and uniform directions in it.
//!
//! tan(Ω/2) = |a·(b×c)| / (1 + a·b + b·c + c·a) for unit vectors a, b, c to the corners
//!
//! A sample cuts off the share u.x of the solid angle by a great circle through b, then picks a point of its arc.
//! # References
//! - Van Oosterom & Strackee 1983, IEEE TBME 30(2) (the solid angle)
//! - Arvo 1995, Stratified sampling of spherical triangles, SIGGRAPH (the map)

use glam::{DVec2, DVec3};

/// Ω \[sr\] of the triangle with corners at `a`, `b`, `c`, seen from the origin; 0 where a corner is at the origin.
pub fn triangle_solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c)).abs();
    let sum = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * volume.atan2(sum)
}

/// A triangle as seen from a point that does not lie in its plane.
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    a: DVec3,
    b: DVec3,
    /// Unit vector perpendicular to `a` in the plane of a and c, towards c.
    towards_c: DVec3,
    cos_ab: f64,
    /// Sine and cosine of the angle at `a`, and the angle.
    alpha: (f64, f64, f64),
    solid_angle: f64,
}

impl SphericalTriangle {
    /// The triangle with corners at `a`, `b`, `c`, as seen from the origin. None where it is seen edge-on.
    pub fn new(a: DVec3, b: DVec3, c: DVec3) -> Option<Self> {
        let solid_angle = triangle_solid_angle(a, b, c);
        let (a, b, c) = (a.normalize_or_zero(), b.normalize_or_zero(), c.normalize_or_zero());
        let (ab, ac) = (a.cross(b), a.cross(c));
        let (sin, cos) = (ab.cross(ac).length(), ab.dot(ac));
        let towards_c = (c - c.dot(a) * a).normalize_or_zero();
        let length = sin.hypot(cos);
        let seen = solid_angle > 0.0 && length > 0.0 && towards_c != DVec3::ZERO;
        seen.then(|| Self {
            a,
            b,
            towards_c,
            cos_ab: a.dot(b),
            alpha: (sin / length, cos / length, sin.atan2(cos)),
            solid_angle,
        })
    }

    /// Ω \[sr\].
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Maps the unit square to the directions of the triangle, uniformly, of density 1/Ω.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let (sin_alpha, cos_alpha, alpha) = self.alpha;
        let (s, t) = (u.x * self.solid_angle - alpha).sin_cos();
        let x = t - cos_alpha;
        let y = s + sin_alpha * self.cos_ab;
        let q = ((y * t - x * s) * cos_alpha - y) / ((y * s + x * t) * sin_alpha);
        // u.x = 0 is the corner a itself, where both are 0.
        let q = if q.is_nan() { 1.0 } else { q.clamp(-1.0, 1.0) };
        let end = q * self.a + ((1.0 - q) * (1.0 + q)).sqrt() * self.towards_c;
        let end_b = end.dot(self.b);
        let below = u.y * (1.0 - end_b);
        let across = (end - end_b * self.b).normalize_or_zero();
        (1.0 - below) * self.b + (below * (2.0 - below)).sqrt() * across
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn an_octant_is_an_eighth_of_the_sphere() {
        assert!((triangle_solid_angle(DVec3::X, DVec3::Y * 3.0, DVec3::Z) - FRAC_PI_2).abs() < 1e-15);
        assert!(SphericalTriangle::new(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y).is_none());
        assert!(SphericalTriangle::new(DVec3::ZERO, DVec3::Y, DVec3::X).is_none());
    }

    fn corner() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0_f64, -1.0..1.0_f64).prop_map(|(x, y)| DVec3::new(x, y, 0.7))
    }

    proptest! {
        #[test]
        fn samples_are_inside_and_the_density_is_the_jacobian(a in corner(), b in corner(), c in corner(), u in 0.02..0.98_f64, v in 0.02..0.98_f64) {
            prop_assume!((b - a).cross(c - a).length() > 0.2);
            let triangle = SphericalTriangle::new(a, b, c).unwrap();
            let direction = |u: f64, v: f64| triangle.sample(DVec2::new(u, v));
            let w = direction(u, v);
            let side = |p: DVec3, q: DVec3| p.cross(q).dot(w) * a.cross(b).dot(c).signum();
            prop_assert!(side(a, b) > -1e-12 && side(b, c) > -1e-12 && side(c, a) > -1e-12, "{w} is outside");
            let h = 1e-5;
            let along_u = (direction(u + h, v) - direction(u - h, v)) / (2.0 * h);
            let along_v = (direction(u, v + h) - direction(u, v - h)) / (2.0 * h);
            // Central differences: h² times third derivatives, which grow towards the corners.
            prop_assert!((along_u.cross(along_v).length() / triangle.solid_angle() - 1.0).abs() < 1e-3);
        }
    }
}
