//! The exchange between any two polygons, by their contours.
//!
//! A F = 1/(2π) ∮∮ ln r dr·dr'   \[m²\]
//!
//! Each polygon is first cut to the half space in front of the other. Along an edge of one, seen from a point p of the
//! other's contour, the integral is known: with x the position along the edge's line from the foot of p on it, h the
//! distance of p from the line, and θ the angle under which the edge is seen,
//!
//! ∫ ln r dx = [x ln r − x] + h θ
//!
//! (−x adds a constant along closed contours, which integrates to nothing, and is left out). Along the other contour it
//! is integrated by Gauss-Legendre rules on panels. What remains has singularities where p meets an end of the edge, or
//! its line within the edge. These are points of the complex plane about p's own edge, at known places; a panel is split
//! until all of them are outside an ellipse about it in which the rule is exact to rounding.
//!
//! Two polygons that touch put a singularity on the contour itself, like x ln x; towards it panels shrink by 4.
//! # References
//! - Schröder & Hanrahan 1993, On the form factor between two polygons, SIGGRAPH (the double contour integral)
//! - Trefethen 2008, Is Gauss quadrature better than Clenshaw-Curtis? SIAM Review 50(1), theorem 4.5 (the ellipse)

use std::f64::consts::TAU;

use glam::DVec3;

use super::gauss::SIXTEEN;
use crate::math::sum::Neumaier;
use crate::render::radiosity::polygon::Polygon;

/// Sum of the distances of a singularity from a panel's ends, in half widths, from which on it is left alone. The sum
/// is ϱ + 1/ϱ, and the error of 16 nodes falls as ϱ^−32: 1e-13 for ϱ = 2.6, times a small factor, as the singularities
/// are those of x ln x and |x|.
const CLEAR: f64 = 3.0;

/// Panels narrower than this share of the edge are not split: the error of the rule for x ln x over a width w is of the
/// order of 1e-5 w².
const NARROWEST: f64 = 1e-7;

/// A F of the light that leaves the front of `a` and reaches the front of `b`, nothing in between, and the same the
/// other way round \[m²\].
///
/// The absolute error is about 1e-15 ∮|dr| ∮|dr'|, for polygons that touch as for others; so relative to the exchange it
/// grows as d/s for polygons of size s at a distance d.
pub fn exchange(a: &Polygon, b: &Polygon) -> f64 {
    let front_of_b = a.above(b.centroid(), b.normal());
    let front_of_a = b.above(a.centroid(), a.normal());
    front_of_b.zip(front_of_a).map_or(0.0, |(a, b)| between(&a, &b).max(0.0))
}

/// The same for polygons of which each is wholly in front of the other.
pub(super) fn between(a: &Polygon, b: &Polygon) -> f64 {
    // The smaller contour is the one that is short of singularities nearby.
    let (outer, inner) = if b.radius() < a.radius() { (b, a) } else { (a, b) };
    // Any unit of length will do; this one makes the logarithms small.
    let unit = a.centroid().distance(b.centroid()).max(inner.radius());
    let edges: Vec<Edge> = inner.edges().map(|(from, to)| Edge::new(from, to)).collect();
    let mut sum = Neumaier::default();
    let mut panels = Vec::new();
    for (from, to) in outer.edges() {
        let along = Edge::new(from, to);
        for edge in &edges {
            let cosine = along.direction.dot(edge.direction);
            if cosine != 0.0 {
                sum.add(cosine * integrate(&along, edge, unit.recip(), &mut panels));
            }
        }
    }
    sum.value() / TAU
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    from: DVec3,
    to: DVec3,
    direction: DVec3,
    length: f64,
}

impl Edge {
    fn new(from: DVec3, to: DVec3) -> Self {
        let length = from.distance(to);
        Self { from, to, direction: (to - from) / length, length }
    }

    /// ∫ ln(r/unit) along the edge, from `p`, without the constant.
    fn logarithm(&self, p: DVec3, per_unit: f64) -> f64 {
        let (v, w) = (self.from - p, self.to - p);
        let (x0, x1) = (v.dot(self.direction), w.dot(self.direction));
        let h = v.cross(self.direction).length();
        let term = |x: f64, v: DVec3| if x == 0.0 { 0.0 } else { x * (v.length() * per_unit).ln() };
        term(x1, w) - term(x0, v) + h * (h * self.length).atan2(h * h + x0 * x1)
    }

    /// Where the function [`Self::logarithm`] of the position along `line` is singular: real and imaginary part.
    fn singularities(&self, line: &Self) -> [(f64, f64); 3] {
        let end = |q: DVec3| {
            let v = q - line.from;
            (v.dot(line.direction), v.cross(line.direction).length())
        };
        // The two lines at their closest: distance d, at an angle φ; h = 0 at a distance d/sin φ off the real axis.
        let across = line.direction.cross(self.direction);
        let sine2 = across.length_squared();
        let offset = self.from - line.from;
        let at = offset.cross(self.direction).dot(across) / sine2;
        let on_edge = offset.cross(line.direction).dot(across) / sine2;
        let close = (0.0..=self.length).contains(&on_edge);
        let lines = if close { (at, offset.dot(across).abs() / sine2) } else { (f64::INFINITY, 0.0) };
        [end(self.from), end(self.to), lines]
    }
}

/// ∫ of `edge.logarithm` along `line`.
fn integrate(line: &Edge, edge: &Edge, per_unit: f64, panels: &mut Vec<(f64, f64)>) -> f64 {
    let singularities = edge.singularities(line);
    let narrowest = NARROWEST * line.length;
    let mut sum = 0.0;
    panels.push((0.0, line.length));
    while let Some((from, to)) = panels.pop() {
        let width = to - from;
        // In half widths; of infinity only that it is far.
        let clearance = |&(x, y): &(f64, f64)| 2.0 * ((x - from).hypot(y) + (x - to).hypot(y)) / width;
        let nearest = singularities.iter().min_by(|a, b| clearance(a).total_cmp(&clearance(b)));
        if let Some(nearest) = nearest.filter(|nearest| clearance(nearest) < CLEAR && width > narrowest) {
            let quarter = 0.25 * width;
            let inside = nearest.0 - from > 0.125 * width && to - nearest.0 > 0.125 * width;
            let at = match nearest.0 {
                x if inside => x,
                x if x - from < to - x => from + quarter,
                _ => to - quarter,
            };
            panels.extend([(from, at), (at, to)]);
            continue;
        }
        let mut panel = 0.0;
        for (x, weight) in SIXTEEN.iter() {
            panel += weight * edge.logarithm(line.from + (from + width * x) * line.direction, per_unit);
        }
        sum += width * panel;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::adaptive;
    use crate::render::radiosity::form::point::factor;
    use crate::render::radiosity::form::published::{FACING, HINGED, facing, hinged, rectangle};
    use crate::render::radiosity::form::rectangles::{self, Rectangle};
    use glam::DQuat;
    use proptest::prelude::*;

    fn polygon(corners: &[[f64; 3]]) -> Polygon {
        Polygon::new(corners.iter().copied().map(DVec3::from).collect()).unwrap()
    }

    /// The exchange of two unit squares with a common edge, at an angle.
    fn at_an_angle(degrees: f64) -> f64 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let floor = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
        exchange(&floor, &rectangle(DVec3::ZERO, DVec3::Y, DVec3::new(cos, 0.0, sin)))
    }

    #[test]
    fn published_factors() {
        let factor = |[a, b]: [Polygon; 2]| exchange(&a, &b) / a.area();
        for (x, y, exact) in FACING {
            let found = factor(facing(x, y));
            assert!((found - exact).abs() < 2e-15, "{x} {y}: {found}");
        }
        for (w, h, exact) in HINGED {
            let found = factor(hinged(w, h));
            assert!((found - exact).abs() < 2e-14, "{w} {h}: {found}");
        }
        // 12 digits are given.
        assert!((at_an_angle(30.0) - 0.619028323091).abs() < 1e-12, "{}", at_an_angle(30.0));
        assert!((at_an_angle(120.0) - 0.086615001118).abs() < 1e-12, "{}", at_an_angle(120.0));
        assert_eq!(at_an_angle(180.0), 0.0);
        assert!(at_an_angle(-90.0) == 0.0 && at_an_angle(1.0) > 0.98 && at_an_angle(1.0) < 1.0);
    }

    #[test]
    fn a_cube_is_closed_also_when_it_is_turned_and_cut_up() {
        let turn = DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(1.1);
        let at = |x: f64, y: f64, z: f64| turn * DVec3::new(x, y, z) + DVec3::new(2.0, 1.0, 0.5);
        let floor =
            Polygon::new(vec![at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(0.0, 1.0, 0.0)]).unwrap();
        let others = [
            vec![at(0.0, 0.0, 1.0), at(0.0, 1.0, 1.0), at(1.0, 1.0, 1.0), at(1.0, 0.0, 1.0)],
            vec![at(0.0, 0.0, 0.0), at(0.0, 0.0, 1.0), at(1.0, 0.0, 1.0), at(1.0, 0.0, 0.0)],
            vec![at(0.0, 1.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 1.0, 1.0), at(0.0, 1.0, 1.0)],
            vec![at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 1.0, 1.0), at(0.0, 0.0, 1.0)],
            // A wall in two, that touch the floor with an edge and with a corner.
            vec![at(1.0, 0.0, 0.0), at(1.0, 1.0, 1.0), at(1.0, 1.0, 0.0)],
            vec![at(1.0, 0.0, 0.0), at(1.0, 0.0, 1.0), at(1.0, 1.0, 1.0)],
        ];
        let sum: f64 = others.into_iter().map(|corners| exchange(&floor, &Polygon::new(corners).unwrap())).sum();
        assert!((sum - 1.0).abs() < 1e-14, "{:e}", sum - 1.0);
    }

    #[test]
    fn empty_cornell_box() {
        let light =
            polygon(&[[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]]);
        let floor = polygon(&[[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]);
        let ceiling = polygon(&[[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]]);
        let back = polygon(&[[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]]);
        let green = polygon(&[[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]]);
        let front = polygon(&[[0.0, 0.0, 0.0], [552.8, 0.0, 0.0], [556.0, 548.8, 0.0], [0.0, 548.8, 0.0]]);
        // Not plane: in two triangles.
        let red = [
            polygon(&[[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2]]),
            polygon(&[[552.8, 0.0, 0.0], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]]),
        ];
        let to = |a: &Polygon, b: &Polygon| exchange(a, b) / a.area();
        let red_from = |a: &Polygon| red.iter().map(|part| to(a, part)).sum::<f64>();
        // Ten digits are given.
        let published = [
            (to(&light, &floor), 0.2415362002),
            (to(&light, &back), 0.1870956047),
            (to(&light, &green), 0.1906392295),
            (red_from(&light), 0.1931771920),
            (to(&light, &front), 0.1875517737),
            (to(&floor, &ceiling), 0.2043286693),
            (to(&floor, &back), 0.1979274433),
            (to(&floor, &green), 0.2007408957),
            (to(&floor, &front), 0.1985946721),
        ];
        for (value, exact) in published {
            assert!((value - exact).abs() < 1e-10, "{value} {exact}");
        }
        for from in [&light, &floor] {
            let closing = if from.normal().y > 0.0 { &ceiling } else { &floor };
            let sum = red_from(from) + [closing, &back, &green, &front].map(|b| to(from, b)).iter().sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-13, "{:e}", sum - 1.0);
        }
    }

    /// ∫ of the point factor of `b` over `a`, triangle by triangle, by nested adaptive rules.
    fn by_points(a: &Polygon, b: &Polygon, tol: f64) -> f64 {
        let corners = a.corners();
        let triangle = |pair: &[DVec3]| {
            let c = corners[0];
            let (u, v) = (pair[0] - c, pair[1] - c);
            let row = |t: f64| {
                let along = |s: f64| [factor(c + t * (u + s * (v - u)), a.normal(), b)];
                [t * adaptive(along, &[0.0, 1.0], tol, 300).value[0]]
            };
            adaptive(row, &[0.0, 1.0], tol, 300).value[0] * u.cross(v).length()
        };
        corners[1..].windows(2).map(triangle).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]
        #[test]
        fn agrees_with_point_factors_also_across_horizons(
            c in prop::array::uniform9(-1.0..1.0_f64), height in 0.1..0.6_f64, triangles in any::<bool>(),
        ) {
            let [o, p, q] = [0, 3, 6].map(|i| DVec3::new(c[i], c[i + 1], c[i + 2]));
            prop_assume!(p.cross(q).length() > 0.1);
            let (a, b) = (rectangle(DVec3::ZERO, DVec3::X, DVec3::Y), rectangle(o, p, q));
            let lowest = b.corners().iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
            let parts = |a: &Polygon| Polygon::new(a.corners()[..if triangles { 3 } else { 4 }].to_vec()).unwrap();
            let raised: Vec<DVec3> = b.corners().iter().map(|corner| *corner + DVec3::Z * (height - lowest)).collect();
            let (a, b) = (parts(&a), parts(&Polygon::new(raised).unwrap()));
            for b in [b.clone(), b.flipped()] {
                // Where the plane of b cuts a, the factor is 0 beyond: slivers of it would be missed by adaptive rules.
                let front = a.above(b.centroid(), b.normal());
                let exact = front.map_or(0.0, |front| by_points(&front, &b, 1e-12));
                // Two nested tolerances, and the noise that the inner one is to the outer.
                prop_assert!((exchange(&a, &b) - exact).abs() < 1e-11, "{:e} {exact:e}", exchange(&a, &b));
            }
        }
    }

    #[test]
    fn agrees_with_point_factors_to_eleven_digits_where_they_are_smooth() {
        let a = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 0.9, 0.0]]);
        let b = polygon(&[[0.1, 0.2, 0.8], [0.3, 1.1, 0.9], [1.2, 0.4, 1.0]]);
        let (value, exact) = (exchange(&a, &b), by_points(&a, &b, 1e-13));
        assert!((value - exact).abs() < 1e-13 && value > 0.05, "{value} {exact}");
        assert!((exchange(&b, &a) - value).abs() < 1e-15);
    }

    #[test]
    fn far_polygons_lose_digits_in_proportion_to_the_distance() {
        for distance in [10.0, 100.0, 1000.0] {
            let a = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
            let b = rectangle(DVec3::new(0.0, 0.0, distance), DVec3::Y, DVec3::X);
            let kernel = 2.0 / (TAU * distance * distance);
            let error = exchange(&a, &b) / kernel - 1.0;
            assert!(error.abs() < 1.0 / (distance * distance) + 1e-14 * distance, "{distance}: {error:e}");
        }
    }

    #[test]
    fn agrees_with_point_factors_where_the_two_cut_each_other() {
        let a = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
        let b = polygon(&[[0.0, 0.7, 0.15], [-0.7, 0.7, 0.015], [0.0, 1.6, -0.6]]);
        for b in [b.clone(), b.flipped()] {
            let front = a.above(b.centroid(), b.normal()).unwrap();
            // The factor goes from 0 to 1 about an end of the line of contact, wherever one is close to it.
            let error = exchange(&a, &b) - by_points(&front, &b, 1e-12);
            assert!(error.abs() < 1e-10, "{error:e}");
        }
        // The broken twin does not cut them: it counts what is behind as negative.
        assert!((between(&a, &b) - exchange(&a, &b)).abs() > 1e-4);
    }

    #[test]
    fn nearly_touching_tends_to_touching() {
        let floor = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
        let exact = 0.200043776075403;
        for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
            let wall = rectangle(DVec3::X * -gap, DVec3::Y, DVec3::Z);
            let closed = rectangles::exchange(&Rectangle::of(&floor).unwrap(), &Rectangle::of(&wall).unwrap()).unwrap();
            assert!((exchange(&floor, &wall) - closed).abs() < 1e-13, "{gap}");
            assert!((closed - exact).abs() < gap);
            // A blade over the middle of the floor, whose edge crosses the floor's lines of sight at a distance of gap.
            let blade = rectangle(DVec3::new(0.3, -0.2, gap), DVec3::new(0.2, 1.5, 0.0), DVec3::Z);
            let above = rectangle(DVec3::new(0.3, -0.2, 0.0), DVec3::new(0.2, 1.5, 0.0), DVec3::Z);
            assert!((exchange(&floor, &blade) - exchange(&floor, &above)).abs() < 2.0 * gap + 1e-12, "{gap}");
        }
    }
}
