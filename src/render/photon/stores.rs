//! How to store a photon map for a fast search of the k nearest: what a scan, a sorted hash grid and a k-d tree of the same
//! photons take for the same queries.
//!
//! A scan looks at all n photons. A tree goes down to where the query is and looks around, n or not. A grid cannot know how far away
//! the k-th is: it is asked for all within a radius that holds k at every other query, and again within twice the area for as
//! long as there are fewer; so all three give the same answer.
//!
//! What is found is the same every time, seconds are not.

use std::hint::black_box;
use std::time::Instant;

use glam::DVec3;

use super::grid::Grid;
use super::nearest::{Nearest, scan};
use super::shoot::{BATCH, Shooting};
use super::tree::Tree;
use super::{Kept, PhotonError};
use crate::math::power_law;
use crate::scene::Scene;

/// A way to keep photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Store {
    /// As they come: [`scan`].
    Scan,
    /// [`Grid`].
    Grid,
    /// [`Tree`].
    Tree,
}

impl Store {
    /// Each of them.
    pub const ALL: [Self; 3] = [Self::Scan, Self::Grid, Self::Tree];

    /// The name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scan => "scan",
            Self::Grid => "hash grid",
            Self::Tree => "k-d tree",
        }
    }
}

/// Photons that are sent out at once.
const SENT: u64 = 64 * BATCH;
/// The most queries.
const QUERIES: usize = 1 << 14;
/// Photons that the queries find, all together: what is around all of them does not fit into a core's own memory.
const FOUND: usize = 1 << 20;
/// Photons that a scan looks at in one go: it takes the same time wherever it is asked, so that few of the queries do.
const SCANNED: usize = 100_000_000;
/// Queries that tell how far away the k-th is.
const PROBES: usize = 256;
/// Times that everything is measured, if a second allows.
const RUNS: u32 = 5;

/// Photons of a scene, and the places where their neighbours are asked for.
#[derive(Clone, Debug)]
pub struct Trial {
    queries: Vec<DVec3>,
    photons: Vec<DVec3>,
    k: usize,
}

impl Trial {
    /// `most` photons of the scene, of which the first n are a smaller map, and queries for the `k` nearest, >= 1, at points of the
    /// surfaces where other photons of the same light have arrived.
    ///
    /// # Errors
    /// As [`Shooting::shoot`], and where no photon is stored.
    pub fn new(scene: &Scene, most: usize, k: usize, seed: u64) -> Result<Self, PhotonError> {
        let asked = QUERIES.min(FOUND / k.max(1)).max(PROBES);
        let mut queries = Vec::new();
        for pass in 0.. {
            let shot = Shooting { photons: SENT, seed, pass, ..Shooting::default() }.shoot(scene)?;
            if shot.photons.is_empty() {
                return Err(PhotonError::NothingReached { emitted: SENT, map: Kept::Global.name() });
            }
            queries.extend(shot.photons.iter().map(|photon| photon.p));
            if queries.len() >= asked + most {
                break;
            }
        }
        let mut photons = queries.split_off(asked);
        photons.truncate(most);
        Ok(Self { queries, photons, k })
    }

    /// Where neighbours are asked for.
    pub fn queries(&self) -> &[DVec3] {
        &self.queries
    }

    /// The first n photons, or all if there are fewer, in every store.
    pub fn stores(&self, n: usize) -> Stores<'_> {
        let photons = &self.photons[..n.min(self.photons.len())];
        let (tree, mut nearest) = (Tree::new(photons), Nearest::default());
        let mut kth2: Vec<f32> = self.queries[..PROBES]
            .iter()
            .map(|&q| {
                nearest.begin(self.k, f32::INFINITY);
                tree.nearest(q, &mut nearest, |_| true);
                nearest.finish().last().map_or(0.0, |kth| kth.distance2())
            })
            .collect();
        kth2.sort_unstable_by(f32::total_cmp);
        // That of photons that all coincide would be 0.
        let radius = f64::from(kth2[PROBES / 2]).sqrt().max(f64::MIN_POSITIVE);
        Stores { photons, k: self.k, radius, grid: Grid::new(photons, radius), tree }
    }

    /// What n photons take: of several runs the one that was disturbed least. Stores are built by all threads and asked by one.
    pub fn measure(&self, n: usize) -> Timing {
        let stores = self.stores(n);
        let Stores { photons, radius, .. } = stores;
        let cost = |store: Store| {
            let queries = match store {
                Store::Scan => &self.queries[..(SCANNED / photons.len().max(1)).clamp(1, self.queries.len())],
                Store::Grid | Store::Tree => &self.queries,
            };
            let mut nearest = Nearest::default();
            let all = seconds(|| {
                for &q in queries {
                    stores.find(store, q, &mut nearest);
                    black_box(nearest.finish().len());
                }
            });
            let build = match store {
                Store::Scan => 0.0,
                Store::Grid => seconds(|| drop(black_box(Grid::new(photons, radius)))),
                Store::Tree => seconds(|| drop(black_box(Tree::new(photons)))),
            };
            Cost { build, query: all / queries.len() as f64 }
        };
        Timing { photons: photons.len(), costs: Store::ALL.map(cost) }
    }
}

/// The same photons in each of the stores.
#[derive(Debug)]
pub struct Stores<'a> {
    photons: &'a [DVec3],
    k: usize,
    radius: f64,
    grid: Grid,
    tree: Tree,
}

impl Stores<'_> {
    /// The photons as they came.
    pub fn photons(&self) -> &[DVec3] {
        self.photons
    }

    /// The radius for which the grid is made: the median of the distance of the k-th. A mean would be that of the dimmest corners.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Leaves the k nearest to `q` in `nearest`, with numbers in the order of the store; all photons if they are fewer.
    pub fn find(&self, store: Store, q: DVec3, nearest: &mut Nearest) {
        nearest.begin(self.k, f32::INFINITY);
        match store {
            Store::Scan => scan(self.photons, q, nearest, |_| true),
            Store::Grid => self.find_in_grid(q, nearest),
            Store::Tree => self.tree.nearest(q, nearest, |_| true),
        }
    }

    fn find_in_grid(&self, q: DVec3, nearest: &mut Nearest) {
        // The cells that a ball of the radius times √area may meet.
        let cells = |area: f64| (area.sqrt() + 2.0).powi(3);
        let mut area = 1.0_f64;
        while cells(area) <= self.photons.len() as f64 {
            self.grid.within(q, self.radius * area.sqrt(), |found| {
                if found.distance2() < nearest.limit() {
                    nearest.push(found);
                }
            });
            if nearest.finish().len() >= self.k {
                return;
            }
            nearest.begin(self.k, f32::INFINITY);
            area *= 2.0;
        }
        // Fewer photons than cells.
        scan(self.grid.points(), q, nearest, |_| true);
    }
}

/// What so many photons take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// How many.
    pub photons: usize,
    /// Of each store, in the order of [`Store::ALL`].
    pub costs: [Cost; 3],
}

/// What a store takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Seconds to build it, on all threads; 0 for a scan.
    pub build: f64,
    /// Seconds to find the k nearest of one query, on one thread.
    pub query: f64,
}

/// p of seconds per query ∝ nᵖ for each store, and its standard error. None for fewer than three numbers of photons.
pub fn exponents(timings: &[Timing]) -> [Option<[f64; 2]>; 3] {
    [0, 1, 2].map(|store| {
        let points: Vec<_> = timings.iter().map(|of| (of.photons as f64, of.costs[store].query)).collect();
        power_law::exponent(&points)
    })
}

/// The least that one of several runs takes.
fn seconds(mut run: impl FnMut()) -> f64 {
    let (start, mut least) = (Instant::now(), f64::INFINITY);
    for _ in 0..RUNS {
        let begun = Instant::now();
        run();
        least = least.min(begun.elapsed().as_secs_f64());
        if start.elapsed().as_secs() >= 1 {
            break;
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    fn trial(most: usize, k: usize) -> Trial {
        let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap();
        Trial::new(&scene, most, k, 1).unwrap()
    }

    /// The largest gap between the distances of the k-th that a search and a scan find, as a share of the extent; infinite where one
    /// finds fewer.
    fn gap(trial: &Trial, stores: &Stores<'_>, find: impl Fn(DVec3, &mut Nearest)) -> f64 {
        let (mut found, mut scanned) = (Nearest::default(), Nearest::default());
        let gaps = trial.queries[..PROBES].iter().map(|&q| {
            find(q, &mut found);
            stores.find(Store::Scan, q, &mut scanned);
            let (found, scanned) = (found.finish(), scanned.finish());
            match (found.last(), scanned.last()) {
                (Some(a), Some(b)) if found.len() == scanned.len() => {
                    let extent = stores.photons.iter().map(|p| p.distance(q)).fold(0.0, f64::max);
                    f64::from((a.distance2().sqrt() - b.distance2().sqrt()).abs()) / extent
                }
                _ => f64::INFINITY,
            }
        });
        gaps.fold(0.0, f64::max)
    }

    /// Single precision: roundings of places to 2⁻²⁴ of half an extent, of both ends in three axes, and of the root.
    const TOL: f64 = 2e-7;

    #[test]
    fn every_store_finds_the_same_kth() {
        for (n, k) in [(50, 100), (1000, 1), (1000, 1000), (10_000, 100)] {
            let trial = trial(n, k);
            let stores = trial.stores(n);
            for store in Store::ALL {
                let gap = gap(&trial, &stores, |q, nearest| stores.find(store, q, nearest));
                assert!(gap <= TOL, "{} of {n} photons, k = {k}: {gap}", store.name());
            }
        }
    }

    #[test]
    fn stores_that_do_not_look_far_enough_are_found_out() {
        let trial = trial(10_000, 100);
        let stores = trial.stores(10_000);
        let (cell, points) = (2.0 * stores.radius, stores.grid.points());
        let within = |q: DVec3, radius: f64, nearest: &mut Nearest, keep: &dyn Fn(DVec3) -> bool| {
            nearest.begin(stores.k, f32::INFINITY);
            stores.grid.within(q, radius, |found| {
                if found.distance2() < nearest.limit() && keep(points[found.number() as usize]) {
                    nearest.push(found);
                }
            });
        };
        // The twins: the query's own cell alone, far enough to see all of it; and the grid's radius, once.
        let own = gap(&trial, &stores, |q, nearest| {
            within(q, 2.0 * cell, nearest, &|p| (p / cell).floor() == (q / cell).floor());
        });
        let once = gap(&trial, &stores, |q, nearest| within(q, stores.radius, nearest, &|_| true));
        assert!(own > TOL && once > TOL, "the comparison has lost its power: {own} {once}");
    }

    #[test]
    fn a_smaller_map_is_the_beginning_of_a_larger_one() {
        let (small, large) = (trial(1000, 10), trial(300_000, 10));
        assert_eq!(small.queries, large.queries);
        assert_eq!(small.photons, large.photons[..1000]);
        assert_eq!(large.photons.len(), 300_000, "more than are sent out at once");
        assert!(small.photons.iter().all(|p| !small.queries.contains(p)));
    }

    #[test]
    fn a_scan_takes_longest() {
        let trial = trial(100_000, 10);
        let Timing { photons, costs: [scan, grid, tree] } = trial.measure(100_000);
        // Some hundredfold in truth.
        assert!(scan.query > 3.0 * grid.query && scan.query > 3.0 * tree.query, "{scan:?} {grid:?} {tree:?}");
        assert!(photons == 100_000 && scan.build == 0.0 && grid.build > 0.0 && tree.build > 0.0);
    }
}
