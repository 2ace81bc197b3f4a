//! The lecture's data, notebooks and pictures: what is in the folder is what the commands make.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::AtomicBool;

use assert_cmd::Command;
use rayon::prelude::*;
use serde_json::Value;
use whitefurnace::image::Image;
use whitefurnace::report::contact_sheet::{Settings, draw, shoot};
use whitefurnace::report::figures::{INDEX, SETS, index};
use whitefurnace::scene::Scene;
use whitefurnace::scene::builtin::builtin;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("notebooks-data")
}

fn run(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whitefurnace")).args(args).output().expect("the program starts")
}

/// Exit 2, nothing on standard output, and one line on standard error that says all of `needles`.
fn refused(args: &[&str], needles: &[&str]) {
    let output = run(args);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
    assert!(output.stdout.is_empty() && error.lines().count() == 1, "{args:?}: {error}");
    for needle in needles {
        assert!(error.contains(needle), "{args:?}: {error}");
    }
}

/// The first line in which two texts differ.
fn difference(committed: &str, made: &str) -> Option<String> {
    if committed == made {
        return None;
    }
    let lines = committed.lines().zip(made.lines()).enumerate().find(|(_, (old, new))| old != new);
    Some(match lines {
        Some((at, (old, new))) => format!("line {}: {old:.200} is now {new:.200}", at + 1),
        None => format!("{} bytes are now {}", committed.len(), made.len()),
    })
}

#[test]
fn the_folder_holds_what_the_command_makes() {
    let committed = |name: &str| fs::read_to_string(folder().join(name)).unwrap_or_default();
    // On this many threads at once, whatever the machine has: the bytes do not depend on it.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let made: Vec<Vec<String>> = pool.install(|| SETS.par_iter().map(|set| (set.make)()).collect());
    let mut stale = Vec::new();
    let mut total = 0;
    for (set, contents) in SETS.iter().zip(&made) {
        assert_eq!(set.files.len(), contents.len(), "{}", set.name);
        for (file, content) in set.files.iter().zip(contents) {
            total += content.len();
            stale.extend(difference(&committed(file.name), content).map(|why| format!("{}: {why}", file.name)));
        }
    }
    stale.extend(difference(&committed(INDEX), &index()).map(|why| format!("{INDEX}: {why}")));
    assert!(stale.is_empty(), "make them again with `whitefurnace notebooks-data`: {stale:#?}");
    assert!(total < 1 << 20, "{total} bytes are no longer small");
}

#[test]
fn a_difference_is_seen() {
    assert_eq!(difference("a\nb\n", "a\nb\n"), None);
    assert!(difference("a\nb\n", "a\nc\n").is_some_and(|why| why.starts_with("line 2")));
    assert!(difference("a\nb\n", "a\n").is_some());
}

#[test]
fn data_without_a_folder_are_refused() {
    let out = tempfile::tempdir().expect("a folder");
    let blocked = out.path().join("blocked");
    fs::write(&blocked, "").expect("a file");
    refused(&["notebooks-data", "--out", &blocked.join("data").display().to_string()], &["--out", "cannot be made"]);
    refused(&["notebooks-data", "extra"], &["unexpected argument 'extra'"]);
}

#[test]
fn notebooks_hold_no_outputs() {
    let entries = fs::read_dir(folder()).expect("the folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let notebooks: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|e| e == "ipynb")).collect();
    assert_eq!(notebooks.len(), 6);
    for path in notebooks {
        let name = path.display();
        let book: Value = serde_json::from_str(&fs::read_to_string(&path).expect("text")).expect("JSON");
        assert_eq!(book["nbformat"], 4, "{name}");
        let cells = book["cells"].as_array().expect("cells");
        let code = cells.iter().filter(|cell| cell["cell_type"] == "code");
        assert!(code.clone().count() > 2 && cells.len() > code.clone().count(), "{name} tells no story");
        let asserts = |cell: &&Value| cell["source"].to_string().contains("assert ");
        assert!(code.clone().any(|cell| asserts(&cell)), "{name} asserts nothing");
        for cell in code {
            assert_eq!(cell["outputs"].as_array().map(Vec::len), Some(0), "{name} holds outputs");
            assert!(cell["execution_count"].is_null(), "{name} holds counts");
        }
    }
}

/// The bytes of a sheet of tiny pictures, on so many threads.
fn tiny_sheet(seed: u64, threads: usize) -> Vec<u8> {
    let scene =
        Scene::new(builtin("cornell-original", &[]).expect("a scene").expect("its description")).expect("its trees");
    let settings = Settings { size: (12, 10), seed, exposure: 0.0 };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let shots = pool.install(|| shoot(scene, &settings, &AtomicBool::new(false), &mut |_| ())).expect("all pictures");
    draw("cornell-original", &shots, &settings).expect("a sheet")
}

#[test]
fn a_contact_sheet_has_the_same_bytes_on_any_number_of_threads() {
    let sheet = tiny_sheet(1, 1);
    assert!(sheet == tiny_sheet(1, 3), "the sheet depends on the number of threads");
    assert!(sheet != tiny_sheet(2, 3), "the sheet does not depend on the seed");
}

#[test]
fn a_contact_sheet_is_as_large_as_its_pictures_ask_for() {
    let out = tempfile::tempdir().expect("a folder");
    let path = out.path().join("sheet.png");
    // Black walls, behind which no path goes on.
    let output =
        run(&["contact-sheet", "furnace-box", "--param", "rho=0", "--size", "64", "-o", &path.display().to_string()]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("samples") && said.contains("64x64") && said.contains("sheet.png"), "{said}");
    let image = Image::read(&path).expect("a PNG");
    // Six pictures of 64 pixels, five gaps of 8, two margins of 16; two rows of 64 and one of 136 with what is written.
    assert_eq!(image.width(), 6 * 64 + 5 * 8 + 2 * 16);
    assert!((330..400).contains(&image.height()), "{}", image.height());
    // A room that emits 1/2 everywhere and reflects nothing: 188 of 255 in sRGB, in the first picture and in the last but one.
    for (x, y) in [(40, 90), (image.width() / 2, image.height() - 80)] {
        assert_eq!(image.rgb(x, y), [188.0 / 255.0; 3], "{x} {y}");
    }
    // The difference of two pictures that are the same is black.
    assert_eq!(image.rgb(image.width() - 40, image.height() - 80), [0.0; 3]);
}

#[test]
fn a_contact_sheet_of_nothing_is_refused() {
    refused(&["contact-sheet", "cornel-original"], &["no such built-in scene", "cornell-original"]);
    refused(&["contact-sheet", "-o", "sheet.exr"], &["-o sheet.exr", ".png"]);
    refused(&["contact-sheet", "-o", "no/such/folder/sheet.png"], &["there is no folder"]);
    refused(&["contact-sheet", "--size", "8"], &["64..=1024"]);
    refused(&["contact-sheet", "--param", "rho"], &["name=value"]);
}
