//! Mitsuba XML: version 3, and the spelling of 0.4 to 0.6.
//!
//! A file means what Mitsuba 3 renders from it in its variant `scalar_rgb`.
//! # References
//! - Jakob et al., Mitsuba 3 documentation (plugins and scene format)

mod bsdf;
mod colour;
mod document;
mod emitter;
mod primitive;
mod props;
#[cfg(test)]
mod refusals;
mod settings;
mod shape;
#[cfg(test)]
mod tests;
mod texture;
mod transform;

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use document::{Document, NodeId};

use super::error::{Place, SceneError, listed};
use super::{LoadOptions, Notes};
use crate::scene::description::SceneDescription;
use crate::scene::light::Light;
use crate::scene::material::Material;
use crate::scene::shape::Shape;

/// What is being built.
struct Context<'a> {
    document: &'a Document,
    notes: &'a Notes,
    materials: RefCell<Vec<Material>>,
    /// The materials of elements that are built already.
    material_of: RefCell<BTreeMap<NodeId, bsdf::Built>>,
    /// What the material being built needs.
    uses: Cell<bsdf::Uses>,
    /// Images as they are in their files, and whether as stored.
    pixels: RefCell<BTreeMap<(PathBuf, bool), texture::Pixels>>,
    /// The triangles so far.
    triangles: Cell<usize>,
    /// Meshes as they are in their files.
    meshes: RefCell<BTreeMap<(PathBuf, String), shape::Loaded>>,
    shapes: RefCell<Vec<Shape>>,
    lights: RefCell<Vec<Light>>,
}

/// Reads the scene in `path`.
pub(super) fn load(path: &Path, options: &LoadOptions, notes: &Notes) -> Result<SceneDescription, SceneError> {
    let document = Document::read(path, &options.params, notes)?;
    let context = Context {
        document: &document,
        notes,
        materials: RefCell::default(),
        material_of: RefCell::default(),
        uses: Cell::default(),
        pixels: RefCell::default(),
        triangles: Cell::default(),
        meshes: RefCell::default(),
        shapes: RefCell::default(),
        lights: RefCell::default(),
    };
    let mut sensors = Vec::new();
    let mut render = None;
    let mut samples = None;
    for &root in &document.roots {
        let id = document.resolve(root)?;
        let node = document.node(id);
        match node.tag.as_str() {
            "shape" => shape::add(&context, id, None)?,
            "emitter" if node.kind == "area" => {}
            "emitter" => emitter::add(&context, id)?,
            "sensor" => sensors.push(id),
            "integrator" => render = Some(settings::integrator(&context, id, 0)?),
            "sampler" => samples = settings::sampler(&context, id)?,
            // Used where a reference asks for them.
            "bsdf" | "texture" | "film" | "rfilter" => {}
            _ => {
                let place = document.place(node);
                let known = listed(["bsdf", "emitter", "integrator", "sensor", "shape", "texture"]);
                let error = SceneError::Unsupported { place, what: node.shown(), known };
                notes.unsupported(error, "it is ignored")?;
            }
        }
    }
    let mut render = render.unwrap_or_default();
    let (camera, film) = match sensors.as_slice() {
        [] => {
            let what = "a <sensor>".to_string();
            return Err(SceneError::Missing { place: Place::whole(path), what, allowed: "one camera".into() });
        }
        [first, others @ ..] => {
            if let Some(&second) = others.first() {
                let node = document.node(second);
                let (place, what) = (document.place(node), "a second <sensor>".to_string());
                let error = SceneError::Unsupported { place, what, known: "one".into() };
                notes.unsupported(error, "the first one counts")?;
            }
            let (camera, film, own) = settings::sensor(&context, *first)?;
            samples = own.or(samples);
            (camera, film)
        }
    };
    render.samples = samples;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(SceneDescription {
        name,
        camera,
        film,
        render,
        materials: context.materials.into_inner(),
        shapes: context.shapes.into_inner(),
        lights: context.lights.into_inner(),
    })
}
