//! Leaves of eight triangles, in two editions.
//!
//! Where every coordinate of a mesh is an f32, as in most files, a leaf holds the vertices themselves, for both tests.
//! Otherwise it holds their rounding, taken where that costs least, and the f64 lie apart.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::DVec3;
use rayon::prelude::*;

use super::build::{Item, Tree};
use super::exact::Corners;
use super::kernel::{Lanes, in_huge_pages};
use super::node::WIDTH;
use super::probe::{Start, Triangles, cross, load3, longest_edge};
use super::query::{Frame, Query};
use super::walk::Prefetch;

/// What the traversal asks of leaves.
pub(super) trait Leaves: Prefetch {
    /// Where a ray starts, for the first test.
    fn start<S: Lanes>(&self, s: S, query: &Query<S>) -> Start<S>;
    /// The triangles of a leaf, for the first test. Absent ones are at NaN, and come last.
    fn triangles<S: Lanes>(&self, s: S, leaf: u32) -> Triangles<S>;
    /// A coordinate of the three vertices of a triangle.
    fn row<S: Lanes>(&self, s: S, leaf: u32, lane: u32, axis: usize) -> S::D;
    /// The triangle's index.
    fn triangle(&self, leaf: u32, lane: u32) -> u32;
    /// How long the tree's unit of length is, in that of the first test.
    fn unit(&self) -> f32;
    /// What they occupy.
    fn memory_bytes(&self) -> usize;
}

/// Eight triangles in f32, and where they begin among all.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Block {
    /// Three vectors of each triangle. Absent triangles are at NaN, and so are never hit.
    rows: [[[f32; WIDTH]; 3]; 3],
    /// No edge is longer: E of [`Query`].
    longest: f32,
    /// The place of the first of them in the tree's order.
    first: u32,
}

impl Block {
    fn new(triangles: &[[DVec3; 3]], size: f64, first: u32, vectors: impl Fn(&[DVec3; 3]) -> [DVec3; 3]) -> Self {
        let mut block = Self { rows: [[[f32::NAN; WIDTH]; 3]; 3], longest: longest_edge(triangles, size), first };
        for (lane, v) in triangles.iter().enumerate() {
            for (row, vector) in block.rows.iter_mut().zip(vectors(v)) {
                for axis in 0..3 {
                    row[axis][lane] = vector[axis] as f32;
                }
            }
        }
        block
    }

    /// Of all leaves of a tree, its triangles being given by `vertices`.
    fn of_tree(
        tree: &Tree,
        size: f64,
        vertices: impl Fn(usize) -> [DVec3; 3] + Sync,
        vectors: impl Fn(&[DVec3; 3]) -> [DVec3; 3] + Sync,
    ) -> Vec<Self> {
        let mut blocks = in_huge_pages(tree.leaves.len());
        let of_leaf = tree.leaves.par_iter().map(|leaf| {
            let mut triangles = [[DVec3::ZERO; 3]; WIDTH];
            for (triangle, at) in triangles.iter_mut().zip(leaf.clone()) {
                *triangle = vertices(at as usize);
            }
            Self::new(&triangles[..leaf.len()], size, leaf.start, &vectors)
        });
        of_leaf.collect_into_vec(&mut blocks);
        blocks
    }
}

/// Leaves that hold the vertices as they are.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    blocks: Vec<Block>,
    /// The index of each triangle, in the tree's order.
    triangles: Vec<u32>,
    /// 1 / scale of the tree.
    unit: f64,
}

impl Exact {
    /// None if a coordinate is not an f32, or products of f32 could over- or underflow.
    pub(super) fn new(tree: &Tree, frame: &Frame, vertices: impl Fn(u32) -> [DVec3; 3] + Sync) -> Option<Self> {
        // E², M E² and the slack of both then are normal numbers, with E down to 10⁻¹² of M.
        if !(1e-9..1e3).contains(&frame.scale) {
            return None;
        }
        let exact = |v: DVec3| v.as_vec3().as_dvec3() == v;
        if !tree.items.par_iter().all(|item| vertices(item.index()).into_iter().all(exact)) {
            return None;
        }
        let mut triangles = in_huge_pages(tree.items.len());
        tree.items.par_iter().map(Item::index).collect_into_vec(&mut triangles);
        let unit = 1.0 / frame.scale;
        let blocks = Block::of_tree(tree, unit, |at| vertices(triangles[at]), |v| *v);
        Some(Self { blocks, triangles, unit })
    }
}

impl Prefetch for Exact {
    #[inline(always)]
    fn prefetch<S: Lanes>(&self, s: S, leaf: u32) {
        s.prefetch(&self.blocks[leaf as usize]);
    }
}

impl Leaves for Exact {
    #[inline(always)]
    fn start<S: Lanes>(&self, s: S, query: &Query<S>) -> Start<S> {
        // C = (v0 − o) − rest: the first difference is rounded by EPS |C| at most, o plus rest is good to 2⁻⁴⁸ |o|.
        let size = s.quad_first(s.quad_sum(s.quad_copysign(query.world, s.quad_splat(1.0))));
        Start { origin: query.world, slack: (f64::from(query.slack) * (self.unit + size * 1e-6)) as f32 }
    }

    #[inline(always)]
    fn triangles<S: Lanes>(&self, s: S, leaf: u32) -> Triangles<S> {
        let block = &self.blocks[leaf as usize];
        let [v0, v1, v2] = &block.rows;
        let (v0, v1, v2) = (load3(s, v0, 0), load3(s, v1, 0), load3(s, v2, 0));
        let edge = |v: [S::F; 3]| [s.sub(v[0], v0[0]), s.sub(v[1], v0[1]), s.sub(v[2], v0[2])];
        let (e1, e2) = (edge(v1), edge(v2));
        Triangles { v0, e1, e2, n: cross(s, e1, e2), longest: block.longest }
    }

    #[inline(always)]
    fn row<S: Lanes>(&self, s: S, leaf: u32, lane: u32, axis: usize) -> S::D {
        let (rows, lane) = (&self.blocks[leaf as usize].rows, lane as usize & 7);
        s.widen(s.half([rows[0][axis][lane], rows[1][axis][lane], rows[2][axis][lane]]))
    }

    #[inline(always)]
    fn triangle(&self, leaf: u32, lane: u32) -> u32 {
        self.triangles[(self.blocks[leaf as usize].first + lane) as usize]
    }

    #[inline(always)]
    fn unit(&self) -> f32 {
        self.unit as f32
    }

    fn memory_bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Block>() + self.triangles.capacity() * size_of::<u32>()
    }
}

/// Leaves that hold roundings, and the vertices apart from them.
#[derive(Clone, Debug)]
pub(super) struct Rounded {
    /// First vertices and the edges from there, in the tree's coordinates.
    blocks: Vec<Block>,
    /// In the tree's order.
    corners: Vec<Corners>,
}

impl Rounded {
    pub(super) fn new(tree: &Tree, frame: &Frame, vertices: impl Fn(u32) -> [DVec3; 3] + Sync) -> Self {
        let corners = Corners::of_tree(tree, vertices);
        let inside = |at: usize| corners[at].vertices().map(|v| frame.enter(v));
        let blocks = Block::of_tree(tree, 1.0, inside, |v| [v[0], v[1] - v[0], v[2] - v[0]]);
        Self { blocks, corners }
    }
}

impl Prefetch for Rounded {
    #[inline(always)]
    fn prefetch<S: Lanes>(&self, s: S, leaf: u32) {
        s.prefetch(&self.blocks[leaf as usize]);
    }
}

impl Leaves for Rounded {
    #[inline(always)]
    fn start<S: Lanes>(&self, _: S, query: &Query<S>) -> Start<S> {
        Start { origin: query.origin, slack: query.slack }
    }

    #[inline(always)]
    fn triangles<S: Lanes>(&self, s: S, leaf: u32) -> Triangles<S> {
        let block = &self.blocks[leaf as usize];
        let [v0, e1, e2] = &block.rows;
        let (v0, e1, e2) = (load3(s, v0, 0), load3(s, e1, 0), load3(s, e2, 0));
        Triangles { v0, e1, e2, n: cross(s, e1, e2), longest: block.longest }
    }

    #[inline(always)]
    fn row<S: Lanes>(&self, s: S, leaf: u32, lane: u32, axis: usize) -> S::D {
        self.corners[(self.blocks[leaf as usize].first + lane) as usize].row(s, axis)
    }

    #[inline(always)]
    fn triangle(&self, leaf: u32, lane: u32) -> u32 {
        self.corners[(self.blocks[leaf as usize].first + lane) as usize].triangle()
    }

    #[inline(always)]
    fn unit(&self) -> f32 {
        1.0
    }

    fn memory_bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Block>() + self.corners.capacity() * size_of::<Corners>()
    }
}
