//! The exchange between two rectangles whose edges are parallel to a common orthogonal frame, in closed form.
//!
//! A F = Σ ± G over the 16 pairs of a corner of one and a corner of the other, ± the product of the signs of the ends
//! that the four coordinates are taken from; with differences x, y of coordinates and the distance z of the planes
//!
//! parallel:      G = 1/(2π) [x t atan(x/t) + y s atan(y/s) − ½ z² ln r²],  s² = x² + z², t² = y² + z², r² = x² + y² + z²
//!
//! and with distances x, z of the ends from the line where the planes meet, y the difference along it
//!
//! perpendicular: G = 1/(2π) [y s atan(y/s) − ¼ (s² − y²) ln r²],  s² = x² + z², r² = s² + y²
//! # References
//! - Gross, Spindler & Hahne 1981, Lett. Heat Mass Transfer 8(3) (arbitrary parallel and perpendicular rectangles)
//! - Howell, A catalog of radiation heat transfer configuration factors, C-11 to C-14 (special cases)

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::render::radiosity::polygon::Polygon;

/// How far edges may be from parallel to the frame, as sines of angles; the result is wrong by about as much.
const ALIGNED: f64 = 1e-12;

/// The error of [`exchange`] in units of the square of the longest distance.
pub const ERROR: f64 = 1e-15;

/// A rectangle, ready to be paired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    corner: DVec3,
    x: DVec3,
    y: DVec3,
    normal: DVec3,
    size: DVec2,
}

impl Rectangle {
    /// The polygon as a rectangle; None if its angles are not right ones.
    pub fn of(polygon: &Polygon) -> Option<Self> {
        let [corner, next, opposite, last] = *polygon.corners() else { return None };
        let (x, y) = (next - corner, last - corner);
        let size = DVec2::new(x.length(), y.length());
        let (x, y) = (x / size.x, y / size.y);
        let closed = (opposite - next - last + corner).length() <= ALIGNED * size.min_element();
        (closed && x.dot(y).abs() <= ALIGNED).then(|| Self { corner, x, y, normal: polygon.normal(), size })
    }
}

/// A F between the fronts of `a` and `b`, nothing in between \[m²\]; parts of one that are behind the other are left out.
/// None where edges are not parallel to a common frame.
///
/// The absolute error is about 1e-15 L², L the longest distance between the two: the 16 terms are as large as that and
/// cancel to A_a A_b/(π d²). For squares of side s at a distance d this is 1e-15 (d/s)⁴ relative: 1e-11 at d = 10 s. From
/// there on the kernel's quadrature is both faster and more accurate.
pub fn exchange(a: &Rectangle, b: &Rectangle) -> Option<f64> {
    let local = |v: DVec3| DVec3::new(v.dot(a.x), v.dot(a.y), v.dot(a.normal));
    let axis = |v: DVec3| {
        let v = local(v).abs();
        (0..3).find(|&i| v[i] > 0.5 && v[(i + 1) % 3] <= ALIGNED && v[(i + 2) % 3] <= ALIGNED)
    };
    let (along_x, along_y) = (axis(b.x)?, axis(b.y)?);
    let flat = 3 - along_x - along_y;
    let corner = local(b.corner - a.corner);
    let opposite = corner + local(b.x * b.size.x + b.y * b.size.y);
    let span = |i: usize| [corner[i].min(opposite[i]), corner[i].max(opposite[i])];
    let facing = local(b.normal)[flat];
    if flat == 2 {
        let facing = facing < 0.0 && corner.z > 0.0;
        let value = || parallel([[0.0, a.size.x], span(0)], [[0.0, a.size.y], span(1)], corner.z);
        return Some(if facing { value() } else { 0.0 });
    }
    // Distances from b's plane, to its front.
    let (near, far) = (-corner[flat] * facing.signum(), (a.size[flat] - corner[flat]) * facing.signum());
    let from_b = [near.min(far).max(0.0), near.max(far)];
    let from_a = [span(2)[0].max(0.0), span(2)[1]];
    let apart = from_a[0] < from_a[1] && from_b[0] < from_b[1];
    let other = 1 - flat;
    Some(if apart { perpendicular([from_a, from_b], [[0.0, a.size[other]], span(other)]) } else { 0.0 })
}

/// Rectangles at a distance `z`, with the two intervals that they span in `x` and in `y`.
fn parallel(x: [[f64; 2]; 2], y: [[f64; 2]; 2], z: f64) -> f64 {
    let scale = unit(&[x[0], x[1], y[0], y[1], [0.0, z]]);
    let z2 = (z / scale) * (z / scale);
    let g = |x: f64, y: f64| {
        let (x, y) = (x / scale, y / scale);
        let (x2, y2) = (x * x, y * y);
        let (s, t) = ((x2 + z2).sqrt(), (y2 + z2).sqrt());
        x * t * (x / t).atan() + y * s * (y / s).atan() - 0.5 * z2 * (x2 + y2 + z2).ln()
    };
    let mut sum = 0.0;
    for (i, j, sign) in ENDS {
        for (k, l, other) in ENDS {
            sum += sign * other * g(x[0][i] - x[1][j], y[0][k] - y[1][l]);
        }
    }
    (sum * scale * scale / TAU).max(0.0)
}

/// Rectangles that span two intervals of distance from the line where their planes meet, and two along it.
fn perpendicular([x, z]: [[f64; 2]; 2], y: [[f64; 2]; 2]) -> f64 {
    let scale = unit(&[x, z, y[0], y[1]]);
    let g = |x: f64, y: f64, z: f64| {
        let (x, y, z) = (x / scale, y / scale, z / scale);
        let (s2, y2) = (x * x + z * z, y * y);
        let (s, r2) = (s2.sqrt(), s2 + y2);
        let logarithm = if r2 > 0.0 { 0.25 * (s2 - y2) * r2.ln() } else { 0.0 };
        y * s * y.atan2(s) - logarithm
    };
    let mut sum = 0.0;
    for (i, j, sign) in ENDS {
        for (k, l, other) in ENDS {
            sum += sign * other * g(x[i], y[0][k] - y[1][l], z[j]);
        }
    }
    (sum * scale * scale / TAU).max(0.0)
}

/// Ends of two intervals, and the product of their signs.
const ENDS: [(usize, usize, f64); 4] = [(0, 0, 1.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, 1.0)];

/// The longest distance within or between intervals: a unit of length in which logarithms are small.
fn unit(intervals: &[[f64; 2]]) -> f64 {
    let [low, high] = intervals.iter().fold([0.0_f64; 2], |[low, high], [from, to]| [low.min(*from), high.max(*to)]);
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::radiosity::form::contour;
    use crate::render::radiosity::form::published::{FACING, HINGED, facing, hinged, rectangle};
    use proptest::prelude::*;

    fn closed(a: &Polygon, b: &Polygon) -> Option<f64> {
        exchange(&Rectangle::of(a)?, &Rectangle::of(b)?)
    }

    fn factor([a, b]: [Polygon; 2]) -> f64 {
        closed(&a, &b).unwrap() / a.area()
    }

    #[test]
    fn published_factors() {
        // 15 digits are given; 16 terms of rounding, of the size of the longest distance's square per area.
        for (x, y, exact) in FACING {
            let found = factor(facing(x, y));
            assert!((found - exact).abs() < 3e-15 * (1.0 + 1.0 / (x * y)), "{x} {y}: {found}");
        }
        for (w, h, exact) in HINGED {
            let found = factor(hinged(w, h));
            assert!((found - exact).abs() < 5e-15, "{w} {h}: {found}");
        }
    }

    #[test]
    fn a_cube_is_closed() {
        // To the rounding of five results.
        assert!((factor(facing(1.0, 1.0)) + 4.0 * factor(hinged(1.0, 1.0)) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn only_what_is_in_front_is_exchanged() {
        let floor = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
        let exchange = |b: &Polygon| closed(&floor, b);
        assert_eq!(exchange(&floor), Some(0.0));
        assert_eq!(exchange(&rectangle(DVec3::Z, DVec3::X, DVec3::Y)), Some(0.0), "its back");
        assert_eq!(exchange(&rectangle(DVec3::NEG_Z, DVec3::Y, DVec3::X)), Some(0.0), "behind");
        assert_eq!(exchange(&rectangle(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y)), Some(0.0), "below the floor");
        assert_eq!(exchange(&rectangle(DVec3::X * 2.0, DVec3::Y, DVec3::Z)), Some(0.0), "facing away");
        // A wall through the floor, of which a half on each side counts, and turned by a right angle in its plane.
        let wall = rectangle(DVec3::new(0.5, 1.0, -1.0), DVec3::Z * 2.0, DVec3::NEG_Y);
        let front = rectangle(DVec3::new(0.5, 0.0, 0.0), DVec3::Y, DVec3::Z);
        let half = rectangle(DVec3::new(0.5, 0.0, 0.0), DVec3::X * 0.5, DVec3::Y);
        assert_eq!(wall.normal(), DVec3::X);
        assert!((exchange(&wall).unwrap() - closed(&half, &front).unwrap()).abs() < 1e-15);
        // Not aligned, or no rectangles.
        assert_eq!(exchange(&rectangle(DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, -1.0, 0.0))), None);
        assert_eq!(exchange(&rectangle(DVec3::Z, DVec3::Y, DVec3::new(1.0, 0.0, 0.1))), None);
        assert_eq!(Rectangle::of(&rectangle(DVec3::Z, DVec3::Y, DVec3::new(1.0, 1.0, 0.0))), None);
        assert_eq!(Rectangle::of(&Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap()), None);
    }

    proptest! {
        #[test]
        fn agrees_with_the_contours_in_any_frame(
            at in prop::array::uniform3(-1.5..1.5_f64), size in prop::array::uniform4(0.1..1.5_f64),
            which in 0..6_usize, turn in 0.0..1.5_f64,
        ) {
            let rotation = glam::DQuat::from_rotation_y(turn) * glam::DQuat::from_rotation_z(0.7 * turn);
            let turned = |corner: DVec3, x: DVec3, y: DVec3| {
                rectangle(rotation * corner + DVec3::splat(3.0), rotation * x, rotation * y)
            };
            let a = turned(DVec3::ZERO, DVec3::X * size[0], DVec3::Y * size[1]);
            let (x, y) = [
                (DVec3::Y, DVec3::X), (DVec3::NEG_Y, DVec3::NEG_X), (DVec3::Y, DVec3::Z),
                (DVec3::Z, DVec3::Y), (DVec3::X, DVec3::Z), (DVec3::Z, DVec3::X),
            ][which];
            let b = turned(DVec3::from(at), x * size[2], y * size[3]);
            let (value, exact) = (closed(&a, &b).unwrap(), contour::exchange(&a, &b));
            // Lengths of up to 5, and the rounding of rotated corners.
            prop_assert!((value - exact).abs() < 1e-13, "{value:e} {exact:e}");
        }
    }
}
