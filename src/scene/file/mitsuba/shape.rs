//! Shapes.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::bsdf::{self, Uses};
use super::colour::Role;
use super::document::NodeId;
use super::props::Props;
use super::{Context, primitive};
use crate::math::color::Rgb;
use crate::scene::file::assembly::MOST_TRIANGLES;
use crate::scene::file::error::{SceneError, quoted};
use crate::scene::file::{obj, ply, serialized};
use crate::scene::mesh::Mesh;
use crate::scene::shape::{Geometry, Shape};

const KNOWN: [&str; 9] = ["rectangle", "cube", "sphere", "disk", "cylinder", "obj", "ply", "serialized", "instance"];
/// A mesh as it is in its file, and whether it has normals of its own.
pub(super) type Loaded = (Arc<Mesh>, bool);

/// Adds the shape `id` to the scene; `placed` is where an instance puts it.
pub(super) fn add(context: &Context<'_>, id: NodeId, placed: Option<DAffine3>) -> Result<(), SceneError> {
    let props = Props::new(context.document, id)?;
    let own = props.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    match props.node.kind.as_str() {
        "instance" => return instance(context, props, own, placed),
        // Seen where instances are.
        "shapegroup" if placed.is_none() => return Ok(()),
        _ => {}
    }
    let to_world = placed.unwrap_or(DAffine3::IDENTITY) * own;
    let mut flip_normals = props.boolean("flip_normals", false)?;
    let emission = match props.object("emitter")? {
        Some(emitter) => emission(context, emitter)?,
        None => None,
    };
    let material = bsdf::built(context, props.object("bsdf")?, emission.is_some())?;
    let geometry = match props.node.kind.as_str() {
        "rectangle" => Geometry::Rectangle { to_world },
        "cube" if material.uses.uv => Geometry::Mesh(moved(context, &props, &Arc::new(textured_cube()), to_world)?),
        "cube" => Geometry::Cube { to_world },
        "sphere" => primitive::sphere(context, &props, &to_world, material.uses.uv)?,
        "disk" => primitive::disk(context, &props, &to_world)?,
        "cylinder" => primitive::cylinder(context, &props, &to_world, material.uses.uv)?,
        "obj" | "ply" | "serialized" => {
            let (mesh, own_normals) = mesh(context, &props)?;
            check_uses(context, &props, &mesh, material.uses)?;
            // A mirror turns the corners of triangles around, and with them the normals that are computed from them.
            flip_normals ^= !own_normals && to_world.matrix3.determinant() < 0.0;
            Geometry::Mesh(moved(context, &props, &mesh, to_world)?)
        }
        _ => {
            context.notes.unsupported(props.unknown_kind(&KNOWN), "it is left out")?;
            return Ok(());
        }
    };
    props.no_effect(&["silhouette_sampling_weight"]);
    let shapes = context.shapes.borrow().len();
    let name = if props.node.id.is_empty() || placed.is_some() {
        let file = props.string("filename").ok().flatten().unwrap_or(&props.node.kind);
        let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
        format!("{stem}-{shapes}")
    } else {
        props.node.id.clone()
    };
    props.finish(context.notes)?;
    let shape = Shape { name, geometry, flip_normals, material: material.index, emission };
    context.shapes.borrow_mut().push(shape);
    Ok(())
}

/// Adds copies of the shapes of a group.
fn instance(
    context: &Context<'_>,
    props: Props<'_>,
    own: DAffine3,
    placed: Option<DAffine3>,
) -> Result<(), SceneError> {
    let Some(group) = props.object("shape")? else {
        return Err(props.missing("a <shape>", "a shapegroup"));
    };
    let group = Props::new(context.document, group)?;
    if group.node.kind != "shapegroup" || placed.is_some() {
        let known = "instances of a shapegroup, whose shapes are no instances";
        return context.notes.unsupported(props.unsupported("", group.node.shown(), known), "it is left out");
    }
    for shape in group.objects("shape") {
        add(context, shape, Some(own))?;
    }
    group.finish(context.notes)?;
    props.finish(context.notes)
}

fn emission(context: &Context<'_>, id: NodeId) -> Result<Option<Rgb>, SceneError> {
    let props = Props::new(context.document, id)?;
    if props.node.kind != "area" {
        context.notes.unsupported(props.unknown_kind(&["area"]), "the shape does not shine")?;
        return Ok(None);
    }
    let textured = props.objects("texture");
    if !textured.is_empty() {
        let error = props.unsupported("radiance", "a textured radiance", "a colour");
        context.notes.unsupported(error, "the shape does not shine")?;
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
    let index = if kind == "serialized" { props.optional_integer("shape_index")?.unwrap_or(0) } else { 0 };
    let Ok(number) = usize::try_from(index) else {
        return Err(props.bad("shape_index", &index.to_string(), "a whole number ≥ 0"));
    };
    if props.optional_float("max_smooth_angle")?.is_some() {
        let error = props.unsupported("max_smooth_angle", "`max_smooth_angle`", "face_normals");
        context.notes.unsupported(error, "it is ignored")?;
    }
    let key = (path.clone(), format!("{kind} {flat} {flip_v} {number}"));
    if let Some(known) = context.meshes.borrow().get(&key) {
        return Ok(known.clone());
    }
    let place = props.place();
    let mesh = match kind {
        "obj" => obj::read(&path, Some(&place), context.notes)?.whole().map_err(|e| failed(props, e))?,
        "ply" => ply::load(&path, Some(&place))?,
        _ => serialized::load(&path, number, Some(&place))?,
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

fn failed(props: &Props<'_>, source: crate::scene::mesh::MeshError) -> SceneError {
    SceneError::Mesh { place: props.place(), source }
}

/// Textures need coordinates.
fn check_uses(context: &Context<'_>, props: &Props<'_>, mesh: &Mesh, uses: Uses) -> Result<(), SceneError> {
    if uses.vertex_color && mesh.colors().is_empty() {
        let error = props.unsupported("", "the colour of vertices that have none", "a mesh with colours");
        context.notes.unsupported(error, "white takes its place")?;
    }
    if uses.uv && mesh.uvs().is_empty() {
        let name = quoted(props.string("filename")?.unwrap_or_default());
        context.notes.warn(format!("{}: {name} has no texture coordinates for its textures", props.place()));
    }
    Ok(())
}

fn moved(
    context: &Context<'_>,
    props: &Props<'_>,
    mesh: &Arc<Mesh>,
    to_world: DAffine3,
) -> Result<Arc<Mesh>, SceneError> {
    context.triangles.set(context.triangles.get() + mesh.triangles().len());
    if context.triangles.get() > MOST_TRIANGLES {
        let (place, what) = (props.place(), "triangles".to_string());
        return Err(SceneError::TooMany { place, what, most: MOST_TRIANGLES as u64 });
    }
    if to_world == DAffine3::IDENTITY {
        return Ok(Arc::clone(mesh));
    }
    Mesh::clone(mesh).transformed(to_world).map(Arc::new).map_err(|e| failed(props, e))
}

/// The cube with Mitsuba's texture coordinates: for every face its outside, and the directions of u and v.
fn textured_cube() -> Mesh {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let faces = [(x, y, -z), (-x, y, z), (y, -x, -z), (-y, z, x), (z, y, x), (-z, -y, x)];
    let (mut positions, mut normals, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (number, (out, u, v)) in (0_u32..).zip(faces) {
        for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            positions.push(out + u * a + v * b);
            uvs.push(DVec2::new(0.5 + 0.5 * a, 0.5 + 0.5 * b));
        }
        normals.extend([out; 4]);
        let corners = if u.cross(v).dot(out) > 0.0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
        triangles.extend(corners.map(|corner| corner.map(|c| 4 * number + c)));
    }
    let mesh = Mesh::new(positions, triangles).and_then(|mesh| mesh.with_normals(normals)?.with_uvs(uvs));
    // Nothing in it depends on a file.
    mesh.unwrap_or_default()
}
