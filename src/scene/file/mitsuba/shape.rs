//! Shapes.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::colour::Role;
use super::document::NodeId;
use super::props::Props;
use super::{Context, bsdf};
use crate::math::color::Rgb;
use crate::scene::file::error::SceneError;
use crate::scene::file::{obj, ply};
use crate::scene::mesh::Mesh;
use crate::scene::shape::{Geometry, Shape};

const KNOWN: [&str; 7] = ["rectangle", "cube", "sphere", "disk", "cylinder", "obj", "ply"];

/// A mesh as it is in its file, and whether it has normals of its own.
pub(super) type Loaded = (Arc<Mesh>, bool);

/// Adds the shape `id` to the scene.
pub(super) fn add(context: &Context<'_>, id: NodeId) -> Result<(), SceneError> {
    let props = Props::new(context.document, id)?;
    let to_world = props.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    let mut flip_normals = props.boolean("flip_normals", false)?;
    let geometry = match props.node.kind.as_str() {
        "rectangle" => Geometry::Rectangle { to_world },
        "cube" => Geometry::Cube { to_world },
        "sphere" => sphere(context, &props, &to_world)?,
        "disk" => {
            check_round(context, &props, &to_world)?;
            Geometry::Disk { to_world }
        }
        "cylinder" => cylinder(context, &props, &to_world)?,
        "obj" | "ply" => {
            let (mesh, own_normals) = mesh(context, &props)?;
            // A mirror turns the corners of triangles around, and with them the normals that are computed from them.
            flip_normals ^= !own_normals && to_world.matrix3.determinant() < 0.0;
            let moved = if to_world == DAffine3::IDENTITY {
                mesh
            } else {
                let moved = Mesh::clone(&mesh).transformed(to_world);
                Arc::new(moved.map_err(|source| SceneError::Mesh { place: props.place(), source })?)
            };
            Geometry::Mesh(moved)
        }
        _ => {
            context.notes.unsupported(props.unknown_kind(&KNOWN), "it is left out")?;
            return Ok(());
        }
    };
    let material = bsdf::index(context, props.object("bsdf")?)?;
    let emission = match props.object("emitter")? {
        Some(emitter) => emission(context, emitter)?,
        None => None,
    };
    props.no_effect(&["silhouette_sampling_weight"]);
    let shapes = context.shapes.borrow().len();
    let name = if props.node.id.is_empty() {
        let file = props.string("filename").ok().flatten().unwrap_or(&props.node.kind);
        let stem = std::path::Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
        format!("{stem}-{shapes}")
    } else {
        props.node.id.clone()
    };
    props.finish(context.notes)?;
    context.shapes.borrow_mut().push(Shape { name, geometry, flip_normals, material, emission });
    Ok(())
}

fn emission(context: &Context<'_>, id: NodeId) -> Result<Option<Rgb>, SceneError> {
    let props = Props::new(context.document, id)?;
    if props.node.kind != "area" {
        context.notes.unsupported(props.unknown_kind(&["area"]), "the shape does not shine")?;
        return Ok(None);
    }
    let radiance = props.colour("radiance", Role::Light, context.notes)?.unwrap_or(Rgb::WHITE);
    props.no_effect(&["sampling_weight"]);
    props.finish(context.notes)?;
    Ok(Some(radiance))
}

/// The mesh in the file that `props` names, and whether it has normals of its own.
fn mesh(context: &Context<'_>, props: &Props<'_>) -> Result<Loaded, SceneError> {
    let Some(file) = props.string("filename")? else {
        return Err(props.missing("filename", "the name of a file"));
    };
    let path = context.document.find_file(props.node, file);
    let flat = props.boolean("face_normals", false)?;
    let kind = props.node.kind.as_str();
    let flip_v = props.boolean("flip_tex_coords", kind == "obj")?;
    let key = (path.clone(), format!("{kind} {flat} {flip_v}"));
    if let Some(known) = context.meshes.borrow().get(&key) {
        return Ok(known.clone());
    }
    let place = props.place();
    let failed = |source| SceneError::Mesh { place: place.clone(), source };
    let mesh = match kind {
        "obj" => obj::read(&path, Some(&place), context.notes)?.whole().map_err(failed)?,
        _ => ply::load(&path, Some(&place))?,
    };
    let own = !mesh.normals().is_empty() && !flat;
    let mesh = match (flat, own) {
        (true, _) => mesh.faceted(),
        (false, true) => mesh,
        (false, false) => mesh.smoothed(),
    };
    let known = (Arc::new(if flip_v { mesh.with_flipped_v() } else { mesh }), own);
    context.meshes.borrow_mut().insert(key, known.clone());
    Ok(known)
}

/// The lengths of the images of the axes.
fn scales(to_world: &DAffine3) -> DVec3 {
    let m = to_world.matrix3;
    DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
}

/// Whether two lengths agree as well as an exporter's five digits let them.
fn agree(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-3 * a.abs().max(b.abs())
}

fn sphere(context: &Context<'_>, props: &Props<'_>, to_world: &DAffine3) -> Result<Geometry, SceneError> {
    let centre = props.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = props.positive("radius", 1.0)?;
    let scales = scales(to_world);
    if !(agree(scales.x, scales.y) && agree(scales.x, scales.z)) {
        let error = props.unsupported("to_world", "an ellipsoid", "the same scale along every axis");
        context.notes.unsupported(error, "the scale along x counts")?;
    }
    let radius = radius * scales.x;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(props.bad("to_world", "a scale that leaves no radius", "a radius > 0"));
    }
    Ok(Geometry::Sphere { centre: to_world.transform_point3(centre), radius })
}

fn cylinder(context: &Context<'_>, props: &Props<'_>, to_world: &DAffine3) -> Result<Geometry, SceneError> {
    let from = props.vector("p0")?.unwrap_or(DVec3::ZERO);
    let to = props.vector("p1")?.unwrap_or(DVec3::Z);
    let radius = props.positive("radius", 1.0)?;
    let Some(axis) = (to - from).try_normalize() else {
        return Err(props.bad("p1", "the same as p0", "another point"));
    };
    let (u, v) = axis.any_orthonormal_pair();
    let [u, v, w] = [u, v, axis].map(|direction| to_world.transform_vector3(direction));
    let upright = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-3 * a.length() * b.length();
    if !(agree(u.length(), v.length()) && upright(u, v) && upright(u, w) && upright(v, w)) {
        let error = props.unsupported("to_world", "a cylinder out of round", "the same scale across the axis");
        context.notes.unsupported(error, "it stays round")?;
    }
    let radius = radius * u.length();
    if !(radius > 0.0 && radius.is_finite() && w.length() > 0.0) {
        return Err(props.bad("to_world", "a scale that leaves nothing", "a radius > 0"));
    }
    Ok(Geometry::Cylinder { from: to_world.transform_point3(from), to: to_world.transform_point3(to), radius })
}

fn check_round(context: &Context<'_>, props: &Props<'_>, to_world: &DAffine3) -> Result<(), SceneError> {
    let (scales, m) = (scales(to_world), to_world.matrix3);
    if agree(scales.x, scales.y) && m.x_axis.dot(m.y_axis).abs() <= 1e-3 * scales.x * scales.y {
        return Ok(());
    }
    let error = props.unsupported("to_world", "an elliptic disk", "the same scale along x and y");
    context.notes.unsupported(error, "it is drawn as it comes")
}
