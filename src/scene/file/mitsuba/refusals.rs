//! Bad Mitsuba files: one error that says what, where, and what is allowed.

use std::fmt::Write;

use super::tests::{error, scene};
use crate::scene::file::testing::{Files, mutate};

#[test]
fn what_is_not_supported_names_line_element_and_what_is_known() {
    let cases = [
        (
            "<shape type='sphere'><float name='foo' value='1'/></shape>",
            "line 2: `foo` of <shape type=\"sphere\"> is not supported; known are to_world",
        ),
        ("\n<shape type='teapot'/>", "line 3: <shape type=\"teapot\"> is not supported; known are rectangle, cube"),
        (
            "<shape type='cube'><bsdf type='hair'/></shape>",
            "line 2: <bsdf type=\"hair\"> is not supported; known are diffuse",
        ),
        ("<emitter type='sunsky'/>", "line 2: <emitter type=\"sunsky\"> is not supported"),
        ("<medium type='homogeneous' id='m'/>", "line 2: <medium type=\"homogeneous\"> is not supported"),
        ("<shape type='cube'><medium name='interior' type='homogeneous'/></shape>", "line 2: `interior` of <shape"),
        ("<integrator type='bdpt'/>", "line 2: <integrator type=\"bdpt\"> is not supported; known are path"),
        (
            "<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>",
            "line 2: `hide_emitters` is not",
        ),
        (
            "<shape type='sphere'><float name='radius' value='1' unit='m'/></shape>",
            "line 2: the attribute `unit` of <float>",
        ),
        (
            "<shape type='cube'><bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='diffuse'/></bsdf></shape>",
            "line 2: a back other",
        ),
        ("<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>", "line 2: an ellipsoid"),
        ("<frob/>", "line 2: <frob> is not supported"),
    ];
    for (body, expected) in cases {
        let found = error(body);
        assert!(found.starts_with(expected), "{found}\n{expected}");
        let lenient = Files::new().with("s.xml", scene(body)).lenient("s.xml").unwrap();
        assert_eq!(lenient.warnings.len(), 1, "{:?}", lenient.warnings);
        assert!(lenient.warnings[0].contains(&found), "{:?}", lenient.warnings);
    }
}

#[test]
fn bad_values_are_errors_even_if_lenient() {
    let cases = [
        (
            "<shape type='sphere'><float name='radius' value='nan'/></shape>",
            "line 2: radius = `nan` is not allowed; allowed is a finite number",
        ),
        ("<shape type='sphere'><float name='radius' value='1e999'/></shape>", "line 2: radius = `1e999`"),
        (
            "<shape type='sphere'><float name='radius' value='-1'/></shape>",
            "line 2: radius = `-1` is not allowed; allowed is a number > 0",
        ),
        (
            "<shape type='sphere'><string name='radius' value='1'/></shape>",
            "line 2: radius = <string name=\"radius\"> is not allowed; allowed is float, integer",
        ),
        (
            "<shape type='sphere'><float name='radius'/></shape>",
            "line 2: the value of <float name=\"radius\"> is missing",
        ),
        (
            "<shape type='sphere'><float name='radius' value='1'/><float name='radius' value='2'/></shape>",
            "line 2: the name of a property = `radius`",
        ),
        (
            "<shape type='sphere'><transform name='to_world'><rotate angle='3' x='0'/></transform></shape>",
            "line 2: its axis of <rotate>",
        ),
        (
            "<shape type='sphere'><transform name='to_world'><matrix value='1 2 3'/></transform></shape>",
            "line 2: value of <matrix> = `1 2 3`",
        ),
        (
            "<shape type='sphere'><bsdf type='diffuse'><rgb name='reflectance' value='1 2 3'/></bsdf></shape>",
            "line 2: <rgb name=\"reflectance\"> = `1 2 3`",
        ),
        (
            "<shape type='sphere'><bsdf type='diffuse'><spectrum name='reflectance' value='500:1, 400:1'/></bsdf></shape>",
            "line 2: the wavelength 400 nm does not come after",
        ),
        (
            "<shape type='sphere'><bsdf type='roughconductor'><float name='alpha' value='2'/></bsdf></shape>",
            "line 2: beckmann: alpha = 2",
        ),
        (
            "<shape type='sphere'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='no.png'/></texture></bsdf></shape>",
            "line 2: no.png: cannot be read",
        ),
        ("<shape type='obj'><string name='filename' value='no.obj'/></shape>", "line 2: no.obj: cannot be read"),
        ("<shape type='obj'><string name='filename' value='.'/></shape>", "line 2: .: cannot be read: it is a folder"),
        ("<shape type='sphere'><ref id='no'/></shape>", "line 2: the id of <ref> = `no` is not allowed"),
        ("<shape type='sphere' id='a'/><shape type='cube' id='a'/>", "line 2: id = `a` is not allowed"),
        ("<shape type='sphere'><float name='radius' value='$no'/></shape>", "line 2: the parameter = `$no`"),
        (
            "<bsdf type='twosided' id='a'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape>",
            "line 2: too many objects within objects",
        ),
        ("text<shape type='cube'/>", "line 1: text `text` between elements"),
        ("<shape type='cube'>", "line 2: "),
        (
            "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='1000000000'/></film></sensor>",
            "line 2: a second <sensor>",
        ),
    ];
    for (body, expected) in cases {
        let found = error(body);
        assert!(found.starts_with(expected), "{found}\n{expected}");
    }
    let film = "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>\n<integer name='width' value='1000000000'/></film></sensor></scene>";
    let found = Files::new().with("s.xml", film).error("s.xml");
    assert!(
        found.starts_with("s.xml: line 2: width = `1000000000` is not allowed; allowed is a number of pixels"),
        "{found}"
    );
}

#[test]
fn hostile_documents_are_refused_quickly() {
    let start = std::time::Instant::now();
    // Entities that expand to others.
    let mut laughs = "<?xml version=\"1.0\"?>\n<!DOCTYPE scene [<!ENTITY a0 \"ha\">".to_string();
    for level in 1..20 {
        let before = format!("&a{};", level - 1).repeat(10);
        write!(laughs, "<!ENTITY a{level} \"{before}\">").unwrap();
    }
    laughs += "]><scene version=\"3.0.0\">&a19;</scene>";
    let error = Files::new().with("s.xml", laughs).error("s.xml");
    assert!(error.contains("a document type; allowed is XML without <!DOCTYPE>"), "{error}");
    // Parameters that do.
    let mut params = "<default name='p0' value='hahahahaha'/>".to_string();
    for level in 1..20 {
        let before = format!("$p{}", level - 1).repeat(10);
        write!(params, "<default name='p{level}' value='{before}'/>").unwrap();
    }
    let error = Files::new().with("s.xml", scene(&params)).error("s.xml");
    assert!(error.contains("too many bytes in the values of parameters"), "{error}");
    // Files that include themselves, or each other many times over.
    let cycle = Files::new()
        .with("s.xml", scene("<include filename='t.xml'/>"))
        .with("t.xml", scene("<include filename='s.xml'/>"));
    let error = cycle.error("s.xml");
    assert!(
        error.starts_with("t.xml: line 2: the filename of <include>")
            && error.ends_with("that does not include itself")
    );
    let mut tree = Files::new();
    for level in 0..12 {
        let twenty = format!("<include filename='{}.xml'/>", level + 1).repeat(20);
        tree = tree.with(&format!("{level}.xml"), format!("<scene version='3.0.0'>{twenty}</scene>"));
    }
    let error = tree.with("12.xml", "<scene version='3.0.0'/>").error("0.xml");
    assert!(error.contains("too many includes"), "{error}");
    // Elements within elements.
    let deep = format!("{}{}", "<bsdf type='twosided'>".repeat(100_000), "</bsdf>".repeat(100_000));
    let error = Files::new().with("s.xml", scene(&deep)).error("s.xml");
    assert!(error.contains("too many elements in elements"), "{error}");
    // References that double at every step.
    let mut doubling = "<bsdf type='diffuse' id='b0'/>".to_string();
    for level in 1..60 {
        let before = level - 1;
        let parts = format!("<ref id='b{before}'/><ref id='b{before}'/>");
        write!(doubling, "<bsdf type='blendbsdf' id='b{level}'>{parts}</bsdf>").unwrap();
    }
    doubling += "<shape type='cube'><ref id='b59'/></shape>";
    let error = Files::new().with("s.xml", scene(&doubling)).error("s.xml");
    assert!(error.contains("too many objects within objects"), "{error}");
    // Names with escapes for terminals.
    let error = error_of_bytes(b"<scene version='3.0.0'><\x1b[31m/></scene>");
    assert!(!error.contains('\x1b'), "{error}");
    let error = error_of_bytes(b"<scene version='3.0.0'>\xff\xfe</scene>");
    assert!(error.starts_with("s.xml: byte 23: this is not UTF-8"), "{error}");
    // Ten seconds would tell of an explosion; all this takes less than one.
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

fn error_of_bytes(bytes: &[u8]) -> String {
    Files::new().with("s.xml", bytes).error("s.xml")
}

#[test]
fn another_root_is_not_mitsuba() {
    let error = error_of_bytes(b"<World>\n<Camera/></World>");
    assert_eq!(error, "s.xml: line 1: a file whose root is <World> is not supported; known are <scene> (Mitsuba)");
    let error = error_of_bytes(b"<scene version='3.0.0'/>");
    assert_eq!(error, "s.xml: a <sensor> is missing; allowed is one camera");
}

#[test]
fn damaged_files_never_panic() {
    let body = "<default name='r' value='2'/><integrator type='path'><integer name='max_depth' value='4'/></integrator>
        <bsdf type='twosided' id='a'><bsdf type='roughconductor'><float name='alpha' value='.2'/></bsdf></bsdf>
        <shape type='sphere'><float name='radius' value='$r'/><ref id='a'/><transform name='to_world'>
        <rotate z='1' angle='30'/><translate x='1' y='2'/></transform><emitter type='area'>
        <spectrum name='radiance' value='400:0, 500:8, 700:18.4'/></emitter></shape>
        <shape type='ply'><string name='filename' value='m.ply'/><ref id='a'/></shape><include filename='p.xml'/>";
    let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n";
    let part = b"<scene version='3.0.0'><emitter type='constant'/></scene>";
    mutate("s.xml", scene(body).as_bytes(), &[("m.ply", ply), ("p.xml", part)], 500);
}
