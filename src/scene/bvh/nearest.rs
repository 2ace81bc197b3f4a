//! The search for the nearest hit of one ray.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::exact::{Place, Shear, TriangleHit};
use super::kernel::Lanes;
use super::leaves::Leaves;
use super::node::{Beam, Node};
use super::probe::Probe;
use super::query::{Frame, Query, Twist, up};
use super::walk::{self, Visit};
use crate::scene::ray::Ray;

/// How far the search for one ray has come.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    best: Option<Found>,
    /// What lies beyond this distance, in the tree's units, cannot be nearer.
    pub(super) reach: f32,
}

/// The nearest hit so far. Which triangle that is need not be known before the end.
#[derive(Clone, Copy)]
struct Found {
    place: Place,
    leaf: u32,
    lane: u32,
}

impl Found {
    /// As [`TriangleHit::before`].
    #[inline(always)]
    fn before(&self, other: &Self, leaves: &impl Leaves) -> bool {
        let lower = || leaves.triangle(self.leaf, self.lane) < leaves.triangle(other.leaf, other.lane);
        self.place.t < other.place.t || (self.place.t == other.place.t && lower())
    }
}

/// What it takes to look at a leaf.
struct Search<'a, S: Lanes, L> {
    nearest: &'a mut Nearest,
    frame: &'a Frame,
    leaves: &'a L,
    ray: &'a Ray,
    probe: Probe<S>,
}

impl<S: Lanes, L: Leaves> Visit<S> for Search<'_, S, L> {
    #[inline(always)]
    fn visit(&mut self, s: S, leaf: u32) -> f32 {
        let Self { nearest, frame, leaves, ray, probe } = self;
        let tested = leaves.triangles(s, leaf).test(s, probe);
        let mut candidates = s.bits(tested.candidates(s, s.splat(nearest.reach * leaves.unit())));
        while candidates != 0 {
            nearest.look_at(s, frame, *leaves, ray, leaf, candidates.trailing_zeros());
            candidates &= candidates - 1;
        }
        nearest.reach
    }
}

impl Nearest {
    /// Nothing is found yet.
    #[inline(always)]
    pub(super) fn within(reach: f32) -> Self {
        Self { best: None, reach }
    }

    /// Looks at everything below a child of a node.
    #[inline(always)]
    pub(super) fn descend<T: Twist, S: Lanes>(
        &mut self,
        s: S,
        (nodes, frame): (&[Node], &Frame),
        leaves: &impl Leaves,
        child: u32,
        (ray, query): (&Ray, &Query<S>),
    ) {
        let beam = Beam::new(s, &query.slabs::<T>(s));
        let probe = Probe::new(s, query, &leaves.start(s, query));
        let reach = self.reach;
        let mut search = Search { nearest: self, frame, leaves, ray, probe };
        walk::nearest_first(s, nodes, child, &beam, reach, leaves, &mut search);
    }

    /// Looks at one triangle of a leaf.
    #[inline(always)]
    pub(super) fn look_at<S: Lanes>(
        &mut self,
        s: S,
        frame: &Frame,
        leaves: &impl Leaves,
        ray: &Ray,
        leaf: u32,
        lane: u32,
    ) {
        if ray.is_beside(leaves.triangle(leaf, lane)) {
            return;
        }
        let Some(place) = Shear::new(s, ray).hit(s, |axis| leaves.row(s, leaf, lane, axis), ray.t_max) else { return };
        let found = Found { place, leaf, lane };
        if self.best.as_ref().is_none_or(|best| found.before(best, leaves)) {
            self.reach = up(place.t * frame.scale);
            self.best = Some(found);
        }
    }

    /// What has been found.
    #[inline(always)]
    pub(super) fn hit(&self, leaves: &impl Leaves) -> Option<TriangleHit> {
        self.best.map(|found| found.place.of(leaves.triangle(found.leaf, found.lane)))
    }
}
