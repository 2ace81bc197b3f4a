//! Path tracing: one engine, its strategies as data.
//!
//! A path starts at the camera and is scattered at most `bounces` times, whether reflected, refracted or let through a
//! masked surface. `bounces = r` thus gives emission, direct light, … up to r reflections: with L₀ the emission and T the
//! transport operator, L₀ + T L₀ + … + Tʳ L₀.
//!
//! | strategy | emission found by chance counts | light is connected to |
//! |---|---|---|
//! | `Bsdf` | always | never |
//! | `Direct` | seen directly or past Dirac lobes only | at every surface |
//! | `Mis` | weighted by the heuristic | at every surface, weighted |
//! | `RandomConnect` | seen directly or past Dirac lobes only | at one surface of the path, picked at random, with weight 1/p |
//!
//! All have the same mean. Basic radiance L/η² is carried, so that a lossless interface neither adds nor takes.
//! # References
//! - Kajiya 1986, The rendering equation, SIGGRAPH; Arvo & Kirk 1990, Particle transport and image synthesis, SIGGRAPH
//! - Veach & Guibas 1995, Optimally combining sampling techniques, SIGGRAPH

mod roulette;
mod vertex;

pub use roulette::Roulette;

use glam::DVec3;

use super::Radiance;
use crate::bsdf::{BsdfSample, Density, Lobes};
use crate::math::color::Rgb;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::bvh::Work;
use crate::scene::{LightSampling, Ray, Scene, Surface, opaque_share};

use vertex::Vertex;

/// How light is found. See the module's table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// By chance and by connection, each weighted by how likely it was.
    #[default]
    Mis,
    /// By connection at every surface.
    Direct,
    /// By chance alone. Lights without a surface are never found.
    Bsdf,
    /// By connection at one surface of the path, picked at random.
    RandomConnect,
}

/// How multiple importance sampling weighs two ways to the same direction, from their densities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// p / (p + q).
    Balance,
    /// p² / (p² + q²): better where one of the two alone is good.
    #[default]
    Power,
}

impl Heuristic {
    /// The weight of a draw of density `p` that could have been made with density `q`.
    #[inline]
    pub fn weight(self, p: f64, q: f64) -> f64 {
        match self {
            Self::Balance => p / (p + q),
            Self::Power => {
                // As a ratio, so that no square overflows.
                let ratio = q / p;
                1.0 / (1.0 + ratio * ratio)
            }
        }
    }
}

/// The path tracer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathTracer {
    /// How light is found.
    pub strategy: Strategy,
    /// The largest number of reflections; None for no limit.
    pub bounces: Option<u32>,
    /// How many times the path is continued from its first surface, each with a share of the weight; 0 counts as 1.
    pub first_split: u32,
    /// What ends a path before its last bounce.
    pub roulette: Roulette,
    /// The weights of `Mis`.
    pub heuristic: Heuristic,
    /// How points of emitters are drawn.
    pub light_sampling: LightSampling,
}

impl Default for PathTracer {
    /// MIS without a limit, ended by roulette from the fifth reflection on.
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            bounces: None,
            first_split: 1,
            roulette: Roulette::From(5),
            heuristic: Heuristic::default(),
            light_sampling: LightSampling::default(),
        }
    }
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
struct Path {
    ray: Ray,
    /// Product of the weights so far.
    throughput: Rgb,
    /// How often it has been scattered.
    depth: u32,
    last: Last,
}

/// Where the last direction came from, as far as the weight of emission at its end depends on it.
#[derive(Clone, Copy, Debug)]
enum Last {
    /// From the camera or a Dirac lobe: no connection could have found the same.
    Sole,
    /// From a surface at `p`, with this density [1/sr].
    Smooth { p: DVec3, pdf: f64 },
}

impl Radiance for PathTracer {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        self.trace(scene, ray, sampler)
    }

    fn radiance_independent(&self, scene: &Scene, ray: Ray, sampler: &mut Independent) -> Rgb {
        scene.accelerate(Trace { tracer: self, scene, ray, sampler })
    }
}

/// One path, to be traced with the best instructions of the machine.
struct Trace<'a> {
    tracer: &'a PathTracer,
    scene: &'a Scene,
    ray: Ray,
    sampler: &'a mut Independent,
}

impl Work for Trace<'_> {
    type Output = Rgb;

    #[allow(clippy::inline_always, reason = "inlined into a function that has those instructions enabled")]
    #[inline(always)]
    fn run(self) -> Rgb {
        self.tracer.trace(self.scene, self.ray, self.sampler)
    }
}

impl PathTracer {
    fn limit(&self) -> u32 {
        self.bounces.unwrap_or(u32::MAX)
    }

    #[allow(clippy::inline_always, reason = "as for `Trace::run`")]
    #[inline(always)]
    fn trace<S: Sampler + ?Sized>(&self, scene: &Scene, ray: Ray, sampler: &mut S) -> Rgb {
        let mut path = Path { ray, throughput: Rgb::WHITE, depth: 0, last: Last::Sole };
        let mut sum = Rgb::BLACK;
        let Some(surface) = self.arrive(scene, &mut path, sampler, &mut sum) else { return sum };
        let ways = self.first_split.max(1);
        let mut rest = Rgb::BLACK;
        for _ in 0..ways {
            rest += self.follow(scene, path, surface, sampler);
        }
        sum + rest / f64::from(ways)
    }

    /// Casts the path's ray: adds the emission that it finds to `sum`; the surface from which it goes on, if it may.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    fn arrive<S: Sampler + ?Sized>(
        &self,
        scene: &Scene,
        path: &mut Path,
        sampler: &mut S,
        sum: &mut Rgb,
    ) -> Option<Surface> {
        loop {
            let Some(surface) = scene.intersect(&path.ray) else {
                for (radiance, pdf) in scene.emitters().escaped(path.ray.dir) {
                    *sum += path.throughput * radiance * self.share(path.last, |_| pdf);
                }
                return None;
            };
            if let Some(opacity) = scene.material_of(surface.shape).opacity()
                && sampler.next_1d() >= opaque_share(opacity, &surface)
            {
                path.depth += 1;
                if path.depth > self.limit() {
                    return None;
                }
                path.ray = scene.leave(&surface, path.ray.dir);
                continue;
            }
            if let Some((emitter, radiance)) = scene.emitters().emitted(&surface, -path.ray.dir) {
                let pdf = |p| scene.emitters().pdf(self.light_sampling, emitter, p, path.ray.dir, &surface);
                *sum += path.throughput * radiance * self.share(path.last, pdf);
            }
            return (path.depth < self.limit()).then_some(surface);
        }
    }

    /// The weight of emission found by chance, where a connection from p would have found it with density `pdf(p)`.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    fn share(&self, last: Last, pdf: impl Fn(DVec3) -> f64) -> f64 {
        match (self.strategy, last) {
            (Strategy::Bsdf, _) | (_, Last::Sole) => 1.0,
            (Strategy::Mis, Last::Smooth { p, pdf: found }) => self.heuristic.weight(found, pdf(p)),
            (Strategy::Direct | Strategy::RandomConnect, Last::Smooth { .. }) => 0.0,
        }
    }

    /// Everything that the path brings from `surface` on.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    fn follow<S: Sampler + ?Sized>(&self, scene: &Scene, mut path: Path, from: Surface, sampler: &mut S) -> Rgb {
        let mut sum = Rgb::BLACK;
        let mut surface = from;
        loop {
            let vertex = Vertex::new(scene, &path.ray, &surface);
            if matches!(self.strategy, Strategy::Mis | Strategy::Direct) {
                sum += path.throughput * self.connect(scene, &path, &vertex, sampler);
            }
            let mut drawn = vertex.sample(sampler.next_uniforms());
            if self.strategy == Strategy::RandomConnect {
                let chance = self.chance_to_connect(&path, &vertex, drawn.as_ref());
                if sampler.next_1d() < chance {
                    return sum + path.throughput * self.connect(scene, &path, &vertex, sampler) / chance;
                }
                // In the weight, so that roulette knows: two games that each stop a path for what it loses at a surface
                // would leave the survivors with an infinite variance.
                if let Some(drawn) = &mut drawn {
                    drawn.weight = drawn.weight / (1.0 - chance);
                }
            }
            let Some(drawn) = drawn else { return sum };
            if !self.scatter(scene, &mut path, &vertex, &drawn, sampler) {
                return sum;
            }
            match self.arrive(scene, &mut path, sampler, &mut sum) {
                Some(next) => surface = next,
                None => return sum,
            }
        }
    }

    /// The light that reaches `vertex` from an emitter and is scattered along the path.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    fn connect<S: Sampler + ?Sized>(&self, scene: &Scene, path: &Path, vertex: &Vertex, sampler: &mut S) -> Rgb {
        let (choice, u) = (sampler.next_1d(), sampler.next_2d());
        let Some(light) = scene.emitters().sample(self.light_sampling, vertex.surface.p, choice, u) else {
            return Rgb::BLACK;
        };
        let (f_cos, pdf) = vertex.eval(light.wi);
        if f_cos.is_black() {
            return Rgb::BLACK;
        }
        let weight = match light.density {
            Density::SolidAngle(p) if self.strategy == Strategy::Mis => self.heuristic.weight(p, pdf) / p,
            Density::SolidAngle(p) | Density::Dirac(p) => 1.0 / p,
        };
        let shadow_ray = scene.shadow_ray(vertex.surface, &light);
        let masks = self.limit() - path.depth - 1;
        f_cos * light.radiance * scene.transmittance(&shadow_ray, masks) * weight
    }

    /// The probability of ending the path by a connection at `vertex`: the same for each of the bounces that are left,
    /// or, without a limit, what keeps the weight of going on near 1.
    fn chance_to_connect(&self, path: &Path, vertex: &Vertex, drawn: Option<&BsdfSample>) -> f64 {
        let Some(limit) = self.bounces else {
            // Below .01 a white furnace would hardly end, and above it a room of albedo ρ would have an infinite variance
            // from ρ² = 1 − .01 on; above .5 direct light is already worth every second path.
            return drawn.map_or(0.5, |drawn| (1.0 - drawn.weight.max_channel()).clamp(0.01, 0.5));
        };
        // A Dirac lobe brings what no connection at this surface can: one more to pick from.
        let beyond = u32::from(vertex.bsdf.lobes().contains(Lobes::DIRAC));
        1.0 / f64::from(limit - path.depth + beyond)
    }

    /// Sends the path on along `drawn`; false where it ends.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    fn scatter<S: Sampler + ?Sized>(
        &self,
        scene: &Scene,
        path: &mut Path,
        vertex: &Vertex,
        drawn: &BsdfSample,
        sampler: &mut S,
    ) -> bool {
        path.depth += 1;
        path.throughput = path.throughput * drawn.weight;
        path.last = match drawn.density {
            Density::SolidAngle(pdf) => Last::Smooth { p: vertex.surface.p, pdf },
            Density::Dirac(_) => Last::Sole,
        };
        let connects = matches!(self.strategy, Strategy::Direct | Strategy::RandomConnect);
        if connects && path.depth == self.limit() && matches!(path.last, Last::Smooth { .. }) {
            return false; // What its ray could find has been connected to.
        }
        let survival = self.roulette.survival(path.depth, drawn.weight, path.throughput);
        if survival < 1.0 {
            if sampler.next_1d() >= survival {
                return false;
            }
            path.throughput = path.throughput / survival;
        }
        path.ray = scene.leave(vertex.surface, vertex.frame.to_world(drawn.wi));
        !path.throughput.is_black()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sum::Moments;
    use crate::scene::{Camera, FilmSettings, FilterKind, Geometry, Material, RenderSettings, SceneDescription, Shape};
    use glam::{DAffine3, DQuat};

    /// The inside of a sphere of radius 1 with this albedo and emission 1/2.
    fn furnace(rho: f64) -> Scene {
        Scene::new(SceneDescription {
            name: "furnace".into(),
            camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0),
            film: FilmSettings { width: 1, height: 1, filter: FilterKind::Box },
            render: RenderSettings::default(),
            materials: vec![Material::diffuse("wall", Rgb::grey(rho).into())],
            shapes: vec![Shape {
                name: "wall".into(),
                geometry: Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 },
                flip_normals: true,
                material: 0,
                emission: Some(Rgb::grey(0.5)),
            }],
            lights: Vec::new(),
        })
        .unwrap()
    }

    fn estimate(tracer: &PathTracer, scene: &Scene, n: u64) -> Moments {
        let mut moments = Moments::default();
        let mut sampler = Independent::new(1);
        for sample in 0..n {
            sampler.begin(0, sample);
            let ray = Ray::new(DVec3::new(0.1, 0.2, 0.3), crate::sampling::warp::uniform_sphere(sampler.next_2d()));
            moments.add(tracer.radiance(scene, ray, &mut sampler).0.x);
        }
        moments
    }

    #[test]
    fn reflections_in_a_furnace_add_up_without_variance() {
        // E = ρ = 1/2: .5, .75, .875, …
        let scene = furnace(0.5);
        for bounces in 0..8 {
            let tracer = PathTracer {
                strategy: Strategy::Bsdf,
                bounces: Some(bounces),
                roulette: Roulette::Off,
                ..PathTracer::default()
            };
            let moments = estimate(&tracer, &scene, 20);
            let exact = 1.0 - 0.5_f64.powf(f64::from(bounces + 1));
            assert!((moments.mean() - exact).abs() < 1e-14 && moments.variance() < 1e-28, "{bounces}: {moments:?}");
        }
    }

    #[test]
    fn all_strategies_agree_in_a_furnace() {
        let scene = furnace(0.5);
        for strategy in [Strategy::Mis, Strategy::Direct, Strategy::Bsdf, Strategy::RandomConnect] {
            for (bounces, exact) in [(Some(0), 0.5), (Some(1), 0.75), (Some(2), 0.875), (None, 1.0)] {
                for (first_split, roulette) in
                    [(1, Roulette::Albedo), (4, Roulette::From(2)), (1, Roulette::Constant(0.8))]
                {
                    let tracer = PathTracer { strategy, bounces, first_split, roulette, ..PathTracer::default() };
                    let moments = estimate(&tracer, &scene, 20_000);
                    let gap = (moments.mean() - exact).abs();
                    // 4.5 sigma over 48 cases: one in 3000 seeds.
                    assert!(gap <= 4.5 * moments.std_err() + 1e-12, "{tracer:?}: {} against {exact}", moments.mean());
                }
            }
        }
    }

    #[test]
    fn a_mask_is_an_event_and_strategies_agree_behind_it() {
        // A white floor under a constant sky, below a sheet that is black and there by two thirds.
        let build = |sheet_emits: bool| {
            let rectangle = |name: &str, z: f64, material: usize, emission: Option<Rgb>| Shape {
                name: name.into(),
                geometry: Geometry::Rectangle {
                    to_world: DAffine3::from_scale_rotation_translation(
                        DVec3::new(1e3, 1e3, 1.0),
                        DQuat::IDENTITY,
                        DVec3::new(0.0, 0.0, z),
                    ),
                },
                flip_normals: false,
                material,
                emission,
            };
            let sheet = Material::diffuse("sheet", Rgb::BLACK.into()).with_opacity(Rgb::grey(2.0 / 3.0).into());
            Scene::new(SceneDescription {
                name: "sheet".into(),
                camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0),
                film: FilmSettings { width: 1, height: 1, filter: FilterKind::Box },
                render: RenderSettings::default(),
                materials: vec![Material::diffuse("floor", Rgb::WHITE.into()), sheet],
                shapes: vec![
                    rectangle("floor", 0.0, 0, None),
                    rectangle("sheet", 1e-3, 1, sheet_emits.then_some(Rgb::WHITE)),
                ],
                lights: vec![crate::scene::Light::Constant { radiance: Rgb::WHITE }],
            })
        };
        assert!(build(true).is_err(), "a connection would find light that is not there");
        let scene = build(false).unwrap();
        // Past the sheet twice, and one reflection: 1/9 with three events, nothing with two.
        for strategy in [Strategy::Mis, Strategy::Direct, Strategy::Bsdf, Strategy::RandomConnect] {
            for (bounces, exact) in [(2, 0.0), (3, 1.0 / 9.0)] {
                let tracer =
                    PathTracer { strategy, bounces: Some(bounces), roulette: Roulette::Off, ..PathTracer::default() };
                let (mut moments, mut sampler) = (Moments::default(), Independent::new(3));
                for sample in 0..40_000 {
                    sampler.begin(0, sample);
                    let ray = Ray::new(DVec3::new(0.3, 0.2, 1.0), DVec3::new(0.0, 0.6, -0.8));
                    moments.add(tracer.radiance(&scene, ray, &mut sampler).0.x);
                }
                // 4.5 sigma over 4 cases with noise; the sheet ends a thousand units away, which a ray in 1e6 sees.
                assert!(
                    (moments.mean() - exact).abs() <= 4.5 * moments.std_err() + 1e-5,
                    "{strategy:?} {bounces}: {moments:?}"
                );
            }
        }
    }
}
