//! Scenes that nobody on this project made, against images that other programs made of them.
//!
//! They are read through `WHITEFURNACE_DATA` and never shipped; without them each test says so and passes.

#![allow(clippy::print_stdout, reason = "figures for the reader")]

mod real_data;

use std::f64::consts::PI;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use statrs::distribution::{ContinuousCDF, Normal};
use whitefurnace::glam::{DVec2, DVec3};
use whitefurnace::image::Image;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::Radiance;
use whitefurnace::render::film::Film;
use whitefurnace::render::path::{PathTracer, Roulette, Strategy};
use whitefurnace::render::progressive::{Job, Stop, render};
use whitefurnace::sampling::filter::Filter;
use whitefurnace::sampling::sampler::{Independent, SamplerKind};
use whitefurnace::scene::file::{LoadOptions, load};
use whitefurnace::scene::{
    Camera, FilmSettings, Geometry, Light, Material, Ray, RenderSettings, Scene, SceneDescription, Shape,
};

use real_data::data;

fn scene(path: &Path, params: &[(&str, &str)]) -> Scene {
    let params = params.iter().map(|(name, value)| ((*name).to_string(), (*value).to_string())).collect();
    let loaded = load(path, &LoadOptions { params, lenient: false }).expect("a scene");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    Scene::new(loaded.scene).expect("a sound scene")
}

fn image(scene: &Scene, tracer: &PathTracer, samples: u64) -> Film {
    image_through(&Filter::BOX, scene, tracer, samples)
}

fn image_through(filter: &Filter, scene: &Scene, tracer: &PathTracer, samples: u64) -> Film {
    let job = Job { scene, radiance: tracer, filter, sampler: &SamplerKind::Independent.sampler(1, samples, 1) };
    let mut film = Film::new(scene.film().width, scene.film().height);
    render(&job, &mut film, Stop::Samples(samples), &AtomicBool::new(false), &mut |_, _| {});
    assert_eq!(film.nonfinite(), 0);
    film
}

/// As the file asks, without roulette.
fn tracer(scene: &Scene) -> PathTracer {
    let bounces = scene.render_settings().bounces.flatten();
    let roulette = if bounces.is_some_and(|r| r < 16) { Roulette::Off } else { Roulette::From(5) };
    PathTracer { bounces, roulette, ..PathTracer::default() }
}

/// Mean and variance of the mean of every block of a 16 x 16 grid, row by row.
fn blocks(film: &Film) -> Vec<(Rgb, Rgb)> {
    let (w, h) = (film.width() / 16, film.height() / 16);
    let pixels = (w * h) as f64;
    let block = |bx: usize, by: usize| {
        let all = || (0..h).flat_map(move |y| (0..w).map(move |x| (bx * w + x, by * h + y)));
        let mean: Rgb = all().map(|(x, y)| film.mean(x, y)).sum();
        let variance: Rgb = all().map(|(x, y)| film.variance_of_mean(x, y)).sum();
        (mean / pixels, variance / (pixels * pixels))
    };
    (0..16).flat_map(|by| (0..16).map(move |bx| (bx, by))).map(|(bx, by)| block(bx, by)).collect()
}

/// The columns of a table of blocks that start with `name`.
fn table(path: &Path, name: &str) -> Vec<Rgb> {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let at = head.iter().position(|column| column.starts_with(name)).expect("the column");
    let numbers = |line: &str| line.split(',').map(|x| x.parse().expect("a number")).collect::<Vec<f64>>();
    lines.map(numbers).map(|row| Rgb::new(row[at], row[at + 1], row[at + 2])).collect()
}

/// Every block within `tol` of the reference, relative, and five standard errors of our own: of 768 normal numbers one
/// exceeds five in one of 2 000 seeds. The mean of the image within `tol / 4` and four of its own.
fn agree(film: &Film, reference: &[Rgb], tol: f64, floor: f64) {
    let ours = blocks(film);
    assert_eq!(ours.len(), reference.len());
    for (at, ((mean, variance), expected)) in ours.iter().zip(reference).enumerate() {
        for ((m, v), e) in mean.to_array().into_iter().zip(variance.to_array()).zip(expected.to_array()) {
            let allowed = tol * e.max(floor) + 5.0 * v.sqrt();
            assert!((m - e).abs() <= allowed, "block {},{}: {m} against {e} ± {allowed}", at / 16, at % 16);
        }
    }
    let n = ours.len() as f64;
    for channel in 0..3 {
        let mean = ours.iter().map(|(mean, _)| mean.to_array()[channel]).sum::<f64>() / n;
        let error = ours.iter().map(|(_, v)| v.to_array()[channel]).sum::<f64>().sqrt() / n;
        let expected = reference.iter().map(|e| e.to_array()[channel]).sum::<f64>() / n;
        assert!((mean - expected).abs() <= 0.25 * tol * expected + 4.0 * error, "{mean} ± {error} against {expected}");
    }
}

#[test]
fn bitterlis_cornell_box_agrees_with_both_references() {
    let Some(path) = data("scenes/bitterli/cornell-box/mitsuba_v3.xml") else { return };
    let Some(blocks) = data("scenes/bitterli/cornell-box/ref_blocks_16x16.csv") else { return };
    let scene = scene(&path, &[]).with_size(128, 128);
    let film = image(&scene, &tracer(&scene), 128);
    for reference in ["tungsten", "mitsuba"] {
        agree(&film, &table(&blocks, reference), 0.01, 0.0);
    }
    // A box one bounce short is seen.
    let short = image(&scene, &PathTracer { bounces: Some(3), ..tracer(&scene) }, 128);
    let refused = std::panic::catch_unwind(|| agree(&short, &table(&blocks, "mitsuba"), 0.01, 0.0));
    assert!(refused.is_err(), "three bounces pass for all");
}

/// At the size and with the filter of the references: an edge between light and shade runs along the border of a block, where
/// a box instead of their tent changes the dark side by 3 %.
///
/// Tungsten's is the less noisy reference. Mitsuba's differs from it by up to 1.9 % itself, in 10 of the 768 numbers by more
/// than 1 %, and so cannot be met within 1 % wherever Tungsten's is; their difference is allowed. So are two of our standard
/// errors, which are .4 % in the darkest blocks.
#[test]
#[ignore = "minutes"]
fn bitterlis_cornell_box_agrees_within_one_per_cent() {
    let Some(path) = data("scenes/bitterli/cornell-box/mitsuba_v3.xml") else { return };
    let Some(csv) = data("scenes/bitterli/cornell-box/ref_blocks_16x16.csv") else { return };
    let scene = scene(&path, &[]).with_size(1024, 1024);
    let filter: Filter = "tent".parse().expect("a filter");
    let tracer = PathTracer { roulette: Roulette::Off, ..tracer(&scene) };
    let ours = blocks(&image_through(&filter, &scene, &tracer, 256));
    let (tungsten, mitsuba) = (table(&csv, "tungsten"), table(&csv, "mitsuba"));
    for (name, reference) in [("tungsten", &tungsten), ("mitsuba", &mitsuba)] {
        let (mut worst, mut beyond) = (0.0_f64, 0);
        for (at, (mean, variance)) in ours.iter().enumerate() {
            let e = reference[at].0;
            let gap = (mean.0 - e).abs() / e;
            let apart = (tungsten[at].0 - e).abs() / e;
            let allowed = apart + 2.0 * variance.0.map(f64::sqrt) / e + 0.01;
            assert!(gap.cmple(allowed).all(), "{name}, block {},{}: {gap} of {allowed}", at / 16, at % 16);
            worst = worst.max(gap.max_element());
            beyond += gap.cmpgt(DVec3::splat(0.01)).bitmask().count_ones();
        }
        println!("{name}: worst block {:.3} %, {beyond} of 768 numbers beyond 1 %", 100.0 * worst);
    }
}

#[test]
fn veach_mis_agrees_at_direct_light() {
    let Some(blocks) = data("scenes/bitterli/veach-mis/ref_blocks_16x16.csv") else { return };
    for (file, params) in [("mitsuba_v3.xml", &[("integrator", "path")][..]), ("mitsuba_v05.xml", &[])] {
        let Some(path) = data(&format!("scenes/bitterli/veach-mis/{file}")) else { return };
        let scene = scene(&path, params).with_size(256, 144);
        let direct = PathTracer { bounces: Some(1), ..tracer(&scene) };
        // The reference was filtered by a tent of its own, finer pixels: edges of lamps cross the borders of blocks.
        agree(&image(&scene, &direct, 64), &table(&blocks, "tungsten"), 0.02, 0.05);
    }
}

/// Mitsuba's own z-test: of all pixels and channels 99.75 % have a p-value above the Šidák level of 1 %.
///
/// The variances that come with the references were transformed like colours, so that in saturated channels they are
/// differences and often negative, where Mitsuba takes 1e-4. Ours counts where it is the larger one.
fn z_test(film: &Film, reference: &Image, per_sample: &Image) -> f64 {
    let count = (film.width() * film.height() * 3) as f64;
    let level = 1.0 - (1.0_f64 - 0.01).powf(1.0 / count);
    let mut passed = 0.0;
    for y in 0..film.height() {
        for x in 0..film.width() {
            let (pixel, r, theirs) = (film.pixel(x, y), reference.rgb(x, y), per_sample.rgb(x, y));
            let (m, ours) = (pixel.mean().to_array(), pixel.variance_of_mean().to_array());
            for channel in 0..3 {
                let theirs = f64::from(theirs[channel]).max(1e-4) / pixel.n as f64;
                let z = (m[channel] - f64::from(r[channel])).abs() / theirs.max(ours[channel]).sqrt();
                passed += f64::from(u8::from(2.0 * Normal::standard().sf(z) > level));
            }
        }
    }
    passed / count
}

#[test]
fn mitsubas_test_scenes_pass_its_z_test() {
    const SAMPLES: u64 = 256;
    let scenes = [
        ("bsdf_spheres/test_constant_path", "test_constant"),
        ("bsdf_spheres/test_arealight_path", "test_arealight"),
        ("bsdf_spheres/test_pointlight_path", "test_pointlight"),
        ("floating_sphere/test_directional_direct", "test_directional"),
        ("infinite_mirrors/scene_path", "scene"),
        ("orthographic_sensor/test_orthographic_path", "test_orthographic"),
    ];
    let mut failed = Vec::new();
    for (file, name) in scenes {
        let Some(path) = data(&format!("scenes/mitsuba/tests/scenes/{file}.xml")) else { return };
        let refs = path.with_file_name("refs");
        let read = |end: &str| Image::read(&refs.join(format!("{name}_ref_rgb{end}.exr"))).expect("a reference");
        let (reference, variance) = (read(""), read("_var"));
        let scene = scene(&path, &[]);
        assert_eq!((scene.film().width, scene.film().height), (reference.width(), reference.height()), "{file}");
        let film = image(&scene, &tracer(&scene), SAMPLES);
        let share = z_test(&film, &reference, &variance);
        println!("{file}: {:.3} % pass", 100.0 * share);
        if share < 0.9975 || share.is_nan() {
            failed.push((file, share));
        }
        // The test sees an image that is a tenth too bright.
        let mut brighter = film.clone();
        brighter.pixels_mut().iter_mut().for_each(|pixel| pixel.mean *= 1.1);
        let share = z_test(&brighter, &reference, &variance);
        assert!(share < 0.9975, "{file}: the test is blind, {share}");
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn ignis_scenes_hold() {
    let albedo = Rgb::new(0.885809, 0.698859, 0.666422);
    let Some(path) = data("scenes/ignis/mitsuba/point.xml") else { return };
    let point = scene(&path, &[]);
    for (x, y) in [(128, 200), (100, 220), (160, 240)] {
        let ray = point.camera_ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), DVec2::ZERO);
        let surface = point.intersect(&ray).expect("the floor");
        // The light is at (0, 1, 0), of intensity 1.
        let way = DVec3::Y - surface.p;
        let cos = way.normalize().dot(surface.ng).abs();
        let expected = albedo * (cos / (PI * way.length_squared()));
        let seen = along(&point, ray);
        let gap = (seen - expected).0.abs().max_element();
        assert!(gap <= 1e-3 * expected.max_channel(), "pixel {x},{y}: {seen} against {expected}");
    }
    let published = Rgb::new(0.06906, 0.05448, 0.05196);
    let ray = point.camera_ray(DVec2::new(128.5, 200.5), DVec2::ZERO);
    // Five digits are given of a value that varies by 1e-4 over the pixel.
    assert!((along(&point, ray) - published).0.abs().max_element() < 1e-4);
    let Some(path) = data("scenes/ignis/mitsuba/emissive-plane.xml") else { return };
    let Some(csv) = data("scenes/ignis/ref_blocks_16x16.csv") else { return };
    let plane = scene(&path, &[]).with_size(64, 64);
    let mut film = image(&plane, &tracer(&plane), 128);
    // The file's light is a spectrum of 1. Mitsuba 3 takes that for the white of illuminant E, which in Rec.709, whose
    // white is D65, is this colour; Ignis takes it for 1.
    let white = DVec3::new(1.204793, 0.948297, 0.908916);
    for pixel in film.pixels_mut() {
        (pixel.mean, pixel.m2) = (pixel.mean / white, pixel.m2 / (white * white));
    }
    agree(&film, &table(&csv, "emissive-plane"), 0.005, 0.05);
    let Some(path) = data("scenes/ignis/mitsuba/plane.xml") else { return };
    let floor = scene(&path, &[]).with_size(128, 128);
    // Rendered spectrally: 1 %.
    agree(&image(&floor, &tracer(&floor), 64), &table(&csv, "plane-d6"), 0.01, 0.05);
}

/// The radiance along a ray under lights that leave no choice.
fn along(scene: &Scene, ray: Ray) -> Rgb {
    let mut sampler = Independent::new(1);
    tracer(scene).radiance(scene, ray, &mut sampler)
}

#[test]
fn the_furnace_of_the_shading_language_reads_one_half() {
    // A white sphere of radius 30 in a sky of 1/2, seen from (0, 100, 300).
    let scene = Scene::new(SceneDescription {
        name: "furnace-diffuse".into(),
        camera: Camera::look_at(DVec3::new(0.0, 100.0, 300.0), DVec3::ZERO, DVec3::Y, 70.0),
        film: FilmSettings { width: 64, height: 48, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials: vec![Material::diffuse("white", Rgb::WHITE.into())],
        shapes: vec![Shape {
            name: "sphere".into(),
            geometry: Geometry::Sphere { centre: DVec3::ZERO, radius: 30.0 },
            flip_normals: false,
            material: 0,
            emission: None,
        }],
        lights: vec![Light::Constant { radiance: Rgb::grey(0.5) }],
    })
    .expect("a scene");
    let exact = PathTracer { strategy: Strategy::Bsdf, bounces: Some(4), ..PathTracer::default() };
    let film = image(&scene, &exact, 4);
    for pixel in film.pixels() {
        // No variance: a few roundings.
        assert!((pixel.mean - 0.5).abs().max_element() < 1e-14, "{}", pixel.mean);
    }
}
