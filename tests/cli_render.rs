//! `render` as its users meet it: images, statistics, checkpoints, bad input.

mod program;

use std::fs;
use std::path::Path;

use program::{refused, stdout};
use serde_json::Value;

fn succeeds(args: &[&str]) -> String {
    stdout(args, 0)
}

fn small<'a>(scene: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut args = vec!["render", scene, "--size", "24x16", "--bounces", "3"];
    args.extend(more);
    args
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").into()
}

#[test]
fn the_statistics_are_those_that_other_programs_read() {
    let folder = tempfile::tempdir().unwrap();
    let image = path(folder.path(), "a.pfm");
    let printed = succeeds(&small("furnace-sphere", &["-o", &image, "--spp", "4", "--quiet", "--stats-json", "-"]));
    let statistics: Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!(statistics["schema"], 1);
    assert_eq!(statistics["samples"], 24 * 16 * 4);
    assert_eq!(statistics["nonfinite"], 0);
    assert!(statistics["rays"].as_u64().unwrap() > 24 * 16 * 4);
    for key in ["load", "build", "render"] {
        assert!(statistics["seconds"][key].as_f64().unwrap() >= 0.0);
    }
    // E (1 − ρ⁴) / (1 − ρ) for E = ρ = 1/2, by MIS: within its own error, four times.
    let error = statistics["rmse_estimate"].as_f64().unwrap() / (24.0_f64 * 16.0).sqrt();
    for mean in statistics["mean"].as_array().unwrap() {
        assert!((mean.as_f64().unwrap() - 0.9375).abs() <= 4.0 * error + 1e-12, "{statistics}");
    }
}

#[test]
fn a_furnace_without_connections_is_exact_to_the_last_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let image = path(folder.path(), "a.exr");
    succeeds(&small("furnace-box", &["-o", &image, "--spp", "2", "--strategy", "bsdf", "--rr", "off"]));
    let image = whitefurnace::image::Image::read(Path::new(&image)).unwrap();
    for pixel in image.pixels_rgb() {
        assert_eq!(pixel, [0.9375; 3], "a sum of powers of two");
    }
    assert_eq!(image.metadata().get("scene").map(String::as_str), Some("furnace-box"));
}

#[test]
fn bits_do_not_depend_on_threads_and_a_checkpoint_goes_on_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let [once, threads, again, state] =
        ["once.pfm", "threads.pfm", "again.pfm", "state.wfc"].map(|n| path(folder.path(), n));
    succeeds(&small("cornell-original", &["-o", &once, "--spp", "9", "--threads", "1"]));
    succeeds(&small("cornell-original", &["-o", &threads, "--spp", "9", "--threads", "3"]));
    assert_eq!(fs::read(&once).unwrap(), fs::read(&threads).unwrap());
    succeeds(&small("cornell-original", &["-o", &again, "--spp", "4", "--checkpoint", &state]));
    assert_ne!(fs::read(&once).unwrap(), fs::read(&again).unwrap());
    succeeds(&small("cornell-original", &["-o", &again, "--spp", "9", "--resume", &state, "--checkpoint", &state]));
    assert_eq!(fs::read(&once).unwrap(), fs::read(&again).unwrap());
    refused(&small("cornell-original", &["-o", &again, "--resume", &state, "--seed", "2"]), &["state.wfc", "seed"]);
    refused(&small("cornell-mitsuba", &["-o", &again, "--resume", &state]), &["state.wfc", "scene"]);
    refused(&small("cornell-original", &["-o", &again, "--resume", &state, "--rr", "off"]), &["state.wfc", "setting"]);
    let mut bytes = fs::read(&state).unwrap();
    bytes.truncate(bytes.len() / 2);
    fs::write(&state, bytes).unwrap();
    refused(&small("cornell-original", &["-o", &again, "--resume", &state]), &["state.wfc"]);
}

#[test]
fn the_error_asked_for_is_reached() {
    let folder = tempfile::tempdir().unwrap();
    let image = path(folder.path(), "a.pfm");
    let args = ["-o", &image, "--rel-error", "0.2", "--quiet", "--stats-json", "-"];
    let statistics: Value = serde_json::from_str(&succeeds(&small("sphere-light", &args))).expect("JSON");
    let mean: f64 = statistics["mean"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap() / 3.0).sum();
    assert!(statistics["rmse_estimate"].as_f64().unwrap() / mean <= 0.2, "{statistics}");
}

#[test]
fn bad_input_is_one_line_before_the_first_ray() {
    let folder = tempfile::tempdir().unwrap();
    let image = path(folder.path(), "a.exr");
    refused(&["render", "cornell-orginal", "-o", &image], &["cornell-orginal", "did you mean cornell-original"]);
    refused(&["render", "no/such.xml", "-o", &image], &["no/such.xml"]);
    refused(&["render", "veach-mis", "-o", "a.gif"], &["a.gif", "exr"]);
    refused(&["render", "veach-mis", "-o", "/no/such/folder/a.exr"], &["/no/such/folder"]);
    refused(&["render", "veach-mis", "-o", &image, "-o", &image], &["twice"]);
    refused(&["render", "veach-mis", "--size", "0x9"], &["--size", "65536"]);
    refused(&["render", "veach-mis", "--spp", "1", "--time", "1"], &["--spp"]);
    refused(&["render", "veach-mis", "--strategy", "mist"], &["--strategy", "random-connect"]);
    refused(&["render", "furnace-box", "--param", "rho=2", "-o", &image], &["rho"]);
    refused(&["render", "furnace-box", "--param", "roh=0.2", "-o", &image], &["roh"]);
    let xml = path(folder.path(), "bad.xml");
    fs::write(
        &xml,
        "<scene version=\"3.0.0\">\n<shape type=\"sphere\">\n<float name=\"radius\" value=\"-1\"/>\n</shape>\n</scene>",
    )
    .unwrap();
    refused(&["render", &xml, "-o", &image], &["bad.xml", "radius"]);
    let point = path(folder.path(), "point.xml");
    fs::write(&point, "<scene version=\"3.0.0\"><emitter type=\"point\"/><sensor type=\"perspective\"/></scene>")
        .unwrap();
    refused(&["render", &point, "-o", &image, "--strategy", "bsdf"], &["--strategy bsdf", "mis"]);
    assert!(!Path::new(&image).exists());
}

#[test]
fn samples_survive_an_output_that_cannot_be_written_in_the_end() {
    // A folder takes the place of the file while the image is rendered: there is no portable way to fill a disk.
    let folder = tempfile::tempdir().unwrap();
    let image = path(folder.path(), "a.exr");
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_whitefurnace"))
        .args(small("cornell-original", &["-o", &image, "--time", "3"]))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    fs::create_dir(&image).unwrap();
    fs::write(Path::new(&image).join("full"), "x").unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(2));
    let mut error = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut error).unwrap();
    let at = error.find("kept in ").unwrap_or_else(|| panic!("{error}")) + "kept in ".len();
    let kept = error[at..].split(',').next().unwrap();
    assert!(whitefurnace::render::checkpoint::Checkpoint::read(Path::new(kept)).is_ok(), "{error}");
    fs::remove_file(kept).unwrap();
}
