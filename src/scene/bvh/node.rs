//! Eight boxes side by side: what one vector instruction works on.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::Vec4;

use super::kernel::Lanes;
use super::query::Slabs;

/// How many children a node and how many triangles a leaf has.
pub(super) const WIDTH: usize = 8;

/// Set in a child that is a leaf; the other bits are its index, among leaves or among nodes.
pub(super) const LEAF: u32 = 1 << 31;

/// The boxes of eight children and where these are.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// For each axis, the least and the greatest coordinates. An absent child has them the wrong way round.
    planes: [[[f32; WIDTH]; 2]; 3],
    /// A child: see [`LEAF`].
    pub(super) child: [u32; WIDTH],
}

impl Node {
    /// Without children.
    pub(super) const EMPTY: Self =
        Self { planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3], child: [LEAF; WIDTH] };

    /// The corners of a child's box that a ray meets first and last, and the child: see [`LEAF`].
    #[inline(always)]
    pub(super) fn child_of(&self, lane: usize, backwards: u32) -> ([[f32; 3]; 2], u32) {
        let corner = |other: u32| {
            let plane = |k: usize| self.planes[k][(backwards >> k & 1 ^ other) as usize][lane];
            [plane(0), plane(1), plane(2)]
        };
        ([corner(0), corner(1)], self.child[lane])
    }

    /// The children's least (0) or greatest (1) coordinates on an axis.
    #[inline(always)]
    pub(super) fn plane(&self, axis: usize, which: usize) -> &[f32; WIDTH] {
        &self.planes[axis][which & 1]
    }

    /// Puts a child into a lane.
    pub(super) fn set(&mut self, lane: usize, lo: Vec4, hi: Vec4, child: u32) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = lo[axis];
            self.planes[axis][1][lane] = hi[axis];
        }
        self.child[lane] = child;
    }
}

/// [`Slabs`] with every number in all lanes.
pub(super) struct Beam<S: Lanes> {
    near: [usize; 3],
    scale: [S::F; 3],
    near_shift: [S::F; 3],
    far_shift: [S::F; 3],
}

impl<S: Lanes> Beam<S> {
    #[inline(always)]
    pub(super) fn new(s: S, slabs: &Slabs<S>) -> Self {
        let backwards = slabs.backwards as usize;
        Self {
            near: [backwards & 1, backwards >> 1 & 1, backwards >> 2 & 1],
            scale: s.spread(slabs.scale),
            near_shift: s.spread(slabs.near_shift),
            far_shift: s.spread(slabs.far_shift),
        }
    }

    /// Distances at which the ray enters the boxes, and which boxes it passes through before `reach`.
    #[inline(always)]
    pub(super) fn enter(&self, s: S, node: &Node, reach: S::F) -> (S::F, u32) {
        let near = |k: usize| s.mul_sub(s.load(node.plane(k, self.near[k])), self.scale[k], self.near_shift[k]);
        let far = |k: usize| s.mul_sub(s.load(node.plane(k, self.near[k] ^ 1)), self.scale[k], self.far_shift[k]);
        let enter = s.max(s.max(near(0), near(1)), s.max(near(2), s.splat(0.0)));
        let leave = s.min(s.min(far(0), far(1)), s.min(far(2), reach));
        (enter, s.bits(s.le(enter, leave)))
    }
}
