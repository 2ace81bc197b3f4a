//! Where to cut a part of the tree in two, and the cut.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use glam::Vec4;
use rayon::prelude::*;

use super::build::{Hull, Item, PIECE, Part};
use super::kernel::{Lanes, Level, Task};

/// Reorders the items of a part and splits them in two, neither of them empty, where the sum of area × leaves is least;
/// None if all centres are one point.
pub(super) fn split(level: Level, items: &mut [Item], part: &Part, leaf_size: usize) -> Option<(Part, Part)> {
    // Few bins for few items, whose own sides then are most of the candidates.
    match part.len() {
        ..96 => split_by::<8>(level, items, part, leaf_size),
        96..256 => split_by::<16>(level, items, part, leaf_size),
        _ => split_by::<32>(level, items, part, leaf_size),
    }
}

fn split_by<const BINS: usize>(
    level: Level,
    items: &mut [Item],
    part: &Part,
    leaf_size: usize,
) -> Option<(Part, Part)> {
    let binning = Binning::of::<BINS>(part);
    let run = &mut items[part.items.clone()];
    if run.len() < 2 * PIECE {
        return level.run(Split::<BINS> { run, part, binning: &binning, leaf_size });
    }
    let pieces = run.par_chunks(PIECE).map(|items| level.run(Fill::<BINS> { items, binning: &binning }));
    let bins = pieces.reduce(
        || [[Bin::EMPTY; BINS]; 3],
        |mut a, b| {
            for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
                *a = a.union(b);
            }
            a
        },
    );
    let plane = best_plane(&bins, &binning, leaf_size)?;
    Some(level.run(Cut { run, part, binning: &binning, plane: &plane }))
}

/// What has its centre in an interval of an axis.
#[derive(Clone, Copy)]
struct Bin {
    hull: Hull,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { hull: Hull::EMPTY, count: 0 };

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        Self { hull: self.hull.union(&other.hull), count: self.count + other.count }
    }
}

type Bins<const BINS: usize> = [[Bin; BINS]; 3];

/// How twice a centre gives the number of its bin on each axis.
struct Binning {
    lo: Vec4,
    scale: Vec4,
    last: Vec4,
    /// Axes on which the centres differ.
    wide: [bool; 3],
}

/// Added to a number below 2²², this leaves its nearest integer in the low bits.
const INTEGER: f32 = 8_388_608.0;

impl Binning {
    fn of<const BINS: usize>(part: &Part) -> Self {
        let size = part.centres.hi - part.centres.lo;
        let wide = [0, 1, 2].map(|axis| size[axis] > f32::MIN_POSITIVE);
        // A little less than the number of bins, so that the greatest centre falls into the last.
        let scale = [0, 1, 2].map(|axis| if wide[axis] { BINS as f32 * 0.9999 / size[axis] } else { 0.0 });
        Self {
            lo: part.centres.lo,
            scale: Vec4::new(scale[0], scale[1], scale[2], 0.0),
            last: Vec4::splat(BINS as f32 - 1.0),
            wide,
        }
    }

    /// The bins on the three axes, plus [`INTEGER`].
    #[inline(always)]
    fn of_centre(&self, centre: Vec4) -> Vec4 {
        let bin = (centre - self.lo) * self.scale - Vec4::splat(0.5);
        bin.max(Vec4::ZERO).min(self.last) + Vec4::splat(INTEGER)
    }
}

/// Where to split: what lies in bins below `bin` of an axis goes left.
struct Plane {
    axis: usize,
    bin: usize,
    left: Hull,
    right: Hull,
}

#[inline(always)]
fn fill<const BINS: usize>(items: &[Item], binning: &Binning) -> Bins<BINS> {
    let mut bins = [[Bin::EMPTY; BINS]; 3];
    for item in items {
        let at = binning.of_centre(item.centre()).to_array();
        for axis in 0..3 {
            let bin = &mut bins[axis][at[axis].to_bits() as usize & (BINS - 1)];
            bin.hull.add(item.lo, item.hi);
            bin.count += 1;
        }
    }
    bins
}

/// The plane with the least sum of area × leaves.
#[inline(always)]
fn best_plane<const BINS: usize>(bins: &Bins<BINS>, binning: &Binning, leaf_size: usize) -> Option<Plane> {
    let leaves = |count: u32| (count as usize).div_ceil(leaf_size) as f32;
    let mut best: Option<(f32, Plane)> = None;
    for axis in (0..3).filter(|&axis| binning.wide[axis]) {
        let bins = &bins[axis];
        let mut below = [Bin::EMPTY; BINS];
        for k in 1..BINS {
            below[k] = below[k - 1].union(&bins[k - 1]);
        }
        let mut above = Bin::EMPTY;
        for k in (1..BINS).rev() {
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

/// Moves what goes left to the front. Each item is put where the next left one belongs, and what was there is put in its
/// place, whichever side it goes to: a branch here would be wrong half of the time.
#[inline(always)]
fn cut(run: &mut [Item], part: &Part, binning: &Binning, plane: &Plane) -> (Part, Part) {
    /// Added to a centre, and subtracted from it, these leave it out of a hull or let it in.
    const OUT_IN: [f32; 2] = [f32::INFINITY, 0.0];
    let limit = INTEGER + plane.bin as f32;
    let (mut left, mut right) = (Hull::EMPTY, Hull::EMPTY);
    let mut count = 0;
    for at in 0..run.len() {
        let item = run[at];
        let centre = item.centre();
        let bin = binning.of_centre(centre).to_array()[plane.axis];
        let goes_left = usize::from(bin < limit);
        let (of_left, of_right) = (Vec4::splat(OUT_IN[goes_left]), Vec4::splat(OUT_IN[1 - goes_left]));
        left.add(centre + of_left, centre - of_left);
        right.add(centre + of_right, centre - of_right);
        run[at] = run[count];
        run[count] = item;
        count += goes_left;
    }
    let middle = part.items.start + count;
    (
        Part { items: part.items.start..middle, hull: plane.left, centres: left },
        Part { items: middle..part.items.end, hull: plane.right, centres: right },
    )
}

struct Split<'a, const BINS: usize> {
    run: &'a mut [Item],
    part: &'a Part,
    binning: &'a Binning,
    leaf_size: usize,
}

impl<const BINS: usize> Task for Split<'_, BINS> {
    type Output = Option<(Part, Part)>;

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, _: N, _: W) -> Option<(Part, Part)> {
        let plane = best_plane(&fill::<BINS>(self.run, self.binning), self.binning, self.leaf_size)?;
        Some(cut(self.run, self.part, self.binning, &plane))
    }
}

struct Fill<'a, const BINS: usize> {
    items: &'a [Item],
    binning: &'a Binning,
}

impl<const BINS: usize> Task for Fill<'_, BINS> {
    type Output = Bins<BINS>;

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, _: N, _: W) -> Bins<BINS> {
        fill(self.items, self.binning)
    }
}

struct Cut<'a> {
    run: &'a mut [Item],
    part: &'a Part,
    binning: &'a Binning,
    plane: &'a Plane,
}

impl Task for Cut<'_> {
    type Output = (Part, Part);

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, _: N, _: W) -> (Part, Part) {
        cut(self.run, self.part, self.binning, self.plane)
    }
}
