//! The solid angle of a rectangle and uniform directions in it.
//!
//! In the frame of the rectangle, seen from the origin, its corners are (x0, y0, z0) … (x1, y1, z0) with z0 < 0. The
//! planes through the origin and its edges meet in the angles of a spherical quadrilateral; by Girard's theorem
//!
//! Ω = Σ γ − 2π = Σ asin(−cos γ),  −cos γ the products of the z of neighbouring edge normals
//!
//! A sample cuts off the share u.x of the solid angle by a plane x = const z, then picks the height along the cut.
//! # References
//! - Ureña, Fajardo & King 2013, An area-preserving parametrization for spherical rectangles, CGF 32(4)

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

/// A rectangle as seen from a point that does not lie in its plane.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    origin: DVec3,
    x_axis: DVec3,
    y_axis: DVec3,
    z_axis: DVec3,
    low: DVec3,
    high: DVec2,
    /// z of the normals of the edges y = y0 and y = y1.
    edges: DVec2,
    /// 2π less the two angles at x = x1, by which the cut turns.
    turn: f64,
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle with this `corner` and edges `x`, `y`, perpendicular, as seen from `origin`.
    ///
    /// None where `origin` lies in the plane, or a length is not positive.
    pub fn new(origin: DVec3, corner: DVec3, x: DVec3, y: DVec3) -> Option<Self> {
        let (width, height) = (x.length(), y.length());
        let (x_axis, y_axis) = (x / width, y / height);
        let mut z_axis = x_axis.cross(y_axis);
        let to_corner = corner - origin;
        let mut low = DVec3::new(to_corner.dot(x_axis), to_corner.dot(y_axis), to_corner.dot(z_axis));
        if low.z > 0.0 {
            low.z = -low.z;
            z_axis = -z_axis;
        }
        let high = DVec2::new(low.x + width, low.y + height);
        let inverse = |a: f64| a / (a * a + low.z * low.z).sqrt();
        let (n0, n1, n2, n3) = (-inverse(low.y), inverse(high.x), inverse(high.y), -inverse(low.x));
        let lost = |a: f64, b: f64| (a * b).clamp(-1.0, 1.0).asin();
        let (g2, g3) = (lost(n2, n3), lost(n3, n0));
        let solid_angle = lost(n0, n1) + lost(n1, n2) + g2 + g3;
        // γ = π/2 + asin(…) each.
        let turn = PI - g2 - g3;
        let seen = low.z < 0.0 && solid_angle > 0.0;
        seen.then_some(Self { origin, x_axis, y_axis, z_axis, low, high, edges: DVec2::new(n0, n2), turn, solid_angle })
    }

    /// Ω \[sr\].
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Maps the unit square to points of the rectangle whose directions are uniform, of density 1/Ω.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let z0 = self.low.z;
        let (sin, cos) = (u.x * self.solid_angle + self.turn).sin_cos();
        let f = (cos * self.edges.x - self.edges.y) / sin;
        let c = (1.0_f64.copysign(f) / (f * f + self.edges.x * self.edges.x).sqrt()).clamp(-1.0, 1.0);
        let x = (-c * z0 / ((1.0 - c) * (1.0 + c)).sqrt()).clamp(self.low.x, self.high.x);
        let x = if x.is_nan() { self.low.x } else { x };
        let d2 = x * x + z0 * z0;
        let sine = |y: f64| y / (d2 + y * y).sqrt();
        let (h0, h1) = (sine(self.low.y), sine(self.high.y));
        let h = h0 + u.y * (h1 - h0);
        let y = (h * (d2 / ((1.0 - h) * (1.0 + h))).sqrt()).clamp(self.low.y, self.high.y);
        let y = if y.is_nan() { self.high.y } else { y };
        self.origin + x * self.x_axis + y * self.y_axis + z0 * self.z_axis
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::solid_angle::triangle_solid_angle;
    use proptest::prelude::*;

    fn from(origin: DVec3, size: DVec2) -> SphericalRectangle {
        SphericalRectangle::new(origin, DVec3::ZERO, DVec3::X * size.x, DVec3::Y * size.y).unwrap()
    }

    #[test]
    fn published_solid_angle() {
        // The unit square from 1 below its centre.
        let rectangle = from(DVec3::new(0.5, 0.5, -1.0), DVec2::ONE);
        assert!((rectangle.solid_angle() - 0.805431683161).abs() < 5e-13, "12 digits are given");
    }

    proptest! {
        #[test]
        fn the_solid_angle_is_that_of_two_triangles(x in -3.0..3.0_f64, y in -3.0..3.0_f64, z in 0.05..3.0_f64, w in 0.1..3.0_f64) {
            let origin = DVec3::new(x, y, z);
            let rectangle = from(origin, DVec2::new(w, 1.0));
            let corner = |a: f64, b: f64| DVec3::new(a, b, 0.0) - origin;
            let halves = triangle_solid_angle(corner(0.0, 0.0), corner(w, 0.0), corner(w, 1.0))
                + triangle_solid_angle(corner(0.0, 0.0), corner(w, 1.0), corner(0.0, 1.0));
            // asin of numbers up to 1 loses half the digits at most.
            prop_assert!((rectangle.solid_angle() - halves).abs() < 1e-7);
        }

        #[test]
        fn the_density_is_the_jacobian(x in -2.0..2.0_f64, y in -2.0..2.0_f64, z in 0.2..2.0_f64, u in 0.02..0.98_f64, v in 0.02..0.98_f64) {
            let origin = DVec3::new(x, y, z);
            let rectangle = from(origin, DVec2::new(1.5, 1.0));
            let direction = |u: f64, v: f64| (rectangle.sample(DVec2::new(u, v)) - origin).normalize();
            let h = 1e-5;
            let along_u = (direction(u + h, v) - direction(u - h, v)) / (2.0 * h);
            let along_v = (direction(u, v + h) - direction(u, v - h)) / (2.0 * h);
            // Central differences: h² times third derivatives, and 1e-11 of cancellation in Ω over h.
            prop_assert!((along_u.cross(along_v).length() / rectangle.solid_angle() - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn nothing_is_seen_edge_on() {
        assert!(SphericalRectangle::new(DVec3::new(5.0, 0.0, 0.0), DVec3::ZERO, DVec3::X, DVec3::Y).is_none());
        assert!(SphericalRectangle::new(DVec3::Z, DVec3::ZERO, DVec3::ZERO, DVec3::Y).is_none());
    }
}
