//! The exchange between polygons that are not near each other, by Gauss-Legendre rules on both.
//!
//! A F = ∫∫ cos θ cos θ' / (π r²) dA dA' = Σᵢ Σⱼ wᵢ wⱼ h'ᵢ hⱼ / (π rᵢⱼ⁴)   \[m²\]
//!
//! where hⱼ is the height of the node j of one above the other's plane, and h'ᵢ the other way round: as they depend on
//! one node each, only r⁴ is left to the innermost loop. A polygon is mapped bilinearly from squares, triangles with two
//! corners in one, and has n × n nodes in each.
//!
//! # How many nodes
//! Along a line of nodes in a, cos θ' r is linear, cos θ r constant and the Jacobian linear: the integrand is
//! (1 + τ s)(1 + J s) r⁻⁴, s in [−1, 1]. The m-th derivative of r⁻⁴ by s is at most m! C(m + 3, 3) q^m r⁻⁴ with q = ℓ/r, ℓ half the
//! line's length: r⁻⁴ generates the Gegenbauer polynomials of index 2, which are largest at 1. So the relative error
//! of n nodes is at most
//!
//! k_n [C(2n+3, 3) q²ⁿ + (τ + J) C(2n+2, 3) q²ⁿ⁻¹ + τ J C(2n+1, 3) q²ⁿ⁻²],  k_n = 2²ⁿ n!⁴ / ((2n + 1) (2n)!²)
//!
//! with r the distance of the centres in place of the smallest one: an estimate to leading order, not a bound. It is an
//! overestimate but for lines that point at the other polygon. So each of the four directions of lines is granted the
//! whole tolerance: of 50 000 pairs of random shapes none took more than three quarters of it, r.m.s. 0.03; of the pairs of
//! a room's patches, 0.81 at most.
//! # References
//! - Abramowitz & Stegun 1964, 25.4.30 (the error term), 22.9.3 (the generating function), 22.14.2 (its bound)

use std::borrow::Cow;
use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

use super::gauss::legendre;
use super::rectangles::Rectangle;
use crate::render::radiosity::polygon::Polygon;

/// The largest number of nodes along a line.
pub const ORDERS: usize = 6;

/// Nodes that are worked on at once.
const LANES: usize = 4;

/// Nodes with their weights; where there are fewer, the last one again, with weight 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    weight: [f64; LANES],
}

impl Block {
    fn point(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// w h: weights times heights above a plane.
    fn heights(&self, plane: &Polygon) -> [f64; LANES] {
        std::array::from_fn(|lane| self.weight[lane] * plane.distance_above(self.point(lane)))
    }
}

/// A polygon with the nodes of all orders, to be paired with many others.
#[derive(Clone, Debug)]
pub struct Quadrature {
    polygon: Polygon,
    rectangle: Option<Rectangle>,
    /// Half the longest line of nodes, ℓ.
    reach: f64,
    /// By which share of its mean the Jacobian varies along half a line, J.
    narrowing: f64,
    /// All orders, or none yet.
    blocks: Vec<Block>,
    /// Where in them each order starts, and the last one ends.
    starts: [usize; ORDERS + 1],
}

impl Quadrature {
    /// All nodes of `polygon`.
    pub fn of(polygon: &Polygon) -> Self {
        let mut all = Self::without_nodes(polygon.clone());
        for order in 1..=ORDERS {
            let blocks = all.make(order);
            all.blocks.extend(blocks);
            all.starts[order] = all.blocks.len();
        }
        all
    }

    /// Nodes are made when they are asked for: for a polygon that is paired once.
    pub(in crate::render::radiosity) fn without_nodes(polygon: Polygon) -> Self {
        let rectangle = Rectangle::of(&polygon);
        let (mut reach, mut narrowing) = (0.0_f64, 0.0_f64);
        for piece in pieces(&polygon) {
            reach = reach.max(piece.reach());
            narrowing = narrowing.max(piece.narrowing(polygon.normal()));
        }
        Self { polygon, rectangle, reach, narrowing, blocks: Vec::new(), starts: [0; ORDERS + 1] }
    }

    /// The polygon.
    pub fn polygon(&self) -> &Polygon {
        &self.polygon
    }

    /// The polygon as a rectangle, if it is one.
    pub fn rectangle(&self) -> Option<&Rectangle> {
        self.rectangle.as_ref()
    }

    fn nodes(&self, order: usize) -> Cow<'_, [Block]> {
        if self.blocks.is_empty() {
            return Cow::Owned(self.make(order));
        }
        Cow::Borrowed(&self.blocks[self.starts[order - 1]..self.starts[order]])
    }

    fn make(&self, order: usize) -> Vec<Block> {
        let mut nodes = Vec::new();
        let rule = &RULES[order - 1];
        for piece in pieces(&self.polygon) {
            for (v, across) in rule {
                nodes.extend(rule.iter().map(|(u, along)| {
                    let (point, jacobian) = piece.at(*u, *v, self.polygon.normal());
                    (point, along * across * jacobian)
                }));
            }
        }
        let block = |nodes: &[(DVec3, f64)]| {
            let node = |lane: usize| nodes[lane.min(nodes.len() - 1)].0;
            Block {
                x: std::array::from_fn(|lane| node(lane).x),
                y: std::array::from_fn(|lane| node(lane).y),
                z: std::array::from_fn(|lane| node(lane).z),
                weight: std::array::from_fn(|lane| nodes.get(lane).map_or(0.0, |node| node.1)),
            }
        };
        nodes.chunks(LANES).map(block).collect()
    }
}

/// The rules of all orders on [0, 1].
static RULES: LazyLock<[Vec<(f64, f64)>; ORDERS]> = LazyLock::new(|| {
    [
        legendre::<1>().to_vec(),
        legendre::<2>().to_vec(),
        legendre::<3>().to_vec(),
        legendre::<4>().to_vec(),
        legendre::<5>().to_vec(),
        legendre::<6>().to_vec(),
    ]
});

/// The image of the unit square: p + u e + v f + u v k.
struct Piece {
    p: DVec3,
    e: DVec3,
    f: DVec3,
    k: DVec3,
}

impl Piece {
    fn at(&self, u: f64, v: f64, normal: DVec3) -> (DVec3, f64) {
        let (along_u, along_v) = (self.e + v * self.k, self.f + u * self.k);
        (self.p + u * along_u + v * self.f, along_u.cross(along_v).dot(normal))
    }

    fn reach(&self) -> f64 {
        let sides = [self.e, self.f, self.e + self.k, self.f + self.k];
        0.5 * sides.iter().map(|side| side.length()).fold(0.0, f64::max)
    }

    fn narrowing(&self, normal: DVec3) -> f64 {
        let jacobian = |u: f64, v: f64| self.at(u, v, normal).1;
        let centre = jacobian(0.5, 0.5);
        let narrowing = (jacobian(1.0, 0.5) - centre).abs().max((jacobian(0.5, 1.0) - centre).abs()) / centre;
        // Rounding would make a parallelogram pay.
        if narrowing < 1e-9 { 0.0 } else { narrowing }
    }
}

/// A fan about the first corner, of as many quadrilaterals as it has, and a triangle where one is left.
fn pieces(polygon: &Polygon) -> impl Iterator<Item = Piece> + '_ {
    let corners = polygon.corners();
    corners[1..].windows(2).step_by(2).enumerate().map(move |(i, pair)| {
        let p = corners[0];
        let last = *corners.get(2 * i + 3).unwrap_or(&pair[1]);
        let (e, f) = (pair[0] - p, last - p);
        Piece { p, e, f, k: pair[1] - p - e - f }
    })
}

/// The numbers of nodes along a line with which the relative error of [`sum`] is estimated to be at most `tolerance`;
/// None if there would have to be more than [`ORDERS`]. Each polygon must be in front of the other.
pub(super) fn orders(a: &Quadrature, b: &Quadrature, tolerance: f64) -> Option<[usize; 2]> {
    let apart = b.polygon.centroid() - a.polygon.centroid();
    let distance2 = apart.length_squared();
    let near = a.polygon.radius() + b.polygon.radius();
    if distance2 < NEAR * NEAR * near * near {
        return None;
    }
    let per_distance = distance2.sqrt().recip();
    let cosine = a.polygon.normal().dot(b.polygon.normal());
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let order = |of: &Quadrature, height: f64| {
        let tilt = if sine < 1e-9 { 0.0 } else { of.reach * sine / height };
        nodes_for(of.reach * per_distance, tilt, of.narrowing, tolerance)
    };
    Some([order(a, -apart.dot(b.polygon.normal()))?, order(b, apart.dot(a.polygon.normal()))?])
}

/// Closer than this times the sum of the radii the estimate does not hold, as distances vary by too much.
const NEAR: f64 = 1.25;

fn nodes_for(q: f64, tilt: f64, narrowing: f64, tolerance: f64) -> Option<usize> {
    let (q2, both, product) = (q * q, tilt + narrowing, tilt * narrowing);
    let mut power = 1.0;
    for (n, [even, odd, last]) in TERMS.iter().enumerate() {
        if power * (even * q2 + odd * both * q + last * product) <= tolerance {
            return Some(n + 1);
        }
        power *= q2;
    }
    None
}

/// k_n C(2n + 3, 3), k_n C(2n + 2, 3) and k_n C(2n + 1, 3) for n = 1, 2, …
const TERMS: [[f64; 3]; ORDERS] = {
    let mut terms = [[0.0; 3]; ORDERS];
    let (mut i, mut k) = (0, 1.0 / 3.0);
    while i < ORDERS {
        let n = i as f64 + 1.0;
        let mut j = 0;
        while j < 3 {
            let m = 2.0 * n + 3.0 - j as f64;
            terms[i][j] = k * m * (m - 1.0) * (m - 2.0) / 6.0;
            j += 1;
        }
        k *= (n + 1.0) * (n + 1.0) / ((2.0 * n + 3.0) * (2.0 * n + 1.0));
        i += 1;
    }
    terms
};

/// A F by `orders` nodes along each line, for polygons in front of each other.
pub(super) fn sum(a: &Quadrature, b: &Quadrature, orders: [usize; 2]) -> f64 {
    let (of_a, of_b) = (a.nodes(orders[0]), b.nodes(orders[1]));
    let mut total = 0.0;
    // As many as stay in registers' reach; a quadrilateral has no more than nine.
    for of_b in of_b.chunks(CHUNK) {
        let mut heights = [[0.0; LANES]; CHUNK];
        for (heights, block) in heights.iter_mut().zip(of_b) {
            *heights = block.heights(&a.polygon);
        }
        for block in of_a.iter() {
            let of_block = block.heights(&b.polygon);
            for (lane, height) in of_block.into_iter().enumerate().filter(|(lane, _)| block.weight[*lane] != 0.0) {
                total += height * row(block.point(lane), of_b, &heights);
            }
        }
    }
    total / PI
}

const CHUNK: usize = 9;

/// Σ w h / r⁴ over nodes seen from `p`.
#[inline]
fn row(p: DVec3, blocks: &[Block], heights: &[[f64; LANES]; CHUNK]) -> f64 {
    let mut sums = [0.0; LANES];
    for (block, heights) in blocks.iter().zip(heights) {
        for lane in 0..LANES {
            let (x, y, z) = (block.x[lane] - p.x, block.y[lane] - p.y, block.z[lane] - p.z);
            let r2 = x * x + y * y + z * z;
            sums[lane] += heights[lane] / (r2 * r2);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regular(corners: i32) -> Polygon {
        let angle = |i: i32| f64::from(i) * 2.0 * PI / f64::from(corners);
        let corner = |t: f64| DVec3::new(2.0 + t.cos(), t.sin(), 1.0 + 0.5 * t.cos());
        Polygon::new((0..corners).map(angle).map(corner).collect()).unwrap()
    }

    fn moment(blocks: &[Block], f: impl Fn(DVec3) -> f64) -> f64 {
        let lanes = blocks.iter().flat_map(|block| (0..LANES).map(move |lane| (block, lane)));
        lanes.map(|(block, lane)| block.weight[lane] * f(block.point(lane))).sum()
    }

    #[test]
    fn nodes_of_all_orders_weigh_the_area_and_balance_at_the_centre() {
        for corners in 3..=8 {
            let polygon = regular(corners);
            let all = Quadrature::of(&polygon);
            for order in 1..=ORDERS {
                let nodes = all.nodes(order);
                assert!((moment(&nodes, |_| 1.0) - polygon.area()).abs() < 1e-14);
                // Linear, times a linear Jacobian: not for one node in a piece that is no parallelogram.
                let balanced = (moment(&nodes, |p| p.x) / polygon.area() - polygon.centroid().x).abs() < 1e-14;
                assert!(balanced || order == 1, "{corners} {order}");
                let inside = nodes.iter().flat_map(|block| (0..LANES).map(move |lane| block.point(lane)));
                assert!(inside.into_iter().all(|p| polygon.distance_inside(p) > 0.0));
                let made = Quadrature::without_nodes(polygon.clone());
                assert_eq!(moment(&made.nodes(order), |p| p.y * p.x), moment(&nodes, |p| p.y * p.x));
            }
        }
    }

    #[test]
    fn the_error_of_one_node_is_that_of_the_midpoint_rule() {
        // f''/24 · width² · with r⁻⁴ along the line of sight: 20 r⁻⁶ (2q r)²/24 = 10/3 q².
        assert!((TERMS[0][0] - 10.0 / 3.0).abs() < 1e-15);
        // Two nodes: f''''/4320 · width⁴, 840 · 16/4320.
        assert!((TERMS[1][0] - 28.0 / 9.0).abs() < 1e-15);
        // More nodes for less error, for larger patches, for slanting and for narrowing ones; none for neighbours.
        assert_eq!(nodes_for(0.01, 0.0, 0.0, 1e-3), Some(1));
        assert_eq!(nodes_for(0.01, 0.0, 0.0, 1e-7), Some(2));
        assert_eq!(nodes_for(0.1, 0.0, 0.0, 1e-7), Some(4));
        assert_eq!(nodes_for(0.01, 0.5, 0.0, 1e-3), Some(2));
        assert_eq!(nodes_for(0.01, 0.5, 1.0, 1e-3), Some(2));
        assert_eq!(nodes_for(1.0, 0.0, 0.0, 1e-3), None);
        assert_eq!(nodes_for(0.01, f64::NAN, 0.0, 1e-3), None);
    }
}
