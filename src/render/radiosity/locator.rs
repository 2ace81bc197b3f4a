//! Which patch of a face a point lies in: bins over the face, each with the patches that reach into it.

use glam::{DVec2, DVec3};

use super::face::Outline;
use super::patch::{Form, Patch};
use crate::math::sphere::basis;
use crate::scene::Quadric;

/// How far outside its edges, in sizes of a bin, a point still belongs to a patch: points of rays are rounded.
const SLACK: f64 = 1e-6;

/// Finds the patches of a face.
#[derive(Debug)]
pub(super) struct Locator {
    chart: Chart,
    /// Lower corner of the bins, and their size.
    from: DVec2,
    size: DVec2,
    /// Bins along each axis.
    across: usize,
    /// Where the list of each bin begins in `members`.
    starts: Vec<u32>,
    /// Numbers of patches.
    members: Vec<u32>,
}

/// Coordinates on a face.
#[derive(Debug)]
enum Chart {
    Plane { x: DVec3, y: DVec3 },
    Curved(Quadric),
}

impl Chart {
    fn at(&self, p: DVec3) -> DVec2 {
        match self {
            Self::Plane { x, y } => DVec2::new(p.dot(*x), p.dot(*y)),
            Self::Curved(quadric) => quadric.sample_area_inv(p),
        }
    }

    /// The smallest rectangle of coordinates around a patch.
    fn bounds(&self, form: &Form) -> (DVec2, DVec2) {
        match form {
            Form::Flat(polygon) => {
                let corners = polygon.corners().iter().map(|&corner| self.at(corner));
                corners.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
            }
            Form::Curved(curved) => (curved.from, curved.from + curved.size),
        }
    }
}

impl Locator {
    /// For these patches of a face, which are numbered from `first` on.
    pub(super) fn new(outline: &Outline, patches: &[Patch], first: usize) -> Self {
        let chart = match outline {
            Outline::Flat(polygon) => {
                let (x, y) = basis(polygon.normal());
                Chart::Plane { x, y }
            }
            Outline::Curved(surface) => Chart::Curved(surface.quadric),
        };
        let bounds: Vec<(DVec2, DVec2)> = patches.iter().map(|patch| chart.bounds(&patch.form)).collect();
        let all = bounds.iter().copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (from, to) = all.unwrap_or((DVec2::ZERO, DVec2::ONE));
        let across = (patches.len() as f64).sqrt().ceil().max(1.0) as usize;
        let size = ((to - from) / across as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut locator = Self { chart, from, size, across, starts: Vec::new(), members: Vec::new() };
        let mut bins = vec![Vec::new(); across * across];
        for (i, (min, max)) in bounds.iter().enumerate() {
            let (low, high) = (locator.bin(*min - size * SLACK), locator.bin(*max + size * SLACK));
            for row in low[1]..=high[1] {
                for column in low[0]..=high[0] {
                    bins[row * across + column].push((first + i) as u32);
                }
            }
        }
        for bin in bins {
            locator.starts.push(locator.members.len() as u32);
            locator.members.extend(bin);
        }
        locator.starts.push(locator.members.len() as u32);
        locator
    }

    fn bin(&self, at: DVec2) -> [usize; 2] {
        let bin = (at - self.from) / self.size;
        // A number below 0 becomes 0.
        [bin.x, bin.y].map(|x| (x as usize).min(self.across - 1))
    }

    /// The patch in which the point of the face lies, if any does.
    pub(super) fn find(&self, patches: &[Patch], p: DVec3) -> Option<usize> {
        let at = self.chart.at(p);
        let [column, row] = self.bin(at);
        let bin = row * self.across + column;
        let members = &self.members[self.starts[bin] as usize..self.starts[bin + 1] as usize];
        let inside = |&member: &u32| match &patches[member as usize].form {
            Form::Flat(polygon) => polygon.distance_inside(p),
            Form::Curved(curved) => (at - curved.from).min(curved.from + curved.size - at).min_element(),
        };
        let found = members.iter().map(|member| (*member, inside(member))).max_by(|a, b| a.1.total_cmp(&b.1));
        found.filter(|(_, inside)| *inside >= -SLACK * self.size.max_element()).map(|(member, _)| member as usize)
    }
}
