//! The tree: a surface-area heuristic over bins, and nodes of eight children from the start.
//!
//! A node begins with one part, and the part of largest area is split in two until there are eight or none is too
//! large for a leaf. A split is the best of up to 32 planes on each axis by the sum of area × leaves, a leaf being a
//! whole vector however full it is. Parts are built in parallel and put together in order; unions and counts of bins
//! do not depend on the order either. So the tree is the same for any number of threads.
//!
//! # References
//! - Wald 2007, On fast construction of SAH-based bounding volume hierarchies, IEEE Symposium on Interactive Ray Tracing
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use std::ops::Range;

use glam::Vec4;
use rayon::prelude::*;

use super::kernel::{Level, Stack, in_huge_pages};
use super::node::{LEAF, Node, WIDTH};
use super::split::split;

/// The box of a thing to be put into the tree, and its index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// The least coordinates; the fourth holds the bits of the index.
    pub(super) lo: Vec4,
    pub(super) hi: Vec4,
}

impl Item {
    pub(super) fn new(lo: [f32; 3], hi: [f32; 3], index: u32) -> Self {
        let number = f32::from_bits(index & Self::INDEX | 1 << 30);
        Self { lo: Vec4::new(lo[0], lo[1], lo[2], number), hi: Vec4::new(hi[0], hi[1], hi[2], 0.0) }
    }

    /// Nothing: a box the wrong way round.
    pub(super) const NONE: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    /// Whether this is not [`Item::NONE`].
    pub(super) fn is_some(&self) -> bool {
        self.lo.x <= self.hi.x
    }

    /// The bits of an index. Another bit makes them a number of ordinary size: some processors are slow with denormal ones,
    /// even if nobody looks at the result.
    const INDEX: u32 = (1 << 30) - 1;

    pub(super) fn index(&self) -> u32 {
        self.lo.w.to_bits() & Self::INDEX
    }

    /// Twice the centre; the fourth coordinate means nothing.
    pub(super) fn centre(&self) -> Vec4 {
        self.lo + self.hi
    }
}

/// The smallest box around some boxes or points; the fourth coordinates mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull {
    pub(super) lo: Vec4,
    pub(super) hi: Vec4,
}

impl Hull {
    pub(super) const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn add(&mut self, lo: Vec4, hi: Vec4) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }

    #[inline(always)]
    pub(super) fn union(mut self, other: &Self) -> Self {
        self.add(other.lo, other.hi);
        self
    }

    /// Half the surface.
    #[inline(always)]
    pub(super) fn area(&self) -> f32 {
        let [x, y, z, _] = (self.hi - self.lo).to_array();
        x * y + y * z + z * x
    }
}

/// A run of items, with the box around them and the box around twice their centres.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) items: Range<usize>,
    pub(super) hull: Hull,
    pub(super) centres: Hull,
}

impl Part {
    pub(super) fn of(items: &[Item], range: Range<usize>) -> Self {
        let (mut hull, mut centres) = (Hull::EMPTY, Hull::EMPTY);
        for item in &items[range.clone()] {
            hull.add(item.lo, item.hi);
            centres.add(item.centre(), item.centre());
        }
        Self { items: range, hull, centres }
    }

    pub(super) fn len(&self) -> usize {
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
    pub(super) fn build(mut items: Vec<Item>, leaf_size: usize, level: Level) -> Self {
        let mut branch = Branch::default();
        let whole = whole(&items);
        let grower = Grower { leaf_size, level };
        let root = (!items.is_empty()).then(|| grower.grow(&mut items, 0, &whole, 0, &mut branch));
        let mut nodes = in_huge_pages(branch.nodes.len());
        nodes.append(&mut branch.nodes);
        Self { nodes, leaves: branch.leaves, items, root }
    }
}

/// Items are gathered in parallel in pieces of this size.
pub(super) const PIECE: usize = 1 << 14;

/// Below this number of items, a part is not worth another thread.
const PARALLEL: usize = 1 << 13;

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

/// Builds nodes from parts.
struct Grower {
    leaf_size: usize,
    level: Level,
}

impl Grower {
    /// Adds a node or a leaf for `part` of `items`, which begin at `start` of all items, and everything below; returns the
    /// child to refer to it.
    fn grow(&self, items: &mut [Item], start: usize, part: &Part, depth: usize, out: &mut Branch) -> u32 {
        if part.len() <= self.leaf_size {
            let first = (start + part.items.start) as u32;
            out.leaves.push(first..first + part.len() as u32);
            return LEAF | (out.leaves.len() - 1) as u32;
        }
        let parts = self.eight(items, part, depth >= DEEP);
        let at = out.nodes.len();
        out.nodes.push(Node::EMPTY);
        let mut children = [LEAF; WIDTH];
        if part.len() < PARALLEL {
            for (child, part) in children.iter_mut().zip(&parts) {
                *child = self.grow(items, start, part, depth + 1, out);
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
                    let child = self.grow(piece, first, &part, depth + 1, &mut branch);
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
    fn eight(&self, items: &mut [Item], part: &Part, halve: bool) -> Vec<Part> {
        let mut parts = Vec::with_capacity(WIDTH);
        parts.push(part.clone());
        while parts.len() < WIDTH {
            let mut largest: Option<(usize, f32)> = None;
            for (at, part) in parts.iter().enumerate() {
                let size = if halve { part.len() as f32 } else { part.hull.area() };
                if part.len() > self.leaf_size && largest.is_none_or(|(_, area)| area < size) {
                    largest = Some((at, size));
                }
            }
            let Some((at, _)) = largest else { break };
            let (left, right) = self.split(items, &parts[at], halve);
            parts[at] = left;
            parts.insert(at + 1, right);
        }
        parts
    }

    /// Reorders the items of a part and splits them in two, neither of them empty.
    fn split(&self, items: &mut [Item], part: &Part, halve: bool) -> (Part, Part) {
        let best = if halve { None } else { split(self.level, items, part, self.leaf_size) };
        best.unwrap_or_else(|| {
            // All centres are one point, or the tree is too deep: any halves will do, whole leaves on the left.
            let half = (part.len() / 2).next_multiple_of(self.leaf_size).min(part.len() - 1);
            let middle = part.items.start + half;
            (Part::of(items, part.items.start..middle), Part::of(items, middle..part.items.end))
        })
    }
}
