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
//! | `Mis` | weighted by the heuristic | at every surface, weighted; to no constant environment |
//! | `RandomConnect` | seen directly or past Dirac lobes only | at one surface of the path, picked at random, with weight 1/p |
//!
//! All have the same mean. Basic radiance L/η² is carried, so that a lossless interface neither adds nor takes.
//! # References
//! - Kajiya 1986, The rendering equation, SIGGRAPH; Arvo & Kirk 1990, Particle transport and image synthesis, SIGGRAPH
//! - Veach & Guibas 1995, Optimally combining sampling techniques, SIGGRAPH

mod roulette;
pub(super) mod vertex;
mod walk;
mod wave;

pub use roulette::Roulette;

use super::{Radiance, Sample, Samples};
use crate::math::color::Rgb;
use crate::sampling::sampler::Sampler;
use crate::scene::{LightSampling, Ray, Scene};

use walk::Walk;
use wave::Wave;

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

impl PathTracer {
    fn limit(&self) -> u32 {
        self.bounces.unwrap_or(u32::MAX)
    }

    fn in_waves<S: Sampler>(&self, scene: &Scene, samples: &mut [Sample<S>]) {
        for samples in samples.chunks_mut(wave::MOST) {
            scene.accelerate(Wave { tracer: self, scene, samples });
        }
    }
}

impl Radiance for PathTracer {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        let mut walk = Walk::new(ray, scene.closest(&ray));
        loop {
            let goes_on = walk.step(self, scene, sampler);
            walk.receive(scene);
            if !goes_on {
                return walk.sum();
            }
            walk.cast(scene);
        }
    }

    fn radiances(&self, scene: &Scene, samples: Samples) {
        match samples {
            Samples::Independent(samples) => self.in_waves(scene, samples),
            Samples::Lattice(samples) => self.in_waves(scene, samples),
            Samples::Any(samples) => self.in_waves(scene, samples),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sum::Moments;
    use crate::sampling::filter::Filter;
    use crate::sampling::points::Lattice;
    use crate::sampling::sampler::{Independent, SamplerKind};
    use crate::scene::builtin::builtin;
    use crate::scene::{Camera, FilmSettings, Geometry, Material, RenderSettings, SceneDescription, Shape};
    use glam::{DAffine3, DQuat, DVec2, DVec3};

    /// The inside of a sphere of radius 1 with this albedo and emission 1/2.
    fn furnace(rho: f64) -> Scene {
        Scene::new(SceneDescription {
            name: "furnace".into(),
            camera: Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0),
            film: FilmSettings { width: 1, height: 1, filter: Filter::BOX },
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
                film: FilmSettings { width: 1, height: 1, filter: Filter::BOX },
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

    /// Radiances of samples in waves, full ones and one that is not, and of each path alone.
    fn in_waves_and_alone<S: Sampler + Clone>(tracer: &PathTracer, scene: &Scene, sampler: &S) -> (Vec<Rgb>, Vec<Rgb>)
    where
        for<'a> Samples<'a>: From<&'a mut [Sample<S>]>,
    {
        let sample = |number: usize| {
            let mut sampler = sampler.clone();
            sampler.begin(0, number as u64);
            Sample::new(scene.camera_ray(512.0 * sampler.next_2d(), DVec2::ZERO), sampler)
        };
        let mut samples: Vec<Sample<S>> = (0..2 * wave::MOST + 5).map(sample).collect();
        let alone = samples.clone().iter_mut().map(|s| tracer.radiance(scene, s.ray, &mut s.sampler)).collect();
        tracer.radiances(scene, samples.as_mut_slice().into());
        (samples.iter().map(|s| s.radiance).collect(), alone)
    }

    #[test]
    fn a_wave_has_the_bits_of_each_path_alone() {
        let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap();
        for strategy in [Strategy::Mis, Strategy::Direct, Strategy::Bsdf, Strategy::RandomConnect] {
            for (first_split, bounces) in [(1, None), (3, Some(4))] {
                let tracer = PathTracer { strategy, bounces, first_split, ..PathTracer::default() };
                let mut light = Rgb::BLACK;
                for (waves, alone) in [
                    in_waves_and_alone(&tracer, &scene, &Independent::new(5)),
                    in_waves_and_alone(&tracer, &scene, &Lattice::new(5)),
                    in_waves_and_alone(&tracer, &scene, &SamplerKind::Halton.sampler(5, 200, 1)),
                ] {
                    assert!(waves == alone, "{tracer:?}");
                    light += waves.into_iter().sum();
                }
                assert!(!light.is_black(), "{tracer:?}: no path has found the lamp");
            }
        }
    }
}
