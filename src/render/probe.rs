//! The mean of an estimator of radiance over a family of rays, with everything that is known of its spread.

use std::ops::Range;

use rayon::prelude::*;

use super::{Radiance, Sample, WAVE};
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{Ray, Scene};

/// Samples of a block: the unit of work, and of what is known of the growth of a variance.
pub const BLOCK: u64 = 1024;

/// Estimates means over families of rays. Sample `i` depends on the seed, the number and `i` alone, so that the result is
/// the same on any number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Seed of every random number.
    pub seed: u64,
    /// Tells one estimate from another under the same seed.
    pub number: u64,
    /// How many samples are taken, rounded up to whole blocks.
    pub samples: u64,
}

impl Probe {
    /// Mean and moments per channel of the radiance along rays that `ray` draws.
    pub fn estimate(
        &self,
        tracer: &dyn Radiance,
        scene: &Scene,
        ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
    ) -> [Moments; 3] {
        merged(&self.blocks(tracer, scene, ray))
    }

    /// The same block by block, in the order of the samples.
    pub fn blocks(
        &self,
        tracer: &dyn Radiance,
        scene: &Scene,
        ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
    ) -> Vec<[Moments; 3]> {
        let block = |block: u64| self.range(tracer, scene, ray, block * BLOCK..(block + 1) * BLOCK);
        (0..self.samples.div_ceil(BLOCK)).into_par_iter().map(block).collect()
    }

    /// Mean and moments per channel of the samples of these numbers, on one thread.
    pub fn range(
        &self,
        tracer: &dyn Radiance,
        scene: &Scene,
        ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
        samples: Range<u64>,
    ) -> [Moments; 3] {
        let mut moments = [Moments::default(); 3];
        for radiance in self.values(tracer, scene, ray, samples) {
            for (moments, value) in moments.iter_mut().zip(radiance.to_array()) {
                moments.add(value);
            }
        }
        moments
    }

    /// The samples of these numbers, one by one.
    pub fn values(
        &self,
        tracer: &dyn Radiance,
        scene: &Scene,
        ray: &(dyn Fn(&mut dyn Sampler) -> Ray + Sync),
        samples: Range<u64>,
    ) -> impl Iterator<Item = Rgb> {
        let ask = move |number: u64| {
            let mut sampler = Independent::at(self.seed, self.number, number);
            Sample::new(ray(&mut sampler), sampler)
        };
        samples.clone().step_by(WAVE).flat_map(move |first| {
            let mut wave: Vec<_> = (first..samples.end.min(first + WAVE as u64)).map(ask).collect();
            tracer.radiances(scene, wave.as_mut_slice().into());
            wave.into_iter().map(|sample| sample.radiance)
        })
    }
}

/// The moments of all blocks together, merged in their order.
pub fn merged(blocks: &[[Moments; 3]]) -> [Moments; 3] {
    let together = |all: [Moments; 3], next: &[Moments; 3]| std::array::from_fn(|c| all[c].merge(&next[c]));
    blocks.iter().fold([Moments::default(); 3], together)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;
    use glam::DVec3;

    /// One random number.
    #[derive(Debug)]
    struct Dice;

    impl Radiance for Dice {
        fn radiance(&self, _: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
            Rgb::new(sampler.next_1d(), ray.origin.x, 1.0)
        }
    }

    #[test]
    fn the_same_bits_on_any_number_of_threads() {
        let scene = Scene::new(builtin("furnace-box", &[]).unwrap().unwrap()).unwrap();
        let probe = Probe { seed: 3, number: 7, samples: 5 * BLOCK - 1 };
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| probe.estimate(&Dice, &scene, &|sampler| Ray::new(DVec3::X * sampler.next_1d(), DVec3::Z)))
        };
        let (one, three) = (run(1), run(3));
        assert_eq!(one, three);
        assert_eq!(one[0].count(), 5 * BLOCK);
        // Uniform numbers have mean 1/2 and standard deviation 1/√12.
        assert!(one.iter().take(2).all(|m| (m.mean() - 0.5).abs() < 4.0 * m.std_err()), "1 in 8000 seeds");
        assert!((one[0].variance() * 12.0 - 1.0).abs() < 0.05 && one[2].variance() == 0.0);
        assert_ne!(probe.estimate(&Dice, &scene, &|_| Ray::new(DVec3::X, DVec3::Z))[0], one[0]);
    }
}
