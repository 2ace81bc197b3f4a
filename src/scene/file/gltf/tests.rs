//! What glTF files mean, and what is wrong with bad ones.

use glam::{DVec2, DVec3};

use crate::math::color::Rgb;
use crate::scene::camera::Projection;
use crate::scene::file::testing::{Files, mutate};
use crate::scene::light::Light;
use crate::scene::mesh::Mesh;
use crate::scene::shape::Shape;

/// Positions of a triangle, its indices as u16 and two bytes of padding, in base64.
fn buffer() -> (String, Vec<u8>) {
    let mut bytes = Vec::new();
    for value in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32] {
        bytes.extend(value.to_le_bytes());
    }
    for corner in [0, 1, 2_u16] {
        bytes.extend(corner.to_le_bytes());
    }
    bytes.extend([0, 0]);
    (base64(&bytes), bytes)
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0_u32, |bits, b| bits << 8 | u32::from(*b)) << (8 * (3 - group.len()));
        for at in 0..=group.len() {
            text.push(char::from(LETTERS[(bits >> (18 - 6 * at) & 63) as usize]));
        }
    }
    text
}

fn triangle(extra: &str) -> String {
    let (data, _) = buffer();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"name":"tri","translation":[0,0,5],"scale":[2,2,2]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],
        "buffers":[{{"byteLength":42,"uri":"data:application/octet-stream;base64,{data}"}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.5,0.25,0.125,1],"metallicFactor":0}},
                       "emissiveFactor":[1,1,0]{extra}}}]}}"#
    )
}

fn mesh(shape: &Shape) -> &Mesh {
    match &shape.geometry {
        crate::scene::shape::Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_triangle_with_a_material() {
    let strength = r#","extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4}}"#;
    let scene = Files::new().with("a.gltf", triangle(strength)).load("a.gltf").unwrap().scene;
    let mesh = mesh(&scene.shapes[0]);
    assert_eq!((mesh.positions()[1], mesh.triangles()), (DVec3::new(2.0, 0.0, 5.0), [[0, 1, 2]].as_slice()));
    assert_eq!(scene.shapes[0].emission, Some(Rgb::new(4.0, 4.0, 0.0)));
    assert!(scene.lights.is_empty());
    let f = scene.materials[0].at(DVec2::ZERO, Rgb::WHITE).eval(DVec3::Z, DVec3::Z);
    // Roughness 1, no metal, at normal incidence: 0.96 c / π + 0.04 D V with D = 1/π, V = 1/4.
    let expected = |c: f64| (0.96 * c + 0.04 * 0.25) / std::f64::consts::PI;
    assert!((f.0 - DVec3::new(expected(0.5), expected(0.25), expected(0.125))).length() < 1e-14, "{f}");
}

#[test]
fn the_binary_form_is_the_same() {
    let (data, bytes) = buffer();
    let json = triangle("").replace(&format!(r#","uri":"data:application/octet-stream;base64,{data}""#), "");
    let json = format!("{json}{}", " ".repeat((4 - json.len() % 4) % 4));
    let mut glb = b"glTF".to_vec();
    for word in [2, 12 + 8 + json.len() + 8 + bytes.len(), json.len(), 0x4e4f_534a] {
        glb.extend((word as u32).to_le_bytes());
    }
    glb.extend(json.as_bytes());
    glb.extend((bytes.len() as u32).to_le_bytes());
    glb.extend(0x004e_4942_u32.to_le_bytes());
    glb.extend(&bytes);
    let files = Files::new().with("a.glb", &glb).with("a.gltf", triangle(""));
    let [binary, text] = ["a.glb", "a.gltf"].map(|name| files.load(name).unwrap().scene);
    assert_eq!(format!("{binary:?}"), format!("{text:?}"));
    for end in [0, 5, 10, 15, 30, glb.len() - 1] {
        let error = Files::new().with("a.glb", &glb[..end]).error("a.glb");
        assert!(error.contains("ends within") || end == 0, "{error}");
    }
    mutate("a.glb", &glb, &[], 500);
}

#[test]
fn cameras_and_lights() {
    let json = triangle("").replace(
        r#""scenes":[{"nodes":[0]}]"#,
        r#""scenes":[{"nodes":[0,1,2]}],"cameras":[{"type":"perspective","perspective":{"yfov":1.0,"aspectRatio":2.0}}],
           "extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[
           {"type":"directional","color":[1,0.5,0],"intensity":2}]}}"#,
    );
    let json = json.replace(
        r#""scale":[2,2,2]}"#,
        r#""scale":[2,2,2]},{"camera":0,"translation":[0,0,9]},
           {"rotation":[-0.7071067811865476,0,0,0.7071067811865476],"extensions":{"KHR_lights_punctual":{"light":0}}}"#,
    );
    let loaded = Files::new().with("a.gltf", json).load("a.gltf").unwrap();
    let scene = loaded.scene;
    assert_eq!(loaded.warnings, [""; 0]);
    assert_eq!((scene.film.width, scene.film.height), (512, 256));
    let Projection::Perspective { tan_half_x } = scene.camera.projection else { panic!() };
    assert!((tan_half_x - 2.0 * 0.5_f64.tan()).abs() < 1e-14);
    let corner = scene.camera.ray(DVec2::new(1.0, 0.0), 2.0, DVec2::ZERO);
    assert!(corner.origin == DVec3::Z * 9.0 && corner.dir.x > 0.0 && corner.dir.y > 0.0 && corner.dir.z < 0.0);
    let Light::Directional { direction, irradiance } = scene.lights[0] else { panic!("{:?}", scene.lights) };
    assert!((direction + DVec3::Y).length() < 1e-15 && irradiance == Rgb::new(2.0, 1.0, 0.0));
}

#[test]
fn strips_and_fans() {
    let place = crate::scene::file::Place::whole(std::path::Path::new("a"));
    let of = |mode| super::scene::triangles(&[0, 1, 2, 3], mode, &place);
    assert_eq!(of(5).unwrap(), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(of(6).unwrap(), [[0, 1, 2], [0, 2, 3]]);
    assert!(of(4).is_err());
}

#[test]
fn lies_are_refused_by_element() {
    let good = triangle("");
    let long = format!("{good} {}", "[".repeat(100_000));
    for (old, new, expected) in [
        (
            "\"count\":3,\"type\":\"VEC3\"",
            "\"count\":1000000000,\"type\":\"VEC3\"",
            "a.gltf: accessors[0]: count = 1000000000 is not",
        ),
        (
            "\"count\":3,\"type\":\"VEC3\"",
            "\"count\":18446744073709551615,\"type\":\"VEC3\"",
            "a.gltf: accessors[0]: count",
        ),
        ("\"count\":3,\"type\":\"VEC3\"", "\"count\":-3,\"type\":\"VEC3\"", "a.gltf: line 4: "),
        ("\"byteLength\":36", "\"byteLength\":3600", "a.gltf: bufferViews[0]: byteOffset + byteLength = 0 + 3600"),
        ("\"byteOffset\":36", "\"byteOffset\":18446744073709551615", "a.gltf: bufferViews[1]: byteOffset"),
        (
            "\"byteLength\":42",
            "\"byteLength\":420",
            "a.gltf: buffers[0]: byteLength = 420 is not allowed; allowed is at most the 44",
        ),
        ("\"indices\":1", "\"indices\":0", "a.gltf: accessors[0]: componentType of indices"),
        ("\"indices\":1", "\"indices\":7", "a.gltf: meshes[0].primitives[0]: accessor = 7"),
        ("\"mesh\":0", "\"mesh\":9", "a.gltf: nodes[0]: mesh = 9"),
        ("\"mesh\":0", "\"children\":[0]", "a.gltf: nodes[0]: it is reached twice"),
        ("\"material\":0", "\"material\":4", "a.gltf: meshes[0].primitives[0]: material = 4"),
        ("\"POSITION\":0", "\"NORMAL\":0", "a.gltf: meshes[0].primitives[0]: the attribute POSITION is missing"),
        ("\"version\":\"2.0\"", "\"version\":\"1.0\"", "a.gltf: asset: version `1.0` is not supported"),
        ("\"scene\":0", "\"scene\":0,\"extensionsUsed\":[\"KHR_x\"]", "a.gltf: extensionsUsed: the extension `KHR_x`"),
        ("[0.5,0.25,", "[5,0.25,", "a.gltf: materials[0]: baseColorFactor = [5.0"),
        ("[2,2,2]", "[1e300,1e300,1e999]", "a.gltf: line 2: "),
        ("\"scale\":[2,2,2]", "\"rotation\":[0,0,0,0]", "a.gltf: nodes[0]: rotation"),
        ("data:application/octet-stream;base64,", "no%20file.bin?", "a.gltf: buffers[0]: no file.bin?"),
        ("data:application/octet-stream;base64,", "https://x/", "a.gltf: buffers[0]: uri = "),
        (
            "\"emissiveFactor\"",
            "\"normalTexture\":{\"index\":0},\"emissiveFactor\"",
            "a.gltf: materials[0]: `normalTexture` is not",
        ),
        (
            "\"emissiveFactor\"",
            "\"doubleSided\":true,\"alphaMode\":\"X\",\"emissiveFactor\"",
            "a.gltf: materials[0]: alphaMode = `X`",
        ),
        (good.as_str(), long.as_str(), "a.gltf: line "),
    ] {
        assert!(good.contains(old), "{old}");
        let found = Files::new().with("a.gltf", good.replacen(old, new, 1)).error("a.gltf");
        assert!(found.starts_with(expected), "{found}\n{expected}");
    }
    // A vertex that is not there, and one that is no number.
    let bad = good.replacen("AAABAAIAAAA", "AAABAAkAAAA", 1);
    let found = Files::new().with("a.gltf", bad).error("a.gltf");
    assert!(found.starts_with("a.gltf: meshes[0].primitives[0]: triangle 0 names vertex 9"), "{found}");
    let nan = good.replacen("base64,AAAA", "base64,AADA", 1).replacen("base64,AADAAA", "base64,AADAfw", 1);
    let found = Files::new().with("a.gltf", nan).error("a.gltf");
    assert!(found.contains("the position of vertex 0 is not finite"), "{found}");
}

#[test]
fn damaged_files_never_panic() {
    mutate("a.gltf", triangle("").as_bytes(), &[], 500);
}
