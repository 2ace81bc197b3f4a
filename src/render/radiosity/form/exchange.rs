//! The exchange between two polygons to a given relative accuracy, by the cheapest way there is.

use glam::DVec3;

use super::quadrature::{Quadrature, orders, sum};
use super::{contour, rectangles};
use crate::render::radiosity::polygon::Polygon;

/// The relative error that is asked for where nothing else is.
pub const TOLERANCE: f64 = 1e-6;

/// Heights below this share of the distance and the radii are none: the rounding of coordinates.
const ON_PLANE: f64 = 1e-12;

/// The way an exchange was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// There is none: one is behind the other, or both are in a plane.
    None,
    /// By quadrature with so many nodes along the lines of either.
    Nodes([usize; 2]),
    /// In closed form, as rectangles.
    Rectangles,
    /// By the contours.
    Contour,
}

/// A F of the light that leaves the front of `a` and reaches the front of `b`, and the other way round, nothing in between
/// \[m²\], with a relative error of [`TOLERANCE`] at most.
pub fn exchange(a: &Polygon, b: &Polygon) -> f64 {
    of_pair(&Quadrature::without_nodes(a.clone()), &Quadrature::without_nodes(b.clone()), TOLERANCE).0
}

/// The same for polygons that are paired with many, with the relative error that is asked for, and the way it was found.
///
/// What rounding leaves comes on top: the product of the perimeters times 1e-15 near by, a few times 1e-16 of the exchange
/// elsewhere.
pub fn of_pair(a: &Quadrature, b: &Quadrature, tolerance: f64) -> (f64, Route) {
    match in_front(a.polygon(), b.polygon()) {
        Front::Nothing => (0.0, Route::None),
        Front::Everything => uncut(a, b, tolerance),
        Front::Part => cut(a.polygon(), b.polygon()).map_or((0.0, Route::None), |(a, b)| {
            uncut(&Quadrature::without_nodes(a), &Quadrature::without_nodes(b), tolerance)
        }),
    }
}

fn uncut(a: &Quadrature, b: &Quadrature, tolerance: f64) -> (f64, Route) {
    if let Some(orders) = orders(a, b, tolerance) {
        return (sum(a, b, orders), Route::Nodes(orders));
    }
    let closed = a.rectangle().zip(b.rectangle()).and_then(|(a, b)| rectangles::exchange(a, b));
    let (a, b) = (a.polygon(), b.polygon());
    let extent = a.centroid().distance(b.centroid()) + a.radius() + b.radius();
    match closed {
        Some(value) if rectangles::ERROR * extent * extent <= tolerance * value => (value, Route::Rectangles),
        _ => (contour::between(a, b).max(0.0), Route::Contour),
    }
}

/// How much of two polygons is in front of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Front {
    Nothing,
    Part,
    Everything,
}

pub(super) fn in_front(a: &Polygon, b: &Polygon) -> Front {
    let apart = b.centroid() - a.centroid();
    match (above(a, b, apart), above(b, a, -apart)) {
        (Front::Nothing, _) | (_, Front::Nothing) => Front::Nothing,
        (Front::Everything, Front::Everything) => Front::Everything,
        _ => Front::Part,
    }
}

/// How much of `b` is in front of `a`; `apart` is the way from the centre of a to that of b.
fn above(a: &Polygon, b: &Polygon, apart: DVec3) -> Front {
    let height = apart.dot(a.normal());
    if height >= b.radius() {
        return Front::Everything;
    }
    if height <= -b.radius() {
        return Front::Nothing;
    }
    let none = ON_PLANE * (apart.length() + a.radius() + b.radius());
    let heights = b.corners().iter().map(|corner| a.distance_above(*corner));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    match (low >= -none, high > none) {
        (_, false) => Front::Nothing,
        (true, true) => Front::Everything,
        (false, true) => Front::Part,
    }
}

/// Of each polygon the part in front of the other.
pub(super) fn cut(a: &Polygon, b: &Polygon) -> Option<(Polygon, Polygon)> {
    a.above(b.centroid(), b.normal()).zip(b.above(a.centroid(), a.normal()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn grid(out: &mut Vec<Polygon>, corner: DVec3, x: DVec3, y: DVec3, [columns, rows]: [u32; 2]) {
        let (x, y) = (x / f64::from(columns), y / f64::from(rows));
        for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
            let p = corner + x * f64::from(i) + y * f64::from(j);
            out.push(Polygon::new(vec![p, p + x, p + x + y, p + y]).unwrap());
        }
    }

    /// The inside of the unit cube, in n × n squares a side.
    fn cube(n: u32) -> Vec<Polygon> {
        let mut out = Vec::new();
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        for (corner, u, v) in
            [(DVec3::ZERO, x, y), (z, y, x), (DVec3::ZERO, z, x), (y, x, z), (DVec3::ZERO, y, z), (x, z, y)]
        {
            grid(&mut out, corner, u, v, [n, n]);
        }
        out
    }

    /// A box that stands in the cube, turned about the vertical: its faces' planes cut the walls' patches.
    fn block(out: &mut Vec<Polygon>, corner: DVec3, size: DVec3, turn: f64, [around, up]: [u32; 2]) {
        let (sin, cos) = turn.sin_cos();
        let (x, y, z) = (DVec3::new(cos, sin, 0.0) * size.x, DVec3::new(-sin, cos, 0.0) * size.y, DVec3::Z * size.z);
        grid(out, corner + z, x, y, [around, around]);
        for (corner, along) in [(corner, x), (corner + x, y), (corner + x + y, -x), (corner + y, -y)] {
            grid(out, corner, along, z, [around, up]);
        }
    }

    fn furnished(n: u32) -> Vec<Polygon> {
        let mut out = cube(n);
        block(&mut out, DVec3::new(0.25, 0.1, 0.0), DVec3::splat(0.3), 0.3, [n / 3, n / 3]);
        block(&mut out, DVec3::new(0.6, 0.5, 0.0), DVec3::new(0.3, 0.3, 0.6), -0.3, [n / 3, 2 * n / 3]);
        out
    }

    /// Squares cut into triangles.
    fn halves(squares: &[Polygon]) -> Vec<Polygon> {
        let half = |c: &[DVec3], i: usize| Polygon::new(vec![c[0], c[i], c[i + 1]]).unwrap();
        squares.iter().flat_map(|square| [1, 2].map(|i| half(square.corners(), i))).collect()
    }

    /// The largest and the mean square of the relative error of `value`, over every `every`-th pair that exchanges
    /// something, against the contours.
    fn errors(patches: &[Quadrature], every: usize, value: impl Fn(&Quadrature, &Quadrature) -> f64) -> [f64; 2] {
        let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
        let pairs = (0..patches.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        for (i, j) in pairs.step_by(every) {
            let (a, b) = (&patches[i], &patches[j]);
            let exact = contour::exchange(a.polygon(), b.polygon());
            if exact == 0.0 {
                assert_eq!(value(a, b), 0.0);
                continue;
            }
            // What the contours themselves may be wrong by: 1e-15 of the product of two perimeters.
            let noise = 1e-15 * (8.0 * a.polygon().radius()) * (8.0 * b.polygon().radius()) / exact;
            let error = ((value(a, b) / exact - 1.0).abs() - noise).max(0.0);
            worst = worst.max(error);
            squares += error * error;
            count += 1.0;
        }
        assert!(count > 1000.0, "{count}");
        [worst, (squares / count).sqrt()]
    }

    #[test]
    fn the_tolerance_is_met_by_all_pairs_of_a_furnished_room() {
        let rooms = [furnished(6), furnished(9), halves(&furnished(5))];
        for (room, every) in rooms.iter().zip([1, 7, 7]) {
            let patches: Vec<Quadrature> = room.iter().map(Quadrature::of).collect();
            for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
                let [worst, rms] = errors(&patches, every, |a, b| of_pair(a, b, tolerance).0);
                assert!(worst <= tolerance && rms <= 0.2 * tolerance, "{tolerance:e}: {worst:e} {rms:e}");
            }
        }
    }

    /// A triangle, rectangle, trapezoid or ellipse of eight corners, of any direction, up to ten times as long as wide.
    fn any_shape(size: f64, c: [f64; 8], kind: usize) -> Option<Polygon> {
        let turn = DQuat::from_xyzw(c[0], c[1], c[2], c[3]).normalize();
        let (x, y) = (turn * DVec3::X * size, turn * DVec3::Y * size * 10.0_f64.powf(c[4]));
        let p = DVec3::new(c[5], c[6], c[7]);
        let corners = match kind {
            0 => vec![p, p + x, p + y],
            1 => vec![p, p + x, p + x + y, p + y],
            2 => vec![p, p + x, p + 0.3 * x + y, p + y],
            _ => (0..8).map(|i| f64::from(i) * PI / 4.0).map(|t| p + t.cos() * x + t.sin() * y).collect(),
        };
        Polygon::new(corners).ok()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn the_tolerance_is_met_by_shapes_of_all_sizes(
            a in prop::array::uniform8(-1.0..1.0_f64), b in prop::array::uniform8(-1.0..1.0_f64),
            kinds in (0..4_usize, 0..4_usize), sizes in (-2.0..0.0_f64, -2.0..0.0_f64), digits in 1..9_i32,
        ) {
            let shapes = any_shape(10.0_f64.powf(sizes.0), a, kinds.0).zip(any_shape(10.0_f64.powf(sizes.1), b, kinds.1));
            let Some((a, b)) = shapes else { return Err(TestCaseError::reject("no shape")) };
            let exact = contour::exchange(&a, &b);
            let (value, route) = of_pair(&Quadrature::of(&a), &Quadrature::of(&b), 10.0_f64.powi(-digits));
            let rounding = 1e-15 * (8.0 * a.radius()) * (8.0 * b.radius());
            let error = (value - exact).abs();
            prop_assert!(error <= 10.0_f64.powi(-digits) * exact + rounding, "{route:?} {value:e} {exact:e}");
        }
    }

    #[test]
    fn patches_without_nodes_are_no_different() {
        let room = furnished(3);
        for (i, a) in room.iter().enumerate() {
            for b in &room[..i] {
                assert_eq!(exchange(a, b), of_pair(&Quadrature::of(a), &Quadrature::of(b), TOLERANCE).0);
            }
        }
    }

    #[test]
    fn the_centres_alone_are_the_broken_twin() {
        let kernel = |a: &Quadrature, b: &Quadrature| {
            let (a, b) = (a.polygon(), b.polygon());
            let line = b.centroid() - a.centroid();
            let cosines = line.dot(a.normal()).max(0.0) * (-line.dot(b.normal())).max(0.0);
            cosines * a.area() * b.area() / (PI * line.length_squared().powi(2))
        };
        let patches: Vec<Quadrature> = cube(6).iter().map(Quadrature::of).collect();
        let [worst, rms] = errors(&patches, 1, kernel);
        assert!(worst > 0.3 && rms > 0.02, "{worst} {rms}");
    }

    #[test]
    fn rows_of_a_closed_room_add_up_to_one() {
        let patches: Vec<Quadrature> = cube(5).iter().map(Quadrature::of).collect();
        for a in &patches {
            let row: f64 = patches.iter().map(|b| of_pair(a, b, 1e-6).0).sum();
            assert!((row / a.polygon().area() - 1.0).abs() < 3e-7, "{:e}", row / a.polygon().area() - 1.0);
        }
    }

    #[test]
    fn every_way_is_taken() {
        let room = furnished(6);
        let patches: Vec<Quadrature> = room.iter().map(Quadrature::of).collect();
        let mut seen = [0_usize; 4];
        for (i, a) in patches.iter().enumerate() {
            for b in &patches[..i] {
                match of_pair(a, b, 1e-5).1 {
                    Route::None => seen[0] += 1,
                    Route::Nodes(_) => seen[1] += 1,
                    Route::Rectangles => seen[2] += 1,
                    Route::Contour => seen[3] += 1,
                }
            }
        }
        assert!(seen[1] > 20 * seen[2] && seen[2] > 100 && seen[3] > 100 && seen[0] > 1000, "{seen:?}");
        assert_eq!(of_pair(&patches[0], &patches[1], 1e-5), (0.0, Route::None), "of one floor");
    }

    #[test]
    fn polygons_of_any_number_of_corners() {
        let regular = |n: i32, z: f64, sign: f64| {
            let corner = |i: i32| sign * f64::from(i) * 2.0 * PI / f64::from(n);
            Polygon::new((0..n).map(corner).map(|t| DVec3::new(t.cos(), t.sin() + 0.3 * z, z)).collect()).unwrap()
        };
        for n in 3..=8 {
            for distance in [1.0, 3.0, 8.0, 60.0] {
                let (a, b) = (regular(n, 0.0, 1.0), regular(11 - n, distance, -1.0));
                let exact = contour::exchange(&a, &b);
                for tolerance in [1e-3, 1e-6, 1e-9] {
                    let (value, route) = of_pair(&Quadrature::of(&a), &Quadrature::of(&b), tolerance);
                    assert!(
                        (value / exact - 1.0).abs() <= tolerance,
                        "{n} {distance} {tolerance:e} {route:?}: {value:e} {exact:e}"
                    );
                }
            }
        }
    }
}
