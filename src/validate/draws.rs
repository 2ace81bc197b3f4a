//! Draws from a model's sampler, tallied for every statistical check at once.
//!
//! The draws from one direction are cut into [`REPLICATES`] blocks, each with its own random stream, so that the tally
//! is the same for any number of threads.

use glam::DVec3;
use rayon::prelude::*;

use super::claim::{Claim, Place, legendre};
use crate::bsdf::{Bsdf, Density};
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::sampling::stream::{stream, uniforms};

/// Independent blocks of draws, and replicates of the convergence test.
pub(crate) const REPLICATES: usize = 64;
/// Samples in the shortest replicate; each next one is twice as long.
pub(crate) const SHORTEST: usize = 64;
/// Legendre moments of each probability integral transform.
pub(crate) const MOMENTS: usize = 8;

/// Disagreement between what a sample says of itself and what eval and pdf say: the largest, and where.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Worst {
    pub(crate) size: f64,
    pub(crate) wi: Option<DVec3>,
}

impl Worst {
    fn see(&mut self, size: f64, wi: DVec3) {
        // NaN counts as the worst there is.
        let size = if size.is_nan() { f64::INFINITY } else { size };
        if size > self.size {
            *self = Self { size, wi: Some(wi) };
        }
    }

    fn merge(&mut self, other: Self) {
        if let Some(wi) = other.wi {
            self.see(other.size, wi);
        }
    }
}

/// What was drawn from one direction in one hemisphere.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartTally {
    /// Draws that fell here.
    pub(crate) n: u64,
    /// Σ √(2j+1) Pⱼ(2u − 1) for j = 1 … MOMENTS, of both transforms.
    pub(crate) moments: [[f64; MOMENTS]; 2],
}

/// What was drawn from one direction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    /// Draws in all.
    pub(crate) n: u64,
    /// Draws that returned None.
    pub(crate) lost: u64,
    /// Draws where nothing of their kind is claimed: on a side that the model does not light, in no Dirac lobe, or of no
    /// unit length.
    pub(crate) stray: u64,
    /// One of these strays.
    pub(crate) stray_at: Option<DVec3>,
    /// Draws in each fine cell of the claim.
    pub(crate) fine: Vec<u64>,
    /// Of each hemisphere in which the pdf claims anything.
    pub(crate) parts: Vec<PartTally>,
    /// The mean channel of the weights, lost draws counting as 0.
    pub(crate) weights: Moments,
    /// Excess kurtosis of the weights of each block.
    pub(crate) kurtoses: Vec<f64>,
    /// Mean weight of each replicate: \[block\]\[length\].
    pub(crate) means: Vec<Vec<f64>>,
    /// |weight · pdf − f cos| relative to f cos; of a Dirac lobe, the weight against that of its other draws.
    pub(crate) weight_gap: Worst,
    /// |density − pdf(wo, wi)| relative to the pdf; of a Dirac lobe, its probability against that of its other draws.
    pub(crate) density_gap: Worst,
}

impl Tally {
    /// Draws `per_block` samples in each of [`REPLICATES`] blocks; `unit` separates the streams of different directions.
    pub(crate) fn draw(bsdf: &dyn Bsdf, claim: &Claim, seed: u64, unit: u64, per_block: usize) -> Self {
        let blocks: Vec<Self> = (0..REPLICATES)
            .into_par_iter()
            .map(|block| Self::block(bsdf, claim, seed, unit, block, per_block))
            .collect();
        let mut total = Self::empty(claim);
        for block in blocks {
            total.merge(block);
        }
        total
    }

    fn empty(claim: &Claim) -> Self {
        let parts = vec![PartTally::default(); claim.parts()];
        Self { fine: vec![0; claim.fine.len()], parts, ..Self::default() }
    }

    fn block(bsdf: &dyn Bsdf, claim: &Claim, seed: u64, unit: u64, block: usize, draws: usize) -> Self {
        let mut rng = stream(seed, unit, block as u64);
        let mut tally = Self { n: draws as u64, ..Self::empty(claim) };
        let mut means = Vec::new();
        let (mut length, mut left, mut sum) = (SHORTEST, SHORTEST, 0.0);
        for _ in 0..draws {
            let weight = tally.one(bsdf, claim, &mut rng);
            tally.weights.add(weight);
            sum += weight;
            left -= 1;
            if left == 0 {
                means.push(sum / length as f64);
                length *= 2;
                (left, sum) = (length, 0.0);
            }
        }
        tally.kurtoses.push(tally.weights.excess_kurtosis());
        tally.means.push(means);
        tally
    }

    /// One draw; returns the mean channel of its weight.
    fn one(&mut self, bsdf: &dyn Bsdf, claim: &Claim, rng: &mut crate::sampling::stream::Stream) -> f64 {
        let Some(sample) = bsdf.sample(claim.wo, uniforms(rng)) else {
            self.lost += 1;
            return 0.0;
        };
        let wi = sample.wi;
        let unit_length = (wi.length_squared() - 1.0).abs() <= 1e-6;
        let place = if unit_length { claim.place(wi, sample.density) } else { None };
        match (place, sample.density) {
            (Some(Place::Dirac(cell, lobe)), Density::Dirac(probability)) => {
                self.fine[cell] += 1;
                // What one draw says must hold of all draws of the lobe.
                self.density_gap.see((probability - lobe.probability).abs() / lobe.probability, wi);
                self.see_weight(sample.weight, lobe.weight, wi);
            }
            (Some(Place::Smooth(cell, part, transforms)), Density::SolidAngle(density)) => {
                self.fine[cell] += 1;
                let tally = &mut self.parts[part];
                tally.n += 1;
                for (sums, u) in tally.moments.iter_mut().zip(transforms) {
                    let p = legendre::<{ MOMENTS + 1 }>(2.0 * u - 1.0);
                    for (j, sum) in sums.iter_mut().enumerate() {
                        *sum += ((2 * j + 3) as f64).sqrt() * p[j + 1];
                    }
                }
                let (pdf, f) = (bsdf.pdf(claim.wo, wi), bsdf.eval(claim.wo, wi));
                self.density_gap.see((density - pdf).abs() / pdf, wi);
                self.see_weight(sample.weight * density, f * wi.z.abs(), wi);
            }
            _ => {
                self.stray += 1;
                self.stray_at = Some(wi);
            }
        }
        sample.weight.mean()
    }

    fn see_weight(&mut self, claimed: Rgb, truth: Rgb, wi: DVec3) {
        // Relative to the largest channel: a channel that is 0 in one and not in the other is a gap of its full size.
        let scale = truth.max_channel().max(claimed.max_channel());
        if scale > 0.0 || !scale.is_finite() || !truth.is_finite() {
            self.weight_gap.see((claimed - truth).0.abs().max_element() / scale, wi);
        }
    }

    fn merge(&mut self, other: Self) {
        self.n += other.n;
        self.lost += other.lost;
        self.stray += other.stray;
        self.stray_at = self.stray_at.or(other.stray_at);
        for (a, b) in self.fine.iter_mut().zip(other.fine) {
            *a += b;
        }
        for (part, other) in self.parts.iter_mut().zip(other.parts) {
            part.n += other.n;
            for (a, b) in part.moments.iter_mut().flatten().zip(other.moments.iter().flatten()) {
                *a += b;
            }
        }
        self.weights = self.weights.merge(&other.weights);
        self.kurtoses.extend(other.kurtoses);
        self.means.extend(other.means);
        self.weight_gap.merge(other.weight_gap);
        self.density_gap.merge(other.density_gap);
    }

    /// Draws that landed in a cell.
    pub(crate) fn kept(&self) -> u64 {
        self.n - self.lost - self.stray
    }
}
