//! What leaves the lights, and where it goes.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::{build, floor, grey, named, quad, shape, shoot};
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::photon::gather::FinalGather;
use crate::render::photon::map::{Gather, PhotonMap};
use crate::render::photon::shoot::{Shooting, Shot};
use crate::render::photon::view::DirectView;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{EnvironmentMap, Geometry, Light, LightSampling, Mesh, Ray, Scene, Shape, Sought};

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
                let light = FinalGather::new(&scene, &shot.photons, Gather::default(), 2, None).unwrap();
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

#[test]
fn a_mask_hides_as_much_light_from_the_map_as_from_paths() {
    // Parallel light on a floor that is half there: half of ρ E / π is seen, by a map that holds what met the floor.
    let lights = vec![Light::Directional { direction: -DVec3::Z, irradiance: Rgb::WHITE }];
    let masked = grey(0.6).with_opacity(Rgb::grey(0.5).into());
    let scene = build(vec![masked], vec![floor(0)], lights);
    let mut moments = Moments::default();
    for seed in 0..40 {
        let photons = Shooting { photons: 5000, seed, ..Shooting::default() }.shoot(&scene).unwrap().photons;
        let view = DirectView::new(PhotonMap::new(&scene, &photons, Gather::default()).unwrap(), None);
        let mut sampler = Independent::new(seed);
        let seen = |sample| {
            sampler.begin(0, sample);
            view.radiance(&scene, Ray::new(DVec3::new(0.4, 0.5, 1.0), -DVec3::Z), &mut sampler).mean()
        };
        moments.add((0..100).map(seen).sum::<f64>() / 100.0);
    }
    let exact = 0.5 * 0.6 / PI;
    // 4 sigma, of which each map has 14 % and its hundred samples 10.
    assert!((moments.mean() - exact).abs() <= 4.0 * moments.std_err(), "{moments:?} against {exact}");
    assert!(moments.std_err() < 0.05 * exact);
}
