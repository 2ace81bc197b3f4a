//! `compare` and `merge` as their users meet them: verdicts, JSON, pictures, files that do not belong together.

mod program;
mod real_data;

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;
use whitefurnace::image::{Format, Image, Storage};
use whitefurnace::math::color::Rgb;
use whitefurnace::render::checkpoint::Checkpoint;
use whitefurnace::render::film::Film;
use whitefurnace::render::provenance::{Provenance, Run};
use whitefurnace::sampling::stream::{stream, uniform};

use program::{refused, stdout};
use real_data::data;

/// A folder with films of one scene: uniform samples of mean `mean`, `range` of the numbers under `seed`.
struct Films {
    folder: TempDir,
}

const SIZE: usize = 32;

impl Films {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn film(mean: f64, seed: u64, range: std::ops::Range<u64>) -> Checkpoint {
        let mut film = Film::new(SIZE, SIZE);
        for (at, pixel) in film.pixels_mut().iter_mut().enumerate() {
            for sample in range.clone() {
                pixel.add(Rgb::grey(2.0 * mean * uniform(&mut stream(seed, at as u64, sample))), 1);
            }
        }
        let run = Run { seed, first: range.start, count: range.end - range.start };
        Checkpoint { film, provenance: Provenance::new("box", "mis", run, 1.0) }
    }

    /// Writes a film as EXR or checkpoint.
    fn put(&self, name: &str, content: &Checkpoint) -> String {
        let path = self.path(name);
        let bytes = match Format::of(Path::new(name)) {
            Ok(format) => content.film.to_image(&content.provenance.metadata()).encode(format, 0.0).expect("a picture"),
            Err(_) => content.encode(),
        };
        fs::write(&path, bytes).expect("a written file");
        path
    }

    fn render(&self, name: &str, mean: f64, seed: u64) -> String {
        self.put(name, &Self::film(mean, seed, 0..16))
    }
}

fn compare_json(args: &[&str], status: i32) -> Value {
    let all = [&["compare"], args, &["--json", "-"]].concat();
    serde_json::from_str(&stdout(&all, status)).expect("JSON")
}

#[test]
fn renderings_of_one_scene_are_equal_and_of_another_are_not() {
    let films = Films::new();
    let (a, b, c) = (films.render("a.exr", 1.0, 1), films.render("b.exr", 1.0, 2), films.render("c.exr", 1.1, 3));
    let equal = compare_json(&[&a, &b], 0);
    assert_eq!((&equal["schema"], &equal["verdict"], &equal["width"]), (&1.into(), &"equal".into(), &32.into()));
    let differ = compare_json(&[&a, &c], 1);
    assert_eq!(differ["verdict"], "differ");
    let image = &differ["noise"]["image"];
    // Standard error of a less c: √(1/3 · (1 + 1.21))/√(16 · 1024) = 0.0067, so z is about −15.
    let z = image["channels"][0]["z"].as_f64().unwrap();
    assert!(image["holds"] == false && (-20.0..-10.0).contains(&z), "{image}");
    let text = stdout(&["compare", &a, &c], 1);
    assert!(text.contains("DIFFER  beyond noise at level 0.01"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 100 || line.contains(&c) || line.contains(&a)), "{text}");
}

#[test]
fn the_reference_is_the_second_unless_it_is_named() {
    let films = Films::new();
    let (a, c) = (films.render("a.exr", 1.0, 1), films.render("c.exr", 2.0, 3));
    let relmse = |args: &[&str]| {
        let json = compare_json(args, 1);
        let metric = json["metrics"].as_array().unwrap().iter().find(|m| m["name"] == "relmse").unwrap().clone();
        assert_eq!(metric["epsilon"], 0.01);
        (metric["value"].as_f64().unwrap(), json["reference"].clone(), json["a"]["mean"][0].as_f64().unwrap())
    };
    let by_c = relmse(&[&a, &c]);
    let by_a = relmse(&[&a, &c, "--reference", "A"]);
    // A difference of 1 over 2² and over 1²; noise of a sixth of a makes the latter larger.
    assert!((by_c.0 - 0.25).abs() <= 0.1 && (1.0..1.5).contains(&by_a.0), "{by_c:?} {by_a:?}");
    assert_eq!((by_c.1, by_a.1), ("b".into(), "a".into()));
    assert!((by_c.2 - 1.0).abs() <= 0.05 && by_a.2 == by_c.2, "A stays A");
    assert_eq!(relmse(&[&a, &c, "--reference", &a]).0, by_a.0);
    refused(&["compare", &a, &c, "--reference", "d.exr"], &["allowed is A, B, or the path"]);
}

#[test]
fn without_variance_nothing_is_said_of_noise() {
    let films = Films::new();
    let strip = |path: &str| {
        let image = Image::read(Path::new(path)).unwrap();
        let bare = format!("{path}.pfm");
        fs::write(&bare, image.encode(Format::Pfm, 0.0).unwrap()).unwrap();
        bare
    };
    let (a, b) = (films.render("a.exr", 1.0, 1), films.render("b.exr", 1.0, 2));
    let (bare_a, bare_b) = (strip(&a), strip(&b));
    let undecided = compare_json(&[&bare_a, &bare_b], 3);
    assert_eq!((&undecided["verdict"], &undecided["noise"]), (&"undecided".into(), &Value::Null));
    assert!(undecided["metrics"][0]["value"].as_f64().unwrap() > 0.0);
    assert_eq!(compare_json(&[&bare_a, &bare_a], 0)["identical"], true);
    refused(&["compare", &bare_a, &bare_b, "--z-image", &films.path("z.png")], &["neither file has a variance"]);
    // One variance: b counts as exact, which it is not, and z² is twice what it should be.
    let half = compare_json(&[&a, &bare_b], 0);
    assert!(half["b"]["noise"].as_str().unwrap().contains("taken as exact"));
    let z2 = |json: &Value| json["noise"]["mean_z2"].as_f64().unwrap();
    assert!((z2(&half) / z2(&compare_json(&[&a, &b], 0)) - 2.0).abs() <= 0.3);
    // Told how many samples b has, its variance is scaled from a's.
    let told = compare_json(&[&a, &bare_b, "--spp-b", "16"], 0);
    assert!((z2(&told) - 1.15).abs() <= 0.1, "{}", z2(&told));
    // And with the variance of one sample in a file, as other renderers have it: 1/3.
    let variance = films.path("var.pfm");
    let third = Image::from_rgb(SIZE, SIZE, &[[1.0 / 3.0; 3]; SIZE * SIZE]).unwrap();
    fs::write(&variance, third.encode(Format::Pfm, 0.0).unwrap()).unwrap();
    let args = ["--variance-a", &variance, "--spp-a", "16", "--variance-b", &variance, "--spp-b", "16"];
    let given = compare_json(&[&[bare_a.as_str(), &bare_b], args.as_slice()].concat(), 0);
    assert!((z2(&given) - 1.0).abs() <= 0.1, "{}", z2(&given));
    refused(&["compare", &bare_a, &bare_b, "--variance-a", &variance], &["--spp-a"]);
}

#[test]
fn pictures_and_json_are_written() {
    let films = Films::new();
    let (a, b) = (films.render("a.exr", 1.0, 1), films.render("b.exr", 1.0, 2));
    let [z, raw, error, json] = ["z.png", "z.exr", "e.png", "c.json"].map(|name| films.path(name));
    stdout(&["compare", &a, &b, "--z-image", &z, "--error-image", &error, "--json", &json], 0);
    stdout(&["compare", &a, &b, "--z-image", &raw], 0);
    assert_eq!(Image::read(Path::new(&z)).unwrap().storage(), Storage::Srgb8);
    assert!(Image::read(Path::new(&error)).unwrap().height() > SIZE, "there is a legend");
    let mean_z2 = |pixels: &[[f32; 3]]| pixels.iter().map(|p| p[0] * p[0]).sum::<f32>() / pixels.len() as f32;
    let raw = mean_z2(&Image::read(Path::new(&raw)).unwrap().pixels_rgb());
    let report: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    assert!((f64::from(raw) - report["noise"]["mean_z2"].as_f64().unwrap()).abs() <= 1e-4);
    refused(&["compare", &a, &b, "--z-image", &films.path("z.hdr")], &["allowed are .png, .exr and .pfm"]);
    refused(&["compare", &a, &b, "--z-image", "/nowhere/z.png"], &["--z-image", "cannot be written"]);
}

#[test]
fn a_nan_never_passes() {
    let films = Films::new();
    let mut bad = Films::film(1.0, 1, 0..16);
    bad.film.pixels_mut()[3] = whitefurnace::render::film::Pixel { nonfinite: 16, ..Default::default() };
    let path = films.put("nan.exr", &bad);
    let json = compare_json(&[&path, &path], 1);
    assert_eq!((&json["verdict"], &json["a"]["nonfinite"]), (&"differ".into(), &1.into()));
    let text = stdout(&["compare", &path, &path], 1);
    assert!(text.contains("1 and 1 pixels are not finite") && text.contains("A left out 16 samples"), "{text}");
}

#[test]
fn merging_is_rendering_longer() {
    let films = Films::new();
    let (first, second) = (Films::film(1.0, 1, 0..16), Films::film(1.0, 1, 16..40));
    let whole = Films::film(1.0, 1, 0..40);
    let (a, b) = (films.put("a.checkpoint", &first), films.put("b.exr", &second));
    let [exr, saved] = ["both.exr", "both.checkpoint"].map(|name| films.path(name));
    let text = stdout(&["merge", &a, &b, "-o", &exr, "-o", &saved], 0);
    assert!(text.contains("merged") && text.ends_with("seed 1: 0..40\n"), "{text}");
    let image = Image::read(Path::new(&exr)).unwrap();
    assert_eq!((&image.metadata()["samples"], &image.metadata()["seed"]), (&"40".to_string(), &"1".to_string()));
    let merged = Checkpoint::read(Path::new(&saved)).unwrap();
    assert_eq!(merged.provenance.runs, whole.provenance.runs);
    for (ours, theirs) in merged.film.pixels().iter().zip(whole.film.pixels()) {
        // b went through f32.
        assert!(ours.n == theirs.n && (ours.mean - theirs.mean).length() <= 1e-6, "{ours:?} {theirs:?}");
        assert!((ours.m2 - theirs.m2).length() <= 1e-5, "{ours:?} {theirs:?}");
    }
    assert_eq!(compare_json(&[&exr, &films.put("whole.exr", &whole)], 0)["verdict"], "equal");
}

#[test]
fn what_does_not_belong_together_is_not_merged() {
    let films = Films::new();
    let out = films.path("out.exr");
    let a = films.render("a.exr", 1.0, 1);
    let again = films.put("again.checkpoint", &Films::film(1.0, 1, 15..20));
    refused(&["merge", &a, &again, "-o", &out], &[&a, &again, "same samples: seed 1: 0..16 and seed 1: 15..20"]);
    let mut other = Films::film(1.0, 2, 0..4);
    other.provenance.scene = "ball".into();
    let other = films.put("other.exr", &other);
    refused(&["merge", &a, &other, "-o", &out], &[&a, &other, "the scenes differ: box and ball"]);
    let foreign = films.path("foreign.pfm");
    fs::write(&foreign, Image::read(Path::new(&a)).unwrap().encode(Format::Pfm, 0.0).unwrap()).unwrap();
    refused(&["merge", &a, &foreign, "-o", &out], &[&foreign, "there is no plane Variance.R"]);
    refused(&["merge", &a, "-o", &films.path("out.tiff")], &["allowed are .exr, .pfm, .hdr and .png, or .checkpoint"]);
    assert!(!Path::new(&out).exists());
}

#[test]
fn hostile_files_are_one_line() {
    let films = Films::new();
    let a = films.render("a.exr", 1.0, 1);
    let put = |name: &str, bytes: &[u8]| {
        fs::write(films.path(name), bytes).unwrap();
        films.path(name)
    };
    let exr = fs::read(&a).unwrap();
    let saved = Films::film(1.0, 1, 0..4).encode();
    refused(&["compare", &a, &put("cut.exr", &exr[..exr.len() / 2])], &["cut.exr: OpenEXR: "]);
    refused(&["compare", &a, &put("text.exr", b"no picture")], &["text.exr: is no image; read are PNG"]);
    refused(&["compare", &a, &films.path("absent.exr")], &["absent.exr: cannot be read"]);
    refused(&["compare", &a, &put("huge.pfm", b"PF\n100000 100000\n-1\n")], &["at most 268435456 are read"]);
    refused(&["compare", &a, &put("small.pfm", b"Pf\n1 1\n-1\n\0\0\0\0")], &["the sizes differ", "32 x 32", "1 x 1"]);
    let cut = put("cut.checkpoint", &saved[..saved.len() / 2]);
    refused(&["merge", &cut, "-o", &films.path("x.exr")], &["cut.checkpoint: it ends before its pixel"]);
}

/// Mitsuba's references with their variance of one sample: each equals itself, and no other.
#[test]
fn references_of_another_renderer() {
    let Some(folder) = data("scenes/mitsuba/tests/scenes/bsdf_spheres/refs") else { return };
    let file = |name: &str| folder.join(format!("test_{name}_ref_rgb.exr")).display().to_string();
    let variance = folder.join("test_constant_ref_rgb_var.exr").display().to_string();
    let (constant, light) = (file("constant"), file("arealight"));
    let by_variance = ["--variance-b", &variance, "--spp-b", "64"];
    let other = compare_json(&[&[light.as_str(), &constant], by_variance.as_slice()].concat(), 1);
    assert_eq!(other["noise"]["untested"], 0, "negative variances are the least one, as in Mitsuba's test");
    assert_eq!(compare_json(&[&constant, &constant], 0)["identical"], true);
}
