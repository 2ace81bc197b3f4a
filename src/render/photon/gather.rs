//! Final gather: the light at a surface by rays, and the map only where those end.
//!
//! What reaches a surface that is seen, Dirac lobes apart, is cut into three parts that share nothing:
//! - straight from a light: a connection and the gather rays, weighted as the path tracer does;
//! - from a light past Dirac lobes alone: the caustic map at the surface itself;
//! - the rest: M gather rays, past Dirac lobes, to the next surface that keeps photons, and the global map there.
//!
//! A ray that ends nearer than the radius of the map's own disk there, in a corner, does another gather instead.
//! # References
//! - Jensen 2001, Realistic image synthesis using photon mapping, §9 (rendering, with distributed rays and caustics by the map)

use super::map::{Around, Gather, PhotonMap};
use super::shoot::{next_surface, stores};
use super::stated::{OfMap, Stated};
use super::view::{mirrored, through_mirrors};
use super::{History, Photon, PhotonError};
use crate::bsdf::{Density, Uniforms};
use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::render::path::Heuristic;
use crate::render::path::vertex::Vertex;
use crate::sampling::sampler::Sampler;
use crate::scene::{LightSampling, Ray, Scene, Sought};
use glam::DVec2;

/// How often a gather may lead to another in a corner.
const NESTED: u32 = 6;
/// Steps of a lattice in three dimensions: powers of the inverse of the root of x⁴ = x + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

/// The photon map as light that is seen.
#[derive(Debug)]
pub struct FinalGather {
    global: PhotonMap,
    caustic: Option<PhotonMap>,
    rays: u32,
    bounces: Option<u32>,
}

impl FinalGather {
    /// Of photons of all kinds, with `rays` of each surface that is seen and at most so many reflections in all. Where there
    /// are fewer caustic photons than the k nearest, all of them count.
    ///
    /// # Errors
    /// As [`PhotonMap::new`], and without rays.
    pub fn new(
        scene: &Scene,
        photons: &[Photon],
        gather: Gather,
        rays: u32,
        bounces: Option<u32>,
    ) -> Result<Self, PhotonError> {
        if rays == 0 {
            return Err(PhotonError::NoRays);
        }
        let caustic: Vec<Photon> =
            photons.iter().filter(|photon| photon.history == History::Caustic).copied().collect();
        let global = PhotonMap::new(scene, photons, gather)?;
        let around = match gather.around {
            Around::Nearest { k, reach } => Around::Nearest { k: k.min(caustic.len()), reach },
            fixed @ Around::Radius(_) => fixed,
        };
        let enough = caustic.len() >= gather.estimator.least();
        let caustic = enough.then(|| PhotonMap::new(scene, &caustic, Gather { around, ..gather })).transpose()?;
        Ok(Self { global, caustic, rays, bounces })
    }

    /// The map of all photons.
    pub fn map(&self) -> &PhotonMap {
        &self.global
    }

    fn limit(&self) -> u32 {
        self.bounces.unwrap_or(u32::MAX)
    }

    /// What `vertex` reflects by lobes that are no Dirac ones, after `depth` reflections on the way to it.
    fn reflected(
        &self,
        scene: &Scene,
        vertex: &Vertex,
        depth: u32,
        (rays, nested): (u32, u32),
        sampler: &mut dyn Sampler,
    ) -> Stated {
        let mut sum = Stated::from(connected(scene, vertex, Some(rays), self.limit() - depth - 1, sampler));
        if let Some(caustic) = &self.caustic {
            sum += caustic.reflected(scene, vertex, self.limit() - depth - 1).into();
        }
        let (lobe, dir) = (sampler.next_1d(), sampler.next_2d());
        let share = 1.0 / f64::from(rays);
        for ray in 0..rays {
            let at = |from: f64, step: f64| (from + f64::from(ray) * step).fract();
            let u = Uniforms { lobe: at(lobe, STEPS[2]), dir: DVec2::new(at(dir.x, STEPS[0]), at(dir.y, STEPS[1])) };
            let Some(drawn) = vertex.sample(u) else { continue };
            let Density::SolidAngle(pdf) = drawn.density else { continue };
            let ray = scene.leave(vertex.surface, drawn.wi);
            let incoming = self.incoming(scene, vertex, ray, pdf * f64::from(rays), (depth + 1, nested), sampler);
            sum += incoming * (drawn.weight * share);
        }
        sum
    }

    /// What arrives at `vertex` along a ray of this density, counting all rays, but for caustics.
    fn incoming(
        &self,
        scene: &Scene,
        vertex: &Vertex,
        mut ray: Ray,
        pdf: f64,
        (mut depth, nested): (u32, u32),
        sampler: &mut dyn Sampler,
    ) -> Stated {
        let (mut sum, mut throughput, mut straight) = (Stated::default(), Rgb::WHITE, true);
        let (emitters, p) = (scene.emitters(), vertex.surface.p);
        loop {
            let Some(surface) = next_surface(scene, &mut ray, sampler) else {
                if straight {
                    for (radiance, connection) in emitters.escaped(ray.dir) {
                        sum.value += radiance * Heuristic::Power.weight(pdf, connection);
                    }
                }
                return sum;
            };
            if straight && let Some((emitter, radiance)) = emitters.emitted(&surface, -ray.dir) {
                let connection = emitters.pdf(LightSampling::default(), emitter, p, ray.dir, &surface);
                sum.value += radiance * Heuristic::Power.weight(pdf, connection);
            }
            if depth >= self.limit() {
                return sum;
            }
            let met = Vertex::new(scene, &ray, &surface);
            if stores(&met) {
                let reading = self.global.reflected(scene, &met, self.limit() - depth - 1);
                let near = surface.p.distance(p) < reading.radius;
                let seen = if near && nested > 0 {
                    self.reflected(scene, &met, depth, (1, nested - 1), sampler)
                } else {
                    reading.into()
                };
                sum += seen * throughput;
            }
            depth += 1;
            straight = false;
            let Some((next, weight)) = mirrored(scene, &met, depth, throughput, sampler) else { return sum };
            (ray, throughput) = (next, weight);
        }
    }
}

/// Light by a connection, past at most so many masks: weighted against so many rays of the model, or all of it.
pub(super) fn connected(
    scene: &Scene,
    vertex: &Vertex,
    rays: Option<u32>,
    masks: u32,
    sampler: &mut dyn Sampler,
) -> Rgb {
    let sought = if rays.is_some() { Sought::Uneven } else { Sought::Every };
    if !scene.emitters().any(sought) {
        return Rgb::BLACK;
    }
    let (choice, u) = (sampler.next_1d(), sampler.next_2d());
    let drawn = scene.emitters().sample(sought, LightSampling::default(), vertex.surface.p, choice, u);
    drawn.map_or(Rgb::BLACK, |light| {
        let (f_cos, pdf) = vertex.eval(light.wi);
        if f_cos.is_black() {
            return Rgb::BLACK;
        }
        let weight = match (light.density, rays) {
            (Density::SolidAngle(p), Some(rays)) => Heuristic::Power.weight(p, pdf * f64::from(rays)) / p,
            (Density::SolidAngle(p) | Density::Dirac(p), _) => 1.0 / p,
        };
        f_cos * light.radiance * weight * scene.transmittance(&scene.shadow_ray(vertex.surface, &light), masks)
    })
}

impl Radiance for FinalGather {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        self.stated(scene, ray, sampler).value
    }
}

impl OfMap for FinalGather {
    fn stated(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Stated {
        through_mirrors(scene, ray, self.limit(), sampler, |vertex, depth, sampler| {
            self.reflected(scene, vertex, depth, (self.rays, NESTED), sampler)
        })
    }
}
