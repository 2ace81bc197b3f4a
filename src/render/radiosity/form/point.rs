//! What share of the light that leaves a point of a surface reaches a polygon.
//!
//! F = −1/(2π) Σ Θᵢ Γᵢ·n,  Θᵢ the angle under which edge i is seen, Γᵢ = vᵢ × vᵢ₊₁ / |vᵢ × vᵢ₊₁|
//!
//! where vᵢ are the corners, seen from the point, and n is the normal there; only the part above the horizon counts, so
//! edges are cut there, and the arc along the horizon that closes the contour again is one edge more. The polygon is
//! seen from its front only.
//! # References
//! - Lambert 1760, Photometria; Baum, Rushmeier & Winget 1989, SIGGRAPH, eq. 9 (the same formula)

use std::f64::consts::TAU;

use glam::DVec3;

use crate::render::radiosity::polygon::Polygon;

/// The share of the diffuse light from `p`, where the normal is `n`, that reaches the front of `polygon`; nothing in
/// between. In [0, 1]; 0 for a point in the polygon's plane or behind it.
///
/// The error is a few roundings of Σ |Θᵢ| / 2π, whatever the position: for a polygon of size s at a distance d ≫ s,
/// 1e-16 d/s relative to F.
pub fn factor(p: DVec3, n: DVec3, polygon: &Polygon) -> f64 {
    if polygon.distance_above(p) <= 0.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    let (mut leaves, mut enters) = (None, None);
    for (a, b) in polygon.edges() {
        let (v, w) = (a - p, b - p);
        let (from, to) = (v.dot(n), w.dot(n));
        if from < 0.0 && to < 0.0 {
            continue;
        }
        // The edge itself, not the difference of what is seen: exact however far away it is.
        let edge = b - a;
        let crossing = || v + edge * (from / (from - to));
        if from < 0.0 {
            let at = crossing();
            enters = Some(at);
            sum += seen(at, w - at, n);
        } else if to < 0.0 {
            let at = crossing();
            leaves = Some(at);
            sum += seen(v, at - v, n);
        } else {
            sum += seen(v, edge, n);
        }
    }
    if let (Some(from), Some(to)) = (leaves, enters) {
        sum += seen(from, to - from, n);
    }
    (-sum / TAU).clamp(0.0, 1.0)
}

/// Θ Γ·n of the edge from `v` to `v + edge`.
fn seen(v: DVec3, edge: DVec3, n: DVec3) -> f64 {
    let cross = v.cross(edge);
    let (sine, cosine) = (cross.length(), v.dot(v + edge));
    if sine > 0.0 {
        return sine.atan2(cosine) * cross.dot(n) / sine;
    }
    // Seen end-on, where it covers no angle; or the point is on it, where the edge's plane is not defined.
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::radiosity::form::published::rectangle;
    use glam::DVec2;
    use std::f64::consts::{FRAC_1_PI, PI};

    /// The unit square at z = 1 that faces down.
    fn ceiling() -> Polygon {
        rectangle(DVec3::Z, DVec3::Y, DVec3::X)
    }

    /// Without the cut at the horizon: what lies below it counts as negative.
    fn uncut(p: DVec3, n: DVec3, polygon: &Polygon) -> f64 {
        -polygon.edges().map(|(a, b)| seen(a - p, b - a, n)).sum::<f64>() / TAU
    }

    #[test]
    fn published_factors_of_rectangles() {
        // The table gives 12 significant digits of π F.
        let up = |x: f64, y: f64| PI * factor(DVec3::new(x, y, 0.0), DVec3::Z, &ceiling());
        assert!((up(0.5, 0.5) - 0.752274688454).abs() < 1e-12);
        assert!((up(0.0, 0.0) - 0.435209875684).abs() < 1e-12);
        assert!((up(-1.0, -1.0) - 0.0362499303545).abs() < 1e-13);
        let below_a_corner = |a: f64| factor(DVec3::ZERO, DVec3::Z, &rectangle(DVec3::Z, DVec3::Y * a, DVec3::X * a));
        assert!((below_a_corner(1.0) - 0.138531605994893).abs() < 1e-15);
        assert!((below_a_corner(0.5) - 0.0598641176151934).abs() < 1e-15);
    }

    #[test]
    fn the_horizon_cuts_and_the_broken_twin_does_not() {
        let p = DVec3::new(0.25, 0.5, 0.0);
        assert!((PI * factor(p, DVec3::X, &ceiling()) - 0.159242507311).abs() < 1e-12);
        assert!((PI * uncut(p, DVec3::X, &ceiling()) - 0.133743693988).abs() < 1e-12);
        // The two agree where nothing is below.
        let p = DVec3::new(-0.25, 0.5, 0.0);
        assert_eq!(factor(p, DVec3::X, &ceiling()), uncut(p, DVec3::X, &ceiling()));
    }

    #[test]
    fn cornell_box_light_as_published() {
        let corner = DVec3::new(213.0, 548.8, 227.0);
        let light = rectangle(corner, DVec3::X * 130.0, DVec3::Z * 105.0);
        assert_eq!(light.normal(), DVec3::NEG_Y);
        let at = |x, y, z, n| PI * factor(DVec3::new(x, y, z), n, &light);
        // Nine or ten digits are given.
        assert!((at(278.0, 400.0, 559.2, DVec3::NEG_Z) - 0.0564689832).abs() < 1e-10);
        assert!((at(100.0, 450.0, 559.2, DVec3::NEG_Z) - 0.0271134669).abs() < 1e-10);
        assert!((at(0.0, 400.0, 279.6, DVec3::X) - 0.0586574891).abs() < 1e-10);
        assert!((at(368.5, 330.0, 351.25, DVec3::Y) - 0.169954967).abs() < 1e-9);
        assert!((at(185.5, 165.0, 169.0, DVec3::Y) - 0.0699268476).abs() < 1e-10);
    }

    #[test]
    fn a_point_close_to_the_polygon_sees_nothing_else() {
        for height in [1e-3, 1e-6, 1e-9, 1e-12] {
            let inside = factor(DVec3::new(0.3, 0.6, 1.0 - height), DVec3::Z, &ceiling());
            assert!((1.0 - inside) <= 20.0 * height * height + 1e-15, "{height}: {inside}");
            // Half of what it sees is beyond the edge.
            let over_edge = factor(DVec3::new(0.0, 0.6, 1.0 - height), DVec3::Z, &ceiling());
            assert!((over_edge - 0.5).abs() <= height, "{height}: {over_edge}");
            // Along the polygon, of which the half in front is seen.
            let along = factor(DVec3::new(0.3, 0.6, 1.0 - height), DVec3::X, &ceiling());
            assert!((along - 0.5).abs() <= 3.0 * height, "{height}: {along}");
        }
        assert_eq!(factor(DVec3::new(0.3, 0.6, 1.0), DVec3::Z, &ceiling()), 0.0, "in the plane");
        assert_eq!(factor(DVec3::new(0.3, 0.6, 2.0), DVec3::NEG_Z, &ceiling()), 0.0, "behind");
        assert_eq!(factor(DVec3::new(0.3, 0.6, 0.0), DVec3::NEG_Z, &ceiling()), 0.0, "below the horizon");
        // In the plane of an edge's end, and below an edge's own line: no angle, no NaN.
        assert!(factor(DVec3::new(0.0, -1.0, 0.0), DVec3::X, &ceiling()) > 0.0);
        assert!(factor(DVec3::ZERO, DVec3::Z, &rectangle(DVec3::Z, DVec3::Z, DVec3::X)) >= 0.0);
    }

    #[test]
    fn far_polygons_tend_to_the_kernel() {
        // F → A cos cos'/(π d²), with a relative error of the order of 1/d².
        for distance in [1e3, 1e5, 1e7] {
            let small = rectangle(DVec3::new(-0.5, -0.5, distance), DVec3::Y, DVec3::X);
            let kernel = FRAC_1_PI / (distance * distance);
            let error = factor(DVec3::ZERO, DVec3::Z, &small) / kernel - 1.0;
            assert!(error.abs() < 2.0 / (distance * distance) + 1e-15 * distance, "{distance}: {error:e}");
        }
    }

    #[test]
    fn an_enclosure_takes_everything() {
        let p = DVec3::new(0.2, 0.3, 0.0);
        let walls = [
            ceiling(),
            rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z),
            rectangle(DVec3::X, DVec3::Z, DVec3::Y),
            rectangle(DVec3::ZERO, DVec3::Z, DVec3::X),
            rectangle(DVec3::Y, DVec3::X, DVec3::Z),
        ];
        let sum = |n: DVec3| walls.iter().map(|wall| factor(p, n, wall)).sum::<f64>();
        assert!((sum(DVec3::Z) - 1.0).abs() < 1e-15);
        // Tilted by t, a share (1 − cos t)/2 sees the outside below.
        let tilted = DVec3::new(0.6, 0.0, 0.8);
        assert!((sum(tilted) - 0.9).abs() < 1e-15);
        assert_eq!(ceiling().sample(DVec2::ZERO), DVec3::Z);
    }
}
