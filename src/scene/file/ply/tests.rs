//! What PLY files mean, and what is wrong with bad ones.

use super::*;
use crate::scene::file::testing::{Files, mutate};

fn file(format: &str, vertex: &str, face: &str) -> String {
    format!("ply\nformat {format} 1.0\ncomment x\n{vertex}{face}end_header\n")
}

const XYZ: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const FACE: &str = "element face 1\nproperty list uchar int vertex_indices\n";
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3";

fn read(bytes: &[u8]) -> Result<Mesh, SceneError> {
    parse(Path::new("a.ply"), bytes)
}

fn error(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

/// The square with a property of every type in every encoding: skipped ones before, between and after.
fn square(big: bool) -> Vec<u8> {
    let vertex = "element vertex 4\nproperty short a\nproperty double x\nproperty list uchar ushort l\nproperty float y\n\
                  property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\n\
                  property float t\nproperty float nx\nproperty float ny\nproperty float nz\n";
    let face = "element junk 2\nproperty int8 j\nelement face 1\nproperty float q\nproperty list int uint vertex_index\n\
                property uint16 flags\n";
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = file(format, vertex, face).into_bytes();
    macro_rules! put {
        ($value:expr) => {
            bytes.extend(if big { $value.to_be_bytes().to_vec() } else { $value.to_le_bytes().to_vec() })
        };
    }
    for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1_u8)] {
        put!(7_i16);
        put!(f64::from(x));
        put!(2_u8);
        put!(1_u16);
        put!(2_u16);
        put!(f32::from(y));
        put!(0.5_f32);
        for c in [255, 0, 51_u8] {
            put!(c);
        }
        for v in [f32::from(x as u8), f32::from(y), 0.0, 0.0, 3.0] {
            put!(v);
        }
    }
    put!(-1_i8);
    put!(5_i8);
    put!(1.5_f32);
    put!(4_i32);
    for corner in [0, 1, 2, 3_u32] {
        put!(corner);
    }
    put!(9_u16);
    bytes
}

#[test]
fn all_encodings_say_the_same() {
    let text = read(file("ascii", XYZ, FACE).replace("end_header\n", &format!("end_header\n{SQUARE}")).as_bytes());
    let text = text.unwrap();
    assert_eq!(text.triangles(), [[0, 1, 2], [0, 2, 3]]);
    for big in [false, true] {
        let mesh = read(&square(big)).unwrap();
        assert_eq!(mesh.triangles(), text.triangles());
        assert!(mesh.positions().iter().zip(text.positions()).all(|(a, b)| *a == *b + DVec3::Z * 0.5));
        assert_eq!(mesh.colors()[3], Rgb::new(1.0, 0.0, 0.2));
        assert_eq!((mesh.uvs()[2], mesh.normals()[0]), (DVec2::ONE, DVec3::Z));
    }
}

#[test]
fn counts_are_compared_with_the_file() {
    let huge = XYZ.replace(" 4\n", " 1000000000\n");
    for format in ["ascii", "binary_little_endian"] {
        let found = error(&format!("{}{SQUARE}", file(format, &huge, FACE)));
        assert!(
            found.starts_with("a.ply: line 4: the count of element `vertex` = 1000000000 is not allowed"),
            "{found}"
        );
    }
    let faces = FACE.replace(" 1\n", " 18446744073709551615\n");
    assert!(error(&format!("{}{SQUARE}", file("ascii", XYZ, &faces))).contains("the count of element `face`"));
    // Elements without properties take no bytes and must take no time.
    let empty = "element nothing 4000000000\n";
    assert!(error(&format!("{}{SQUARE}", file("ascii", empty, ""))).contains("element vertex is missing"));
    // A list that claims to be longer than the file.
    let found = error(&format!("{}0 0 0\n1 0 0\n1 1 0\n0 1 0\n4000000000 0 1 2", file("ascii", XYZ, FACE)));
    assert!(found.contains("the file ends within element face 0 of 1"), "{found}");
}

#[test]
fn bad_files_are_refused() {
    let with = |data: &str| error(&format!("{}{data}", file("ascii", XYZ, FACE)));
    for (found, expected) in [
        (error("plywood\n"), "a.ply: line 1: `plywood`; allowed is the word `ply`"),
        (error("ply\nformat ascii 1.0\n"), "a.ply: line 3: the file ends within its header"),
        (error("ply\nend_header\n"), "a.ply: line 2: no format"),
        (error("ply\nformat utf8 1.0\n"), "a.ply: line 2: format `utf8`; allowed is ascii"),
        (error("ply\nformat ascii 1.0\nproperty float x\nend_header\n"), "a.ply: line 3: `property float x`"),
        (error("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n"), "a.ply: line 3: `element vertex -1`"),
        (error("ply\nformat ascii 1.0\nelement v 1\nproperty half x\n"), "a.ply: line 4: `property half x`"),
        (error("ply\nformat ascii 1.0\nfrob\n"), "a.ply: line 3: `frob`; allowed is format, comment"),
        (error(&file("ascii", "", "")), "a.ply: element vertex is missing"),
        (error(&format!("{}1 2 3", file("ascii", &XYZ.replace(" x", " q"), FACE))), "a.ply: line 4: "),
        (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 4"), "a.ply: triangle 1 names vertex 4, but there are 4"),
        (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 -1"), "a.ply: face 0: a vertex index = -1"),
        (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 1.5"), "a.ply: face 0: a vertex index = 1.5"),
        (with("0 0 0\n1 0 0\nnan 1 0\n0 1 0\n4 0 1 2 3"), "a.ply: the position of vertex 2 is not finite"),
        (with("0 0 0\n1 0 0\n1e999 1 0\n0 1 0\n4 0 1 2 3"), "a.ply: the position of vertex 2 is not finite"),
        (with("0 0 0\n1 0 0\nfoo 1 0\n0 1 0\n4 0 1 2 3"), "a.ply: byte "),
        (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n"), "a.ply: byte "),
    ] {
        assert!(found.starts_with(expected), "{found}\n{expected}");
    }
    let mut short = square(false);
    short.truncate(short.len() - 3);
    let found = read(&short).unwrap_err().to_string();
    assert!(found.contains("the file ends within element face 0 of 1"), "{found}");
}

#[test]
fn a_file_alone_is_a_scene() {
    let files = Files::new().with("a.ply", format!("{}{SQUARE}", file("ascii", XYZ, FACE)));
    let loaded = files.load("a.ply").unwrap();
    assert_eq!((loaded.scene.name.as_str(), loaded.scene.shapes.len(), loaded.warnings.len()), ("a", 1, 2));
}

#[test]
fn damaged_files_never_panic() {
    mutate("a.ply", &square(false), &[], 500);
    mutate("a.ply", format!("{}{SQUARE}", file("ascii", XYZ, FACE)).as_bytes(), &[], 500);
}
