//! What must not matter: units of light and of length, and which of two patches is the eye. And a negative control.

use crate::common::{Family, STRATEGIES, anywhere, diffuse, facing, named, radiosity, scene, shape, towards, tracer};
use whitefurnace::glam::{DAffine3, DVec3};
use whitefurnace::integrate::Estimate;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::path::{PathTracer, Roulette, Strategy};
use whitefurnace::render::probe::Probe;
use whitefurnace::sampling::sampler::Sampler;
use whitefurnace::scene::{Geometry, Ray, Scene};

const SAMPLES: u64 = 30_000;

#[test]
fn the_unit_of_light_and_of_length_do_not_matter() {
    let tracer = PathTracer::default();
    let run = |size: f64, brightness: f64| {
        let mut wall = shape("wall", Geometry::Cube { to_world: DAffine3::from_scale(DVec3::splat(size)) }, 0, None);
        wall.flip_normals = true;
        let block = facing(DVec3::new(0.2, -0.1, -0.6) * size, DVec3::new(0.1, 0.7, 0.7).normalize(), 0.3 * size);
        let lamp = facing(DVec3::new(0.0, 0.1, 0.9) * size, DVec3::NEG_Z, 0.25 * size);
        let room = scene(
            vec![diffuse(0.6), diffuse(0.2)],
            vec![
                wall,
                shape("block", Geometry::Cube { to_world: block }, 1, None),
                shape("lamp", Geometry::Disk { to_world: lamp }, 1, Some(brightness)),
            ],
            vec![],
        );
        let probe = Probe { seed: 1, number: 3200, samples: 20_000 };
        probe.estimate(&tracer, &room, &|s| Ray::new(DVec3::new(-0.5, 0.5, 0.0) * size, anywhere(s.next_2d())))[0]
    };
    let reference = run(1.0, 1.0);
    // Powers of two are exact: the same bits.
    assert_eq!(run(1.0, 1024.0).mean(), 1024.0 * reference.mean());
    for size in [1e-3, 550.0, 1e6] {
        // The same random numbers, rounded elsewhere: single paths may part at an edge, one in a million at most.
        let gap = (run(size, 1.0).mean() / reference.mean() - 1.0).abs();
        assert!(gap < 1e-4, "size {size}: {gap}");
    }
}

#[test]
fn eye_and_light_may_be_swapped() {
    let mut family = Family::default();
    // A diffuse box with a block that hides much of one patch from the other; each is of its own size.
    let patches = [
        facing(DVec3::new(-0.4, 0.2, -0.95), DVec3::Z, 0.3),
        facing(DVec3::new(0.95, 0.3, 0.4), DVec3::new(-1.0, 0.0, 0.0), 0.15),
    ];
    let room = |lit: usize| {
        let mut wall = shape("wall", Geometry::Cube { to_world: DAffine3::IDENTITY }, 0, None);
        wall.flip_normals = true;
        let block = facing(DVec3::new(0.3, 0.2, -0.2), DVec3::new(0.6, 0.0, 0.8), 0.25);
        let patch =
            |i: usize| shape("patch", Geometry::Rectangle { to_world: patches[i] }, 1, (i == lit).then_some(1.0));
        scene(
            vec![diffuse(0.7), diffuse(0.4)],
            vec![wall, shape("block", Geometry::Cube { to_world: block }, 1, None), patch(0), patch(1)],
            vec![],
        )
    };
    // Flux that one patch receives from the other, by rays that leave it with the density of the cosine.
    let received = |number, lit: usize, tracer: &PathTracer| {
        let dark = 1 - lit;
        let scene = room(lit);
        let b = radiosity(number, 100_000, tracer, &scene, &|s| {
            let on = 2.0 * s.next_2d() - 1.0;
            let to_world = patches[dark];
            let frame = to_world.matrix3 * (1.0 / to_world.matrix3.x_axis.length());
            let dir = frame * whitefurnace::sampling::warp::cosine_hemisphere(s.next_2d());
            Ray::new(to_world.transform_point3(DVec3::new(on.x, on.y, 0.0)) + 1e-9 * frame.z_axis, dir.normalize())
        });
        let area = 4.0 * patches[dark].matrix3.x_axis.length_squared();
        Estimate { mean: area * b.mean, std_err: area * b.std_err, n: b.n }
    };
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        for (j, bounces) in [Some(0), Some(1), Some(3), None].into_iter().enumerate() {
            let tracer = tracer(strategy, bounces);
            let number = 3300 + 20 * k as u64 + 2 * j as u64;
            let (there, back) = (received(number, 0, &tracer), received(number + 1, 1, &tracer));
            let gap = Estimate { mean: there.mean - back.mean, std_err: there.std_err.hypot(back.std_err), n: there.n };
            family.add(format!("{strategy:?} {bounces:?}: {} and {}", there.mean, back.mean), gap, 0.0, 0.0);
        }
    }
    family.judge();
}

#[test]
fn a_wrong_roulette_weight_would_be_seen() {
    // The negative control of every comparison above: paths that go on without being weighed up lose light.
    #[derive(Debug)]
    struct Unweighted;
    impl whitefurnace::render::Radiance for Unweighted {
        fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
            let bounces = if sampler.next_1d() < 0.9 { Some(3) } else { Some(2) };
            PathTracer { bounces, roulette: Roulette::Off, ..tracer(Strategy::Mis, None) }.radiance(scene, ray, sampler)
        }
    }
    let scene = named("cube-one-emitter", &["rho=0.5"]);
    let b = radiosity(3400, SAMPLES, &Unweighted, &scene, &|s| {
        towards(DVec3::new(0.4, 0.5, 0.55), DVec3::Z, DVec3::X, DVec3::Y, s.next_2d())
    });
    let mut family = Family::default();
    family.add("top", b, 0.151010, 5e-7);
    assert!(std::panic::catch_unwind(|| family.judge()).is_err(), "{b:?}");
}
