//! Scene files that users have: real ones, where the data is at hand.

#![allow(clippy::print_stderr, reason = "figures for the reader")]

mod real_data;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use whitefurnace::glam;
use whitefurnace::math::color::Rgb;
use whitefurnace::scene::file::{LoadOptions, Loaded, SceneError, load};
use whitefurnace::scene::{Geometry, Light, Mesh, Projection, SceneDescription, Shape};

use real_data::data;

/// The folder of real scenes.
fn scenes() -> Option<PathBuf> {
    data("scenes")
}

/// What `path` describes, if nothing in it is amiss.
fn strictly(path: &Path) -> Result<Loaded, SceneError> {
    load(path, &LoadOptions::default())
}

fn leniently(path: &Path) -> Result<Loaded, SceneError> {
    load(path, &LoadOptions { lenient: true, ..LoadOptions::default() })
}

fn mesh(shape: &Shape) -> &Mesh {
    match &shape.geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{} is {other:?}", shape.name),
    }
}

/// The reflectance of a diffuse material at the normal.
fn diffuse(scene: &SceneDescription, shape: &Shape) -> Rgb {
    let material = scene.materials[shape.material].at(DVec2::splat(0.5), Rgb::WHITE);
    material.eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI
}

fn near(a: Rgb, b: [f64; 3], relative: f64) -> bool {
    a.to_array().iter().zip(b).all(|(a, b)| (a - b).abs() <= relative * b.abs())
}

#[test]
fn bitterli_scenes_in_both_spellings() {
    let Some(scenes) = scenes() else { return };
    let cornell = strictly(&scenes.join("bitterli/cornell-box/mitsuba_v3.xml")).unwrap();
    assert_eq!(cornell.warnings, [""; 0]);
    assert_eq!((cornell.scene.film.width, cornell.scene.film.height), (1024, 1024));
    assert_eq!((cornell.scene.shapes.len(), cornell.scene.materials.len()), (8, 8));
    assert_eq!(cornell.scene.render.bounces, Some(Some(64)));
    let edited = scenes.join("bitterli/cornell-box/mitsuba_v3_user_edited.xml");
    assert!(strictly(&edited).is_err());
    let edited = leniently(&edited).unwrap();
    assert_eq!(edited.warnings.len(), 1, "{:?}", edited.warnings);
    let shapes = |scene: &SceneDescription| {
        // Names apart.
        let plain = |s: &Shape| format!("{:?} {} {:?}", s.geometry, s.material, s.emission);
        scene.shapes.iter().map(plain).collect::<Vec<_>>()
    };
    assert_eq!(shapes(&edited.scene), shapes(&cornell.scene));
    let old = strictly(&scenes.join("bitterli/veach-mis/mitsuba_v05.xml")).unwrap().scene;
    // The file's own integrator is not ours, which is an error; from outside, another can be named.
    let path = scenes.join("bitterli/veach-mis/mitsuba_v3.xml");
    let error = strictly(&path).unwrap_err().to_string();
    assert!(error.contains("line 8: <integrator type=\"path_guiding_integrator\">"), "{error}");
    let params = vec![("integrator".to_string(), "path".to_string())];
    let new = load(&path, &LoadOptions { params, lenient: false }).unwrap().scene;
    assert_eq!(shapes(&old), shapes(&new));
    assert_eq!(format!("{:?}", old.camera), format!("{:?}", new.camera));
}

#[test]
fn the_six_mitsuba_tests() {
    let Some(scenes) = scenes() else { return };
    let tests = scenes.join("mitsuba/tests/scenes");
    let read = |name: &str| {
        let loaded = strictly(&tests.join(name)).unwrap();
        assert_eq!(loaded.warnings, [""; 0], "{name}");
        loaded.scene
    };
    for light in ["constant", "pointlight", "arealight"] {
        let scene = read(&format!("bsdf_spheres/test_{light}_path.xml"));
        let lamps = usize::from(light == "arealight");
        assert_eq!((scene.shapes.len(), scene.lights.len()), (12 + lamps, 1 - lamps));
        assert_eq!(scene.render.bounces, Some(Some(1)));
        let spheres = scene.shapes.iter().filter(|shape| shape.name.starts_with("sphere"));
        assert!(spheres.clone().count() == 10 && spheres.clone().all(|s| mesh(s).triangles().len() > 1000));
        if lamps == 1 {
            // Mitsuba 3.9.1 has this radiance in scalar_rgb; its matrix from XYZ has other digits.
            assert!(near(scene.shapes[0].emission.unwrap(), [20.7108, 10.8546, 2.77115], 3e-4));
        }
    }
    let mirrors = read("infinite_mirrors/scene_path.xml");
    let [Light::Environment(map)] = mirrors.lights.as_slice() else { panic!("{:?}", mirrors.lights.len()) };
    assert_eq!((map.width, map.height, map.pixels.len()), (512, 256, 512 * 256));
    let sphere = read("floating_sphere/test_directional_direct.xml");
    let Projection::Perspective { tan_half_x } = sphere.camera.projection else { panic!() };
    // 50 mm lens on 36 × 24 mm, square image: 43.27 mm of diagonal.
    assert!((tan_half_x - 1872_f64.sqrt() / 100.0 / 2_f64.sqrt()).abs() < 1e-12);
    let orthographic = read("orthographic_sensor/test_orthographic_path.xml");
    assert_eq!(orthographic.camera.projection, Projection::Orthographic);
    // Three units of the world wide, and the left is towards −y, since the view is along +x.
    let ray = |x| orthographic.camera.ray(DVec2::new(x, 0.5), 200.0 / 120.0, DVec2::ZERO).origin;
    assert!((ray(0.0) - ray(1.0) - DVec3::Y * 3.0).length() < 1e-12, "{}", ray(0.0) - ray(1.0));
}

#[test]
fn the_cornell_box_in_spectra_and_in_colours() {
    let Some(scenes) = scenes() else { return };
    let folder = scenes.join("mitsuba/scenes/cbox");
    let spectral = strictly(&folder.join("cbox-spectral.xml")).unwrap().scene;
    let colours = strictly(&folder.join("cbox-rgb.xml")).unwrap().scene;
    assert_eq!((spectral.shapes.len(), colours.shapes.len()), (8, 8));
    let of = |name: &str| spectral.shapes.iter().find(|shape| shape.name.contains(name)).unwrap();
    // Mitsuba 3.9.1 in scalar_rgb, of which a constant reflectance of 1 becomes 0.999: its sum over 1000 points counts 999.
    for (name, theirs) in [
        ("floor", [0.735013, 0.735625, 0.736264]),
        ("greenwall", [0.0682825, 0.39776, 0.0862909]),
        ("redwall", [0.49132, 0.0492281, 0.0509219]),
    ] {
        let found = diffuse(&spectral, of(name));
        // Spectra that end at 700 nm end there between two of its points.
        assert!(near(found * 0.999, theirs, 2e-3), "{name}: {found}");
    }
    let params = vec![("spp".to_string(), "7".to_string()), ("max_depth".to_string(), "2".to_string())];
    let given = load(&folder.join("cbox-rgb.xml"), &LoadOptions { params, lenient: false }).unwrap().scene;
    assert_eq!((given.render.samples, given.render.bounces), (Some(7), Some(Some(1))));
}

#[test]
fn other_mitsuba_scenes() {
    let Some(scenes) = scenes() else { return };
    for (name, shapes) in [
        ("ignis/mitsuba/plane.xml", 1),
        ("ignis/mitsuba/point.xml", 1),
        ("ignis/mitsuba/emissive-plane.xml", 2),
        ("lajolla/cbox/cbox.xml", 8),
        ("lajolla/veach_mi/mi.xml", 10),
        ("mitsuba/scenes/cbox/cbox.xml", 8),
    ] {
        let loaded = strictly(&scenes.join(name)).unwrap();
        assert_eq!((loaded.scene.shapes.len(), loaded.warnings.len()), (shapes, 0), "{name}: {:?}", loaded.warnings);
    }
    // Another program's format that is XML too.
    let error = strictly(&scenes.join("osl/cornell/cornell.xml")).unwrap_err().to_string();
    assert!(error.ends_with("a file whose root is <World> is not supported; known are <scene> (Mitsuba)"), "{error}");
}

/// The documentation of Mitsuba 3 shows what there is; most of its meshes are not at hand.
#[test]
fn the_examples_of_mitsuba_documentation() {
    let Some(scenes) = scenes() else { return };
    let mut all = Vec::new();
    for folder in
        ["mitsuba/docs/scenes", "mitsuba/docs/scenes/include", "mitsuba/docs/scenes/principled_blend_creation"]
    {
        let entries = std::fs::read_dir(scenes.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        all.extend(entries.filter(|path| path.extension().is_some_and(|e| e == "xml")));
    }
    assert!(all.len() >= 100, "{}", all.len());
    let (mut strict, mut lenient, mut refused) = (0, 0, 0);
    for path in &all {
        let start = Instant::now();
        match strictly(path) {
            Ok(_) => strict += 1,
            Err(error) => {
                let shown = error.to_string();
                assert!(shown.contains(".xml") && !shown.contains('\n'), "{shown}");
                match leniently(path) {
                    Ok(loaded) => {
                        assert!(!loaded.warnings.is_empty());
                        lenient += 1;
                    }
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(start.elapsed() < Duration::from_secs(20), "{} took {:?}", path.display(), start.elapsed());
    }
    eprintln!("of {}: {strict} strictly, {lenient} leniently, {refused} not (missing files, fragments)", all.len());
    assert!(strict >= 8, "{strict}");
}

#[test]
fn meshes_of_other_programs() {
    for (name, triangles, vertices) in [
        ("meshes/spot.obj", 5856, 3225),
        ("meshes/teapot.obj", 6320, 3644),
        ("meshes/tinyobj/cube.obj", 12, 8),
        ("meshes/tinyobj/cube-vertexcol.obj", 12, 8),
        ("meshes/tinyobj/cube-vertex-w-component.obj", 12, 8),
        ("scenes/mitsuba/common/meshes/bunny_lowres.ply", 0, 0),
        ("scenes/mitsuba/tests/ply/triangle_face_colors.ply", 1, 3),
    ] {
        let Some(path) = data(name) else { return };
        let loaded = strictly(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        let count: usize = loaded.scene.shapes.iter().map(|s| mesh(s).triangles().len()).sum();
        if triangles > 0 {
            assert_eq!(count, triangles, "{name}");
        }
        let count: usize = loaded.scene.shapes.iter().map(|s| mesh(s).positions().len()).sum();
        assert!(count >= vertices.max(3), "{name}: {count}");
        assert_eq!(loaded.scene.lights.len(), 1, "{name}: what has no light is lit from everywhere");
    }
    for name in ["cornell_box.obj", "cornell_box_multimaterial.obj"] {
        let Some(path) = data(&format!("meshes/tinyobj/{name}")) else { return };
        let scene = strictly(&path).unwrap().scene;
        assert!(scene.shapes.len() >= 6, "{name}: {}", scene.shapes.len());
    }
}

#[test]
fn the_cornell_boxes_of_the_computer_graphics_archive() {
    let Some(scenes) = scenes() else { return };
    let original = strictly(&scenes.join("mcguire/CornellBox-Original.obj")).unwrap().scene;
    let lamps: Vec<_> = original.shapes.iter().filter(|shape| shape.emission.is_some()).collect();
    assert_eq!(lamps.len(), 1);
    assert_eq!(lamps[0].emission, Some(Rgb::new(17.0, 12.0, 4.0)));
    // It shines downwards.
    let [a, b, c] = mesh(lamps[0]).triangles()[0].map(|corner| mesh(lamps[0]).positions()[corner as usize]);
    assert!((b - a).cross(c - a).y < 0.0);
    let floor = original.shapes.iter().find(|shape| shape.name == "floor").unwrap();
    assert_eq!(mesh(floor).positions()[0], DVec3::new(-1.01, 0.0, 0.99));
    let spheres = strictly(&scenes.join("mcguire/CornellBox-Sphere.obj"));
    let spheres = spheres.unwrap();
    let glass = spheres.scene.materials.iter().find(|material| material.name() == "rightSphere").unwrap();
    assert!(!glass.is_two_sided(), "{glass:?}");
}

#[test]
fn one_box_in_three_packagings_of_gltf() {
    let Some(scenes) = scenes() else { return };
    let read = |name: &str| strictly(&scenes.join("gltf").join(name)).unwrap().scene;
    let boxes = ["Box/Box.gltf", "Box_embedded.gltf", "Box.glb"].map(read);
    for other in &boxes[1..] {
        assert_eq!(format!("{:?}", other.shapes), format!("{:?}", boxes[0].shapes));
    }
    let shape = &boxes[0].shapes[0];
    assert_eq!((mesh(shape).triangles().len(), mesh(shape).positions().len()), (12, 24));
    let low = mesh(shape).positions().iter().copied().reduce(DVec3::min).unwrap();
    assert!((low - DVec3::splat(-0.5)).length() < 1e-12, "{low}");
    let coloured = read("BoxVertexColors.glb");
    assert_eq!(mesh(&coloured.shapes[0]).colors().len(), 24);
}
