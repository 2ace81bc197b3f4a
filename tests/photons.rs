//! Photon maps of whole scenes against path tracing.

#![allow(clippy::print_stdout, reason = "figures for the reader")]

use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;
use whitefurnace::bsdf::Dielectric;
use whitefurnace::glam::{DVec2, DVec3};
use whitefurnace::math::color::Rgb;
use whitefurnace::math::power_law;
use whitefurnace::math::sum::Moments;
use whitefurnace::render::Radiance;
use whitefurnace::render::film::Film;
use whitefurnace::render::path::{PathTracer, Roulette, Strategy};
use whitefurnace::render::photon::Kept;
use whitefurnace::render::photon::gather::FinalGather;
use whitefurnace::render::photon::kernel::Estimator;
use whitefurnace::render::photon::map::{Around, Gather};
use whitefurnace::render::photon::progressive::{ALPHA, First, Sppm};
use whitefurnace::render::photon::shoot::Shooting;
use whitefurnace::render::progressive::{Job, Stop, render};
use whitefurnace::sampling::filter::Filter;
use whitefurnace::sampling::sampler::{Independent, Sampler, SamplerKind};
use whitefurnace::sampling::warp::cosine_hemisphere;
use whitefurnace::scene::builtin::builtin;
use whitefurnace::scene::{Geometry, Material, Ray, Scene, SceneDescription, Shape, Surface};

const BOXES: [&str; 2] = ["cornell-original", "cornell-bitterli"];
/// Pixels of an image, and of a block, along a side.
const SIDE: usize = 128;
const BLOCK: usize = 16;

fn description(name: &str) -> SceneDescription {
    builtin(name, &[]).expect("a built-in scene").expect("its defaults")
}

fn image(scene: &Scene, radiance: &dyn Radiance, samples: u64, seed: u64) -> Film {
    let sampler = SamplerKind::default().sampler(seed, samples, SIDE as u64);
    let job = Job { scene, radiance, filter: &Filter::BOX, sampler: &sampler };
    let mut film = Film::new(SIDE, SIDE);
    render(&job, &mut film, Stop::Samples(samples), &AtomicBool::new(false), &mut |_, _| {});
    film
}

/// The surface in the middle of a pixel.
fn seen(scene: &Scene, x: usize, y: usize) -> Option<Surface> {
    scene.intersect(&scene.camera_ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), DVec2::ZERO))
}

/// The pixels of a block.
fn pixels(block: usize) -> impl Iterator<Item = (usize, usize)> {
    let (x, y) = (block % (SIDE / BLOCK) * BLOCK, block / (SIDE / BLOCK) * BLOCK);
    (y..y + BLOCK).flat_map(move |y| (x..x + BLOCK).map(move |x| (x, y)))
}

/// Whether all of a block is one flat side of one shape.
fn is_without_edges(scene: &Scene, block: usize) -> bool {
    let sides: Option<Vec<(usize, DVec3)>> =
        pixels(block).map(|(x, y)| seen(scene, x, y).map(|surface| (surface.shape, surface.ng))).collect();
    sides.is_some_and(|sides| sides.iter().all(|(shape, n)| *shape == sides[0].0 && n.dot(sides[0].1) > 0.999))
}

/// Mean of a block, and its standard error.
fn mean(film: &Film, block: usize) -> (f64, f64) {
    let (sum, variance) = pixels(block).fold((0.0, 0.0), |(sum, variance), (x, y)| {
        (sum + film.mean(x, y).mean(), variance + film.variance_of_mean(x, y).mean())
    });
    let count = (BLOCK * BLOCK) as f64;
    (sum / count, variance.sqrt() / count)
}

/// The largest gap of blocks relative to what is allowed: a hundredth, and twice that where the image has edges; of noise
/// one standard error of independent samples, which those of a lattice keep below. With the largest gap itself of blocks that
/// are known to a hundredth, without and with edges.
fn gaps(scene: &Scene, photons: &Film, paths: &Film) -> (f64, [f64; 2]) {
    let (mut excess, mut largest) = (0.0_f64, [0.0_f64; 2]);
    for block in 0..(SIDE / BLOCK).pow(2) {
        let edges = usize::from(!is_without_edges(scene, block));
        let ((photon, a), (path, b)) = (mean(photons, block), mean(paths, block));
        let (gap, noise) = ((photon / path - 1.0).abs(), a.hypot(b) / path);
        let share = gap / ([0.01, 0.02][edges] + noise);
        excess = if share.is_nan() { f64::INFINITY } else { excess.max(share) };
        if noise < 0.01 {
            largest[edges] = largest[edges].max(gap);
        }
    }
    (excess, largest)
}

#[test]
fn a_final_gather_is_within_a_hundredth_of_path_tracing() {
    for name in BOXES {
        let scene = Scene::new(description(name)).expect("a scene").with_size(SIDE, SIDE);
        let paths = image(&scene, &PathTracer::default(), 512, 1);
        let shot = Shooting { photons: 1_000_000, ..Shooting::default() }.shoot(&scene).expect("light");
        let around = Around::Nearest { k: 100, reach: 0.1 * scene.bounding_sphere().1 };
        let gather = Gather { around, ..Gather::default() };
        let seen = |photons: &[_], samples| {
            let light = FinalGather::new(&scene, photons, gather, 4, None).expect("photons");
            gaps(&scene, &image(&scene, &light, samples, 2), &paths)
        };
        let (excess, [smooth, edges]) = seen(&shot.photons, 32);
        println!("{name}: {excess:.2} of what is allowed; blocks known to .01: {smooth:.4}, with edges {edges:.4}");
        assert!(excess <= 1.0 && smooth > 0.0, "{name}: {excess}");
        // The twin: a tenth of the photons is lost, which so few samples can tell.
        let (excess, _) = seen(&shot.photons[shot.photons.len() / 10..], 4);
        assert!(excess > 1.0, "{name}: the comparison has lost its power, {excess}");
    }
}

/// Points in the middle of 16 x 16 parts of the image, and towards where they are seen from.
fn places(scene: &Scene) -> Vec<(Surface, DVec3)> {
    let middle = |i: usize| i * SIDE / 16 + SIDE / 32;
    let all = (0..256).filter_map(|i| {
        let ray = scene.camera_ray(DVec2::new(middle(i % 16) as f64, middle(i / 16) as f64), DVec2::ZERO);
        scene.intersect(&ray).map(|surface| (surface, -ray.dir))
    });
    all.collect()
}

/// Irradiance of light that was reflected before, by paths, with its standard error.
fn by_paths(scene: &Scene, (surface, towards): &(Surface, DVec3), seed: u64) -> Moments {
    let n = if surface.ng.dot(*towards) > 0.0 { surface.ng } else { -surface.ng };
    let frame = whitefurnace::math::frame::Frame::about(n);
    let tracer = PathTracer::default();
    let (mut moments, mut sampler) = (Moments::default(), Independent::new(7));
    for sample in 0..8000 {
        sampler.begin(seed, sample);
        let ray = scene.leave(surface, frame.to_world(cosine_hemisphere(sampler.next_2d())));
        let all = tracer.radiance(scene, ray, &mut sampler);
        let straight = scene
            .intersect(&ray)
            .and_then(|met| scene.emitters().emitted(&met, -ray.dir))
            .map_or(Rgb::BLACK, |(_, radiance)| radiance);
        moments.add(PI * (all - straight).mean());
    }
    moments
}

#[test]
fn progressive_maps_converge_to_path_tracing_by_their_law() {
    const COUNTS: [u64; 4] = [4, 16, 64, 256];
    for name in BOXES {
        let scene = Scene::new(description(name)).unwrap().with_size(SIDE, SIDE);
        let places = places(&scene);
        let exact: Vec<Moments> =
            places.par_iter().enumerate().map(|(i, place)| by_paths(&scene, place, i as u64)).collect();
        let noise: f64 = exact.iter().map(|e| e.std_err().powi(2)).sum();
        for alpha in [ALPHA, 0.999] {
            let mut squares = [0.0_f64; 4];
            for seed in 0..4 {
                let shooting = Shooting { photons: 4000, seed, ..Shooting::default() };
                let how = (First::Holds(3), Estimator::KMinusOne);
                let plan = Sppm::new(&scene, shooting, how, alpha, None).unwrap();
                let mut sums = vec![0.0; places.len()];
                for pass in 0..COUNTS[3] {
                    let light = plan.pass(&scene, pass).unwrap();
                    for (sum, (surface, towards)) in sums.iter_mut().zip(&places) {
                        *sum += light.map().irradiance(&scene, surface, *towards).value.mean();
                    }
                    if let Some(at) = COUNTS.iter().position(|&n| n == pass + 1) {
                        let error = |(sum, exact): (&f64, &Moments)| (sum / (pass + 1) as f64 - exact.mean()).powi(2);
                        squares[at] += sums.iter().zip(&exact).map(error).sum::<f64>() - noise;
                    }
                }
            }
            let points: Vec<_> = COUNTS.iter().zip(squares).map(|(&n, s)| (n as f64, s.sqrt())).collect();
            let [slope, _] = power_law::exponent(&points).expect("errors above the noise of the paths");
            println!("{name}, alpha {alpha}: slope {slope:.4}, squares {squares:?}, of the paths {noise:.3e}");
            assert!(squares[3] > 10.0 * noise, "{name}: the paths must be known better");
            // The slopes of four seeds differ by about .02; the twin has radii that hardly fall.
            assert_eq!((slope + 1.0 / 3.0).abs() <= 0.05, alpha == ALPHA, "{name}, alpha {alpha}: {slope}");
        }
    }
}

/// The Cornell box with a ball of glass in place of its blocks, its walls as they are or black.
fn with_glass(radius: f64, black: bool) -> Scene {
    let mut scene = description("cornell-original");
    scene.shapes.retain(|shape| !shape.name.contains("block"));
    if black {
        for material in &mut scene.materials {
            *material = Material::diffuse("black", Rgb::BLACK.into());
        }
    }
    scene.materials.push(Material::uniform("glass", Box::new(Dielectric::new(1.5).expect("an index"))));
    let geometry = Geometry::Sphere { centre: DVec3::new(200.0, radius, 250.0), radius };
    let material = scene.materials.len() - 1;
    scene.shapes.push(Shape { name: "ball".into(), geometry, flip_normals: false, material, emission: None });
    Scene::new(scene).expect("a scene")
}

/// The number of the floor.
fn floor(scene: &Scene) -> usize {
    scene.shapes().iter().position(|shape| shape.name == "floor").expect("a floor")
}

/// Flux that photons bring to the floor past the ball.
fn caustic_by_photons(scene: &Scene) -> Moments {
    let floor = floor(scene);
    let mut photons = Moments::default();
    for seed in 0..20 {
        let shooting = Shooting { photons: 100_000, kept: Kept::Caustic, seed, ..Shooting::default() };
        let stored = shooting.shoot(scene).expect("light").photons;
        photons.add(stored.iter().filter(|p| p.shape as usize == floor).map(|p| p.flux.mean()).sum());
    }
    photons
}

/// The same by paths from the floor without direct light, in a box that reflects nothing else: what arrives past the ball.
fn caustic_by_paths(dark: &Scene) -> Moments {
    let (floor, ball) = (floor(dark), dark.shapes().len() - 1);
    let tracer =
        PathTracer { strategy: Strategy::Bsdf, roulette: Roulette::Off, bounces: Some(64), ..PathTracer::default() };
    // The floor is a quadrangle in a plane: points of the rectangle around it, and those of it count.
    let [width, depth] = [552.8, 559.2];
    let batches: Vec<Moments> = (0..64)
        .into_par_iter()
        .map(|batch| {
            let (mut moments, mut sampler) = (Moments::default(), Independent::new(3));
            for sample in 0..150_000 {
                sampler.begin(batch, sample);
                let (at, along) = (sampler.next_2d(), sampler.next_2d());
                // Below the ball, which touches the floor.
                let from = DVec3::new(at.x * width, 1e-4, at.y * depth);
                let surface = dark.intersect(&Ray::new(from, -DVec3::Y)).filter(|met| met.shape == floor);
                let flux = surface.map_or(0.0, |surface| {
                    let w = cosine_hemisphere(along);
                    let ray = dark.leave(&surface, DVec3::new(w.x, w.z, w.y));
                    let glass = dark.intersect(&ray).is_some_and(|met| met.shape == ball);
                    if glass { PI * width * depth * tracer.radiance(dark, ray, &mut sampler).mean() } else { 0.0 }
                });
                moments.add(flux);
            }
            moments
        })
        .collect();
    batches.iter().fold(Moments::default(), |sum, batch| sum.merge(batch))
}

#[test]
fn the_caustic_of_a_glass_ball_on_the_cornell_floor_has_the_flux_of_paths() {
    let photons = caustic_by_photons(&with_glass(100.0, false));
    let paths = caustic_by_paths(&with_glass(100.0, true));
    let sigmas = |photons: &Moments| (photons.mean() - paths.mean()).abs() / photons.std_err().hypot(paths.std_err());
    println!("photons {} ± {}, paths {} ± {}", photons.mean(), photons.std_err(), paths.mean(), paths.std_err());
    assert!(sigmas(&photons) <= 3.0, "{photons:?} {paths:?}");
    // The twin: a ball a twentieth smaller, which a tenth less light meets.
    assert!(sigmas(&caustic_by_photons(&with_glass(95.0, false))) > 3.0, "the comparison has lost its power");
}
