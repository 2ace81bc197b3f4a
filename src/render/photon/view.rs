//! The map itself: the density of photons at the first surface that keeps them.

use super::map::PhotonMap;
use super::shoot::{next_surface, stores};
use super::stated::{OfMap, Stated};
use crate::bsdf::{Density, Lobes};
use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::render::path::Roulette;
use crate::render::path::vertex::Vertex;
use crate::sampling::sampler::Sampler;
use crate::scene::{Ray, Scene};

/// What ends paths between mirrors.
const ROULETTE: Roulette = Roulette::From(5);

/// Emission, and the light of the map where the path first meets a surface without a Dirac lobe; past those it is traced.
#[derive(Debug)]
pub struct DirectView {
    map: PhotonMap,
    bounces: Option<u32>,
}

impl DirectView {
    /// Of this map, with at most so many reflections in all.
    pub fn new(map: PhotonMap, bounces: Option<u32>) -> Self {
        Self { map, bounces }
    }

    /// The map.
    pub fn map(&self) -> &PhotonMap {
        &self.map
    }
}

impl Radiance for DirectView {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        self.stated(scene, ray, sampler).value
    }
}

impl OfMap for DirectView {
    fn stated(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Stated {
        let limit = self.bounces.unwrap_or(u32::MAX);
        through_mirrors(scene, ray, limit, sampler, |vertex, depth, _| {
            self.map.reflected(scene, vertex, limit - depth - 1).into()
        })
    }
}

/// Emission along the ray and past Dirac lobes, and what `shade` says of each surface on the way that has other lobes. `shade`
/// is told how often the path was scattered before, which is less than `limit`.
pub(super) fn through_mirrors(
    scene: &Scene,
    mut ray: Ray,
    limit: u32,
    sampler: &mut dyn Sampler,
    mut shade: impl FnMut(&Vertex, u32, &mut dyn Sampler) -> Stated,
) -> Stated {
    let (mut sum, mut throughput, mut depth) = (Stated::default(), Rgb::WHITE, 0);
    loop {
        let Some(surface) = next_surface(scene, &mut ray, sampler) else {
            sum.value += throughput * scene.emitters().escaped(ray.dir).map(|(radiance, _)| radiance).sum::<Rgb>();
            return sum;
        };
        if let Some((_, radiance)) = scene.emitters().emitted(&surface, -ray.dir) {
            sum.value += throughput * radiance;
        }
        if depth >= limit {
            return sum;
        }
        let vertex = Vertex::new(scene, &ray, &surface);
        if stores(&vertex) {
            sum += shade(&vertex, depth, sampler) * throughput;
        }
        depth += 1;
        let Some((next, weight)) = mirrored(scene, &vertex, depth, throughput, sampler) else { return sum };
        (ray, throughput) = (next, weight);
    }
}

/// The ray that a Dirac lobe sends on, and the throughput after roulette; None where the draw is not of one, or ends.
pub(super) fn mirrored(
    scene: &Scene,
    vertex: &Vertex,
    depth: u32,
    throughput: Rgb,
    sampler: &mut dyn Sampler,
) -> Option<(Ray, Rgb)> {
    if !vertex.bsdf.lobes().contains(Lobes::DIRAC) {
        return None;
    }
    let (u, luck) = (sampler.next_uniforms(), sampler.next_1d());
    let drawn = vertex.sample(u).filter(|drawn| matches!(drawn.density, Density::Dirac(_)))?;
    let after = throughput * drawn.weight;
    let survival = ROULETTE.survival(depth, drawn.weight, after);
    (luck < survival && !after.is_black()).then(|| (scene.leave(vertex.surface, drawn.wi), after / survival))
}
