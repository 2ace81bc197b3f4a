//! Data flows one way through the layers of `src`: no layer names a later one.
//!
//! Unit tests may: an oracle often comes from a later layer. The block `#[cfg(test)] mod … {` at the bottom of a file
//! is not scanned, nor are the files and folders of modules declared by `#[cfg(test)] mod …;`, nor comments.

use std::fs;
use std::path::{Path, PathBuf};

const LAYERS: [&str; 11] =
    ["math", "image", "sampling", "bsdf", "integrate", "validate", "scene", "render", "converge", "report", "cli"];

/// The layers after `layer` that `source` names in its paths, with the line on which it does.
fn later_layers_named(layer: &str, source: &str) -> Vec<(usize, &'static str)> {
    let at = LAYERS.iter().position(|l| *l == layer).expect("a layer");
    let lines: Vec<&str> = source.lines().collect();
    let tests = (0..lines.len()).find(|&at| test_module(&lines, at).is_some_and(|declared| declared.ends_with('{')));
    let code = &lines[..tests.unwrap_or(lines.len())];
    let mut found = Vec::new();
    for later in &LAYERS[at + 1..] {
        for (number, line) in code.iter().enumerate() {
            let line = line.split("//").next().unwrap_or_default();
            let names = |path: &str| {
                line.match_indices(path).any(|(start, _)| {
                    let rest = line[start + path.len()..].chars().next();
                    !rest.is_some_and(|c| c.is_alphanumeric() || c == '_')
                })
            };
            if names(&format!("crate::{later}")) {
                found.push((number + 1, *later));
            }
        }
    }
    found
}

/// What follows `#[cfg(test)]` on line `at`, past other attributes, if it is a module: `mod name;` or `mod name {`.
fn test_module<'a>(lines: &[&'a str], at: usize) -> Option<&'a str> {
    let item = lines[at..].iter().map(|line| line.trim()).skip_while(|line| line.starts_with("#["));
    let item = item.take(usize::from(lines[at].trim() == "#[cfg(test)]")).next()?;
    (item.starts_with("mod ") || item.contains(" mod ")).then_some(item)
}

/// The names of modules that `source` declares for tests alone, in files of their own.
fn test_modules(source: &str) -> Vec<&str> {
    let lines: Vec<&str> = source.lines().collect();
    (0..lines.len()).filter_map(|at| test_module(&lines, at)?.strip_suffix(';')?.rsplit(' ').next()).collect()
}

/// Whether a file, or a folder that it lies in, is such a module.
fn is_for_tests(src: &Path, path: &Path) -> bool {
    path.ancestors().take_while(|module| *module != src).any(|module| {
        let parent = fs::read_to_string(module.with_file_name("mod.rs")).unwrap_or_default();
        test_modules(&parent).iter().any(|name| module.file_stem().is_some_and(|stem| stem == *name))
    })
}

/// `use crate::{a, b}` would hide a layer from the scan above; each layer has its own line.
fn has_grouped_import_of_layers(source: &str) -> bool {
    source.lines().any(|line| !line.trim_start().starts_with("//") && line.contains("crate::{"))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return all };
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            all.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
    all.sort();
    all
}

#[test]
fn no_layer_names_a_later_one() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut scanned = 0;
    for layer in LAYERS {
        for path in sources(&src.join(layer)) {
            let source = fs::read_to_string(&path).expect("a readable source");
            if is_for_tests(&src, &path) {
                continue;
            }
            let found = later_layers_named(layer, &source);
            assert!(found.is_empty(), "{}: {found:?} come after {layer}", path.display());
            assert!(!has_grouped_import_of_layers(&source), "{}: import each layer on its own line", path.display());
            scanned += 1;
        }
    }
    assert!(scanned > 20, "only {scanned} files were found: the scan has lost its subject");
}

#[test]
fn every_folder_of_src_is_a_layer() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(src).expect("a readable folder") {
        let path = entry.expect("a readable folder").path();
        let name = path.file_name().and_then(|n| n.to_str()).expect("a name").to_string();
        assert!(!path.is_dir() || LAYERS.contains(&name.as_str()), "{name} has no place in the order of layers");
    }
}

#[test]
fn the_scan_sees_what_it_must() {
    let source = "use crate::math::sphere;\nuse crate::validate::Check;\nlet x = crate::cli::main();\n";
    assert_eq!(later_layers_named("bsdf", source), [(2, "validate"), (3, "cli")]);
    assert_eq!(later_layers_named("cli", source), []);
    let innocent = "// crate::cli\nuse crate::clip;\n#[cfg(test)]\nmod tests {\n    use crate::cli;\n}\n";
    assert_eq!(later_layers_named("math", innocent), []);
    let declared = "#[cfg(test)]\npub(crate) mod oracle;\nuse crate::bsdf;\n";
    assert_eq!(test_modules(declared), ["oracle"]);
    assert_eq!(later_layers_named("math", declared), [(3, "bsdf")], "what follows a declaration is scanned");
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let [tests, code] =
        ["tests/density.rs", "map.rs"].map(|file| is_for_tests(&src, &src.join("render/photon").join(file)));
    assert!(tests && !code);
    assert!(has_grouped_import_of_layers("use crate::{bsdf, cli};"));
}
