//! The tree: a surface-area heuristic over bins, and nodes of eight children from the start.
//!
//! A node begins with one part, and the part of largest area is split in two until there are eight or none is too
//! large for a leaf. A split is the best of up to 32 planes on each axis by the sum of area × leaves, a leaf being a
//! whole vector however full it is. Parts are built in parallel and put together in order; unions and counts of bins
//! do not depend on the order either. So the tree is the same for any number of threads.
//!
//! # References
//! - Wald 2007, On fast construction of SAH-based bounding volume hierarchies, IEEE Symposium on Interactive Ray Tracing

use std::ops::Range;

use glam::Vec4;
use rayon::prelude::*;

use super::kernel::{Stack, in_huge_pages};
use super::node::{LEAF, Node, WIDTH};

/// The box of a thing to be put into the tree, and its index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// The least coordinates; the fourth holds the bits of the index.
    lo: Vec4,
    hi: Vec4,
}

impl Item {
    pub(super) fn new(lo: [f32; 3], hi: [f32; 3], index: u32) -> Self {
        Self { lo: Vec4::new(lo[0], lo[1], lo[2], f32::from_bits(index)), hi: Vec4::new(hi[0], hi[1], hi[2], 0.0) }
    }

    pub(super) fn index(&self) -> u32 {
        self.lo.w.to_bits()
    }

    /// Twice the centre; the fourth coordinate means nothing.
    fn centre(&self) -> Vec4 {
        self.lo + self.hi
    }
}

/// The smallest box around some boxes or points; the fourth coordinates mean nothing.
#[derive(Clone, Copy, Debug)]
struct Hull {
    lo: Vec4,
    hi: Vec4,
}

impl Hull {
    const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    fn add(&mut self, lo: Vec4, hi: Vec4) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }

    fn union(mut self, other: &Self) -> Self {
        self.add(other.lo, other.hi);
        self
    }

    /// Half the surface.
    fn area(&self) -> f32 {
        let [x, y, z, _] = (self.hi - self.lo).to_array();
        x * y + y * z + z * x
    }
}

/// A run of items, with the box around them and the box around twice their centres.
#[derive(Clone, Debug)]
struct Part {
    items: Range<usize>,
    hull: Hull,
    centres: Hull,
}

impl Part {
    fn of(items: &[Item], range: Range<usize>) -> Self {
        let (mut hull, mut centres) = (Hull::EMPTY, Hull::EMPTY);
        for item in &items[range.clone()] {
            hull.add(item.lo, item.hi);
            centres.add(item.centre(), item.centre());
        }
        Self { items: range, hull, centres }
    }

    fn len(&self) -> usize {
        self.items.len()
    }
}

/// Nodes, and leaves as runs of the ordered items.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// The root is what [`Tree::root`] says; children are indices into this or into `leaves`.
    pub(super) nodes: Vec<Node>,
    /// Runs of `items`.
    pub(super) leaves: Vec<Range<u32>>,
    /// The items in the order of the leaves.
    pub(super) items: Vec<Item>,
    /// The child that everything is below; None if there is nothing.
    pub(super) root: Option<u32>,
}

impl Tree {
    /// Builds one with no more than `leaf_size` ≤ 8 items in a leaf.
    pub(super) fn build(mut items: Vec<Item>, leaf_size: usize) -> Self {
        let mut branch = Branch::default();
        let whole = whole(&items);
        let root = (!items.is_empty()).then(|| grow(&mut items, 0, &whole, leaf_size, 0, &mut branch));
        let mut nodes = in_huge_pages(branch.nodes.len());
        nodes.append(&mut branch.nodes);
        Self { nodes, leaves: branch.leaves, items, root }
    }
}

/// Items are gathered in parallel in pieces of this size.
const PIECE: usize = 1 << 14;

/// Below this number of items, a part is not worth another thread.
const PARALLEL: usize = 1 << 12;

/// [`Part::of`] everything, in parallel.
fn whole(items: &[Item]) -> Part {
    let pieces = items.par_chunks(PIECE).map(|piece| Part::of(piece, 0..piece.len()));
    let neutral = || Part { items: 0..0, hull: Hull::EMPTY, centres: Hull::EMPTY };
    let join =
        |a: Part, b: Part| Part { items: 0..0, hull: a.hull.union(&b.hull), centres: a.centres.union(&b.centres) };
    Part { items: 0..items.len(), ..pieces.reduce(neutral, join) }
}

/// The nodes and leaves of a part of the tree, before it is put in its place.
#[derive(Default)]
struct Branch {
    nodes: Vec<Node>,
    leaves: Vec<Range<u32>>,
}

impl Branch {
    /// Takes over another branch whose top is `child`; returns the child's new name.
    fn append(&mut self, other: Self, child: u32) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let moved = |child: u32| child + if child & LEAF == 0 { nodes } else { leaves };
        self.nodes.extend(other.nodes.into_iter().map(|mut node| {
            node.child = node.child.map(moved);
            node
        }));
        self.leaves.extend(other.leaves);
        moved(child)
    }
}

/// From this depth on parts are halved by count, which bounds the depth for any input, and so the traversal's stack.
const DEEP: usize = 14;

// Halving thrice a level ends after 11 levels for 2³² items; each level leaves 7 siblings waiting.
const _: () = assert!((DEEP + 11) * (WIDTH - 1) < Stack::SLOTS);

/// Adds a node or a leaf for `part` of `items`, which begin at `start` of all items, and everything below; returns the
/// child to refer to it.
fn grow(items: &mut [Item], start: usize, part: &Part, leaf_size: usize, depth: usize, out: &mut Branch) -> u32 {
    if part.len() <= leaf_size {
        let first = (start + part.items.start) as u32;
        out.leaves.push(first..first + part.len() as u32);
        return LEAF | (out.leaves.len() - 1) as u32;
    }
    let parts = eight(items, part, leaf_size, depth >= DEEP);
    let at = out.nodes.len();
    out.nodes.push(Node::EMPTY);
    let mut children = [LEAF; WIDTH];
    if part.len() < PARALLEL {
        for (child, part) in children.iter_mut().zip(&parts) {
            *child = grow(items, start, part, leaf_size, depth + 1, out);
        }
    } else {
        // Parts lie one after the other, from the beginning of `part` to its end.
        let mut pieces = Vec::with_capacity(parts.len());
        let mut rest = &mut items[part.items.clone()];
        for part in &parts {
            let (piece, after) = rest.split_at_mut(part.len());
            pieces.push((piece, start + part.items.start));
            rest = after;
        }
        let branches: Vec<(Branch, u32)> = pieces
            .into_par_iter()
            .zip(&parts)
            .map(|((piece, first), part)| {
                let mut branch = Branch::default();
                let part = Part { items: 0..piece.len(), ..part.clone() };
                let child = grow(piece, first, &part, leaf_size, depth + 1, &mut branch);
                (branch, child)
            })
            .collect();
        for (child, (branch, top)) in children.iter_mut().zip(branches) {
            *child = out.append(branch, top);
        }
    }
    for (lane, (part, child)) in parts.iter().zip(children).enumerate() {
        out.nodes[at].set(lane, part.hull.lo, part.hull.hi, child);
    }
    at as u32
}

/// Splits a part into up to eight, in the order of their items.
fn eight(items: &mut [Item], part: &Part, leaf_size: usize, halve: bool) -> Vec<Part> {
    let mut parts = Vec::with_capacity(WIDTH);
    parts.push(part.clone());
    while parts.len() < WIDTH {
        let mut largest: Option<(usize, f32)> = None;
        for (at, part) in parts.iter().enumerate() {
            let size = if halve { part.len() as f32 } else { part.hull.area() };
            if part.len() > leaf_size && largest.is_none_or(|(_, area)| area < size) {
                largest = Some((at, size));
            }
        }
        let Some((at, _)) = largest else { break };
        let (left, right) = split(items, &parts[at], leaf_size, halve);
        parts[at] = left;
        parts.insert(at + 1, right);
    }
    parts
}

const BINS: usize = 32;

/// What has its centre in an interval of an axis.
#[derive(Clone, Copy)]
struct Bin {
    hull: Hull,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { hull: Hull::EMPTY, count: 0 };

    fn union(&self, other: &Self) -> Self {
        Self { hull: self.hull.union(&other.hull), count: self.count + other.count }
    }
}

/// How twice a centre gives the number of its bin on each axis.
#[derive(Clone, Copy)]
struct Binning {
    bins: usize,
    lo: Vec4,
    scale: Vec4,
    /// Axes on which the centres differ.
    wide: [bool; 3],
}

impl Binning {
    fn of(part: &Part) -> Self {
        let bins = (4 + part.len() / 16).min(BINS);
        let size = part.centres.hi - part.centres.lo;
        let wide = [0, 1, 2].map(|axis| size[axis] > f32::MIN_POSITIVE);
        // A little less than the number of bins, so that the greatest centre falls into the last.
        let scale = [0, 1, 2].map(|axis| if wide[axis] { bins as f32 * 0.9999 / size[axis] } else { 0.0 });
        Self { bins, lo: part.centres.lo, scale: Vec4::new(scale[0], scale[1], scale[2], 0.0), wide }
    }

    /// The bins on the three axes. Adding 2²³ leaves a number's nearest integer in the low bits.
    fn of_item(&self, item: &Item) -> [usize; 3] {
        const INTEGER: f32 = 8_388_608.0;
        let bin = (item.centre() - self.lo) * self.scale - Vec4::splat(0.5);
        let bin = bin.max(Vec4::ZERO).min(Vec4::splat((self.bins - 1) as f32)) + Vec4::splat(INTEGER);
        let [x, y, z, _] = bin.to_array();
        [x, y, z].map(|k| k.to_bits() as usize & (BINS - 1))
    }
}

type Bins = [[Bin; BINS]; 3];

fn fill(items: &[Item], binning: &Binning) -> Bins {
    let mut bins = [[Bin::EMPTY; BINS]; 3];
    for item in items {
        let at = binning.of_item(item);
        for axis in 0..3 {
            let bin = &mut bins[axis][at[axis]];
            bin.hull.add(item.lo, item.hi);
            bin.count += 1;
        }
    }
    bins
}

fn fill_parallel(items: &[Item], binning: &Binning) -> Bins {
    if items.len() < 2 * PIECE {
        return fill(items, binning);
    }
    let pieces = items.par_chunks(PIECE).map(|piece| fill(piece, binning));
    let join = |mut a: Bins, b: Bins| {
        for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
            *a = a.union(b);
        }
        a
    };
    pieces.reduce(|| [[Bin::EMPTY; BINS]; 3], join)
}

/// Where to split: what lies in bins below `bin` of an axis goes left.
struct Plane {
    axis: usize,
    bin: usize,
    left: Hull,
    right: Hull,
}

/// The plane with the least sum of area × leaves.
fn best_plane(bins: &Bins, binning: &Binning, leaf_size: usize) -> Option<Plane> {
    let leaves = |count: u32| (count as usize).div_ceil(leaf_size) as f32;
    let mut best: Option<(f32, Plane)> = None;
    for axis in (0..3).filter(|&axis| binning.wide[axis]) {
        let bins = &bins[axis][..binning.bins];
        let mut below = [Bin::EMPTY; BINS];
        for k in 1..bins.len() {
            below[k] = below[k - 1].union(&bins[k - 1]);
        }
        let mut above = Bin::EMPTY;
        for k in (1..bins.len()).rev() {
            above = above.union(&bins[k]);
            let left = &below[k];
            if left.count == 0 || above.count == 0 {
                continue;
            }
            let cost = left.hull.area() * leaves(left.count) + above.hull.area() * leaves(above.count);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, Plane { axis, bin: k, left: left.hull, right: above.hull }));
            }
        }
    }
    best.map(|(_, plane)| plane)
}

/// Reorders the items of a part and splits them in two, neither of them empty.
fn split(items: &mut [Item], part: &Part, leaf_size: usize, halve: bool) -> (Part, Part) {
    let binning = Binning::of(part);
    let run = &mut items[part.items.clone()];
    let plane = if halve { None } else { best_plane(&fill_parallel(run, &binning), &binning, leaf_size) };
    let Some(plane) = plane else {
        // All centres are one point, or the tree is too deep: any halves will do, whole leaves on the left.
        let half = (part.len() / 2).next_multiple_of(leaf_size).min(part.len() - 1);
        let middle = part.items.start + half;
        return (Part::of(items, part.items.start..middle), Part::of(items, middle..part.items.end));
    };
    let (mut left, mut right) = (Hull::EMPTY, Hull::EMPTY);
    let (mut at, mut end) = (0, run.len());
    while at < end {
        let item = run[at];
        let centre = item.centre();
        if binning.of_item(&item)[plane.axis] < plane.bin {
            left.add(centre, centre);
            at += 1;
        } else {
            right.add(centre, centre);
            end -= 1;
            run.swap(at, end);
        }
    }
    let middle = part.items.start + at;
    (
        Part { items: part.items.start..middle, hull: plane.left, centres: left },
        Part { items: middle..part.items.end, hull: plane.right, centres: right },
    )
}
