//! Photon maps against what is known in closed form, and against path tracing.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::gather::FinalGather;
use super::kernel::Estimator;
use super::map::{Around, Gather, PhotonMap};
use super::progressive::{ALPHA, First, Sppm};
use super::shoot::{Shooting, Shot};
use super::view::DirectView;
use super::{History, Kept, PhotonError};
use crate::bsdf::Dielectric;
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Independent, Sampler};
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::builtin::builtin;
use crate::scene::{
    Camera, EnvironmentMap, FilmSettings, Geometry, Light, LightSampling, Material, Mesh, Ray, RenderSettings, Scene,
    SceneDescription, Shape, Sought,
};

fn quad(corners: [DVec3; 4]) -> Geometry {
    Geometry::Mesh(Arc::new(Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()))
}

fn shape(name: &str, geometry: Geometry, material: usize) -> Shape {
    Shape { name: name.into(), geometry, flip_normals: false, material, emission: None }
}

fn build(materials: Vec<Material>, shapes: Vec<Shape>, lights: Vec<Light>) -> Scene {
    Scene::new(SceneDescription {
        name: "photons".into(),
        camera: Camera::look_at(DVec3::new(0.3, 0.4, 3.0), DVec3::new(0.3, 0.4, 0.0), DVec3::Y, 60.0),
        film: FilmSettings { width: 8, height: 8, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials,
        shapes,
        lights,
    })
    .unwrap()
}

fn grey(rho: f64) -> Material {
    Material::diffuse("grey", Rgb::grey(rho).into())
}

fn named(name: &str, params: &[(&str, &str)]) -> Scene {
    let params: Vec<_> = params.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
    Scene::new(builtin(name, &params).unwrap().unwrap()).unwrap()
}

fn shoot(scene: &Scene, photons: u64) -> Shot {
    Shooting { photons, ..Shooting::default() }.shoot(scene).unwrap()
}

/// The unit square at z = 0, seen from above.
fn floor(material: usize) -> Shape {
    shape("floor", quad([DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]), material)
}

/// Flux on the floor by connections from points of it: nothing that photons are made of.
fn by_connections(scene: &Scene) -> Moments {
    let (mut moments, mut sampler) = (Moments::default(), Independent::new(77));
    for sample in 0..200_000 {
        sampler.begin(0, sample);
        let (at, choice, u) = (sampler.next_2d(), sampler.next_1d(), sampler.next_2d());
        let from = Ray::new(at.extend(1e-3), -DVec3::Z);
        let surface = scene.intersect(&from).expect("the floor");
        let light = scene.emitters().sample(Sought::Every, LightSampling::Area, surface.p, choice, u);
        moments.add(light.filter(|light| light.wi.z > 0.0).map_or(0.0, |light| {
            let (crate::bsdf::Density::SolidAngle(p) | crate::bsdf::Density::Dirac(p)) = light.density;
            let open = scene.transmittance(&scene.shadow_ray(&surface, &light), 0).mean();
            open * light.radiance.mean() * light.wi.z / p
        }));
    }
    moments
}

#[test]
fn every_kind_of_light_sends_what_connections_find() {
    let emitting = |geometry, flip_normals| Shape {
        flip_normals,
        emission: Some(Rgb::new(3.0, 2.0, 1.0)),
        ..shape("light", geometry, 1)
    };
    let above = DVec3::new(0.4, 0.7, 0.8);
    let down = DVec3::new(0.2, -0.3, -0.9).normalize();
    let mut pixels = vec![[0.1_f32; 3]; 16 * 8];
    pixels[16 + 5] = [50.0, 20.0, 10.0];
    let map = EnvironmentMap {
        pixels: Arc::new(pixels),
        width: 16,
        height: 8,
        to_world: DMat3::from_rotation_x(0.5 * PI),
        scale: 2.0,
    };
    let square = [(0.2, 0.2), (0.2, 0.9), (0.7, 0.9), (0.7, 0.2)].map(|(x, y)| DVec3::new(x, y, 0.6));
    let triangle = Mesh::new(square[..3].to_vec(), vec![[0, 1, 2]]).unwrap();
    let white = Rgb::WHITE;
    let cases: Vec<(&str, Vec<Shape>, Vec<Light>)> = vec![
        ("rectangle", vec![emitting(quad(square), false)], vec![]),
        ("triangle", vec![emitting(Geometry::Mesh(Arc::new(triangle)), false)], vec![]),
        ("sphere", vec![emitting(Geometry::Sphere { centre: above, radius: 0.3 }, false)], vec![]),
        ("point", vec![], vec![Light::Point { position: above, intensity: white }]),
        (
            "spot",
            vec![],
            vec![Light::Spot { position: above, direction: down, intensity: white, beam: 0.3, cutoff: 0.8 }],
        ),
        ("directional", vec![], vec![Light::Directional { direction: down, irradiance: white }]),
        ("constant", vec![], vec![Light::Constant { radiance: white }]),
        ("picture", vec![], vec![Light::Environment(map)]),
        (
            "several",
            vec![emitting(quad(square), false)],
            vec![
                Light::Point { position: above, intensity: white * 0.3 },
                Light::Directional { direction: down, irradiance: white },
            ],
        ),
    ];
    for (name, shapes, lights) in cases {
        let shapes = [floor(0)].into_iter().chain(shapes).collect();
        let scene = build(vec![grey(0.0), grey(0.0)], shapes, lights);
        let batches: Vec<f64> = (1..=20)
            .map(|seed| {
                let shooting = Shooting { photons: 20_000, seed, ..Shooting::default() };
                let upper = shooting.shoot(&scene).unwrap();
                upper.photons.iter().filter(|p| p.shape == 0 && p.n.z > 0.0).map(|p| p.flux.mean()).sum()
            })
            .collect();
        let mut photons = Moments::default();
        for flux in batches {
            photons.add(flux);
        }
        let connections = by_connections(&scene);
        let error = photons.std_err().hypot(connections.std_err());
        let gap = (photons.mean() - connections.mean()).abs();
        // 4 sigma, of which the photons' is known from 20 batches: Student's t beyond 4 is 1 in 1300 a case.
        assert!(gap <= 4.0 * error, "{name}: {} against {} ± {error}", photons.mean(), connections.mean());
        // The twin: twice the light.
        assert!((2.0 * photons.mean() - connections.mean()).abs() > 4.0 * error, "{name}: the test has lost its power");
    }
}

#[test]
fn hits_are_geometric_and_light_is_where_it_must_be() {
    for rho in [0.0_f64, 0.3, 0.8] {
        let scene = named("furnace-box", &[("rho", &rho.to_string()), ("e", "0.5")]);
        let photons = 100_000;
        let Shot { tally, photons: stored } = shoot(&scene, photons);
        // Of a geometric distribution: mean 1 / (1 − ρ), variance ρ / (1 − ρ)².
        let (mean, sigma) = (1.0 / (1.0 - rho), rho.sqrt() / (1.0 - rho) / (photons as f64).sqrt());
        assert!((tally.hits.mean() - mean).abs() <= 4.0 * sigma + 1e-12, "rho {rho}: {}", tally.hits.mean());
        // Emitted: π L A, of the cube of side 2. Every photon has the same flux; 1e5 roundings.
        let power = PI * 0.5 * 24.0;
        let relative = |flux: Rgb| (flux.0 / power - 1.0).abs().max_element();
        assert!(relative(tally.emitted_flux) < 1e-10, "{}", tally.emitted_flux);
        let first: Rgb = tally.shapes.iter().map(|shape| shape.first).sum();
        assert!(relative(first) < 1e-10, "first hits carry {first} of {power}");
        assert!((tally.missing().0 / power).abs().max_element() < 1e-10 && tally.escaped == 0);
        // Absorbed by what arrives, not by what ended: (1 − ρ) Σ Φ, to 4 sigma of the mean hits.
        let absorbed = stored.iter().map(|p| p.flux).sum::<Rgb>() * (1.0 - rho);
        assert!(relative(absorbed) <= 4.0 * sigma * (1.0 - rho) + 1e-10, "rho {rho}: {absorbed} of {power}");
        let flux = stored[0].flux.mean();
        assert!(stored.iter().all(|p| (p.flux.mean() / flux - 1.0).abs() < 1e-12), "roulette keeps the flux");
        if rho == 0.8 {
            // The twin: who takes the albedo for .78 is found out.
            assert!((tally.hits.mean() - 1.0 / 0.22).abs() > 4.0 * sigma);
        }
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    let scene = named("cornell-original", &[]);
    let all: Vec<_> = [1, 2, 3]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let shot = shoot(&scene, 20_000);
                let tally = shot.tally.clone();
                let light = FinalGather::new(&scene, shot, Gather::default(), 2, None).unwrap();
                let mut sampler = Independent::new(3);
                let seen: Vec<[f64; 3]> = (0..50)
                    .map(|i| {
                        sampler.begin(0, i);
                        let ray = scene.camera_ray(512.0 * sampler.next_2d(), DVec2::ZERO);
                        light.radiance(&scene, ray, &mut sampler).to_array()
                    })
                    .collect();
                (tally, light.map().photons().copied().collect::<Vec<_>>(), seen)
            })
        })
        .collect();
    assert!(all[0] == all[1] && all[0] == all[2]);
    let other = Shooting { photons: 20_000, seed: 2, ..Shooting::default() }.shoot(&scene).unwrap();
    assert!(other.tally != all[0].0, "another seed is another map");
}

/// Mean irradiance over maps at `p` of the floor, relative to that of a constant field, with its standard error.
fn relative(scene: &Scene, p: DVec2, gather: Gather, irradiance: f64, maps: u64) -> Moments {
    let mut moments = Moments::default();
    for seed in 0..maps {
        let shot = Shooting { photons: 20_000, seed, ..Shooting::default() }.shoot(scene).unwrap();
        let map = PhotonMap::new(scene, shot.photons, gather).unwrap();
        let surface = scene.intersect(&Ray::new(p.extend(0.5), -DVec3::Z)).expect("the floor");
        moments.add(map.irradiance(scene, &surface, DVec3::Z).value.mean() / irradiance);
    }
    moments
}

#[test]
fn edges_are_dark_without_the_correction_and_right_with_it() {
    // Parallel light on a square: a constant field. A black wall stands at one edge, so that there is something to leak.
    let wall = shape("wall", quad([DVec3::ZERO, DVec3::Y, DVec3::new(0.0, 1.0, 1.0), DVec3::Z]), 0);
    let lights = vec![Light::Directional { direction: -DVec3::Z, irradiance: Rgb::WHITE }];
    let scene = build(vec![grey(0.0)], vec![floor(0), wall], lights);
    let near = 1e-6;
    for (p, factor) in [((0.5, 0.5), 1.0), ((near, 0.5), 0.5), ((1.0 - near, 1.0 - near), 0.25)] {
        let p = DVec2::new(p.0, p.1);
        for around in [Around::Nearest { k: 50, reach: f64::INFINITY }, Around::Radius(0.08)] {
            for estimator in [Estimator::KMinusOne, Estimator::Epanechnikov, Estimator::Biweight] {
                let gather = Gather { around, estimator, ..Gather::default() };
                let with = relative(&scene, p, gather, 1.0, 60);
                let without = relative(&scene, p, Gather { edges: false, ..gather }, 1.0, 60);
                // 4.5 sigma of 36 comparisons, the error known from 60 maps.
                assert!((with.mean() - 1.0).abs() <= 4.5 * with.std_err(), "{p} {gather:?}: {with:?}");
                assert!((without.mean() - factor).abs() <= 4.5 * without.std_err(), "{p} {gather:?}: {without:?}");
            }
        }
    }
}

#[test]
fn the_variance_of_an_estimate_is_the_one_that_it_states() {
    let lights = vec![Light::Directional { direction: -DVec3::Z, irradiance: Rgb::WHITE }];
    let scene = build(vec![grey(0.0)], vec![floor(0)], lights);
    let surface = scene.intersect(&Ray::new(DVec3::new(0.4, 0.6, 0.5), -DVec3::Z)).expect("the floor");
    for around in [Around::Nearest { k: 30, reach: f64::INFINITY }, Around::Radius(0.05)] {
        let gather = Gather { around, estimator: Estimator::Epanechnikov, ..Gather::default() };
        let (mut values, mut stated) = (Moments::default(), Moments::default());
        for seed in 0..400 {
            let shot = Shooting { photons: 8_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
            let map = PhotonMap::new(&scene, shot.photons, gather).unwrap();
            let reading = map.irradiance(&scene, &surface, DVec3::Z);
            values.add(reading.value.mean());
            stated.add(reading.variance);
        }
        let ratio = stated.mean() / values.variance();
        // A variance from 400 values is known to 7 %: 4 sigma.
        assert!((ratio - 1.0).abs() <= 0.3, "{around:?}: {ratio}");
    }
}

#[test]
fn the_bias_of_a_bent_field_is_the_one_that_is_stated() {
    // E = I h / (h² + ρ²)^(3/2) under a point; at its foot E = 1 / h² and the mean over a disk of radius R, by integration of
    // w(u) E(√u R), is what an estimate has.
    let (h, radius) = (0.5_f64, 0.2_f64);
    let lights = vec![Light::Point { position: DVec3::new(0.5, 0.5, h), intensity: Rgb::WHITE }];
    let scene = build(vec![grey(0.0)], vec![floor(0)], lights);
    let surface = scene.intersect(&Ray::new(DVec3::new(0.5, 0.5, 0.2), -DVec3::Z)).expect("the floor");
    for estimator in Estimator::ALL {
        let steps = 10_000;
        let exact: f64 = (0..steps)
            .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
            .map(|u| estimator.weight(u) * h * (h * h + u * radius * radius).powf(-1.5) / f64::from(steps))
            .sum();
        let truth = 1.0 / (h * h);
        let gather = Gather { around: Around::Radius(radius), estimator, ..Gather::default() };
        let (mut values, mut stated) = (Moments::default(), Moments::default());
        for seed in 0..60 {
            let shot = Shooting { photons: 40_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
            let reading = PhotonMap::new(&scene, shot.photons, gather).unwrap().irradiance(&scene, &surface, DVec3::Z);
            values.add(reading.value.mean());
            stated.add(reading.bias);
        }
        // 4.5 sigma of 10 comparisons with errors from 60 maps.
        assert!((values.mean() - exact).abs() <= 4.5 * values.std_err(), "{estimator:?}: {} {exact}", values.mean());
        let bias = exact - truth;
        // The next order of the field: R²/h² = .16 of the leading one.
        let gap = (stated.mean() - bias).abs();
        assert!(gap <= 4.5 * stated.std_err() + 0.16 * bias.abs(), "{estimator:?}: {} against {bias}", stated.mean());
        assert!(bias < -0.05 * truth && stated.mean() < 0.0, "there must be a bias to be seen");
    }
}

/// Two rooms under one ceiling and on one floor, with a wall of no thickness between them; the light is in the one at x < 1.
fn two_rooms(wall: bool) -> Scene {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut shapes = vec![
        shape("floor", quad([p(0., 0., 0.), p(2., 0., 0.), p(2., 1., 0.), p(0., 1., 0.)]), 0),
        shape("ceiling", quad([p(0., 0., 1.), p(0., 1., 1.), p(2., 1., 1.), p(2., 0., 1.)]), 0),
        shape("front", quad([p(0., 0., 0.), p(0., 0., 1.), p(2., 0., 1.), p(2., 0., 0.)]), 0),
        shape("back", quad([p(0., 1., 0.), p(2., 1., 0.), p(2., 1., 1.), p(0., 1., 1.)]), 0),
        shape("left", quad([p(0., 0., 0.), p(0., 1., 0.), p(0., 1., 1.), p(0., 0., 1.)]), 0),
        shape("right", quad([p(2., 0., 0.), p(2., 0., 1.), p(2., 1., 1.), p(2., 1., 0.)]), 0),
    ];
    if wall {
        shapes.push(shape("wall", quad([p(1., 0., 0.), p(1., 1., 0.), p(1., 1., 1.), p(1., 0., 1.)]), 0));
    }
    let lights = vec![Light::Point { position: p(0.5, 0.5, 0.6), intensity: Rgb::WHITE }];
    build(vec![grey(0.5).two_sided()], shapes, lights)
}

#[test]
fn a_wall_of_no_thickness_keeps_a_sealed_room_exactly_dark() {
    let scene = two_rooms(true);
    let shot = shoot(&scene, 30_000);
    let rays: Vec<Ray> = (0..400)
        .map(|i| {
            let mut sampler = Independent::at(5, 0, i);
            let (near, dir) = (sampler.next_1d(), crate::sampling::warp::uniform_sphere(sampler.next_2d()));
            // Half of them close to the wall.
            let x = if i % 2 == 0 { 1.0 + 1e-3 + 0.01 * near } else { 1.05 + 0.9 * near };
            Ray::new(DVec3::new(x, 0.5, 0.5), dir)
        })
        .collect();
    let seen = |light: &dyn Radiance| {
        let mut sampler = Independent::new(1);
        rays.iter().map(|ray| light.radiance(&scene, *ray, &mut sampler).max_channel()).fold(0.0, f64::max)
    };
    for around in [Around::Nearest { k: 50, reach: f64::INFINITY }, Around::Radius(0.3)] {
        let gather = Gather { around, ..Gather::default() };
        let map = |gather| PhotonMap::new(&scene, shot.photons.clone(), gather).unwrap();
        assert_eq!(seen(&DirectView::new(map(gather), None)), 0.0, "{around:?}");
        let gathered = FinalGather::new(&scene, shot.clone(), gather, 2, None).unwrap();
        assert_eq!(seen(&gathered), 0.0, "{around:?}");
        // The twin: without the rays that look for walls, the floor lets light through under the wall.
        assert!(seen(&DirectView::new(map(Gather { walls: false, ..gather }), None)) > 0.0);
    }
    let open = two_rooms(false);
    let map = PhotonMap::new(&open, shoot(&open, 30_000).photons, Gather::default()).unwrap();
    let mut sampler = Independent::new(1);
    assert!(DirectView::new(map, None).radiance(&open, rays[1], &mut sampler).max_channel() > 0.0);
}

#[test]
fn a_furnace_is_as_bright_as_it_must_be() {
    // e / (1 − ρ) everywhere, and e (1 + ρ + … + ρʳ) after r reflections, by both views.
    let scene = named("furnace-sphere", &[]);
    for (bounces, exact) in [(None, 1.0), (Some(0), 0.5), (Some(1), 0.75), (Some(3), 0.9375)] {
        let (mut seen, mut gathered) = (Moments::default(), Moments::default());
        for seed in 0..20 {
            let shot = Shooting { photons: 20_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
            let view =
                DirectView::new(PhotonMap::new(&scene, shot.photons.clone(), Gather::default()).unwrap(), bounces);
            let gather = FinalGather::new(&scene, shot, Gather::default(), 2, bounces).unwrap();
            let mut sampler = Independent::new(seed);
            // Means of one map, whose errors are one.
            let (mut of_view, mut of_gather) = (Moments::default(), Moments::default());
            for sample in 0..40 {
                sampler.begin(0, sample);
                let ray = scene.camera_ray(512.0 * sampler.next_2d(), DVec2::ZERO);
                of_view.add(view.radiance(&scene, ray, &mut sampler).mean());
                of_gather.add(gather.radiance(&scene, ray, &mut sampler).mean());
            }
            seen.add(of_view.mean());
            gathered.add(of_gather.mean());
        }
        for moments in [seen, gathered] {
            // 4.5 sigma of 8 comparisons, with the error from 20 maps.
            let gap = (moments.mean() - exact).abs();
            assert!(gap <= 4.5 * moments.std_err() + 1e-12, "{bounces:?}: {} against {exact}", moments.mean());
        }
        // 200 photons of 3 % noise each: half a per cent is a mistake that would be seen.
        assert!(seen.std_err() < 5e-3 && gathered.std_err() < 5e-3);
    }
}

/// Block means of the image by one algorithm.
fn blocks(scene: &Scene, light: &dyn Radiance, samples: u64, seed: u64) -> Vec<Moments> {
    use rayon::prelude::*;
    (0..256_u64)
        .into_par_iter()
        .map(|block| {
            let mut moments = Moments::default();
            let mut sampler = Independent::new(seed);
            for sample in 0..samples {
                sampler.begin(block, sample);
                let at = sampler.next_2d() + DVec2::new((block % 16) as f64, (block / 16) as f64);
                let ray = scene.camera_ray(32.0 * at, DVec2::ZERO);
                moments.add(light.radiance(scene, ray, &mut sampler).mean());
            }
            moments
        })
        .collect()
}

#[test]
fn the_cornell_box_is_that_of_path_tracing() {
    let scene = named("cornell-original", &[]);
    let paths = blocks(&scene, &PathTracer::default(), 3000, 1);
    // Independent maps: the error of one map is common to all of its samples.
    let maps: Vec<Vec<Moments>> = (0..4)
        .map(|seed| {
            let shot = Shooting { photons: 50_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
            let (_, radius) = scene.bounding_sphere();
            let around = Around::Nearest { k: 60, reach: 0.1 * radius };
            let light = FinalGather::new(&scene, shot, Gather { around, ..Gather::default() }, 2, None).unwrap();
            blocks(&scene, &light, 250, seed + 10)
        })
        .collect();
    let (mut gaps, mut total) = (Moments::default(), (0.0, 0.0));
    for (block, path) in paths.iter().enumerate() {
        let photon = maps.iter().map(|map| map[block].mean()).sum::<f64>() / 4.0;
        total = (total.0 + photon, total.1 + path.mean());
        // Blocks on the light have emission alone, and edges are in most others: what is compared is the gap against noise.
        let noise = path.std_err().hypot(maps.iter().map(|map| map[block].std_err()).fold(0.0, f64::hypot) / 4.0);
        let allowed = 0.02 * path.mean() + 4.5 * noise;
        assert!((photon - path.mean()).abs() <= allowed, "block {block}: {photon} against {} ± {noise}", path.mean());
        if path.mean() > 0.0 {
            gaps.add(photon / path.mean() - 1.0);
        }
    }
    // Over the whole image noise is below 3 in a thousand.
    assert!((total.0 / total.1 - 1.0).abs() <= 0.01, "{} of the light", total.0 / total.1);
}

#[test]
fn progressive_maps_of_the_cornell_box_come_to_path_tracing() {
    let scene = named("cornell-original", &[]);
    let paths = blocks(&scene, &PathTracer::default(), 1500, 1);
    let total = |blocks: &[Moments]| blocks.iter().map(Moments::mean).sum::<f64>();
    let shooting = Shooting { photons: 10_000, ..Shooting::default() };
    let plan = Sppm::new(&scene, shooting, (First::Holds(40), Estimator::KMinusOne), ALPHA, None).unwrap();
    let mut means = Moments::default();
    for pass in 0..40 {
        means.add(total(&blocks(&scene, &plan.pass(&scene, pass).unwrap(), 8, pass + 100)) / total(&paths));
    }
    // Noise to 4 sigma; blurred over radii of 3 % of the room, the light of the whole image loses less than 1 % at outlines.
    assert!((means.mean() - 1.0).abs() <= 4.0 * means.std_err() + 0.01, "{means:?}");
    // The twin: direct light counted twice, by photons as well as by connection.
    let twice = Shooting { kept: Kept::Global, ..shooting }.shoot(&scene).unwrap();
    let around = Around::Radius(plan.radius(0));
    let map = PhotonMap::new(&scene, twice.photons, Gather { around, ..Gather::default() }).unwrap();
    let all = total(&blocks(&scene, &DirectView::new(map, None), 100, 5)) / total(&paths);
    let direct =
        total(&blocks(&scene, &PathTracer { bounces: Some(1), ..PathTracer::default() }, 500, 6)) / total(&paths);
    let emitted =
        total(&blocks(&scene, &PathTracer { bounces: Some(0), ..PathTracer::default() }, 500, 7)) / total(&paths);
    assert!((all + direct - emitted - 1.0).abs() > 0.1, "the comparison has lost its power");
}

#[test]
fn glass_makes_caustics_and_stores_nothing() {
    let ball = shape("ball", Geometry::Sphere { centre: DVec3::new(0.5, 0.5, 0.35), radius: 0.2 }, 1);
    let glass = Material::uniform("glass", Box::new(Dielectric::new(1.5).unwrap()));
    let (position, direction) = (DVec3::new(0.5, 0.5, 1.5), -DVec3::Z);
    // Half of the cone meets the ball.
    let lights = vec![Light::Spot { position, direction, intensity: Rgb::WHITE, beam: 0.25, cutoff: 0.25 }];
    let scene = build(vec![grey(0.6), glass], vec![floor(0), ball], lights);
    let all = shoot(&scene, 50_000);
    assert!(all.photons.iter().all(|photon| photon.shape == 0));
    let count = |history| all.photons.iter().filter(|photon| photon.history == history).count();
    for (kept, history) in [(Kept::Caustic, History::Caustic), (Kept::Indirect, History::Indirect)] {
        let shot = Shooting { photons: 50_000, kept, ..Shooting::default() }.shoot(&scene).unwrap();
        assert_eq!(shot.photons.len(), count(history));
        assert!(shot.photons.iter().all(|photon| photon.history == history && photon.bounces > 0));
    }
    assert!(count(History::Caustic) > 1000 && count(History::Direct) > 1000);
    // Under the ball there is no direct light: the spot of the lens is caustic alone.
    let middle = all.photons.iter().filter(|p| p.p.truncate().distance(DVec2::splat(0.5)) < 0.02);
    assert!(middle.clone().count() > 100 && middle.clone().all(|p| p.history != History::Direct));
}

/// A floor, a light above it, and something of glass between or around, with what is known of neither map nor path.
fn under_glass(rho: f64, geometry: Geometry) -> Scene {
    let glass = Material::uniform("glass", Box::new(Dielectric::new(1.5).unwrap()));
    let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    let light = Shape { emission: Some(Rgb::WHITE), ..shape("light", quad(square), 0) };
    build(vec![grey(rho), glass], vec![floor(0), shape("glass", geometry, 1), light], vec![])
}

fn cube(centre: DVec3, half: DVec3) -> Geometry {
    Geometry::Cube { to_world: DAffine3::from_scale_rotation_translation(half, DQuat::IDENTITY, centre) }
}

/// The flux that photons bring to the floor through glass, in units of basic radiance, and the same by paths that find the
/// light by chance.
fn through_glass(scene: &Scene) -> (Moments, Moments) {
    let mut photons = Moments::default();
    for seed in 0..20 {
        let shooting = Shooting { photons: 20_000, kept: Kept::Caustic, seed, ..Shooting::default() };
        let stored = shooting.shoot(scene).unwrap().photons;
        photons.add(stored.iter().filter(|p| p.shape == 0 && p.n.z > 0.0).map(|p| p.flux.mean() * p.basic).sum());
    }
    let tracer =
        PathTracer { strategy: Strategy::Bsdf, roulette: Roulette::Off, bounces: Some(50), ..PathTracer::default() };
    let (mut paths, mut sampler) = (Moments::default(), Independent::new(9));
    for sample in 0..300_000 {
        sampler.begin(0, sample);
        let (at, along) = (sampler.next_2d(), sampler.next_2d());
        let ray = Ray::new(at.extend(1e-9), cosine_hemisphere(along));
        let glass = scene.intersect(&ray).is_some_and(|met| met.shape == 1);
        // E = π times the mean of what arrives by the cosine; the floor's area is 1, and nothing else reflects.
        paths.add(if glass { PI * tracer.radiance(scene, ray, &mut sampler).mean() } else { 0.0 });
    }
    (photons, paths)
}

#[test]
fn light_through_glass_is_that_of_paths() {
    let slab = cube(DVec3::new(0.5, 0.5, 0.5), DVec3::new(0.4, 0.4, 0.1));
    let ball = Geometry::Sphere { centre: DVec3::new(0.5, 0.5, 0.4), radius: 0.3 };
    // The floor itself within the glass: flux is that of basic radiance times η², which is the law.
    let around = cube(DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.6, 0.6, 0.3));
    for (name, geometry) in [("slab", slab), ("ball", ball), ("around", around)] {
        let (photons, paths) = through_glass(&under_glass(0.0, geometry));
        let error = photons.std_err().hypot(paths.std_err());
        let gap = (photons.mean() - paths.mean()).abs();
        // 4 sigma with the error of the photons known from 20 maps.
        assert!(gap <= 4.0 * error, "{name}: photons {} paths {} ± {error}", photons.mean(), paths.mean());
        assert!(error < 0.02 * paths.mean(), "{name}: the test must see 1.5² and Fresnel's 4 %");
    }
}

#[test]
fn a_gather_past_glass_is_that_of_paths() {
    let ball = Geometry::Sphere { centre: DVec3::new(0.5, 0.5, 0.4), radius: 0.3 };
    let scene = under_glass(0.6, ball);
    // From above, past the light, and through the ball.
    let rays = |sampler: &mut Independent| {
        let at = sampler.next_2d() * 0.2 + 0.05;
        let from = DVec3::new(0.9, 0.95, 0.8);
        Ray::new(from, (at.extend(0.0) - from).normalize())
    };
    let mean = |light: &dyn Radiance, seed: u64, samples: u64| {
        let (mut moments, mut sampler) = (Moments::default(), Independent::new(seed));
        for sample in 0..samples {
            sampler.begin(1, sample);
            let ray = rays(&mut sampler);
            moments.add(light.radiance(&scene, ray, &mut sampler).mean());
        }
        moments
    };
    let paths = mean(&PathTracer::default(), 1, 200_000);
    // Without a limit the nearest of a caustic would be looked for where there is none.
    let around = Around::Nearest { k: 50, reach: 0.04 };
    let mut photons = Moments::default();
    for seed in 0..12 {
        let shot = Shooting { photons: 50_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
        let light = FinalGather::new(&scene, shot, Gather { around, ..Gather::default() }, 2, None).unwrap();
        photons.add(mean(&light, seed, 2000).mean());
    }
    let error = photons.std_err().hypot(paths.std_err());
    let gap = (photons.mean() - paths.mean()).abs();
    // 4 sigma of noise; a caustic in the 50 nearest photons is blurred, which moves light and loses none: 1 %.
    assert!(gap <= 4.0 * error + 0.01 * paths.mean(), "{} against {} ± {error}", photons.mean(), paths.mean());
}

#[test]
fn what_cannot_be_is_one_clear_error() {
    let dark = build(vec![grey(0.5)], vec![floor(0)], vec![]);
    assert_eq!(Shooting::default().shoot(&dark).unwrap_err(), PhotonError::NoLight);
    let scene = named("furnace-box", &[]);
    let none = Shooting { photons: 0, ..Shooting::default() };
    assert_eq!(none.shoot(&scene).unwrap_err(), PhotonError::NoPhotons);
    let endless = named("furnace-box", &[("rho", "1")]);
    let few = Shooting { photons: 2000, most: 10_000, ..Shooting::default() };
    assert_eq!(few.shoot(&endless).unwrap_err(), PhotonError::TooMany { most: 10_000 });
    let shot = shoot(&scene, 10);
    let stored = shot.photons.len();
    let map = |around| PhotonMap::new(&scene, shot.photons.clone(), Gather { around, ..Gather::default() });
    let nearest = |k| Around::Nearest { k, reach: f64::INFINITY };
    assert_eq!(map(nearest(1000)).unwrap_err(), PhotonError::TooFew { k: 1000, stored });
    assert!(matches!(map(nearest(1)).unwrap_err(), PhotonError::NoNeighbours { k: 1, least: 2, .. }));
    for radius in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(map(Around::Radius(radius)).unwrap_err(), PhotonError::Radius(radius));
    }
    assert!(map(Around::Radius(f64::NAN)).is_err());
    assert!(FinalGather::new(&scene, shot.clone(), Gather::default(), 0, None).is_err());
}
