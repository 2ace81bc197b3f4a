//! Convex plane polygons: what patches are made of.
//!
//! Corners run counter-clockwise as seen from the side that the normal points to: n · Σ cᵢ × cᵢ₊₁ > 0.
//! # References
//! - Sutherland & Hodgman 1974, Reentrant polygon clipping, CACM 17(1)

use glam::{DVec2, DVec3};
use thiserror::Error;

/// How far from plane, and from convex, a polygon may be, relative to its radius: what the rounding of coordinates of
/// single precision, a hundred times as large as the polygon, may leave of it.
pub const FLATNESS: f64 = 1e-5;

/// Distances below this share of the lengths that they were computed from are taken for zero when cutting: a few
/// thousand times the rounding, and too little to be seen in any exchange.
const ON_PLANE: f64 = 1e-12;

/// Why corners do not make a polygon.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PolygonError {
    /// After repeated corners were dropped there are fewer than three.
    #[error("a polygon needs 3 different corners, and has {0}")]
    TooFewCorners(usize),
    /// A coordinate is not a finite number.
    #[error("corner {0} of a polygon is not finite")]
    NotFinite(usize),
    /// The corners lie on a line.
    #[error("the corners of a polygon lie on a line")]
    NoArea,
    /// A corner is off the plane.
    #[error("a polygon is not plane: a corner is off by {0:.1e} of its radius (at most {FLATNESS:.0e})")]
    NotPlane(f64),
    /// A corner lies outside an edge.
    #[error("a polygon is not convex: a corner is outside an edge by {0:.1e} of its radius (at most {FLATNESS:.0e})")]
    NotConvex(f64),
}

/// A convex plane polygon with a front: the side from which its corners run counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: Vec<DVec3>,
    normal: DVec3,
    area: f64,
    centroid: DVec3,
    radius: f64,
}

impl Polygon {
    /// The polygon with these corners, counter-clockwise as seen from its front. Repeated corners are dropped; corners
    /// on the line between their neighbours are kept.
    pub fn new(mut corners: Vec<DVec3>) -> Result<Self, PolygonError> {
        if let Some(i) = corners.iter().position(|corner| !corner.is_finite()) {
            return Err(PolygonError::NotFinite(i));
        }
        drop_repeated(&mut corners, 0.0);
        if corners.len() < 3 {
            return Err(PolygonError::TooFewCorners(corners.len()));
        }
        let twice = twice_area(&corners);
        let extent = corners.iter().map(|corner| corner.distance(corners[0])).fold(0.0, f64::max);
        let area = twice.length();
        // Thinner than that, the normal is made of rounding.
        if area <= ON_PLANE * extent * extent {
            return Err(PolygonError::NoArea);
        }
        let polygon = Self::made_of(corners, twice / area);
        let off_plane = polygon.corners.iter().map(|&corner| polygon.distance_above(corner).abs()).fold(0.0, f64::max);
        if off_plane > FLATNESS * polygon.radius {
            return Err(PolygonError::NotPlane(off_plane / polygon.radius));
        }
        let inside = polygon.corners.iter().map(|&corner| polygon.distance_inside(corner)).fold(0.0, f64::min);
        if inside < -FLATNESS * polygon.radius {
            return Err(PolygonError::NotConvex(-inside / polygon.radius));
        }
        Ok(polygon)
    }

    /// Of corners and a normal known to be in order.
    fn made_of(corners: Vec<DVec3>, normal: DVec3) -> Self {
        let (mut area, mut moment) = (0.0, DVec3::ZERO);
        for (a, b) in fan(&corners) {
            let part = 0.5 * a.cross(b).dot(normal);
            area += part;
            moment += part * (a + b) / 3.0;
        }
        let centroid = corners[0] + moment / area;
        let radius = corners.iter().map(|corner| corner.distance(centroid)).fold(0.0, f64::max);
        Self { corners, normal, area, centroid, radius }
    }

    /// The corners, counter-clockwise as seen from the front.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// The edges, from corner to corner.
    pub fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// The unit normal, on the front.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The area \[m²\].
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The centre of mass.
    pub fn centroid(&self) -> DVec3 {
        self.centroid
    }

    /// Radius of the sphere about the centroid that holds all corners \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The same, seen from its back.
    pub fn flipped(&self) -> Self {
        let mut flipped = self.clone();
        flipped.corners.reverse();
        flipped.normal = -self.normal;
        flipped
    }

    /// Signed distance of `p` from the plane, positive in front \[m\].
    pub fn distance_above(&self, p: DVec3) -> f64 {
        (p - self.centroid).dot(self.normal)
    }

    /// How far inside the edges the projection of `p` to the plane is \[m\]: the distance to the nearest edge if it is
    /// inside; outside, negative, the distance to the line of the edge that it is farthest out of.
    pub fn distance_inside(&self, p: DVec3) -> f64 {
        let of_edge = |(a, b): (DVec3, DVec3)| self.normal.cross((b - a).normalize()).dot(p - a);
        self.edges().map(of_edge).fold(f64::INFINITY, f64::min)
    }

    /// The part of the polygon on the side of a plane that `plane_normal`, a unit vector, points to; None where none is.
    ///
    /// Corners are taken to be on the plane that are closer to it than 1e-12 of their distance from `plane_point`.
    pub fn above(&self, plane_point: DVec3, plane_normal: DVec3) -> Option<Self> {
        let heights = |corner: &DVec3| {
            let offset = *corner - plane_point;
            let height = offset.dot(plane_normal);
            if height.abs() <= ON_PLANE * (offset.length() + self.radius) { 0.0 } else { height }
        };
        let heights: Vec<f64> = self.corners.iter().map(heights).collect();
        if heights.iter().all(|&height| height >= 0.0) {
            return heights.iter().any(|&height| height > 0.0).then(|| self.clone());
        }
        let mut kept = Vec::with_capacity(self.corners.len() + 1);
        for (i, (a, b)) in self.edges().enumerate() {
            let (from, to) = (heights[i], heights[(i + 1) % heights.len()]);
            if from >= 0.0 {
                kept.push(a);
            }
            if from * to < 0.0 {
                // From the lower end to the upper, whichever way the edge runs: neighbours find the same point.
                let (low, high, down, up) = if from < to { (a, b, from, to) } else { (b, a, to, from) };
                kept.push(low + (high - low) * (down / (down - up)));
            }
        }
        drop_repeated(&mut kept, ON_PLANE * self.radius);
        let area = 0.5 * twice_area(&kept).dot(self.normal);
        (kept.len() >= 3 && area > ON_PLANE * ON_PLANE * self.area).then(|| Self::made_of(kept, self.normal))
    }

    /// Maps the unit square to points of the polygon, uniformly in area.
    ///
    /// Linearly for a parallelogram, so that a stratified pattern stays one; else a fan of triangles, laid side by side
    /// along `u.x`.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let c = &self.corners;
        let origin = c[0];
        if let [_, next, opposite, last] = c[..] {
            let (x, y) = (next - origin, last - origin);
            if (opposite - origin - x - y).length() <= ON_PLANE * self.radius {
                return origin + u.x * x + u.y * y;
            }
        }
        let mut left = u.x * self.area;
        let last = c.len() - 3;
        for (i, (a, b)) in fan(c).enumerate() {
            let part = 0.5 * a.cross(b).dot(self.normal);
            if left < part || i == last {
                // Across, from the fan's corner outwards; along, from a to b.
                let across = u.y.sqrt();
                let along = (left / part).clamp(0.0, 1.0);
                return origin + across * (a + along * (b - a));
            }
            left -= part;
        }
        self.centroid
    }
}

/// The sides from the first corner of the triangles that make up the polygon.
fn fan(corners: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    corners[1..].windows(2).map(|pair| (pair[0] - corners[0], pair[1] - corners[0]))
}

/// The normal times twice the area.
fn twice_area(corners: &[DVec3]) -> DVec3 {
    if corners.len() < 3 { DVec3::ZERO } else { fan(corners).map(|(a, b)| a.cross(b)).sum() }
}

/// Drops corners that are no farther than `distance` from the one before.
fn drop_repeated(corners: &mut Vec<DVec3>, distance: f64) {
    corners.dedup_by(|b, a| a.distance(*b) <= distance);
    while let [first, .., last] = corners[..] {
        if first.distance(last) > distance {
            break;
        }
        corners.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn polygon(corners: &[[f64; 3]]) -> Result<Polygon, PolygonError> {
        Polygon::new(corners.iter().copied().map(DVec3::from).collect())
    }

    fn trapezoid() -> Polygon {
        polygon(&[[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 1.0]]).unwrap()
    }

    #[test]
    fn a_trapezoid_is_measured() {
        let p = trapezoid();
        assert_eq!((p.normal(), p.area(), p.flipped().normal()), (DVec3::Z, 6.0, DVec3::NEG_Z));
        // Height of the centroid: h/3 · (a + 2b)/(a + b) = 2/3 · 8/6; farthest are the lower corners.
        assert!((p.centroid() - DVec3::new(2.0, 8.0 / 9.0, 1.0)).length() < 1e-15);
        assert!((p.radius() - 2.0_f64.hypot(8.0 / 9.0)).abs() < 1e-15);
        assert_eq!(p.distance_above(DVec3::new(9.0, 9.0, 3.0)), 2.0);
        assert_eq!(p.distance_inside(DVec3::new(2.0, 0.5, 7.0)), 0.5);
        assert_eq!(p.distance_inside(DVec3::new(2.0, -0.5, 7.0)), -0.5);
        assert_eq!(p.edges().last(), Some((DVec3::new(1.0, 2.0, 1.0), DVec3::new(0.0, 0.0, 1.0))));
    }

    #[test]
    fn what_is_no_convex_plane_polygon_is_refused() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(polygon(&square[..2]), Err(PolygonError::TooFewCorners(2)));
        assert_eq!(polygon(&[square[0], square[1], square[1], square[0]]), Err(PolygonError::TooFewCorners(2)));
        assert_eq!(polygon(&[square[0], square[1], [f64::NAN; 3]]), Err(PolygonError::NotFinite(2)));
        assert_eq!(polygon(&[square[0], square[1], [3.0, 0.0, 0.0]]), Err(PolygonError::NoArea));
        let bent = |z| polygon(&[square[0], square[1], [1.0, 1.0, z], square[3]]);
        assert!(matches!(bent(0.01), Err(PolygonError::NotPlane(off)) if off > 1e-3) && bent(1e-7).is_ok());
        let dented = |x| polygon(&[square[0], square[1], [x, x, 0.0], square[3]]);
        assert!(matches!(dented(0.4), Err(PolygonError::NotConvex(_))) && dented(0.5).is_ok() && dented(0.6).is_ok());
        // Every corner of a pentagram turns left, and all the same it is none.
        let star = |i: i32| {
            DVec3::new((f64::from(2 * i) * 72.0).to_radians().cos(), (f64::from(2 * i) * 72.0).to_radians().sin(), 0.0)
        };
        assert!(matches!(Polygon::new((0..5).map(star).collect()), Err(PolygonError::NotConvex(_))));
    }

    #[test]
    fn repeated_corners_are_dropped_and_straight_ones_kept() {
        let p =
            polygon(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]).unwrap();
        assert_eq!((p.corners().len(), p.area()), (4, 1.0));
    }

    #[test]
    fn a_cut_keeps_what_is_above() {
        let p = trapezoid();
        let right = p.above(DVec3::X * 2.0, DVec3::X).unwrap();
        assert_eq!((right.area(), right.corners().len(), right.normal()), (3.0, 4, DVec3::Z));
        assert_eq!(p.above(DVec3::ZERO, DVec3::Z), Some(p.clone()));
        assert_eq!(p.above(DVec3::ZERO, DVec3::NEG_Z), None);
        // In the plane, and touching it with an edge or a corner from below: nothing is above.
        assert_eq!(p.above(DVec3::Z, DVec3::Z), None);
        assert_eq!(p.above(DVec3::ZERO, DVec3::NEG_Y), None);
        assert_eq!(p.above(DVec3::X * 4.0, DVec3::X), None);
        // A cut through a corner makes a triangle of it, without a corner twice.
        let half = p.above(DVec3::ZERO, DVec3::new(2.0, -3.0, 0.0).normalize()).unwrap();
        assert_eq!(half.corners().len(), 3);
        assert!((half.area() - 4.0).abs() < 1e-14);
    }

    proptest! {
        #[test]
        fn the_two_sides_of_a_cut_make_up_the_whole(x in 0.0..4.0_f64, y in 0.0..2.0_f64, turn in 0.0..std::f64::consts::TAU) {
            let (p, at) = (trapezoid(), DVec3::new(x, y, 1.0));
            let normal = DVec3::new(turn.cos(), turn.sin(), 0.3).normalize();
            let parts = [p.above(at, normal), p.above(at, -normal)];
            let area: f64 = parts.iter().flatten().map(Polygon::area).sum();
            prop_assert!((area - p.area()).abs() < 1e-12);
            for (part, sign) in parts.iter().zip([1.0, -1.0]) {
                let corners = part.iter().flat_map(Polygon::corners);
                prop_assert!(corners.into_iter().all(|c| sign * (*c - at).dot(normal) > -1e-11));
            }
        }
    }

    /// The mean and the second moments of the samples of a fine grid, with a sample of the triangle or linear.
    fn moments(sample: impl Fn(DVec2) -> DVec3) -> [f64; 4] {
        let n = 400;
        let mut sums = [0.0; 4];
        for i in 0..n * n {
            let u = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
            let p = sample(u);
            for (sum, moment) in sums.iter_mut().zip([p.x, p.y, p.x * p.x, p.y * p.y]) {
                *sum += moment / f64::from(n * n);
            }
        }
        sums
    }

    #[test]
    fn samples_are_uniform() {
        // ∫ over the trapezoid by its strips: width 4 − y centred at x = 2.
        let p = trapezoid();
        let width = |y: f64| 4.0 - y;
        let strips: [f64; 2] = [
            (0..2000)
                .map(|i| (f64::from(i) + 0.5) / 1000.0)
                .map(|y| 1e-3 * width(y) * (4.0 + width(y).powi(2) / 12.0))
                .sum(),
            (0..2000).map(|i| (f64::from(i) + 0.5) / 1000.0).map(|y| 1e-3 * width(y) * y * y).sum(),
        ];
        let exact = [2.0, 8.0 / 9.0, strips[0] / 6.0, strips[1] / 6.0];
        // 400 midpoints a side, and a seam of two triangles through them: an error of 1/400 in the strip at the seam.
        let close = |m: [f64; 4]| m.iter().zip(exact).all(|(m, e)| (m - e).abs() < 2e-3);
        assert!(close(moments(|u| p.sample(u))));
        // The broken twin, bilinear: dense where the trapezoid is narrow.
        let c = p.corners();
        let bilinear = |u: DVec2| c[0].lerp(c[1], u.x).lerp(c[3].lerp(c[2], u.x), u.y);
        assert!(!close(moments(bilinear)));
        let square = polygon(&[[0.0; 3], [2.0, 0.0, 0.0], [3.0, 1.0, 0.0], [1.0, 1.0, 0.0]]).unwrap();
        assert_eq!(square.sample(DVec2::new(0.25, 0.5)), DVec3::new(1.0, 0.5, 0.0));
        assert!(p.distance_inside(p.sample(DVec2::new(0.999_999, 0.999_999))) > -1e-9);
    }
}
