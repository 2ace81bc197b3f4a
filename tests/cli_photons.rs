//! `photons` and `render --method photon` as their users meet them.

mod program;

use program::{refused, stdout};
use serde_json::Value;
use whitefurnace::image::Image;

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&stdout(args, 0)).expect("JSON")
}

#[test]
fn counts_and_flux_are_in_the_format_that_other_programs_read() {
    let found = json(&["photons", "cube-one-emitter", "--photons", "20000", "--json", "-"]);
    assert_eq!((&found["schema"], &found["map"], &found["photons"]), (&1.into(), &"global".into(), &20000.into()));
    // 1 / (1 − ρ) with ρ = ½, to 5 standard errors of √2 / √20000.
    assert!((found["hits"]["mean"].as_f64().unwrap() - 2.0).abs() < 0.05, "{found}");
    assert_eq!(found["escaped"], 0);
    let flux = |key: &str| found["flux"][key][1].as_f64().unwrap();
    assert!(
        (flux("emitted") - 1.0).abs() < 1e-9 && (flux("absorbed") - 1.0).abs() < 1e-9 && flux("missing").abs() < 1e-9
    );
    let surfaces = found["surfaces"].as_array().unwrap();
    assert_eq!((surfaces.len(), &surfaces[0]["name"], &surfaces[0]["area"]), (6, &"bottom".into(), &1.0.into()));
    // The first hits are the view factors of the cube: .199825 on the top; none on the bottom that emits.
    assert!((surfaces[1]["first"][0].as_f64().unwrap() - 0.199825).abs() < 0.015, "{found}");
    assert_eq!(surfaces[0]["first"][0], 0.0);
    let hits: u64 = surfaces.iter().filter_map(|surface| surface["hits"].as_u64()).sum();
    assert_eq!(found["stored"].as_u64(), Some(hits));
}

#[test]
fn the_table_says_where_the_light_goes() {
    let text = stdout(&["photons", "cornell-original", "--photons", "5000"], 0);
    for needle in ["surface", "floor", "5000 photons", "hits per photon", "emitted", "escaped", "global map"] {
        assert!(text.contains(needle), "{needle}: {text}");
    }
}

#[test]
fn files_are_written_and_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let args = ["photons", "cornell-original", "--photons", "3000", "--size", "16x16", "--quiet"];
    for threads in ["1", "3"] {
        let (ply, image) = (path(&format!("{threads}.ply")), path(&format!("{threads}.pfm")));
        stdout(&[&args[..], &["--threads", threads, "--ply", &ply, "-o", &image]].concat(), 0);
    }
    let read = |name: &str| std::fs::read(path(name)).unwrap();
    assert!(read("1.ply") == read("3.ply") && read("1.pfm") == read("3.pfm"));
    let ply = read("1.ply");
    let text = String::from_utf8_lossy(&ply[..400]).to_string();
    let count: usize = text.lines().find_map(|line| line.strip_prefix("element vertex ")).unwrap().parse().unwrap();
    let header = text.find("end_header\n").unwrap() + "end_header\n".len();
    assert!(count > 3000 && ply.len() == header + count * 56, "{text}");
}

#[test]
fn a_map_is_rendered_by_three_methods_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let args = ["render", "cornell-original", "--size", "16x16", "--photons", "3000", "--quiet", "--method"];
    for method in ["photon", "photon-direct-view", "sppm"] {
        let (whole, kept, rest) = (path("whole.pfm"), path("kept.wfc"), path("rest.pfm"));
        stdout(&[&args[..], &[method, "--spp", "8", "-o", &whole]].concat(), 0);
        stdout(&[&args[..], &[method, "--spp", "4", "-o", &rest, "--checkpoint", &kept]].concat(), 0);
        stdout(&[&args[..], &[method, "--spp", "8", "-o", &rest, "--resume", &kept]].concat(), 0);
        assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(&rest).unwrap(), "{method}");
        refused(
            &[&args[..], &[method, "--spp", "8", "-o", &rest, "--resume", &kept, "--k", "20"]].concat(),
            &["--resume"],
        );
    }
}

#[test]
fn an_exr_has_the_error_of_the_map_beside_that_of_the_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let size = ["cornell-original", "--size", "16x16", "--photons", "20000", "--spp", "4", "--quiet", "-o"];
    let planes = |args: &[&str], name: &str| {
        let file = path(name);
        stdout(&[args, &size[..], &[file.to_str().unwrap()]].concat(), 0);
        let image = Image::read(&file).unwrap();
        ["Map.StdErr", "Map.Bias"].map(|plane| image.plane(plane).map(<[f32]>::to_vec))
    };
    for args in [&["photons"][..], &["render", "--method", "photon"], &["render", "--method", "photon-direct-view"]] {
        let [deviations, biases] = planes(args, "map.exr").map(|plane| plane.expect("a plane"));
        let share = deviations.iter().filter(|&&deviation| deviation > 0.0).count();
        assert!(share > 128 && biases.iter().any(|&bias| bias != 0.0), "{args:?}: {share}");
        assert!(deviations.iter().chain(&biases).all(|value| value.is_finite()));
    }
    // Passes that know nothing of each other: the variance of the samples has that of the maps in it.
    assert_eq!(planes(&["render", "--method", "sppm"], "sppm.exr"), [None, None]);
}

#[test]
fn bad_input_is_one_clear_line() {
    refused(&["photons", "cornell-original", "--photons", "0"], &["--photons"]);
    refused(&["photons", "cornell-original", "--radius", "0"], &["--radius", "> 0"]);
    refused(&["photons", "cornell-original", "--radius", "nan"], &["--radius"]);
    refused(&["photons", "cornell-original", "--k", "0"], &["--k"]);
    refused(&["photons", "cornell-original", "--k", "1"], &["k = 1", "k-1", "2 or more"]);
    refused(&["photons", "cornell-original", "--k", "5", "--radius", "1"], &["--k", "--radius"]);
    refused(&["photons", "cornell-original", "--photons", "100", "--k", "100000"], &["100000", "stored photons"]);
    refused(&["photons", "cornell-original", "--map", "caustic"], &["none of 100000 photons", "caustic"]);
    refused(&["photons", "furnace-box", "--param", "e=0"], &["no light"]);
    refused(&["photons", "cornell-original", "--estimator", "gauss"], &["epanechnikov"]);
    refused(&["render", "cornell-original", "--method", "sppm", "--alpha", "1", "-o", "/tmp/never.png"], &["--alpha"]);
    refused(&["render", "furnace-box", "--param", "e=0", "--method", "photon", "-o", "/tmp/never.png"], &["no light"]);
}
