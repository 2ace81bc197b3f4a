//! Adaptive cubature over directions: value and error bound, in coordinates that follow the lobe.
//!
//! A [`Mesh`] cuts a [`Chart`] into cells and integrates each with the tensor product of the Gauss-Kronrod 7-15 pair.
//! The error estimate of a cell is the sum, over the two axes, of the differences that the 7-point rule along that axis
//! makes, line by line and without regard to sign: along a slanting crease they alternate, and their sum would hide it.
//! It is the error of a rule much worse than the one whose value is used. The axis with the larger difference is the one
//! that is halved next.
//!
//! # References
//! - Genz & Malik 1980 (global adaptivity: always halve the worst cell, along its worst axis)

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::chart::Chart;
use super::quadrature::{NODES, PAIR};
use super::sum::Neumaier;

/// Evaluations that one cell costs.
pub const CELL_EVALS: u64 = (NODES * NODES) as u64;

/// A cell narrower than this in either coordinate is not halved again: its nodes would no longer differ.
const MIN_WIDTH: f64 = 1e-13;

#[derive(Clone, Copy, Debug)]
struct Cell<const N: usize> {
    lo: DVec2,
    hi: DVec2,
    value: [f64; N],
    /// Estimated error along t and along φ.
    error: [f64; 2],
    /// The largest integrand at any node, and where.
    peak: f64,
    peak_at: DVec3,
}

impl<const N: usize> Cell<N> {
    fn total_error(&self) -> f64 {
        self.error[0] + self.error[1]
    }
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Leaf { cell: usize },
    Split { axis: usize, at: f64, children: [usize; 2] },
}

/// A chart cut into numbered cells: a binary tree below each cell of an initial grid.
#[derive(Clone, Debug)]
pub struct Partition {
    chart: Chart,
    /// Initial cuts of t and φ; the cell (i, j) of this grid has its root at node i + j · (number of t cells).
    breaks: (Vec<f64>, Vec<f64>),
    nodes: Vec<Node>,
}

impl Partition {
    /// The coordinate system.
    pub fn chart(&self) -> &Chart {
        &self.chart
    }

    /// The number of the cell that holds the coordinates `p`; beyond the edges, of the nearest.
    pub fn locate(&self, p: DVec2) -> usize {
        let (radial, azimuths) = &self.breaks;
        let interval = |cuts: &[f64], x: f64| cuts[1..cuts.len() - 1].iter().filter(|cut| **cut <= x).count();
        let mut node = interval(radial, p.x) + interval(azimuths, p.y) * (radial.len() - 1);
        loop {
            match self.nodes[node] {
                Node::Leaf { cell } => return cell,
                Node::Split { axis, at, children } => node = children[usize::from(p[axis] >= at)],
            }
        }
    }

    /// The cells' numbers in an order in which neighbours on the list are neighbours in the chart: depth first.
    fn order(&self) -> Vec<usize> {
        let roots = (self.breaks.0.len() - 1) * (self.breaks.1.len() - 1);
        let mut stack: Vec<usize> = (0..roots).rev().collect();
        let mut order = Vec::new();
        while let Some(node) = stack.pop() {
            match self.nodes[node] {
                Node::Leaf { cell } => order.push(cell),
                Node::Split { children: [low, high], .. } => stack.extend([high, low]),
            }
        }
        order
    }
}

/// A cell of a mesh: the coordinates it spans and the integral of the first function over it.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// Lower corner (t, φ).
    pub lo: DVec2,
    /// Upper corner (t, φ).
    pub hi: DVec2,
    /// Integral of the first function.
    pub mass: f64,
}

/// A cell's place in the queue of those to be halved, worst first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rank {
    error: f64,
    index: usize,
}

impl Eq for Rank {}

impl Ord for Rank {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Rank {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The integral of N functions of direction at once, refined step by step.
pub struct Mesh<'a, const N: usize> {
    partition: Partition,
    f: &'a dyn Fn(DVec3) -> [f64; N],
    cells: Vec<Cell<N>>,
    /// The node that is each cell's leaf, in the order of the cells.
    node_of: Vec<usize>,
    queue: BinaryHeap<Rank>,
    evals: u64,
}

impl<const N: usize> std::fmt::Debug for Mesh<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mesh")
            .field("chart", &self.partition.chart)
            .field("cells", &self.cells.len())
            .finish_non_exhaustive()
    }
}

impl<'a, const N: usize> Mesh<'a, N> {
    /// Evaluates `f` on the chart's initial cells.
    pub fn new(chart: Chart, f: &'a dyn Fn(DVec3) -> [f64; N]) -> Self {
        let breaks = chart.breaks();
        let mut mesh = Self {
            partition: Partition { chart, breaks: breaks.clone(), nodes: Vec::new() },
            f,
            cells: Vec::new(),
            node_of: Vec::new(),
            queue: BinaryHeap::new(),
            evals: 0,
        };
        for p in breaks.1.windows(2) {
            for t in breaks.0.windows(2) {
                let cell = mesh.evaluate(DVec2::new(t[0], p[0]), DVec2::new(t[1], p[1]));
                mesh.push(cell);
            }
        }
        mesh
    }

    /// Adds a cell with its leaf; returns the leaf's node.
    fn push(&mut self, cell: Cell<N>) -> usize {
        let (index, node) = (self.cells.len(), self.partition.nodes.len());
        self.queue.push(Rank { error: cell.total_error(), index });
        self.cells.push(cell);
        self.partition.nodes.push(Node::Leaf { cell: index });
        self.node_of.push(node);
        node
    }

    fn evaluate(&mut self, lo: DVec2, hi: DVec2) -> Cell<N> {
        self.evals += CELL_EVALS;
        let size = hi - lo;
        let area = size.x * size.y;
        let mut cell = Cell { lo, hi, value: [0.0; N], error: [0.0; 2], peak: 0.0, peak_at: DVec3::Z };
        let (mut along_t, mut along_phi) = ([0.0; N], [[0.0; N]; NODES]);
        for p in PAIR {
            let row = self.partition.chart.row(lo.y + size.y * p.x);
            let (mut kronrod, mut gauss) = ([0.0; N], [0.0; N]);
            for (t, column) in PAIR.iter().zip(&mut along_phi) {
                let (w, jacobian) = row.at(lo.x + size.x * t.x);
                let values = (self.f)(w);
                for c in 0..N {
                    let value = jacobian * values[c];
                    kronrod[c] += t.kronrod * value;
                    gauss[c] += t.gauss * value;
                    column[c] += (p.kronrod - p.gauss) * value;
                    if values[c] > cell.peak {
                        (cell.peak, cell.peak_at) = (values[c], w);
                    }
                }
            }
            for c in 0..N {
                cell.value[c] += p.kronrod * kronrod[c];
                along_t[c] += p.kronrod * (kronrod[c] - gauss[c]).abs();
            }
        }
        for c in 0..N {
            cell.value[c] *= area;
            let across: f64 = PAIR.iter().zip(&along_phi).map(|(t, column)| t.kronrod * column[c].abs()).sum();
            for (axis, difference) in [area * along_t[c], area * across].into_iter().enumerate() {
                // Written so that NaN wins: it must not pass for a small error.
                cell.error[axis] = if difference <= cell.error[axis] { cell.error[axis] } else { difference };
            }
        }
        cell
    }

    /// Halves the cell `index` along its worse axis; false where it is too small for that.
    fn split(&mut self, index: usize) -> bool {
        let [along_t, along_phi] = self.cells[index].error;
        let axis = usize::from(along_t < along_phi);
        self.split_along(index, axis) || self.split_along(index, 1 - axis)
    }

    fn split_along(&mut self, index: usize, axis: usize) -> bool {
        let Cell { lo, hi, .. } = self.cells[index];
        if hi[axis] - lo[axis] < MIN_WIDTH {
            return false;
        }
        let at = 0.5 * (lo[axis] + hi[axis]);
        let (mut low_hi, mut high_lo) = (hi, lo);
        low_hi[axis] = at;
        high_lo[axis] = at;
        self.cells[index] = self.evaluate(lo, low_hi);
        self.queue.push(Rank { error: self.cells[index].total_error(), index });
        let high = self.evaluate(high_lo, hi);
        let high = self.push(high);
        let parent = self.node_of[index];
        let low = self.partition.nodes.len();
        self.partition.nodes.push(Node::Leaf { cell: index });
        self.node_of[index] = low;
        self.partition.nodes[parent] = Node::Split { axis, at, children: [low, high] };
        true
    }

    /// Halves every cell until none holds more than `mass` of the first integral, keeping cells about square (a zoomed
    /// lobe spans a third of t and all of φ), or until `max_evals` are spent.
    pub fn split_heavier_than(&mut self, mass: f64, max_evals: u64) {
        let mut index = 0;
        while index < self.cells.len() {
            let cell = &self.cells[index];
            let size = cell.hi - cell.lo;
            let axis = usize::from(3.0 * TAU * size.x < size.y);
            let heavy = cell.value[0] > mass && self.evals < max_evals;
            if !(heavy && self.split_along(index, axis)) {
                index += 1;
            }
        }
    }

    /// Halves every cell along both axes, or as many as `max_evals` allow.
    pub fn halve_all(&mut self, max_evals: u64) {
        for axis in [0, 1] {
            for index in 0..self.cells.len() {
                if self.evals < max_evals {
                    self.split_along(index, axis);
                }
            }
        }
    }

    /// The cells and their integrals, depth first, so that neighbours on the list are neighbours in the chart; each with
    /// its number in the [`Partition`].
    pub fn leaves(&self) -> Vec<(usize, Leaf)> {
        let leaf = |index: usize| {
            let Cell { lo, hi, value, .. } = self.cells[index];
            (index, Leaf { lo, hi, mass: value[0] })
        };
        self.partition.order().into_iter().map(leaf).collect()
    }

    /// The chart as it is cut at present.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// Makes sure that a feature at `w`, where the integrand is `value`, has been noticed: the cell around it is halved
    /// until one of its nodes sees at least half of that value.
    pub fn witness(&mut self, w: DVec3, value: f64, max_evals: u64) {
        let p = self.partition.chart.coordinates(w);
        while self.evals < max_evals {
            let index = self.partition.locate(p);
            let cell = &self.cells[index];
            if 2.0 * cell.peak >= value || cell.value.iter().any(|v| v.is_nan()) {
                return;
            }
            // Shrink evenly: where nothing is seen yet, the estimates say nothing about the axes.
            let size = cell.hi - cell.lo;
            let axis = usize::from(TAU * size.x < size.y);
            if !(self.split_along(index, axis) || self.split_along(index, 1 - axis)) {
                return;
            }
        }
    }

    /// Halves the worst cell again and again until the error is at most `tol` or `max_evals` are spent.
    pub fn refine(&mut self, tol: f64, max_evals: u64) {
        let mut error = self.error();
        let mut steps = 0_u32;
        while error > tol && self.evals < max_evals {
            let Some(Rank { error: worst, index }) = self.queue.pop() else { return };
            if self.cells[index].total_error() != worst {
                continue; // The cell has been halved since it was queued.
            }
            if !self.split(index) {
                continue;
            }
            let last = self.cells.len() - 1;
            error += self.cells[index].total_error() + self.cells[last].total_error() - worst;
            steps += 1;
            // The running difference loses digits as the sum shrinks: count afresh now and then, and before stopping.
            if steps.is_multiple_of(64) || error <= tol {
                error = self.error();
            }
        }
    }

    /// The integrals so far.
    pub fn value(&self) -> [f64; N] {
        std::array::from_fn(|c| self.cells.iter().map(|cell| cell.value[c]).collect::<Neumaier>().value())
    }

    /// A bound on the error of each integral: the sum of all cells' estimates. NaN where the integrand is.
    pub fn error(&self) -> f64 {
        self.cells.iter().map(Cell::total_error).sum()
    }

    /// The largest integrand seen at any node, and where.
    pub fn peak(&self) -> (DVec3, f64) {
        let hottest = self.cells.iter().max_by(|a, b| a.peak.total_cmp(&b.peak));
        hottest.map_or((DVec3::Z, 0.0), |cell| (cell.peak_at, cell.peak))
    }

    /// How often the integrand was evaluated.
    pub fn evals(&self) -> u64 {
        self.evals
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::{direction, mirror};
    use std::f64::consts::PI;

    #[test]
    fn moments_of_the_hemisphere_to_the_last_digits() {
        // ∫ cos^k dω = 2π/(k + 1)
        let f = |w: DVec3| [1.0, w.z, w.z.powi(5)];
        for chart in [Chart::upright(direction(0.9, 1.0)), Chart::half(direction(1.5, 0.0))] {
            let mut mesh = Mesh::new(chart, &f);
            mesh.refine(1e-11, 1 << 22);
            for (value, exact) in mesh.value().into_iter().zip([TAU, PI, TAU / 6.0]) {
                assert!((value - exact).abs() <= mesh.error() + 1e-13, "{value} {exact}");
            }
            assert!(mesh.error() <= 1e-11, "{} after {}", mesh.error(), mesh.evals());
        }
    }

    /// (r·w)^n about the mirror direction, as in a Phong lobe of exponent 10⁶: ∫ = 2π/(n + 1) where none of it is cut.
    fn spike(r: DVec3) -> impl Fn(DVec3) -> [f64; 1] {
        move |w| [(1e6 * (-0.5 * (w - r).length_squared()).max(-1.0).ln_1p()).exp()]
    }

    #[test]
    fn a_chart_about_the_lobe_resolves_a_spike_of_a_thousandth_of_a_radian() {
        let wo = direction(0.8, 2.0);
        let f = spike(mirror(wo));
        let mut mesh = Mesh::new(Chart::about(mirror(wo), wo), &f);
        mesh.refine(1e-15, 1 << 20);
        let exact = TAU / (1e6 + 1.0);
        assert!((mesh.value()[0] - exact).abs() < 1e-9 * exact && mesh.error() <= 1e-15);
    }

    #[test]
    fn a_spike_away_from_every_pole_is_missed_without_and_found_with_a_witness() {
        let wo = direction(0.8, 2.0);
        let r = direction(0.35, -0.7);
        let f = spike(r);
        let mut mesh = Mesh::new(Chart::upright(wo), &f);
        mesh.refine(1e-12, 1 << 20);
        assert!(mesh.value()[0] < 1e-9, "the negative control: no node sees the spike");
        let mut mesh = Mesh::new(Chart::upright(wo), &f);
        mesh.witness(r, 1.0, 1 << 20);
        mesh.refine(1e-14, 1 << 20);
        assert!((mesh.value()[0] * (1e6 + 1.0) / TAU - 1.0).abs() < 1e-8);
    }

    #[test]
    fn locate_finds_the_cell_and_the_leaves_tile_the_chart() {
        let f = |w: DVec3| [w.z];
        let mut mesh = Mesh::new(Chart::half(direction(1.0, 0.4)), &f);
        mesh.split_heavier_than(PI / 500.0, 1 << 22);
        let leaves = mesh.leaves();
        let area: f64 = leaves.iter().map(|(_, leaf)| (leaf.hi - leaf.lo).element_product()).sum();
        assert!((area - TAU).abs() < 1e-12 && leaves.iter().all(|(_, leaf)| leaf.mass <= PI / 500.0));
        for (index, leaf) in leaves {
            assert_eq!(mesh.partition().locate(0.5 * (leaf.lo + leaf.hi)), index);
        }
    }

    #[test]
    fn nan_is_never_resolved() {
        let f = |w: DVec3| [if w.z > 0.99 { f64::NAN } else { 1.0 }];
        let mut mesh = Mesh::new(Chart::upright(DVec3::Z), &f);
        mesh.refine(1e-6, 1 << 16);
        assert!(mesh.error().is_nan());
    }
}
