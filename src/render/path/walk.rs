//! A path from surface to surface, one ray at a time.
#![allow(
    clippy::inline_always,
    reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
)]

use glam::DVec3;

use super::vertex::Vertex;
use super::{PathTracer, Strategy};
use crate::bsdf::{BsdfSample, Density, Lobes};
use crate::math::color::Rgb;
use crate::sampling::sampler::Sampler;
use crate::scene::{Hit, Ray, Scene, Sought, Surface, opaque_share};

/// A path on its way. It makes a [step](Self::step) at what its ray has met, [receives](Self::receive) the light that it has
/// connected to there, [casts](Self::cast) its next ray, and so on.
#[derive(Clone, Debug)]
pub(super) struct Walk {
    ray: Ray,
    hit: Option<Hit>,
    /// Product of the weights so far.
    throughput: Rgb,
    /// How often it has been scattered.
    depth: u32,
    last: Last,
    /// What it has brought.
    sum: Rgb,
    promised: Option<Promise>,
    fork: Option<Box<Fork>>,
}

/// Where the last direction came from, as far as the weight of emission at its end depends on it.
#[derive(Clone, Copy, Debug)]
enum Last {
    /// From the camera or a Dirac lobe: no connection could have found the same.
    Sole,
    /// From a surface at `p`, with this density [1/sr].
    Smooth { p: DVec3, pdf: f64 },
}

/// What an emitter brings, if its light gets through along the ray, past at most so many masked surfaces.
#[derive(Clone, Copy, Debug)]
struct Promise {
    ray: Ray,
    radiance: Rgb,
    masks: u32,
}

/// The first surface of a path, from which it goes on several times.
#[derive(Clone, Debug)]
struct Fork {
    ray: Ray,
    hit: Hit,
    throughput: Rgb,
    depth: u32,
    /// How many times more.
    left: u32,
    /// Whether the path is there again.
    back: bool,
}

impl Walk {
    /// A path that begins with this ray, which has been cast already.
    #[inline(always)]
    pub(super) fn new(ray: Ray, hit: Option<Hit>) -> Self {
        Self {
            ray,
            hit,
            throughput: Rgb::WHITE,
            depth: 0,
            last: Last::Sole,
            sum: Rgb::BLACK,
            promised: None,
            fork: None,
        }
    }

    /// The radiance that it has brought.
    #[inline(always)]
    pub(super) fn sum(&self) -> Rgb {
        self.sum
    }

    /// Casts the ray.
    #[inline(always)]
    pub(super) fn cast(&mut self, scene: &Scene) {
        self.hit = match &self.fork {
            Some(fork) if fork.back => Some(fork.hit),
            _ => scene.closest(&self.ray),
        };
    }

    /// Whether light was promised at the last step.
    #[inline(always)]
    pub(super) fn is_promised_light(&self) -> bool {
        self.promised.is_some()
    }

    /// Takes the light that was promised at the last step, if it gets through.
    #[inline(always)]
    pub(super) fn receive(&mut self, scene: &Scene) {
        if let Some(Promise { ray, radiance, masks }) = self.promised.take() {
            self.sum += radiance * scene.transmittance(&ray, masks);
        }
    }

    /// Takes the emission where the ray has ended, connects to a light and scatters the path; false where it ends.
    #[inline(always)]
    pub(super) fn step<S: Sampler + ?Sized>(&mut self, tracer: &PathTracer, scene: &Scene, sampler: &mut S) -> bool {
        self.advance(tracer, scene, sampler) || self.return_to_fork()
    }

    #[inline(always)]
    fn advance<S: Sampler + ?Sized>(&mut self, tracer: &PathTracer, scene: &Scene, sampler: &mut S) -> bool {
        let Some(hit) = self.hit else {
            for (radiance, pdf) in scene.emitters().escaped(self.ray.dir) {
                self.sum += self.throughput * radiance * self.share(tracer, |_| pdf);
            }
            return false;
        };
        let surface = scene.surface(&self.ray, &hit);
        if !self.is_back_at_fork() {
            if let Some(opacity) = scene.material_of(surface.shape).opacity()
                && sampler.next_1d() >= opaque_share(opacity, &surface)
            {
                self.depth += 1;
                self.ray = scene.leave(&surface, self.ray.dir);
                return self.depth <= tracer.limit();
            }
            if let Some((emitter, radiance)) = scene.emitters().emitted(&surface, -self.ray.dir) {
                let pdf = |p| scene.emitters().pdf(tracer.light_sampling, emitter, p, self.ray.dir, &surface);
                self.sum += self.throughput * radiance * self.share(tracer, pdf);
            }
            if self.depth >= tracer.limit() {
                return false;
            }
            if tracer.first_split > 1 && self.fork.is_none() {
                self.throughput = self.throughput / f64::from(tracer.first_split);
                let Self { ray, throughput, depth, .. } = *self;
                let left = tracer.first_split - 1;
                self.fork = Some(Box::new(Fork { ray, hit, throughput, depth, left, back: false }));
            }
        }
        self.scatter(tracer, scene, &surface, sampler)
    }

    #[inline(always)]
    fn is_back_at_fork(&mut self) -> bool {
        self.fork.as_mut().is_some_and(|fork| std::mem::take(&mut fork.back))
    }

    /// Where the path ends, takes it back to its first surface if it is to go on from there once more.
    #[inline(always)]
    fn return_to_fork(&mut self) -> bool {
        let Some(fork) = self.fork.as_mut().filter(|fork| fork.left > 0) else { return false };
        fork.left -= 1;
        fork.back = true;
        (self.ray, self.throughput, self.depth) = (fork.ray, fork.throughput, fork.depth);
        true
    }

    /// The weight of emission found by chance, where a connection from p would have found it with density `pdf(p)`.
    #[inline(always)]
    fn share(&self, tracer: &PathTracer, pdf: impl Fn(DVec3) -> f64) -> f64 {
        match (tracer.strategy, self.last) {
            (Strategy::Bsdf, _) | (_, Last::Sole) => 1.0,
            (Strategy::Mis, Last::Smooth { p, pdf: found }) => tracer.heuristic.weight(found, pdf(p)),
            (Strategy::Direct | Strategy::RandomConnect, Last::Smooth { .. }) => 0.0,
        }
    }

    /// Connects to a light and draws the next direction; false where the path ends.
    #[inline(always)]
    fn scatter<S: Sampler + ?Sized>(
        &mut self,
        tracer: &PathTracer,
        scene: &Scene,
        surface: &Surface,
        sampler: &mut S,
    ) -> bool {
        let vertex = Vertex::new(scene, &self.ray, surface);
        if matches!(tracer.strategy, Strategy::Mis | Strategy::Direct) {
            self.promised = self.connect(tracer, scene, &vertex, sampler);
        }
        let mut drawn = vertex.sample(sampler.next_uniforms());
        if tracer.strategy == Strategy::RandomConnect {
            let chance = self.chance_to_connect(tracer, &vertex, drawn.as_ref());
            if sampler.next_1d() < chance {
                self.throughput = self.throughput / chance;
                self.promised = self.connect(tracer, scene, &vertex, sampler);
                return false;
            }
            // In the weight, so that roulette knows: two games that each stop a path for what it loses at a surface
            // would leave the survivors with an infinite variance.
            if let Some(drawn) = &mut drawn {
                drawn.weight = drawn.weight / (1.0 - chance);
            }
        }
        drawn.is_some_and(|drawn| self.leave(tracer, scene, &vertex, &drawn, sampler))
    }

    /// What an emitter promises to bring to `vertex` and along the path.
    #[inline(always)]
    fn connect<S: Sampler + ?Sized>(
        &self,
        tracer: &PathTracer,
        scene: &Scene,
        vertex: &Vertex,
        sampler: &mut S,
    ) -> Option<Promise> {
        let sought = if tracer.strategy == Strategy::Mis { Sought::Uneven } else { Sought::Every };
        if !scene.emitters().any(sought) {
            return None; // And no numbers are spent, so that those of the path's directions come next to each other.
        }
        let (choice, u) = (sampler.next_1d(), sampler.next_2d());
        let light = scene.emitters().sample(sought, tracer.light_sampling, vertex.surface.p, choice, u)?;
        let (f_cos, pdf) = vertex.eval(light.wi);
        if f_cos.is_black() {
            return None;
        }
        let weight = match light.density {
            Density::SolidAngle(p) if tracer.strategy == Strategy::Mis => tracer.heuristic.weight(p, pdf) / p,
            Density::SolidAngle(p) | Density::Dirac(p) => 1.0 / p,
        };
        Some(Promise {
            ray: scene.shadow_ray(vertex.surface, &light),
            radiance: self.throughput * f_cos * light.radiance * weight,
            masks: tracer.limit() - self.depth - 1,
        })
    }

    /// The probability of ending the path by a connection at `vertex`: the same for each of the bounces that are left,
    /// or, without a limit, what keeps the weight of going on near 1.
    fn chance_to_connect(&self, tracer: &PathTracer, vertex: &Vertex, drawn: Option<&BsdfSample>) -> f64 {
        let Some(limit) = tracer.bounces else {
            // Below .01 a white furnace would hardly end, and above it a room of albedo ρ would have an infinite variance
            // from ρ² = 1 − .01 on; above .5 direct light is already worth every second path.
            return drawn.map_or(0.5, |drawn| (1.0 - drawn.weight.max_channel()).clamp(0.01, 0.5));
        };
        // A Dirac lobe brings what no connection at this surface can: one more to pick from.
        let beyond = u32::from(vertex.bsdf.lobes().contains(Lobes::DIRAC));
        1.0 / f64::from(limit - self.depth + beyond)
    }

    /// Sends the path on along `drawn`; false where it ends.
    #[inline(always)]
    fn leave<S: Sampler + ?Sized>(
        &mut self,
        tracer: &PathTracer,
        scene: &Scene,
        vertex: &Vertex,
        drawn: &BsdfSample,
        sampler: &mut S,
    ) -> bool {
        self.depth += 1;
        self.throughput = self.throughput * drawn.weight;
        self.last = match drawn.density {
            Density::SolidAngle(pdf) => Last::Smooth { p: vertex.surface.p, pdf },
            Density::Dirac(_) => Last::Sole,
        };
        let connects = matches!(tracer.strategy, Strategy::Direct | Strategy::RandomConnect);
        if connects && self.depth == tracer.limit() && matches!(self.last, Last::Smooth { .. }) {
            return false; // What its ray could find has been connected to.
        }
        let survival = tracer.roulette.survival(self.depth, drawn.weight, self.throughput);
        if survival < 1.0 {
            if sampler.next_1d() >= survival {
                return false;
            }
            self.throughput = self.throughput / survival;
        }
        self.ray = scene.leave(vertex.surface, drawn.wi);
        !self.throughput.is_black()
    }
}
