//! How a form is cut in parts, again and again, down to the cells that it would be cut into at once.
//!
//! A quadrangle, or a curved surface, of columns × rows cells is halved at a line between cells, so that parts of an odd number
//! are of unequal areas; both ways, or only the long way where it is more than twice as long as wide. A triangle is cut at
//! the middles of its sides. Any other polygon is halved across the way in which it is longest.

use glam::{DVec2, DVec3};

use crate::render::radiosity::face::Outline;
use crate::render::radiosity::patch::{Curved, Form};
use crate::render::radiosity::patches::{Cells, cells};
use crate::render::radiosity::polygon::Polygon;

/// What is left to be cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// Columns and rows of cells.
    Grid([usize; 2]),
    /// So many times into four.
    Quarters(u32),
    /// So many times into two.
    Halves(u32),
}

impl Cut {
    /// Of an outline that is to be cut into squares of about this side.
    pub(super) fn of(outline: &Outline, side: f64) -> Self {
        let Cells { columns, rows } = cells(outline, side);
        match outline {
            Outline::Flat(polygon) => match polygon.corners().len() {
                4 => Self::Grid([columns, rows]),
                3 => Self::Quarters((columns as f64).log2().round() as u32),
                _ => Self::Halves((columns as f64 * rows as f64).log2().round() as u32),
            },
            Outline::Curved(_) => Self::Grid([columns, rows]),
        }
    }

    /// Cells in the end.
    pub(super) fn count(self) -> usize {
        match self {
            Self::Grid([columns, rows]) => columns.saturating_mul(rows),
            Self::Quarters(times) => 4_usize.saturating_pow(times),
            Self::Halves(times) => 2_usize.saturating_pow(times),
        }
    }

    /// The parts of `form`; none if it is not to be cut further.
    pub(super) fn parts(self, form: &Form) -> Vec<(Form, Self)> {
        match (self, form) {
            (Self::Grid([1, 1]), _) => Vec::new(),
            (Self::Grid(cells), _) => grid(cells, form),
            (Self::Quarters(times @ 1..), Form::Flat(polygon)) => {
                let of = |corners: [DVec3; 3]| Polygon::new(corners.to_vec()).ok();
                let [a, b, c] = [0, 1, 2].map(|i| polygon.corners()[i]);
                let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
                let all = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].map(of);
                all.into_iter().flatten().map(|part| (Form::Flat(part), Self::Quarters(times - 1))).collect()
            }
            (Self::Halves(times @ 1..), Form::Flat(polygon)) => {
                let across = longest(polygon);
                let halves = [across, -across].map(|normal| polygon.above(polygon.centroid(), normal));
                halves.into_iter().flatten().map(|half| (Form::Flat(half), Self::Halves(times - 1))).collect()
            }
            (Self::Quarters(_) | Self::Halves(_), _) => Vec::new(),
        }
    }
}

/// The direction of the longest way from the centre to a corner.
fn longest(polygon: &Polygon) -> DVec3 {
    let ways = polygon.corners().iter().map(|&corner| corner - polygon.centroid());
    ways.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::X).normalize()
}

fn grid(cells: [usize; 2], form: &Form) -> Vec<(Form, Cut)> {
    // Cells are about square: more than twice as many of them are more than twice the length.
    let [columns, rows] = cells;
    let halves = |n: usize, other: usize| {
        if n == 1 || 2 * n < other { vec![(0, n)] } else { vec![(0, n / 2), (n / 2, n)] }
    };
    let mut parts = Vec::with_capacity(4);
    for (low, high) in halves(rows, columns) {
        for (left, right) in halves(columns, rows) {
            let share = |at: [usize; 2]| DVec2::new(at[0] as f64 / columns as f64, at[1] as f64 / rows as f64);
            let part = within(form, share([left, low]), share([right, high]));
            parts.extend(part.map(|part| (part, Cut::Grid([right - left, high - low]))));
        }
    }
    parts
}

/// The part of a form between two points of its unit square.
fn within(form: &Form, from: DVec2, to: DVec2) -> Option<Form> {
    match form {
        Form::Flat(polygon) => {
            let &[a, b, c, d] = polygon.corners() else { return None };
            let at = |u: f64, v: f64| a.lerp(b, u).lerp(d.lerp(c, u), v);
            let corners = vec![at(from.x, from.y), at(to.x, from.y), at(to.x, to.y), at(from.x, to.y)];
            Polygon::new(corners).ok().map(Form::Flat)
        }
        Form::Curved(Curved { surface, from: origin, size }) => {
            Some(Form::Curved(Curved { surface: *surface, from: *origin + *size * from, size: *size * (to - from) }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Polygon {
        Polygon::new(corners.iter().map(|[x, y]| DVec3::new(*x, *y, 1.0)).collect()).unwrap()
    }

    fn ends(form: &Form, cut: Cut, areas: &mut Vec<f64>) {
        let parts = cut.parts(form);
        let area = |form: &Form| form.polygon().unwrap().area();
        if parts.is_empty() {
            areas.push(area(form));
            return;
        }
        let sum: f64 = parts.iter().map(|(part, _)| area(part)).sum();
        assert!((sum - area(form)).abs() < 1e-14 * sum, "parts of {sum} of {}", area(form));
        for (part, cut) in parts {
            assert!(part.polygon().unwrap().normal().z > 0.999);
            ends(&part, cut, areas);
        }
    }

    #[test]
    fn every_polygon_is_cut_into_as_many_cells_as_wanted_and_none_is_lost() {
        let square = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]];
        let oblique = [[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.0, 1.5]];
        let triangle = [[0.0, 0.0], [1.0, 0.2], [0.3, 1.0]];
        let house = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.5], [0.0, 1.0]];
        for (corners, side) in [(&square[..], 0.1), (&square, 0.37), (&oblique, 0.2), (&triangle, 0.1), (&house, 0.1)] {
            let polygon = polygon(corners);
            let cut = Cut::of(&Outline::Flat(polygon.clone()), side);
            let mut areas = Vec::new();
            ends(&Form::Flat(polygon.clone()), cut, &mut areas);
            assert_eq!(areas.len(), cut.count());
            let wanted = polygon.area() / (side * side);
            let ratio = areas.len() as f64 / wanted;
            // Triangles and polygons of many corners by powers of 4 and 2.
            assert!((0.5..=2.0).contains(&ratio), "{} of {wanted}", areas.len());
        }
    }

    #[test]
    fn the_cells_of_a_rectangle_are_equal_though_its_parts_are_not() {
        let rectangle = polygon(&[[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [0.0, 3.0]]);
        let form = Form::Flat(rectangle.clone());
        let cut = Cut::of(&Outline::Flat(rectangle), 1.0);
        assert_eq!(cut, Cut::Grid([5, 3]));
        let parts: Vec<f64> = cut.parts(&form).iter().map(|(part, _)| part.polygon().unwrap().area().round()).collect();
        assert_eq!(parts, [2.0, 3.0, 4.0, 6.0], "unequal children");
        let mut areas = Vec::new();
        ends(&form, cut, &mut areas);
        assert!(areas.iter().all(|area| (area - 1.0).abs() < 1e-13));
    }
}
