//! View factors as the product of what would be without anything in between and the share of it that gets through.
//!
//! A_i F_ij = G_ij · Σ_k w_k V_k / Σ_k w_k,   w = cos θ cos θ' / r² between the points k of both patches
//!
//! G by quadrature, closed form or contour, V_k = 1 where a ray gets through. The weights are those of the kernel, as what
//! hides the near parts of two patches takes away more than their share. Every pair that something may lie between gets as many
//! rays: to stop early where the first ones agree would favour what is nearly free or nearly hidden. Where a patch is curved, the
//! same points integrate the kernel as well.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::blockers::Blockers;
use super::fill::by_pairs;
use super::{Found, ViewFactors};
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::form::{self, Quadrature};
use crate::render::radiosity::patches::Patches;
use crate::sampling::stream::{stream, uniform};
use crate::scene::Scene;

/// Rays of a pair.
const RAYS: usize = 16;
/// Rays of a pair of which one patch is curved, and of each pair of parts of theirs.
const CURVED_RAYS: [usize; 2] = [32, 8];
/// Parts of curved patches closer than so many times the side of the larger are quartered, at most [`DEEPEST`] times in all.
const NEAR: f64 = 2.0;
/// Quarterings of either part of a pair.
const DEEPEST: u32 = 6;
/// Rays of a pair by which the error of the others is judged.
const JUDGES: usize = 1024;
/// Pairs that are judged.
const JUDGED: usize = 2000;
/// Rays of each pair of parts by which curved patches are judged, times those of the pair itself.
const MORE: usize = 8;
/// Generators of a lattice sequence in four dimensions: the first three and the sixth of Cools, Kuo & Nuyens 2006, SIAM J. Sci.
/// Comput. 28(6). Modulo 16 their fourth is the first again, and two coordinates would be one.
const GENERATOR: [u64; 4] = [1, 182_667, 469_891, 446_247];

/// Exchange without occlusion times kernel-weighted visibility.
#[derive(Clone, Copy, Debug)]
pub struct Visibility {
    /// Relative error of the exchange without occlusion.
    pub tolerance: f64,
    /// Seed of the random shifts of the rays' ends.
    pub seed: u64,
}

impl Default for Visibility {
    fn default() -> Self {
        Self { tolerance: form::TOLERANCE, seed: 1 }
    }
}

impl ViewFactors for Visibility {
    fn name(&self) -> &'static str {
        "visibility"
    }

    fn find(&self, scene: &Scene, patches: &Patches) -> Result<Found, RadiosityError> {
        let pairs = Pairs::new(scene, patches, self);
        let mut found = by_pairs(patches, |i, j| (pairs.exchange(i, j), 0.0));
        let error = pairs.judge();
        found.row_errors = vec![error; patches.all().len()];
        Ok(found)
    }
}

/// What all pairs share.
#[derive(Debug)]
struct Pairs<'a> {
    scene: &'a Scene,
    patches: &'a Patches,
    tolerance: f64,
    seed: u64,
    /// Nodes of plane patches.
    nodes: Vec<Option<Quadrature>>,
    /// Of each patch, where its rays start when it is the first of a pair, and end when it is the second.
    ends: Vec<[Vec<End>; 2]>,
    /// What can lie between patches.
    blockers: Blockers,
}

/// The end of a ray: a point just off a surface, and the normal there.
pub(in crate::render::radiosity) type End = (DVec3, DVec3);

fn lifted(scene: &Scene, (p, n): End) -> End {
    (scene.lifted(p, n), n)
}

impl<'a> Pairs<'a> {
    fn new(scene: &'a Scene, patches: &'a Patches, settings: &Visibility) -> Self {
        let all = patches.all();
        let nodes = all.iter().map(|patch| patch.form.polygon().map(Quadrature::of)).collect();
        let ends = (0..all.len()).map(|i| {
            let mut rng = stream(settings.seed, i as u64, 0);
            [0, 2].map(|axis| {
                let shift = DVec2::new(uniform(&mut rng), uniform(&mut rng));
                (0..RAYS).map(|k| lifted(scene, all[i].form.at(lattice(k, axis, shift)))).collect()
            })
        });
        Self {
            scene,
            patches,
            tolerance: settings.tolerance,
            seed: settings.seed,
            nodes,
            ends: ends.collect(),
            blockers: Blockers::new(patches.faces(), all.iter().map(|patch| &patch.form), patches.extent()),
        }
    }

    /// A_i F_ij.
    fn exchange(&self, i: usize, j: usize) -> f64 {
        match (&self.nodes[i], &self.nodes[j]) {
            (Some(_), Some(_)) if i == j => 0.0,
            (Some(a), Some(b)) => {
                let (exchange, _) = form::of_pair(a, b, self.tolerance);
                if exchange == 0.0 || self.blockers.leave_free(i, j) { exchange } else { exchange * self.visible(i, j) }
            }
            _ => self.curved(i, j, CURVED_RAYS, DEEPEST),
        }
    }

    /// The share of the exchange that gets through.
    fn visible(&self, i: usize, j: usize) -> f64 {
        self.weigh(self.ends[i][0].iter().copied().zip(self.ends[j][1].iter().copied())).share()
    }

    fn weigh(&self, ends: impl Iterator<Item = (End, End)>) -> Weights {
        let mut weights = Weights::default();
        for (from, to) in ends {
            let weight = kernel(from, to);
            if weight > 0.0 {
                weights.sum += weight;
                if self.scene.is_free(from.0, to.0) {
                    weights.through += weight;
                }
            }
        }
        weights
    }

    /// The exchange where a patch is curved, by points alone: where parts of patches are near each other for their size, of
    /// their quarters.
    fn curved(&self, i: usize, j: usize, rays: [usize; 2], depth: u32) -> f64 {
        let [a, b] = [i, j].map(|patch| Part { patch, from: DVec2::ZERO, size: 1.0, number: 1 });
        // A patch is as near to itself as can be, and all the same its kernel is bounded.
        self.parts(a, b, rays, if i == j { 0 } else { depth })
    }

    fn parts(&self, a: Part, b: Part, [rays, of_quarters]: [usize; 2], depth: u32) -> f64 {
        let form = |part: Part, u: DVec2| self.patches.all()[part.patch].form.at(part.from + part.size * u);
        let [area, other] = [a, b].map(|part| self.patches.all()[part.patch].area * part.size * part.size);
        let apart = form(a, DVec2::splat(0.5)).0.distance_squared(form(b, DVec2::splat(0.5)).0);
        if depth > 0 && apart < NEAR * NEAR * area.max(other) {
            // Of the larger one alone, so that parts become alike.
            let closer = |a, b| self.parts(a, b, [of_quarters; 2], depth - 1);
            return if area >= other {
                a.quarters().map(|a| closer(a, b)).iter().sum()
            } else {
                b.quarters().map(|b| closer(a, b)).iter().sum()
            };
        }
        let pair = (a.patch * self.patches.all().len() + b.patch) as u64;
        let mut rng = stream(self.seed, pair, a.number << 32 | b.number);
        let shift = [(); 2].map(|()| DVec2::new(uniform(&mut rng), uniform(&mut rng)));
        let end = |part: Part, k: usize, axis: usize| lifted(self.scene, form(part, lattice(k, axis, shift[axis / 2])));
        let weights = self.weigh((0..rays).map(|k| (end(a, k, 0), end(b, k, 2))));
        FRAC_1_PI * area * other * weights.through / rays as f64
    }

    /// The root mean square error of a factor, from a sample of pairs with many more rays.
    fn judge(&self) -> f64 {
        let n = self.patches.all().len();
        if self.blockers.is_empty() && self.nodes.iter().all(Option::is_some) {
            // Relative to a factor, of which a row has n that sum to 1 at most.
            return self.tolerance / n as f64;
        }
        let squares: Vec<f64> = (0..JUDGED as u64)
            .into_par_iter()
            .map(|k| {
                let mut rng = stream(self.seed, u64::MAX, k);
                let mut pick = || ((uniform(&mut rng) * n as f64) as usize).min(n - 1);
                let (i, j) = (pick(), pick());
                let shift = [(); 2].map(|()| DVec2::new(uniform(&mut rng), uniform(&mut rng)));
                (self.gap(i, j, shift) / self.patches.all()[i].area).powi(2)
            })
            .collect();
        (squares.iter().sum::<f64>() / JUDGED as f64).sqrt()
    }

    /// How far an exchange is from that by many more rays.
    fn gap(&self, i: usize, j: usize, shift: [DVec2; 2]) -> f64 {
        match (&self.nodes[i], &self.nodes[j]) {
            (Some(_), Some(_)) if i == j || self.blockers.leave_free(i, j) => 0.0,
            (Some(a), Some(b)) => {
                let (exchange, _) = form::of_pair(a, b, self.tolerance);
                if exchange == 0.0 {
                    return 0.0;
                }
                let end = |patch: usize, k: usize, axis: usize| {
                    lifted(self.scene, self.patches.all()[patch].form.at(lattice(k, axis, shift[axis / 2])))
                };
                let many = self.weigh((0..JUDGES).map(|k| (end(i, k, 0), end(j, k, 2))));
                exchange * (self.visible(i, j) - many.share())
            }
            _ => self.exchange(i, j) - self.curved(i, j, [JUDGES, MORE * CURVED_RAYS[1]], DEEPEST + 2),
        }
    }
}

/// A square of the unit square, and so a part of a patch.
#[derive(Clone, Copy, Debug)]
struct Part {
    patch: usize,
    from: DVec2,
    size: f64,
    /// 1 for the whole, 4 n to 4 n + 3 for the quarters of part n.
    number: u64,
}

impl Part {
    fn quarters(self) -> [Self; 4] {
        let half = 0.5 * self.size;
        let corners = [(0, DVec2::ZERO), (1, DVec2::X), (2, DVec2::Y), (3, DVec2::ONE)];
        corners.map(|(k, at)| Self { from: self.from + half * at, size: half, number: 4 * self.number + k, ..self })
    }
}

/// Weights of all rays, and of those that get through.
#[derive(Clone, Copy, Debug, Default)]
struct Weights {
    through: f64,
    sum: f64,
}

impl Weights {
    fn share(self) -> f64 {
        // No weight at all: the points see nothing of each other, so neither do the patches, but for slivers.
        if self.sum > 0.0 { self.through / self.sum } else { 0.0 }
    }
}

/// Two coordinates, from `axis` on, of point `k` of a lattice sequence with a shift.
pub(in crate::render::radiosity) fn lattice(k: usize, axis: usize, shift: DVec2) -> DVec2 {
    // k mirrored at the point: any first 2^m of them are a lattice.
    let at = (k as u64).reverse_bits();
    let coordinate = |axis: usize| at.wrapping_mul(GENERATOR[axis]) as f64 * (1.0 / 18_446_744_073_709_551_616.0);
    let shifted = DVec2::new(coordinate(axis), coordinate(axis + 1)) + shift;
    shifted - shifted.floor()
}

/// cos θ cos θ' / r² = (n·d) (−n'·d) / r⁴ for the way d of length r; 0 where one looks away from the other.
#[inline]
pub(in crate::render::radiosity) fn kernel((p, n): End, (q, m): End) -> f64 {
    let way = q - p;
    let r2 = way.length_squared();
    let (out, back) = (way.dot(n), -way.dot(m));
    if out > 0.0 && back > 0.0 { out * back / (r2 * r2) } else { 0.0 }
}
