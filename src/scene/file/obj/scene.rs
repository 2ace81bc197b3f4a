//! An OBJ file as a scene: one shape for every group and material.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::mtl::{self, Finish};
use super::{Obj, read};
use crate::scene::description::SceneDescription;
use crate::scene::file::Notes;
use crate::scene::file::assembly::Parts;
use crate::scene::file::error::{Place, SceneError, listed, quoted};
use crate::scene::material::Material;
use crate::scene::shape::{Geometry, Shape};
use crate::scene::texture::Texture;

/// The scene in `path`.
pub(in crate::scene::file) fn load(path: &Path, notes: &Notes) -> Result<SceneDescription, SceneError> {
    let obj = read(path, None, notes)?;
    let mut library = library(path, &obj, notes)?;
    let mut parts = Parts::default();
    let mut used: BTreeMap<&str, usize> = BTreeMap::new();
    let mut emissions = Vec::new();
    for group in &obj.groups {
        let place = Place::line(path, group.line);
        let known = used.get(group.material.as_str()).copied();
        let index = if let Some(index) = known {
            index
        } else {
            let finish = match library.remove(&group.material) {
                Some(finish) => finish,
                None => unnamed(&obj, &group.material, &place, &library, notes)?,
            };
            parts.materials.push(finish.material);
            emissions.push(finish.emission);
            used.insert(&group.material, parts.materials.len() - 1);
            parts.materials.len() - 1
        };
        let mesh = obj.group(group).map_err(|source| SceneError::Mesh { place, source })?;
        let name = if group.name.is_empty() { &group.material } else { &group.name };
        parts.shapes.push(Shape {
            name: if name.is_empty() { format!("shape-{}", parts.shapes.len()) } else { name.clone() },
            geometry: Geometry::Mesh(Arc::new(mesh)),
            flip_normals: false,
            material: index,
            emission: emissions[index],
        });
    }
    parts.into_scene(path, notes)
}

/// The materials of all files that `obj` names.
fn library(path: &Path, obj: &Obj, notes: &Notes) -> Result<BTreeMap<String, Finish>, SceneError> {
    let mut library = BTreeMap::new();
    for (file, line) in &obj.libraries {
        let place = Place::line(path, *line);
        match mtl::load(&path.with_file_name(file), &place, notes) {
            Ok(materials) => library.extend(materials),
            // A mesh without its library is still a mesh.
            Err(error @ SceneError::Read { .. }) => notes.unsupported(error, "its materials are grey")?,
            Err(error) => return Err(error),
        }
    }
    Ok(library)
}

/// The material of a group that names none, or one that is not there.
fn unnamed(
    obj: &Obj,
    name: &str,
    place: &Place,
    library: &BTreeMap<String, Finish>,
    notes: &Notes,
) -> Result<Finish, SceneError> {
    if !name.is_empty() {
        let known = listed(library.keys().map(String::as_str));
        let what = format!("the material {}", quoted(name));
        notes.unsupported(SceneError::Unsupported { place: place.clone(), what, known }, "grey takes its place")?;
    }
    let colour = if obj.is_coloured() { Texture::VertexColor } else { Texture::Constant(0.5.into()) };
    Ok(Finish { material: Material::diffuse("default", colour).two_sided(), emission: None })
}
