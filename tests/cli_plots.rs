//! `plot` as its users meet it: every kind as SVG and as PNG, numbers where they are measured, one line where it is wrong.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use whitefurnace::image::{Format, Image};

fn run(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitefurnace"));
    command.current_dir(folder).args(args).output().expect("the program starts")
}

/// Standard output of a run that must end well and say nothing on standard error.
#[track_caller]
fn stdout(folder: &Path, args: &[&str]) -> String {
    let output = run(folder, args);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && error.is_empty(), "{args:?}: {error}");
    String::from_utf8_lossy(&output.stdout).into()
}

#[track_caller]
fn refused(folder: &Path, args: &[&str], needle: &str) {
    let output = run(folder, args);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
    assert!(output.stdout.is_empty() && error.lines().count() == 1 && error.contains(needle), "{args:?}: {error}");
}

#[test]
fn every_kind_is_drawn_in_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    stdout(at, &["converge", "irradiance:unit-square", "--estimator", "area", "--n", "16..256", "--out", "study"]);
    stdout(at, &["render", "cornell-original", "-o", "box.exr", "--size", "12x8", "--spp", "4", "--quiet"]);
    for kind in [
        &["convergence", "study/convergence.json"][..],
        &["convergence", "study/convergence.csv"],
        &["albedo", "lambert:rho=0.5"],
        &["lobes", "lambert:rho=0.5"],
        &["asymmetry", "lambert:rho=0.5"],
        &["histogram", "lambert:rho=0.5", "-n", "1000"],
        &["variance", "box.exr"],
        &["first-split", "--most", "8", "-n", "4096"],
        &["first-split", "--most", "4", "-n", "1024", "--scene", "cornell-original", "--size", "4x4", "--pixel", "1,2"],
        &["roulette", "--rho", "0.5", "-n", "4096"],
        &["stores", "--most", "1000", "-k", "10"],
    ] {
        let typed = [&["plot"], kind].concat();
        let shown = stdout(at, &[&typed[..], &["--out", "a.png"]].concat());
        assert!(shown.ends_with("wrote a.png\n"), "{kind:?}: {shown}");
        let picture = Image::read(&at.join("a.png")).unwrap();
        assert_eq!((picture.width(), picture.height()), (1280, 840), "{kind:?}");
        // The name is the kind's where none is given.
        stdout(at, &typed);
        let svg = fs::read_to_string(at.join(format!("{}.svg", kind[0]))).unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert!(document.descendants().filter(|node| node.has_tag_name("text")).count() >= 3, "{kind:?}");
        assert!(svg.contains("@font-face"), "{kind:?} carries its face");
    }
}

#[test]
fn what_is_measured_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let split = stdout(folder.path(), &["plot", "first-split", "-n", "16384"]);
    // F²/12 with F = E/π and E = 0.752274688454.
    assert!(split.contains("V0 = ") && split.contains("(exact 0.004778)"), "{split}");
    let roulette = stdout(folder.path(), &["plot", "roulette", "--rho", "0.9", "-n", "4096"]);
    let first = roulette.lines().nth(1).unwrap();
    assert!(first.contains("<= 0.81") && first.ends_with("inf"), "{roulette}");
    assert!(roulette.contains("unknown"), "next to the pole no error can be known: {roulette}");
    let stores =
        stdout(folder.path(), &["plot", "stores", "--scene", "cube-one-emitter", "--most", "20000", "-k", "10"]);
    let sizes: Vec<&str> = stores.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(sizes[..4], ["1000", "2714", "7368", "20000"], "half a decade or less: {stores}");
    for store in ["scan", "hash grid", "k-d tree"] {
        assert!(stores.contains(&format!("{store}: seconds as n^p, p = ")), "{stores}");
    }
}

const DARK: &str = r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="sphere"/></scene>"#;

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("empty.json"), "{}").unwrap();
    let without_variances = Image::from_rgb(1, 1, &[[1.0; 3]]).unwrap();
    fs::write(at.join("plain.exr"), without_variances.encode(Format::Exr, 0.0).unwrap()).unwrap();
    fs::write(at.join("dark.xml"), DARK).unwrap();
    refused(at, &["plot"], "convergence, albedo, lobes");
    refused(at, &["plot", "pie"], "known are convergence, albedo, lobes");
    refused(at, &["plot", "lobe", "lambert"], "lobes");
    refused(at, &["plot", "lobes", "lambrt"], "did you mean lambert?");
    refused(at, &["plot", "lobes", "lambert", "-o", "a.pdf"], "ends in .svg or .png");
    refused(at, &["plot", "lobes", "lambert", "-o", "no/such/a.svg"], "there is no folder");
    refused(at, &["plot", "convergence", "none.json"], "cannot be read");
    refused(at, &["plot", "convergence", "empty.json"], "is no JSON of converge");
    refused(at, &["plot", "variance", "plain.exr"], "holds no variances");
    refused(at, &["plot", "roulette", "--rho", "1"], "a number in (0, 1)");
    refused(at, &["plot", "first-split", "--size", "2x2"], "--scene");
    refused(at, &["plot", "first-split", "--scene", "cornell-original", "--pixel", "8,0"], "outside");
    refused(at, &["plot", "stores", "--most", "999"], "1000..=10000000");
    refused(at, &["plot", "stores", "--most", "10000001"], "1000..=10000000");
    refused(at, &["plot", "stores", "-k", "1001"], "1..=1000");
    refused(at, &["plot", "stores", "--scene", "dark.xml"], "dark.xml: the scene has no light");
    assert_eq!(fs::read_dir(at).unwrap().count(), 3, "no file is left behind");
}
