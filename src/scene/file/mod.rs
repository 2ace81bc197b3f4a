//! Scene files: Mitsuba XML (version 3, and the spelling of 0.4 to 0.6), OBJ with MTL, PLY, and glTF 2.0.
//!
//! What a file asks for and this program lacks is an error that names file, line and element; with
//! [`LoadOptions::lenient`] it is a warning, and the nearest thing takes its place. A scene is never silently another.
//! Files are not trusted: memory and time are bounded, whatever they say.

mod assembly;
mod error;
mod gltf;
mod mitsuba;
mod obj;
mod ply;
mod serialized;
mod source;
#[cfg(test)]
mod testing;

use std::cell::RefCell;
use std::path::Path;

pub use error::{At, Place, SceneError};

use super::description::SceneDescription;

/// How to read a file.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Values for the `$names` of a Mitsuba file, which go before those it declares.
    pub params: Vec<(String, String)>,
    /// Whether what is not supported is a warning instead of an error.
    pub lenient: bool,
}

/// What a file describes.
#[derive(Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: SceneDescription,
    /// What the reader of the picture should know, one line each.
    pub warnings: Vec<String>,
}

/// Reads the scene in `path`.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, SceneError> {
    let notes = Notes::new(options.lenient);
    let scene = match format_of(path)? {
        Format::Mitsuba => mitsuba::load(path, options, &notes)?,
        Format::Obj => obj::load(path, &notes)?,
        Format::Ply => ply::load_scene(path, &notes)?,
        Format::Gltf => gltf::load(path, &notes)?,
    };
    Ok(Loaded { scene, warnings: notes.into_warnings() })
}

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Mitsuba,
    Obj,
    Ply,
    Gltf,
}

/// The format of `path`: by its first bytes where they tell, else by its extension.
fn format_of(path: &Path) -> Result<Format, SceneError> {
    let start = source::read_start(path)?;
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start).trim_ascii_start();
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        _ if text.starts_with(b"ply") && text.get(3).is_some_and(u8::is_ascii_whitespace) => Ok(Format::Ply),
        _ if start.starts_with(b"glTF") || text.starts_with(b"{") => Ok(Format::Gltf),
        _ if text.starts_with(b"<") => Ok(Format::Mitsuba),
        "xml" => Ok(Format::Mitsuba),
        "obj" => Ok(Format::Obj),
        "ply" => Ok(Format::Ply),
        "gltf" | "glb" => Ok(Format::Gltf),
        _ => Err(SceneError::Unsupported {
            place: Place::whole(path),
            what: format!("a file of type {}", error::quoted(&extension)),
            known: "Mitsuba XML (.xml), Wavefront OBJ (.obj), PLY (.ply), glTF 2.0 (.gltf, .glb)".into(),
        }),
    }
}

/// The warnings so far, and whether what is not supported is one.
#[derive(Debug)]
struct Notes {
    lenient: bool,
    warnings: RefCell<Vec<String>>,
}

impl Notes {
    /// A file of errors must not fill the memory with warnings.
    const MOST: usize = 1000;

    fn new(lenient: bool) -> Self {
        Self { lenient, warnings: RefCell::default() }
    }

    /// Warns of what changes no picture much, or cannot be decided by the file.
    fn warn(&self, warning: impl Into<String>) {
        let mut warnings = self.warnings.borrow_mut();
        if warnings.len() < Self::MOST {
            warnings.push(warning.into());
        } else if warnings.len() == Self::MOST {
            warnings.push("more warnings are not shown".to_string());
        }
    }

    /// `error` if readers are strict; else a warning that says what takes its place.
    fn unsupported(&self, error: SceneError, instead: &str) -> Result<(), SceneError> {
        if !self.lenient {
            return Err(error);
        }
        self.warn(format!("{error}; {instead}"));
        Ok(())
    }

    fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }
}
