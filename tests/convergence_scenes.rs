//! Whole images in the convergence lab: rates, floors that a bias leaves and an honest renderer does not, studies that go on.

#![allow(clippy::print_stderr, reason = "figures for the reader")]

mod real_data;

use std::path::Path;
use std::process::Output;
use std::sync::atomic::AtomicBool;

use assert_cmd::Command;
use serde_json::Value;
use statrs::distribution::{ContinuousCDF, Normal};
use whitefurnace::converge::image::{
    ImageConvergence, ImageLab, ImageStudy, Numbers, Reference, State, View, estimator,
};
use whitefurnace::converge::{Study, Theory, Verdict};
use whitefurnace::render::path::{PathTracer, Roulette};
use whitefurnace::sampling::filter::Filter;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::Scene;
use whitefurnace::scene::builtin::builtin;
use whitefurnace::scene::file::{LoadOptions, load};

use real_data::data;

/// The probability that a verdict is wrong by chance: the seeds are fixed, so it will not be.
const LEVEL: f64 = 1e-4;

/// In a room without a lamp in sight all pixels count alike. In the Cornell box the few on the edge of the lamp have most of the
/// mean square error, and it takes more than a test's time to know a rate.
fn room(name: &str) -> Scene {
    let scene = builtin(name, &[]).expect("a built-in scene").expect("a sound one");
    Scene::new(scene).expect("a scene").with_size(12, 12)
}

fn tracer(bounces: u32) -> PathTracer {
    PathTracer { bounces: Some(bounces), roulette: Roulette::Off, ..PathTracer::default() }
}

fn reference(view: &View, tracer: &PathTracer, samples: u64) -> Reference {
    let numbers = Numbers { sampler: SamplerKind::Independent, seed: 1_000_003, samples };
    let mut film = view.blank();
    view.raise(tracer, numbers, &mut film, &AtomicBool::new(false), &mut |_, _| {});
    Reference::of_film(&film).expect("finite samples")
}

fn study(
    view: View,
    tracer: &PathTracer,
    sampler: SamplerKind,
    counts: &[u64],
    reference: Option<&Reference>,
) -> ImageConvergence {
    let plan = Study { counts: counts.to_vec(), replicates: 24, seed: 1, number: 0, sampler };
    let lab = ImageLab { view, reference, studies: vec![ImageStudy { radiance: tracer, plan }] };
    let mut state = State::default();
    lab.go_on(&mut state, &AtomicBool::new(false), &mut |_| {});
    lab.found(&state).swap_remove(0)
}

/// The probability of so high a floor without a bias.
fn p_of_floor(found: &ImageConvergence) -> f64 {
    Normal::standard().sf(found.floor().expect("a floor").z.expect("a reference of known error"))
}

#[test]
fn independent_samples_have_their_rate_and_every_strategy_the_same_mean() {
    let scene = room("cube-one-emitter");
    let view = View { scene: &scene, filter: &Filter::BOX, pixel: None };
    let known = reference(&view, &tracer(3), 1024);
    for name in ["mis", "direct", "random-connect", "balance", "split=3", "roulette=0.7"] {
        let tracer = estimator::tracer(name, tracer(3)).expect("a known name");
        let found = study(view, &tracer, SamplerKind::Independent, &[2, 4, 8, 16, 32], Some(&known));
        let theory = Theory::of(SamplerKind::Independent);
        assert_eq!(theory.verdict(found.fit.as_ref(), found.heavy, LEVEL), Verdict::Agrees, "{name}: {found:?}");
        let fit = found.fit.expect("a fit");
        assert!((fit.slope + 0.5).abs() < fit.half_width(0.999), "{name}: {fit:?}");
        assert!(p_of_floor(&found) >= LEVEL, "{name}: {:?}", found.floor());
    }
}

#[test]
fn a_bounce_less_is_a_floor_that_the_reference_does_not_explain() {
    let scene = room("cornell-original");
    let view = View { scene: &scene, filter: &Filter::BOX, pixel: None };
    let known = reference(&view, &tracer(2), 512);
    let counts = [8, 16, 32, 64];
    let honest = study(view, &tracer(2), SamplerKind::Independent, &counts, Some(&known));
    assert!(p_of_floor(&honest) >= LEVEL, "{:?}", honest.floor());
    let short = study(view, &tracer(1), SamplerKind::Independent, &counts, Some(&known));
    assert!(p_of_floor(&short) < LEVEL, "the second bounce is not missed: {:?}", short.floor());
    // The spread does not know of it.
    let ratio = short.variance() / honest.variance();
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
}

#[test]
fn nets_beat_independent_samples_in_an_image() {
    let scene = room("cube-one-emitter");
    let view = View { scene: &scene, filter: &Filter::BOX, pixel: None };
    let [independent, sobol] = [SamplerKind::Independent, SamplerKind::Sobol]
        .map(|kind| study(view, &tracer(1), kind, &[4, 8, 16, 32, 64], None));
    assert!(sobol.variance() < 0.6 * independent.variance());
    let fit = sobol.fit.expect("a fit");
    assert_eq!(Theory::of(SamplerKind::Sobol).verdict(Some(&fit), sobol.heavy, LEVEL), Verdict::Agrees, "{fit:?}");
    assert_eq!(Theory::of(SamplerKind::Independent).verdict(Some(&fit), sobol.heavy, LEVEL), Verdict::Differs);
    assert!(sobol.floor().is_none(), "there is no reference");
}

fn run(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whitefurnace")).args(args).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn prints(args: &[&str], status: i32) -> String {
    let output = run(args);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {}{}", text(&output.stdout), text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{args:?}");
    text(&output.stdout)
}

fn refused(args: &[&str], needle: &str) {
    let output = run(args);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
    assert!(error.starts_with("error: ") && error.lines().count() == 1, "{args:?}: {error}");
    assert!(error.contains(needle), "{args:?}: {error}");
}

fn small<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["converge", "scene:cube-one-emitter", "--size", "12x12", "--bounces", "2"], more].concat()
}

fn report(folder: &Path) -> Value {
    let json = std::fs::read_to_string(folder.join("convergence.json")).expect("a report");
    serde_json::from_str(&json).expect("JSON")
}

/// Everything but times.
fn timeless(mut report: Value) -> Value {
    for study in report["studies"].as_array_mut().expect("studies") {
        for time in ["seconds_per_sample", "efficiency"] {
            study[time] = Value::Null;
        }
    }
    report
}

#[test]
fn the_command_says_what_it_has_found_and_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("study");
    let typed = ["--estimator", "mis,direct", "--sampler", "independent,sobol", "--n", "4..64", "--replicates", "24"];
    let shown = prints(&small(&[&typed[..], &["--out", out.to_str().unwrap(), "--equal-time"]].concat()), 0);
    for words in ["12 x 12 pixels", "reference: own", "no bias is seen", "the least error at equal time: "] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    let found = report(&out);
    assert_eq!(
        (&found["schema"], &found["image"]["width"], &found["image"]["height"]),
        (&1.into(), &12.into(), &12.into())
    );
    let studies = found["studies"].as_array().unwrap();
    assert!(studies.len() == 4 && studies.iter().all(|study| study["bias"] == "none seen"), "{found}");
    assert!(studies.iter().all(|study| study["points"][4]["floor_std_err"].as_f64().unwrap() > 0.0));
    let csv = std::fs::read_to_string(out.join("convergence.csv")).unwrap();
    assert!(csv.lines().count() == 1 + 4 * 5 && csv.starts_with("estimator,sampler,n,rmse,"), "{csv}");
    assert!(out.join("convergence.svg").exists() && !out.join("convergence.state").exists());
    // Its reference states its own error, and so serves again: for an estimator without the second bounce it is a twin to
    // be told apart.
    let picture = out.join("reference.exr");
    let again = ["--reference", picture.to_str().unwrap(), "--n", "4..64", "--replicates", "24", "--seed", "2"];
    assert!(prints(&small(&again), 0).contains("no bias is seen"));
    let short = ["converge", "scene:cube-one-emitter", "--bounces", "1"];
    assert!(prints(&[&short[..], &again].concat(), 1).contains("a bias"));
    // Without an error of its own a picture is only a floor.
    let bare = folder.path().join("bare.pfm");
    let image = whitefurnace::image::Image::read(&picture).unwrap();
    std::fs::write(&bare, image.encode(whitefurnace::image::Format::Pfm, 0.0).unwrap()).unwrap();
    let bare = ["--reference", bare.to_str().unwrap(), "--n", "4..64", "--replicates", "24"];
    assert!(prints(&small(&bare), 0).contains("which is not stated"));
    assert!(prints(&small(&[&bare[..], &["--reference-error", "0.05"]].concat()), 0).contains("no bias is seen"));
    assert!(prints(&small(&["--reference", "none", "--n", "4..64", "--replicates", "24"]), 0).contains("no reference"));
}

#[test]
fn an_interrupted_study_goes_on_to_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, broken) = (folder.path().join("whole"), folder.path().join("broken"));
    let args = |out: &Path| -> Vec<String> {
        let typed = ["--n", "4..256", "--replicates", "16", "--estimator", "mis,bsdf", "--out"];
        let all = small(&typed).into_iter().map(String::from);
        all.chain([out.to_str().unwrap().to_string()]).collect()
    };
    let args_of = |out: &Path| args(out).leak().iter().map(String::as_str).collect::<Vec<_>>();
    run(&args_of(&whole));
    let mut stops = 0;
    #[cfg(unix)]
    for _ in 0..3 {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_whitefurnace"))
            .args(args(&broken))
            .stdout(std::process::Stdio::null())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(std::time::Duration::from_millis(250));
        // As Ctrl-C does.
        let pid = child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
        let code = child.wait().unwrap().code();
        stops += usize::from(code == Some(3) && broken.join("reference.wfc").exists());
    }
    // A study of other settings is not mixed with this one.
    if broken.join("convergence.state").exists() || broken.join("reference.wfc").exists() {
        refused(&[&args_of(&broken)[..], &["--seed", "9"]].concat(), "--restart begins anew");
    }
    run(&args_of(&broken));
    assert_eq!(timeless(report(&whole)), timeless(report(&broken)), "after {stops} interruptions");
    let pictures = [&whole, &broken].map(|out| whitefurnace::image::Image::read(&out.join("reference.exr")).unwrap());
    assert!(pictures[0] == pictures[1]);
    // What is no state is refused, and --restart begins anew.
    std::fs::write(broken.join("convergence.state"), b"WFSTUDY\n\x01\0\0\0").unwrap();
    refused(&args_of(&broken), "it ends before its settings; --restart begins anew");
    std::fs::write(broken.join("convergence.state"), b"something else").unwrap();
    refused(&args_of(&broken), "is no state of a study");
    let quick = ["--n", "4..64", "--replicates", "24", "--out", broken.to_str().unwrap(), "--restart"];
    prints(&small(&quick), 0);
}

#[test]
fn bad_input_is_one_line() {
    refused(&["converge", "scene:cornell-orginal"], "did you mean cornell-original");
    refused(&["converge", "scene:cornell-original@700,2"], "columns and rows count from 0");
    refused(&small(&["--estimator", "drect"]), "did you mean direct?");
    refused(&small(&["--estimator", "split=0"]), "allowed is a whole number from 1");
    refused(&small(&["--estimator", "nonsense"]), "random-connect");
    refused(&small(&["--sampler", "sobl"]), "did you mean sobol?");
    refused(&small(&["--replicates", "3"]), "allowed are 4 to 4096");
    refused(&small(&["--n", "5..7"]), "no power of two");
    refused(&small(&["--reference", "no/such.exr"]), "no/such.exr");
    refused(&small(&["--reference-error", "0.1", "--reference", "own"]), "the reference is no picture");
    refused(&["converge", "scene:cornell-original", "--size", "60000x60000"], "fill more than");
    refused(&small(&["--param", "nothing=1"]), "nothing");
    refused(&["converge", "irradiance:unit-square", "--size", "4x4"], "--size: irradiance:unit-square is no scene");
}

#[test]
fn a_pixel_is_a_target_too() {
    let typed = ["converge", "scene:cornell-original@100,300", "--n", "16..1024", "--bounces", "1"];
    let shown = prints(&typed, 0);
    assert!(shown.contains("column 100 and row 300") && shown.contains("no bias is seen"), "{shown}");
}

/// Scenes and references of others: the rate is ours alone, and the floor is as small as the two programs agree. Small, filtered
/// by a box, against the means of blocks of their pixels.
#[test]
fn the_images_of_others_are_floors() {
    for (name, picture, size, params, bounces, allowed) in [
        // Blocks of these two references differ by up to 1.9 %.
        (
            "scenes/bitterli/cornell-box/mitsuba_v3.xml",
            "scenes/bitterli/cornell-box/ref_tungsten.exr",
            16,
            None,
            None,
            0.02,
        ),
        (
            "scenes/bitterli/cornell-box/mitsuba_v3.xml",
            "scenes/bitterli/cornell-box/ref_mitsuba3.exr",
            16,
            None,
            None,
            0.02,
        ),
        // The edges of its lamps are filtered otherwise.
        (
            "scenes/bitterli/veach-mis/mitsuba_v3.xml",
            "scenes/bitterli/veach-mis/ref_tungsten.exr",
            32,
            Some("path"),
            Some(1),
            1.0,
        ),
    ] {
        let (Some(path), Some(picture)) = (data(name), data(picture)) else { return };
        let params = params.map(|value: &str| ("integrator".to_string(), value.to_string())).into_iter().collect();
        let loaded = load(&path, &LoadOptions { params, lenient: false }).expect("a scene");
        let image = whitefurnace::image::Image::read(&picture).expect("a picture");
        let height = size * image.height() / image.width();
        let scene = Scene::new(loaded.scene).expect("a sound scene").with_size(size, height);
        let known = Reference::of_image(&image, [size, height]).expect("a whole part of it");
        let bounces = bounces.or(scene.render_settings().bounces.flatten());
        let tracer = PathTracer { bounces, ..PathTracer::default() };
        let view = View { scene: &scene, filter: &Filter::BOX, pixel: None };
        let found = study(view, &tracer, SamplerKind::Independent, &[4, 8, 16, 32, 64], Some(&known));
        let floor = found.floor().expect("a floor");
        eprintln!("{}: floor {floor:?}, mean {}, fit {:?}", picture.display(), known.mean(), found.fit);
        assert!(floor.z.is_none(), "the picture does not state its error");
        let verdict = Theory::of(SamplerKind::Independent).verdict(found.fit.as_ref(), found.heavy, LEVEL);
        // Edges of lamps of radiance 900 have nearly all of the mean square error of veach-mis.
        assert!(verdict == Verdict::Agrees || bounces == Some(1), "{found:?}");
        assert_ne!(verdict, Verdict::Differs, "{found:?}");
        let bound = (allowed * known.mean()).powi(2) + 4.0 * floor.std_err;
        assert!(floor.value < bound, "{}: {floor:?} above {bound}", picture.display());
    }
}
