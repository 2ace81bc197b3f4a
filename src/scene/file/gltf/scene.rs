//! Nodes and the meshes, cameras and lights that they place.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3};

use super::buffers::{Buffers, get};
use super::json::{Node, Primitive, Root};
use super::light;
use super::material::{Library, Uses};
use crate::math::color::Rgb;
use crate::scene::camera::{Camera, Projection};
use crate::scene::description::SceneDescription;
use crate::scene::file::Notes;
use crate::scene::file::assembly::{MOST_TRIANGLES, Parts};
use crate::scene::file::error::{Place, SceneError, one_line};
use crate::scene::mesh::Mesh;
use crate::scene::shape::{Geometry, Shape};

/// Nodes within nodes.
const DEEPEST_NODE: usize = 256;

/// The scene that `root` describes.
pub(super) fn build(
    path: &Path,
    root: &Root,
    binary: Option<&[u8]>,
    notes: &Notes,
) -> Result<SceneDescription, SceneError> {
    let buffers = Buffers::load(path, root, binary)?;
    let mut builder = Builder {
        path,
        root,
        notes,
        buffers: &buffers,
        materials: Library::new(path, root, &buffers, notes),
        parts: Parts::default(),
        meshes: BTreeMap::new(),
        visits: 0,
        triangles: 0,
    };
    let place = Place::whole(path);
    match (root.scene, root.scenes.first()) {
        // Without scenes, every node that is no child.
        (None, None) => {
            let mut is_child = vec![false; root.nodes.len()];
            for &child in root.nodes.iter().flat_map(|node| &node.children) {
                if let Some(child) = is_child.get_mut(child) {
                    *child = true;
                }
            }
            for index in (0..root.nodes.len()).filter(|&index| !is_child[index]) {
                builder.node(index, DAffine3::IDENTITY, 0, &place)?;
            }
        }
        (scene, _) => {
            let scene = get(&root.scenes, scene.unwrap_or(0), "scene", &place)?;
            for &index in &scene.nodes {
                builder.node(index, DAffine3::IDENTITY, 0, &place)?;
            }
        }
    }
    let Builder { materials, mut parts, .. } = builder;
    parts.materials = materials.into_materials();
    parts.into_scene(path, notes)
}

struct Builder<'a> {
    path: &'a Path,
    root: &'a Root,
    notes: &'a Notes,
    buffers: &'a Buffers<'a>,
    materials: Library<'a>,
    parts: Parts,
    /// The primitives of meshes that are read already.
    meshes: BTreeMap<(usize, usize), Arc<Mesh>>,
    visits: usize,
    triangles: usize,
}

impl Builder<'_> {
    fn node(&mut self, index: usize, above: DAffine3, depth: usize, asked: &Place) -> Result<(), SceneError> {
        let node = get(&self.root.nodes, index, "node", asked)?;
        let place = Place::element(self.path, format!("nodes[{index}]"));
        self.visits += 1;
        if self.visits > self.root.nodes.len() {
            return Err(SceneError::Malformed {
                place,
                problem: "it is reached twice".into(),
                allowed: "nodes that form trees".into(),
            });
        }
        if depth >= DEEPEST_NODE {
            return Err(SceneError::TooMany { place, what: "nodes in nodes".into(), most: DEEPEST_NODE as u64 });
        }
        let to_world = above * local(node, &place)?;
        if let Some(mesh) = node.mesh {
            if node.skin.is_some() {
                let (place, known) = (place.clone(), "rigid meshes".into());
                let error = SceneError::Unsupported { place, what: "a skin".into(), known };
                self.notes.unsupported(error, "the mesh keeps its own shape")?;
            }
            self.mesh(mesh, node, to_world, &place)?;
        }
        if let Some(camera) = node.camera {
            self.camera(camera, to_world, &place)?;
        }
        if let Some(light) = node.extensions.lights.as_ref().and_then(|lights| lights.light) {
            let lights = self.root.extensions.lights.as_ref().map_or(&[][..], |lights| &lights.lights);
            let light = light::light(get(lights, light, "light", &place)?, to_world, &place, self.notes)?;
            self.parts.lights.extend(light);
        }
        node.children.iter().try_for_each(|&child| self.node(child, to_world, depth + 1, &place))
    }

    fn mesh(&mut self, index: usize, node: &Node, to_world: DAffine3, asked: &Place) -> Result<(), SceneError> {
        let mesh = get(&self.root.meshes, index, "mesh", asked)?;
        let name = node.name.as_ref().or(mesh.name.as_ref()).map_or("mesh", String::as_str);
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let place = Place::element(self.path, format!("meshes[{index}].primitives[{number}]"));
            let Some(geometry) = self.primitive((index, number), primitive, &place)? else { continue };
            self.triangles += geometry.triangles().len();
            if self.triangles > MOST_TRIANGLES {
                return Err(SceneError::TooMany { place, what: "triangles".into(), most: MOST_TRIANGLES as u64 });
            }
            let uses = Uses { vertex_color: !geometry.colors().is_empty(), uv: !geometry.uvs().is_empty() };
            let (material, emission) = self.materials.material(primitive.material, uses, &place)?;
            let moved = if to_world == DAffine3::IDENTITY {
                geometry
            } else {
                let moved = Mesh::clone(&geometry).transformed(to_world);
                Arc::new(moved.map_err(|source| SceneError::Mesh { place, source })?)
            };
            let name = format!("{}-{}", one_line(name, 80), self.parts.shapes.len());
            let geometry = Geometry::Mesh(moved);
            self.parts.shapes.push(Shape { name, geometry, flip_normals: false, material, emission });
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        key: (usize, usize),
        primitive: &Primitive,
        place: &Place,
    ) -> Result<Option<Arc<Mesh>>, SceneError> {
        if let Some(known) = self.meshes.get(&key) {
            return Ok(Some(Arc::clone(known)));
        }
        if !primitive.targets.is_empty() {
            let (what, known) = ("morph targets".to_string(), "meshes that keep their shape".to_string());
            let error = SceneError::Unsupported { place: place.clone(), what, known };
            self.notes.unsupported(error, "they are ignored")?;
        }
        let mode = primitive.mode.unwrap_or(4);
        if !(4..=6).contains(&mode) {
            let (what, known) = (format!("the mode {mode}"), "4 (triangles), 5 (strip), 6 (fan)".to_string());
            let error = SceneError::Unsupported { place: place.clone(), what, known };
            self.notes.unsupported(error, "it is left out")?;
            return Ok(None);
        }
        let attributes = &primitive.attributes;
        let Some(position) = attributes.position else {
            let (what, allowed) = ("the attribute POSITION".into(), "an accessor of VEC3".into());
            return Err(SceneError::Missing { place: place.clone(), what, allowed });
        };
        let read = |accessor| self.buffers.rows::<3>(accessor, &["VEC3"], place);
        let positions: Vec<_> = read(position)?.into_iter().map(DVec3::from).collect();
        let corners = match primitive.indices {
            Some(indices) => self.buffers.indices(indices, place)?,
            None => (0..positions.len() as u32).collect(),
        };
        let triangles = triangles(&corners, mode, place)?;
        let failed = |source| SceneError::Mesh { place: place.clone(), source };
        let mut mesh = Mesh::new(positions, triangles).map_err(failed)?;
        if let Some(normal) = attributes.normal {
            let normals = read(normal)?.into_iter().map(DVec3::from).collect();
            mesh = mesh.with_normals(normals).map_err(failed)?;
        }
        if let Some(uv) = attributes.texcoord_0 {
            let uvs = self.buffers.rows::<2>(uv, &["VEC2"], place)?.into_iter().map(DVec2::from).collect();
            mesh = mesh.with_uvs(uvs).map_err(failed)?;
        }
        if let Some(color) = attributes.color_0 {
            let rows = self.buffers.rows::<4>(color, &["VEC3", "VEC4"], place)?;
            let colors = rows.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect();
            mesh = mesh.with_colors(colors).map_err(failed)?;
        }
        let mesh = Arc::new(mesh);
        self.meshes.insert(key, Arc::clone(&mesh));
        Ok(Some(mesh))
    }

    /// The first camera counts.
    fn camera(&mut self, index: usize, to_world: DAffine3, asked: &Place) -> Result<(), SceneError> {
        let camera = get(&self.root.cameras, index, "camera", asked)?;
        let place = Place::element(self.path, format!("cameras[{index}]"));
        if self.parts.camera.is_some() {
            self.notes.warn(format!("{place}: the first camera counts, not this one"));
            return Ok(());
        }
        let positive = |what: &str, value: f64, most: f64| {
            if value > 0.0 && value <= most {
                return Ok(value);
            }
            let allowed = format!("a number in (0, {most}]");
            Err(SceneError::Value { place: place.clone(), what: what.into(), given: value.to_string(), allowed })
        };
        // There it looks along −z, with +x to the right.
        let turned = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0)));
        let axes = to_world.matrix3;
        let axis = |axis: DVec3, default| axis.normalize_or(default);
        let axes = [axis(axes.x_axis, DVec3::X), axis(axes.y_axis, DVec3::Y), axis(axes.z_axis, DVec3::Z)];
        let rigid = DAffine3::from_cols(axes[0], axes[1], axes[2], to_world.translation) * turned;
        let given = match (&camera.perspective, &camera.orthographic) {
            (Some(view), _) => {
                let aspect = positive("aspectRatio", view.aspect_ratio.unwrap_or(1.0), 1e3)?;
                let yfov = positive("yfov", view.yfov, 3.1)?;
                let projection = Projection::Perspective { tan_half_x: (0.5 * yfov).tan() * aspect };
                (Camera { to_world: rigid, projection }, aspect)
            }
            (None, Some(view)) => {
                let (x, y) = (positive("xmag", view.xmag, 1e9)?, positive("ymag", view.ymag, 1e9)?);
                let aspect = positive("xmag / ymag", x / y, 1e3)?;
                let to_world = rigid * DAffine3::from_scale(DVec3::new(x, x, 1.0));
                (Camera { to_world, projection: Projection::Orthographic }, aspect)
            }
            (None, None) => {
                let allowed = "perspective or orthographic".into();
                return Err(SceneError::Missing { place, what: "the projection".into(), allowed });
            }
        };
        self.parts.camera = Some(given);
        Ok(())
    }
}

/// The triangles of a list, a strip or a fan of corners.
pub(super) fn triangles(corners: &[u32], mode: u32, place: &Place) -> Result<Vec<[u32; 3]>, SceneError> {
    match mode {
        4 => match corners.as_chunks() {
            (triangles, []) => Ok(triangles.to_vec()),
            _ => Err(SceneError::Malformed {
                place: place.clone(),
                problem: format!("{} corners of triangles", corners.len()),
                allowed: "a multiple of three".into(),
            }),
        },
        5 => {
            // Every other triangle of a strip is turned around.
            let turned = |(at, c): (usize, &[u32])| if at % 2 == 0 { [c[0], c[1], c[2]] } else { [c[1], c[0], c[2]] };
            Ok(corners.windows(3).enumerate().map(turned).collect())
        }
        _ => Ok(corners.windows(2).skip(1).map(|c| [corners[0], c[0], c[1]]).collect()),
    }
}

/// The map of a node: a matrix, or translation · rotation · scale.
fn local(node: &Node, place: &Place) -> Result<DAffine3, SceneError> {
    let bad = |what: &str, allowed: &str| SceneError::Value {
        place: place.clone(),
        what: what.into(),
        given: "its numbers".into(),
        allowed: allowed.into(),
    };
    let map = if let Some(matrix) = node.matrix {
        if [matrix[3], matrix[7], matrix[11], matrix[15]] != [0.0, 0.0, 0.0, 1.0] {
            return Err(bad("matrix", "columns of four numbers, the last of each 0 0 0 1"));
        }
        DAffine3::from_mat4(DMat4::from_cols_array(&matrix))
    } else {
        let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let length = rotation.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(bad("rotation", "a quaternion that is not 0"));
        }
        let scale = DVec3::from(node.scale.unwrap_or([1.0; 3]));
        DAffine3::from_scale_rotation_translation(scale, rotation / length, node.translation.unwrap_or_default().into())
    };
    if map.is_finite() { Ok(map) } else { Err(bad("the map", "finite numbers")) }
}
