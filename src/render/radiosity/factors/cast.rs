//! View factors by rays: where a patch's light arrives, counted.

use glam::DVec2;

use super::fill::by_rows;
use super::{Found, ViewFactors};
use crate::math::frame::Frame;
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::patches::Patches;
use crate::sampling::points::Sobol;
use crate::sampling::sampler::Sampler;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::Scene;

/// Rays by the cosine from points spread over a patch. The sum of a row is exactly the share that reaches any patch.
#[derive(Clone, Copy, Debug)]
pub struct MonteCarlo {
    /// Rays from each patch, at least 1.
    pub rays: u64,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for MonteCarlo {
    fn default() -> Self {
        Self { rays: 4096, seed: 1 }
    }
}

impl ViewFactors for MonteCarlo {
    fn name(&self) -> &'static str {
        "monte-carlo"
    }

    fn find(&self, scene: &Scene, patches: &Patches) -> Result<Found, RadiosityError> {
        let rays = self.rays.max(1);
        Ok(by_rows(patches, |i, row| {
            let mut arrived = |j: usize| row[j] += 1.0;
            for_each_ray(scene, patches, i, rays, self.seed, |met| {
                met.map(&mut arrived);
            });
            let mut squares = 0.0;
            for factor in row.iter_mut() {
                *factor /= rays as f64;
                // Independent rays' variance; those of a net vary less. A factor that no ray found may still be 1 / N.
                let spread = if *factor > 0.0 { *factor * (1.0 - *factor) / rays as f64 } else { 0.0 };
                squares += spread;
            }
            (squares / row.len() as f64).sqrt()
        }))
    }
}

/// What each of the rays that patch `i` sends out meets.
pub(super) fn for_each_ray(
    scene: &Scene,
    patches: &Patches,
    i: usize,
    rays: u64,
    seed: u64,
    mut meets: impl FnMut(Option<usize>),
) {
    let form = &patches.all()[i].form;
    let mut net = Sobol::new(seed);
    for k in 0..rays {
        net.begin(i as u64, k);
        let (place, turn): (DVec2, DVec2) = (net.next_2d(), net.next_2d());
        let (p, n) = form.at(place);
        let ray = scene.ray_off(p, n, Frame::about(n).to_world(cosine_hemisphere(turn)));
        meets(scene.intersect(&ray).and_then(|surface| patches.at(&surface, -ray.dir)));
    }
}

/// The share of the light of each patch that reaches no patch, by `rays` rays each.
pub(super) fn escape(scene: &Scene, patches: &Patches, rays: u64, seed: u64) -> Vec<f64> {
    use rayon::prelude::*;
    let share = |i: usize| {
        let mut lost = 0_u64;
        for_each_ray(scene, patches, i, rays, seed, |met| lost += u64::from(met.is_none()));
        lost as f64 / rays as f64
    };
    (0..patches.all().len()).into_par_iter().map(share).collect()
}
