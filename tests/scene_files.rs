//! Scene files that users have: real ones, where the data is at hand.

#![allow(clippy::print_stderr, reason = "a test that skips says so")]

use std::path::{Path, PathBuf};

use whitefurnace::scene::file::{LoadOptions, Loaded, SceneError, load};
use whitefurnace::scene::{SceneDescription, Shape};

/// The folder of real scenes, or None with a printed line.
fn scenes() -> Option<PathBuf> {
    let data = std::env::var_os("WHITEFURNACE_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    let scenes = data.join("scenes");
    if scenes.is_dir() {
        return Some(scenes);
    }
    eprintln!("skipped: no {}; WHITEFURNACE_DATA names the folder of real data", scenes.display());
    None
}

fn strictly(path: &Path) -> Result<Loaded, SceneError> {
    load(path, &LoadOptions::default())
}

#[test]
fn bitterli_scenes_in_both_spellings() {
    let Some(scenes) = scenes() else { return };
    let cornell = strictly(&scenes.join("bitterli/cornell-box/mitsuba_v3.xml")).unwrap();
    assert_eq!(cornell.warnings, [""; 0]);
    assert_eq!((cornell.scene.film.width, cornell.scene.film.height), (1024, 1024));
    assert_eq!((cornell.scene.shapes.len(), cornell.scene.materials.len()), (8, 8));
    let old = strictly(&scenes.join("bitterli/veach-mis/mitsuba_v05.xml")).unwrap().scene;
    // The file's own integrator is not ours, which is an error; from outside, another can be named.
    let path = scenes.join("bitterli/veach-mis/mitsuba_v3.xml");
    let error = strictly(&path).unwrap_err().to_string();
    assert!(error.contains("line 8: <integrator type=\"path_guiding_integrator\">"), "{error}");
    let params = vec![("integrator".to_string(), "path".to_string())];
    let new = load(&path, &LoadOptions { params, lenient: false }).unwrap().scene;
    // They differ in names alone.
    let shapes = |scene: &SceneDescription| {
        let plain = |s: &Shape| format!("{:?} {} {:?}", s.geometry, s.material, s.emission);
        scene.shapes.iter().map(plain).collect::<Vec<_>>()
    };
    assert_eq!(shapes(&old), shapes(&new));
    assert_eq!(format!("{:?}", old.camera), format!("{:?}", new.camera));
}
