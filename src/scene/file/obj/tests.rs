//! What OBJ and MTL files mean, and what is wrong with bad ones.

use glam::{DVec2, DVec3};

use crate::bsdf::Lobes;
use crate::math::color::Rgb;
use crate::scene::description::SceneDescription;
use crate::scene::file::testing::{Files, mutate};
use crate::scene::mesh::Mesh;
use crate::scene::shape::Geometry;

fn mesh(scene: &SceneDescription, shape: usize) -> &Mesh {
    match &scene.shapes[shape].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read(obj: &str) -> SceneDescription {
    Files::new().with("a.obj", obj).load("a.obj").unwrap().scene
}

fn error(obj: &str) -> String {
    Files::new().with("a.obj", obj).error("a.obj")
}

#[test]
fn polygons_become_fans_and_indices_count_from_either_end() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f\t1 2  3 4 # a comment", "f 1 2 3 4\r"] {
        let scene = read(&format!("# head\n\n{SQUARE}{face}"));
        assert_eq!(mesh(&scene, 0).triangles(), [[0, 1, 2], [0, 2, 3]], "{face}");
        assert_eq!(mesh(&scene, 0).positions()[2], DVec3::new(1.0, 1.0, 0.0));
    }
}

#[test]
fn corners_share_vertices_where_all_three_indices_agree() {
    let scene = read(&format!("{SQUARE}vt .25 .5\nvt .75 1 0\nvn 0 0 2\nf 1/1/1 2/2/1 3/1/1\nf 1/1/1 3/2/1 4/1/1\n"));
    let mesh = mesh(&scene, 0);
    assert_eq!(mesh.positions().len(), 5, "corner 3 has two texture coordinates");
    assert_eq!((mesh.uvs()[0], mesh.uvs()[1]), (DVec2::new(0.25, 0.5), DVec2::new(0.75, 1.0)));
    assert_eq!(mesh.normals()[0], DVec3::Z);
    // v//vn, and a mesh that lacks normals at one corner has none.
    let mixed = read(&format!("{SQUARE}vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\n"));
    assert!(self::mesh(&mixed, 0).normals().is_empty());
}

#[test]
fn colours_and_weights_of_vertices() {
    let scene = read("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(mesh(&scene, 0).colors()[1], Rgb::new(0.0, 1.0, 0.0));
    let at = scene.materials[0].at(DVec2::ZERO, Rgb::grey(0.25)).eval(DVec3::Z, DVec3::Z);
    assert!((at.0.x * std::f64::consts::PI - 0.25).abs() < 1e-15);
    let scene = read("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n");
    assert!(mesh(&scene, 0).colors().is_empty());
}

#[test]
fn groups_and_materials_are_shapes() {
    let obj =
        format!("mtllib my lib.mtl\n{SQUARE}o first\nusemtl red\nf 1 2 3\ng second\nf 1 3 4\nusemtl lamp\nf 2 3 4\n");
    let mtl = "newmtl red\n\tKd 0.5 0.25 0 # brick\n\tKs 0 0 0\n\nnewmtl lamp\nKd 0 0 0\nKe 17 12 4";
    let loaded = Files::new().with("a.obj", obj).with("my lib.mtl", mtl).load("a.obj").unwrap();
    let scene = &loaded.scene;
    let names: Vec<_> = scene.shapes.iter().map(|s| (s.name.as_str(), s.material)).collect();
    assert_eq!(names, [("first", 0), ("second", 0), ("second", 1)]);
    assert_eq!(scene.materials[0].lambertian(), Some(Rgb::new(0.5, 0.25, 0.0)));
    assert!(scene.materials[0].is_two_sided());
    assert_eq!(scene.shapes[2].emission, Some(Rgb::new(17.0, 12.0, 4.0)));
    assert!(scene.lights.is_empty());
    assert_eq!(loaded.warnings.len(), 1, "only the camera is missing: {:?}", loaded.warnings);
}

#[test]
fn materials_follow_illum() {
    let obj = format!(
        "mtllib a.mtl\n{SQUARE}usemtl shiny\nf 1 2 3\nusemtl mirror\nf 1 2 3\nusemtl glass\nf 1 2 3\nusemtl thin\nf 1 2 3\n"
    );
    let mtl = "newmtl shiny\nillum 2\nKd .9 .9 .9\nKs .9 .9 .9\nNs 20\nnewmtl mirror\nillum 5\nKd .1 .1 .1\nKs .8 .8 .8\n\
               newmtl glass\nillum 7\nNi 1.5\nKs 1 1 1\nTf .9 1 1\nnewmtl thin\nd .25\nillum 1\nKs 1 1 1\nKd .5 .5 .5\n";
    let loaded = Files::new().with("a.obj", obj).with("a.mtl", mtl).load("a.obj").unwrap();
    let [shiny, mirror, glass, thin] = loaded.scene.materials.as_slice() else { panic!() };
    assert!(!shiny.lobes().contains(Lobes::DIRAC) && mirror.lobes().contains(Lobes::DIRAC));
    assert!(glass.lobes().contains(Lobes::TRANSMIT) && !glass.is_two_sided());
    assert_eq!(thin.lambertian(), Some(Rgb::grey(0.5)));
    assert_eq!(thin.opacity().unwrap().max_channel(), 0.25);
    assert!(loaded.warnings.iter().any(|w| w.contains("Kd + Ks of `shiny` is 1.800")), "{:?}", loaded.warnings);
    // The diffuse part of a mirror with a base: Kd / π, whatever the shares of the mixture.
    let f = mirror.at(DVec2::ZERO, Rgb::WHITE).eval(DVec3::Z, DVec3::new(0.6, 0.0, 0.8));
    assert!((f.0.x * std::f64::consts::PI - 0.1).abs() < 1e-15);
}

#[test]
fn textures_are_scaled_by_the_colour() {
    let pfm = b"PF\n1 1\n-1\n\x00\x00\x00\x3f\x00\x00\x00\x3f\x00\x00\x00\x3f";
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3\n");
    let mtl = "newmtl a\nKd 1 .5 .5\nmap_Kd -s 2 2 1 -o .1 .1 -clamp on some file.pfm\n";
    let files = Files::new().with("a.obj", obj).with("a.mtl", mtl).with("some file.pfm", pfm);
    let scene = files.load("a.obj").unwrap().scene;
    let f = scene.materials[0].at(DVec2::splat(0.5), Rgb::WHITE).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI;
    assert!((f.0.x - 0.5).abs() < 1e-7 && (f.0.y - 0.25).abs() < 1e-7, "{f}");
}

#[test]
fn bad_files_are_refused_by_line() {
    for (obj, expected) in [
        (format!("{SQUARE}f 1 2 5\n"), "a.obj: line 5: an index = `f 1 2 5` is not allowed; allowed is 1 to 4 for v"),
        (format!("{SQUARE}f 1 2 0\n"), "a.obj: line 5: an index = `f 1 2 0`"),
        (format!("{SQUARE}f 1 2 -5\n"), "a.obj: line 5: an index"),
        (format!("{SQUARE}f 1/1 2/1 3/1\n"), "a.obj: line 5: an index"),
        (
            format!("{SQUARE}f 1 2 99999999999999999999\n"),
            "a.obj: line 5: `f 1 2 99999999999999999999`; allowed is f with three",
        ),
        (format!("{SQUARE}f 1 2\n"), "a.obj: line 5: `f 1 2`; allowed is f with three or more"),
        (format!("{SQUARE}f 1///1 2 3\n"), "a.obj: line 5: `f 1///1 2 3`"),
        ("v 0 0\n".into(), "a.obj: line 1: `v 0 0`; allowed is v x y z"),
        ("v 0 0 nan\n".into(), "a.obj: line 1: `nan`; allowed is a finite number"),
        ("v 0 0 1e999\n".into(), "a.obj: line 1: `1e999`; allowed is a finite number"),
        ("v 0 0 1 2 3 4 5 6 7\n".into(), "a.obj: line 1: `6`; allowed is at most 7 numbers"),
        ("\ncurv 1 2\n".into(), "a.obj: line 2: the statement `curv` is not supported; known are v, vt"),
        (SQUARE.into(), "a.obj: a surface is missing"),
        (format!("{SQUARE}usemtl no\nf 1 2 3\n"), "a.obj: line 6: the material `no` is not supported; known are none"),
        (format!("mtllib no.mtl\n{SQUARE}f 1 2 3\n"), "a.obj: line 1: no.mtl: cannot be read"),
    ] {
        let found = error(&obj);
        assert!(found.starts_with(expected), "{found}\n{expected}");
    }
    let found = Files::new().with("a.obj", b"v 0 0 0\n\xff\xfe\n").error("a.obj");
    assert!(found.starts_with("a.obj: line 2: this is not UTF-8"), "{found}");
}

#[test]
fn bad_materials_are_refused_by_line() {
    for (mtl, expected) in [
        ("Kd 1 1 1\n", "a.mtl: line 1: `Kd 1 1 1`; allowed is newmtl before"),
        ("newmtl a\nKd 1 1\n", "a.mtl: line 2: Kd = `1 1` is not allowed; allowed is one or three numbers in [0, 1]"),
        ("newmtl a\nKd 2 2 2\n", "a.mtl: line 2: Kd"),
        ("newmtl a\nKe nan 0 0\n", "a.mtl: line 2: Ke"),
        ("newmtl a\nillum 12\n", "a.mtl: line 2: illum = `12`"),
        ("newmtl a\nmap_bump b.png\n", "a.mtl: line 2: the statement `map_bump` is not supported"),
        ("newmtl a\nmap_Kd b.png\n", "a.mtl: line 2: b.png: cannot be read"),
    ] {
        let obj = format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3\n");
        let found = Files::new().with("a.obj", obj).with("a.mtl", mtl);
        let found = found.error("a.obj");
        assert!(found.starts_with(expected), "{found}\n{expected}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let obj = format!(
        "mtllib a.mtl\n{SQUARE}vt 0 0\nvn 0 0 1\no a\nusemtl a\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1//1 -2//1 -3//1\n"
    );
    let mtl = b"newmtl a\nKd .5 .5 .5\nKs .2 .2 .2\nNs 10\nillum 2\nKe 1 1 1\nd .5\n";
    mutate("a.obj", obj.as_bytes(), &[("a.mtl", mtl)], 500);
}
