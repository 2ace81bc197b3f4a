//! Rooms that are known: sealed ones, and furnaces.

use glam::{DVec2, DVec3};

use super::{build, grey, named, quad, shape, shoot};
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::photon::gather::FinalGather;
use crate::render::photon::map::{Around, Gather, PhotonMap};
use crate::render::photon::shoot::Shooting;
use crate::render::photon::view::DirectView;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{Light, Ray, Scene};

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
        let map = |gather| PhotonMap::new(&scene, &shot.photons, gather).unwrap();
        assert_eq!(seen(&DirectView::new(map(gather), None)), 0.0, "{around:?}");
        let gathered = FinalGather::new(&scene, &shot.photons, gather, 2, None).unwrap();
        assert_eq!(seen(&gathered), 0.0, "{around:?}");
        // The twin: without the rays that look for walls, the floor lets light through under the wall.
        assert!(seen(&DirectView::new(map(Gather { walls: false, ..gather }), None)) > 0.0);
    }
    let open = two_rooms(false);
    let map = PhotonMap::new(&open, &shoot(&open, 30_000).photons, Gather::default()).unwrap();
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
            let view = DirectView::new(PhotonMap::new(&scene, &shot.photons, Gather::default()).unwrap(), bounces);
            let gather = FinalGather::new(&scene, &shot.photons, Gather::default(), 2, bounces).unwrap();
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
