//! The hemicube: what a point of a surface sees, drawn on half a cube of cells around it.
//!
//! With the point as the origin and n = +z, the cube's top is z = 1 and its sides are x, y = ±1, z in [0, 1]. A cell sees
//! what a ray through its centre meets first, and has the weight
//!
//! top:  ∫ dx dy / (π (1 + x² + y²)²) = \[T\],  T = 1/(2π) [x/s atan(y/s) + y/t atan(x/t)],  s² = 1 + x², t² = 1 + y²
//!
//! side: ∫ z dy dz / (π (1 + y² + z²)²) = \[S\],  S = −1/(2π) atan(y/s)/s,  s² = 1 + z²
//!
//! (\[·\] the difference over the ends of both variables), so that all cells together have exactly 1. Weights taken at the
//! cells' centres add up to 1.0005 for 32 cells a side.
//!
//! It is an approximation by sampling: on random quadrilaterals of F between 10⁻³ and 10⁻² the error is 20 % r.m.s. with
//! 32 cells a side, 1 % with 256, and near patches are not cured by more cells. Turn it differently at each point, or its
//! errors line up from patch to patch.
//! # References
//! - Cohen & Greenberg 1985, The hemi-cube, SIGGRAPH (the method, and the weights at centres)

use std::f64::consts::TAU;

use glam::DVec3;
use thiserror::Error;

use crate::math::frame::Frame;
use crate::render::radiosity::polygon::Polygon;

/// Cells of a side that is not an even number of cells from 2 to [`MAX_RESOLUTION`] wide.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("a hemicube's side is an even number of cells from 2 to {MAX_RESOLUTION}, not {0}")]
pub struct ResolutionError(pub usize);

/// The finest hemicube: beyond it the cells do not fit into memory.
pub const MAX_RESOLUTION: usize = 8192;

/// Of two surfaces that are closer together than this share of their distance, the lower number is in front, whichever was
/// drawn first: rounding would mix coincident ones cell by cell.
const COINCIDENT: f64 = 1e-9;

/// Nearer to a polygon's plane than this share of the distance, the point sees nothing of it.
const EDGE_ON: f64 = 1e-12;

const NOTHING: u32 = u32::MAX;

/// A number for the back of a polygon, which hides what is behind it and is nobody's.
const BACK: u32 = u32::MAX - 1;

/// The shares of what leaves the point that reach no polygon's front.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[must_use]
pub struct Missed {
    /// That meet nothing.
    pub nothing: f64,
    /// That meet the back of a polygon.
    pub backs: f64,
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Inverse of the distance along the face's axis: 0 where nothing is.
    nearness: f64,
    id: u32,
}

const EMPTY: Cell = Cell { nearness: 0.0, id: NOTHING };

/// A hemicube, to be drawn on again and again.
#[derive(Clone, Debug)]
pub struct Hemicube {
    resolution: usize,
    /// Weights of the top, and of one side, row by row upwards.
    top: Vec<f64>,
    side: Vec<f64>,
    /// The top's cells, then those of the four sides.
    cells: Vec<Cell>,
    eye: DVec3,
    faces: [Face; 5],
    /// Corners that are left on one face, and those after the next cut.
    corners: [Vec<DVec3>; 2],
    /// Of each row, from where to where it is covered.
    spans: Vec<(f64, f64)>,
}

/// Columns run along `u`, rows along `v`, and the face is seen along `w`.
#[derive(Clone, Copy, Debug, Default)]
struct Face {
    u: DVec3,
    v: DVec3,
    w: DVec3,
}

impl Hemicube {
    /// With `resolution` cells along the sides of the top.
    pub fn new(resolution: usize) -> Result<Self, ResolutionError> {
        if !(2..=MAX_RESOLUTION).contains(&resolution) || !resolution.is_multiple_of(2) {
            return Err(ResolutionError(resolution));
        }
        let edge = |i: usize| 2.0 * i as f64 / resolution as f64;
        let grid = |rows: usize, low: f64, primitive: fn(f64, f64) -> f64| -> Vec<f64> {
            let at = |i: usize, j: usize| primitive(edge(i) - 1.0, edge(j) + low);
            let cell = |i, j| (at(i + 1, j + 1) - at(i, j + 1)) - (at(i + 1, j) - at(i, j));
            (0..rows * resolution).map(|k| cell(k % resolution, k / resolution)).collect()
        };
        let top = grid(resolution, -1.0, |x, y| {
            let (s, t) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
            (x / s * (y / s).atan() + y / t * (x / t).atan()) / TAU
        });
        let side = grid(resolution / 2, 0.0, |y, z| {
            let s = (1.0 + z * z).sqrt();
            -(y / s).atan() / (s * TAU)
        });
        let cells = vec![EMPTY; top.len() + 4 * side.len()];
        let mut cube = Self {
            resolution,
            top,
            side,
            cells,
            eye: DVec3::ZERO,
            faces: [Face::default(); 5],
            corners: [Vec::new(), Vec::new()],
            spans: vec![(0.0, 0.0); resolution],
        };
        cube.look(DVec3::ZERO, DVec3::Z, 0.0);
        Ok(cube)
    }

    /// Cells along the sides of the top.
    pub fn resolution(&self) -> usize {
        self.resolution
    }

    /// The shares of what leaves `eye`, where the normal is `normal`, that reach the fronts of the polygons that come with a
    /// number: added to `shares` at that number. The cube is turned about the normal by `turn` \[rad\].
    ///
    /// Polygons hide each other, from both sides. Numbers beyond the end of `shares` only hide.
    pub fn shares<'a>(
        &mut self,
        (eye, normal, turn): (DVec3, DVec3, f64),
        polygons: impl IntoIterator<Item = (u32, &'a Polygon)>,
        shares: &mut [f64],
    ) -> Missed {
        self.look(eye, normal, turn);
        for (id, polygon) in polygons {
            self.draw(id, polygon);
        }
        self.collect(shares)
    }

    /// Clears all cells and stands the cube on a point.
    fn look(&mut self, eye: DVec3, normal: DVec3, turn: f64) {
        self.cells.fill(EMPTY);
        self.eye = eye;
        let frame = Frame::about(normal);
        let (sin, cos) = turn.sin_cos();
        let (x, y) = (frame.to_world(DVec3::new(cos, sin, 0.0)), frame.to_world(DVec3::new(-sin, cos, 0.0)));
        let side = |w: DVec3| Face { u: normal.cross(w), v: normal, w };
        self.faces = [Face { u: x, v: y, w: normal }, side(x), side(y), side(-x), side(-y)];
    }

    fn draw(&mut self, id: u32, polygon: &Polygon) {
        let offset = polygon.centroid() - self.eye;
        let distance = offset.dot(polygon.normal());
        if distance.abs() <= EDGE_ON * (offset.length() + polygon.radius()) {
            return;
        }
        let id = if distance < 0.0 { id } else { BACK };
        let normal = polygon.normal() / distance;
        for (number, face) in self.faces.into_iter().enumerate() {
            if self.cut(&face, polygon, number > 0) {
                self.fill(number, id, DVec3::new(normal.dot(face.u), normal.dot(face.v), normal.dot(face.w)));
            }
        }
    }

    /// Leaves in `corners[0]` what of the polygon is seen through a face, in its coordinates; false if nothing.
    fn cut(&mut self, face: &Face, polygon: &Polygon, side: bool) -> bool {
        let [kept, next] = &mut self.corners;
        kept.clear();
        kept.extend(polygon.corners().iter().map(|corner| {
            let v = *corner - self.eye;
            DVec3::new(v.dot(face.u), v.dot(face.v), v.dot(face.w))
        }));
        let lower = if side { DVec3::Y } else { DVec3::new(0.0, 1.0, 1.0) };
        let planes = [DVec3::new(1.0, 0.0, 1.0), DVec3::new(-1.0, 0.0, 1.0), DVec3::new(0.0, -1.0, 1.0), lower];
        // Most faces see nothing of most polygons.
        if planes.iter().any(|plane| kept.iter().all(|corner| corner.dot(*plane) <= 0.0)) {
            return false;
        }
        for plane in planes {
            next.clear();
            for (i, &a) in kept.iter().enumerate() {
                let b = kept[(i + 1) % kept.len()];
                let (from, to) = (a.dot(plane), b.dot(plane));
                if from >= 0.0 {
                    next.push(a);
                }
                if (from < 0.0) != (to < 0.0) {
                    // From inside outwards: the polygon across this edge finds the same point.
                    let (a, b, from, to) = if from < 0.0 { (b, a, to, from) } else { (a, b, from, to) };
                    next.push(a + (b - a) * (from / (from - to)));
                }
            }
            std::mem::swap(kept, next);
        }
        kept.len() >= 3
    }

    /// Draws the corners that are left on a face; `slope` · (u, v, 1) is the nearness along the line of sight (u, v, 1).
    fn fill(&mut self, number: usize, id: u32, slope: DVec3) {
        let resolution = self.resolution;
        let half = 0.5 * resolution as f64;
        // In cells, relative to the centre of the first one; rows of a side start at the horizon.
        let bottom = if number == 0 { half - 0.5 } else { -0.5 };
        let rows = if number == 0 { resolution } else { resolution / 2 };
        let corners = &mut self.corners[0];
        corners.retain(|corner| corner.z > 0.0);
        for corner in corners.iter_mut() {
            let scale = half / corner.z;
            *corner = DVec3::new(corner.x * scale + half - 0.5, corner.y * scale + bottom, 0.0);
        }
        let (low, high) = corners
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| (low.min(corner.y), high.max(corner.y)));
        let first = |y: f64, end: usize| (y.ceil().max(0.0) as usize).min(end);
        let (from, to) = (first(low, rows), first(high, rows));
        let spans = &mut self.spans[from..to.max(from)];
        spans.fill((f64::INFINITY, f64::NEG_INFINITY));
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            // Upwards, whichever way it runs: neighbours end where this one begins.
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            let slant = (b.x - a.x) / (b.y - a.y);
            for row in first(a.y, rows)..first(b.y, rows) {
                let x = a.x + (row as f64 - a.y) * slant;
                let span = &mut spans[row - from];
                *span = (span.0.min(x), span.1.max(x));
            }
        }
        let start = if number == 0 { 0 } else { self.top.len() + (number - 1) * self.side.len() };
        let step = slope.x / half;
        for (row, (left, right)) in (from..).zip(spans.iter()) {
            let (left, right) = (first(*left, resolution), first(*right, resolution));
            let base = slope.z + slope.y * (row as f64 - bottom) / half + slope.x * (0.5 / half - 1.0);
            let cells = &mut self.cells[start + row * resolution..][left..right.max(left)];
            for (column, cell) in (left..).zip(cells) {
                let nearness = base + step * column as f64;
                let margin = COINCIDENT * cell.nearness;
                let nearer = nearness > cell.nearness + margin;
                let first_of_two = id < cell.id && nearness >= cell.nearness - margin;
                if nearness > 0.0 && (nearer || first_of_two) {
                    *cell = Cell { nearness, id };
                }
            }
        }
    }

    fn collect(&self, shares: &mut [f64]) -> Missed {
        let mut missed = Missed::default();
        let (top, sides) = self.cells.split_at(self.top.len());
        let faces =
            std::iter::once((top, &self.top)).chain(sides.chunks(self.side.len()).map(|side| (side, &self.side)));
        for (cell, weight) in faces.flat_map(|(cells, weights)| cells.iter().zip(weights)) {
            match cell.id {
                NOTHING => missed.nothing += weight,
                BACK => missed.backs += weight,
                id => {
                    if let Some(share) = shares.get_mut(id as usize) {
                        *share += weight;
                    }
                }
            }
        }
        missed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::radiosity::form::point::factor;
    use crate::render::radiosity::form::published::rectangle;
    use std::f64::consts::PI;

    /// A square of this side at z = height over the origin, that faces down.
    fn above(side: f64, height: f64) -> Polygon {
        rectangle(DVec3::new(-0.5 * side, -0.5 * side, height), DVec3::Y * side, DVec3::X * side)
    }

    fn from_origin(cube: &mut Hemicube, turn: f64, polygons: &[Polygon]) -> (Vec<f64>, Missed) {
        let mut shares = vec![0.0; polygons.len()];
        let missed = cube.shares((DVec3::ZERO, DVec3::Z, turn), (0..).zip(polygons), &mut shares);
        (shares, missed)
    }

    #[test]
    fn cells_weigh_one_together_and_their_centres_do_not() {
        for (resolution, centres) in
            [(32, 1.000529642), (64, 1.000132339), (128, 1.000033080), (256, 1.000008270), (512, 1.000002067)]
        {
            let cube = Hemicube::new(resolution).unwrap();
            let (top, side): (f64, f64) = (cube.top.iter().sum(), cube.side.iter().sum());
            // Twelve digits are given; 10⁵ differences of rounded primitives.
            assert!((top - 0.554126423980).abs() < 1e-12 && (side - 0.111468394005).abs() < 1e-12);
            assert!((top + 4.0 * side - 1.0).abs() < 1e-13);
            assert!(cube.top.iter().chain(&cube.side).all(|weight| *weight > 0.0));
            // The broken twin: weights at the centres, as first published.
            let size = 2.0 / resolution as f64;
            let at = |i: usize| (i as f64 + 0.5) * size;
            let weight = |x: f64, y: f64, cosine: f64| cosine * size * size / (PI * (1.0 + x * x + y * y).powi(2));
            let mut sum = 0.0;
            for (i, j) in (0..resolution).flat_map(|i| (0..resolution).map(move |j| (i, j))) {
                sum += weight(at(i) - 1.0, at(j) - 1.0, 1.0);
                sum += if j < resolution / 2 { 4.0 * weight(at(i) - 1.0, at(j), at(j)) } else { 0.0 };
            }
            assert!((sum - centres).abs() < 1e-9, "{sum}");
        }
    }

    #[test]
    fn sizes_are_checked() {
        for wrong in [0, 1, 31, MAX_RESOLUTION + 2] {
            assert_eq!(Hemicube::new(wrong).unwrap_err(), ResolutionError(wrong));
        }
        assert_eq!(Hemicube::new(2).unwrap().resolution(), 2);
    }

    #[test]
    fn shares_converge_to_the_point_factors() {
        let squares = [above(1.0, 1.0), rectangle(DVec3::new(0.7, -0.4, -0.3), DVec3::Z, DVec3::Y), above(0.3, 2.0)];
        // The error is one of the cells along the edges: r.m.s. 18 % with 32 of them, as the smallest share is 0.007.
        let mut errors = Vec::new();
        for resolution in [32, 128, 512] {
            let mut cube = Hemicube::new(resolution).unwrap();
            let mut squared = 0.0;
            for turn in 0..20 {
                for square in &squares {
                    let exact = factor(DVec3::ZERO, DVec3::Z, square);
                    let (shares, _) = from_origin(&mut cube, f64::from(turn), std::slice::from_ref(square));
                    squared += (shares[0] / exact - 1.0).powi(2) / 60.0;
                }
            }
            errors.push(squared.sqrt());
        }
        assert!(errors[0] < 0.25 && errors[1] < 0.25 * errors[0] && errors[2] < 0.25 * errors[1], "{errors:?}");
    }

    #[test]
    fn a_closed_room_leaves_no_cell_empty() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let sides = [(z, y, x), (DVec3::ZERO, z, x), (y, x, z), (DVec3::ZERO, y, z), (x, z, y)];
        let mut walls = Vec::new();
        for (corner, u, v) in sides {
            for k in 0..49 {
                let at = corner + u * (f64::from(k % 7) / 7.0) + v * (f64::from(k / 7) / 7.0);
                walls.push(rectangle(at, u / 7.0, v / 7.0));
            }
        }
        let mut cube = Hemicube::new(64).unwrap();
        for turn in [0.0, 0.1, std::f64::consts::FRAC_PI_4, 2.0] {
            let mut shares = vec![0.0; walls.len()];
            let at = (DVec3::new(0.31, 0.42, 0.0), z, turn);
            let missed = cube.shares(at, (0..).zip(&walls), &mut shares);
            assert_eq!(missed, Missed::default());
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        }
        // From the floor's own plane, the floor is not seen.
        let floor = [rectangle(DVec3::ZERO, x, y), rectangle(x, x, y)];
        let (shares, missed) = from_origin(&mut cube, 0.2, &floor);
        assert!(shares == [0.0; 2] && (missed.nothing - 1.0).abs() < 1e-13);
    }

    #[test]
    fn the_nearest_wins_whichever_is_drawn_first() {
        let mut cube = Hemicube::new(256).unwrap();
        // A blocker in front of the middle, and one that hides everything.
        let (far, near, all) = (above(2.0, 2.0), above(0.5, 1.0), above(1.1, 1.0));
        let hidden = factor(DVec3::ZERO, DVec3::Z, &near);
        let rest = factor(DVec3::ZERO, DVec3::Z, &far) - hidden;
        for order in [[far.clone(), near.clone()], [near.clone(), far.clone()]] {
            let (shares, _) = from_origin(&mut cube, 0.3, &order);
            let (of_far, of_near) = if order[0] == far { (shares[0], shares[1]) } else { (shares[1], shares[0]) };
            // A quarter of the cells along the edges, of 256 · 2 each, may be on the wrong side.
            assert!((of_near - hidden).abs() < 2e-3 && (of_far - rest).abs() < 2e-3, "{of_near} {of_far}");
        }
        assert_eq!(from_origin(&mut cube, 0.3, &[far.clone(), all]).0[0], 0.0);
        // The back of a polygon hides as well, and is nobody's.
        let (shares, missed) = from_origin(&mut cube, 0.3, &[far, near.flipped()]);
        assert!((missed.backs - hidden).abs() < 2e-3 && (shares[0] - rest).abs() < 2e-3 && shares[1] == 0.0);
    }

    #[test]
    fn of_a_coincident_pair_the_lower_number_is_seen() {
        // A square that faces the origin, and a part of it with other roundings of its plane.
        let whole = rectangle(DVec3::new(1.0, -0.4, 0.1), DVec3::new(0.1, 0.2, 0.8), DVec3::new(0.3, 0.9, 0.1));
        let part = whole.above(whole.centroid(), DVec3::new(0.0, 0.6, 0.8)).unwrap();
        let mut cube = Hemicube::new(128).unwrap();
        let mut seen = |drawn: &[(u32, &Polygon)]| {
            let mut shares = [0.0; 2];
            let missed = cube.shares((DVec3::ZERO, DVec3::Z, 0.4), drawn.iter().copied(), &mut shares);
            (shares, missed)
        };
        let alone = seen(&[(0, &part)]).0[0];
        let both = seen(&[(0, &part), (1, &whole)]);
        assert_eq!(both, seen(&[(1, &whole), (0, &part)]));
        assert!(both.0[0] == alone && alone > 0.01 && both.0[1] > 0.01, "{both:?} {alone}");
        let both = seen(&[(0, &whole), (1, &part)]);
        assert!(both == seen(&[(1, &part), (0, &whole)]) && both.0[1] == 0.0, "{both:?}");
    }
}
