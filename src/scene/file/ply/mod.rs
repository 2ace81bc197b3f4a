//! PLY: text or binary, any order and type of properties.
//!
//! A header declares elements with a count each, and their properties; the data follows. Of the element `vertex` the
//! properties x, y, z; nx, ny, nz; u, v (or s, t; texture_u, texture_v; u0, v0); red, green, blue or r, g, b are read; of
//! the element `face` the list vertex_indices or vertex_index, whose polygons are cut into fans. All else is skipped.
//! Every count is compared with the size of the file before memory is taken for it.
//! # References
//! - Turk 1994, The PLY polygon file format

mod header;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Notes;
use super::assembly::Parts;
use super::error::{Place, SceneError, one_line, quoted};
use super::source;
use crate::math::color::Rgb;
use crate::scene::description::SceneDescription;
use crate::scene::material::Material;
use crate::scene::mesh::Mesh;
use crate::scene::shape::{Geometry, Shape};
use crate::scene::texture::Texture;
use header::{Element, Encoding, Property, Type, header};

/// The mesh in `path`. `asked` is where another file names it.
pub(super) fn load(path: &Path, asked: Option<&Place>) -> Result<Mesh, SceneError> {
    parse(path, &source::read(path, source::LARGEST_DATA, asked)?)
}

/// The mesh in `path` as a scene: diffuse, seen from both sides, of the colours of its vertices or else grey.
pub(super) fn load_scene(path: &Path, notes: &Notes) -> Result<SceneDescription, SceneError> {
    let mesh = load(path, None)?;
    let colour = if mesh.colors().is_empty() { Texture::Constant(Rgb::grey(0.5)) } else { Texture::VertexColor };
    let shape = Shape {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        geometry: Geometry::Mesh(Arc::new(mesh)),
        flip_normals: false,
        material: 0,
        emission: None,
    };
    let materials = vec![Material::diffuse("default", colour).two_sided()];
    Parts { materials, shapes: vec![shape], ..Parts::default() }.into_scene(path, notes)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh, SceneError> {
    let (encoding, elements, start) = header(path, bytes)?;
    let mut data = Data { path, bytes, at: start, encoding };
    let mut vertices = None;
    let mut triangles = None;
    for element in &elements {
        let left = (bytes.len() - data.at) as u64;
        let least = element.count.saturating_mul(element.least_size(encoding));
        // The last line of a text may lack its end.
        if least > left + 1 || element.count > u64::from(u32::MAX) {
            return Err(SceneError::Value {
                place: Place::line(path, element.line),
                what: format!("the count of element {}", quoted(&element.name)),
                given: element.count.to_string(),
                allowed: format!("what fits into the {left} bytes that follow, and is below 2^32"),
            });
        }
        match element.name.as_str() {
            "vertex" => vertices = Some(data.vertices(element)?),
            "face" | "tristrips" if vertices.is_none() => {
                let what = format!("element vertex before element {}", element.name);
                let place = Place::line(path, element.line);
                return Err(SceneError::Missing { place, what, allowed: "vertices first".into() });
            }
            "face" => triangles = Some(data.faces(element)?),
            "tristrips" => {
                return Err(SceneError::Unsupported {
                    place: Place::line(path, element.line),
                    what: "element `tristrips`".into(),
                    known: "vertex, face".into(),
                });
            }
            _ => data.skip(element)?,
        }
    }
    let missing = |what: &str| SceneError::Missing {
        place: Place::whole(path),
        what: format!("element {what}"),
        allowed: "the elements vertex and face".into(),
    };
    let vertices = vertices.ok_or_else(|| missing("vertex"))?;
    let triangles = triangles.ok_or_else(|| missing("face"))?;
    vertices.into_mesh(triangles).map_err(|source| SceneError::Mesh { place: Place::whole(path), source })
}

#[derive(Debug, Default)]
struct Vertices {
    positions: Vec<DVec3>,
    normals: Option<Vec<DVec3>>,
    uvs: Option<Vec<DVec2>>,
    colors: Option<Vec<Rgb>>,
}

impl Vertices {
    fn into_mesh(self, triangles: Vec<[u32; 3]>) -> Result<Mesh, crate::scene::mesh::MeshError> {
        let mut mesh = Mesh::new(self.positions, triangles)?;
        if let Some(normals) = self.normals {
            mesh = mesh.with_normals(normals)?;
        }
        if let Some(uvs) = self.uvs {
            mesh = mesh.with_uvs(uvs)?;
        }
        if let Some(colors) = self.colors {
            mesh = mesh.with_colors(colors)?;
        }
        Ok(mesh)
    }
}

/// The data after the header, and how far it is read.
struct Data<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl Data<'_> {
    fn vertices(&mut self, element: &Element) -> Result<Vertices, SceneError> {
        let count = element.count as usize;
        let position = element.all(["x", "y", "z"]).ok_or_else(|| SceneError::Missing {
            place: Place::line(self.path, element.line),
            what: "a property x, y or z of element vertex".into(),
            allowed: "the properties x, y, z".into(),
        })?;
        let normal = element.all(["nx", "ny", "nz"]);
        let pairs = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["u0", "v0"]];
        let uv = pairs.into_iter().find_map(|names| element.all(names));
        let color = [["red", "green", "blue"], ["r", "g", "b"]].into_iter().find_map(|names| element.all(names));
        let full = color.map(|[r, ..]| element.properties[r].value.full());
        let mut vertices = Vertices {
            positions: Vec::with_capacity(count),
            normals: normal.map(|_| Vec::with_capacity(count)),
            uvs: uv.map(|_| Vec::with_capacity(count)),
            colors: color.map(|_| Vec::with_capacity(count)),
        };
        let mut row = vec![0.0; element.properties.len()];
        for number in 0..count {
            self.row(element, number, &mut row)?;
            let triple = |[x, y, z]: [usize; 3]| DVec3::new(row[x], row[y], row[z]);
            vertices.positions.push(triple(position));
            if let (Some(normals), Some(at)) = (&mut vertices.normals, normal) {
                normals.push(triple(at));
            }
            if let (Some(uvs), Some([u, v])) = (&mut vertices.uvs, uv) {
                uvs.push(DVec2::new(row[u], row[v]));
            }
            if let (Some(colors), Some(at), Some(full)) = (&mut vertices.colors, color, full) {
                colors.push(Rgb(triple(at) / full));
            }
        }
        Ok(vertices)
    }

    /// The scalar properties of element `number` into `row`; lists are skipped.
    fn row(&mut self, element: &Element, number: usize, row: &mut [f64]) -> Result<(), SceneError> {
        for (property, value) in element.properties.iter().zip(row) {
            match property.length {
                None => *value = self.value(property.value, element, number)?,
                Some(_) => self.list(property, element, number, |_| Ok(()))?,
            }
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element) -> Result<Vec<[u32; 3]>, SceneError> {
        let names = ["vertex_indices", "vertex_index"];
        let corners = element.properties.iter().position(|p| names.contains(&p.name.as_str()) && p.length.is_some());
        let corners = corners.ok_or_else(|| SceneError::Missing {
            place: Place::line(self.path, element.line),
            what: "the list vertex_indices of element face".into(),
            allowed: "property list TYPE TYPE vertex_indices".into(),
        })?;
        let mut triangles = Vec::with_capacity(element.count as usize);
        for number in 0..element.count as usize {
            for (at, property) in element.properties.iter().enumerate() {
                if at != corners {
                    match property.length {
                        None => drop(self.value(property.value, element, number)?),
                        Some(_) => self.list(property, element, number, |_| Ok(()))?,
                    }
                    continue;
                }
                let path = self.path;
                let (mut first, mut before, mut seen) = (0, 0, 0_usize);
                self.list(property, element, number, |index| {
                    let corner = index as u32;
                    if f64::from(corner) != index {
                        return Err(SceneError::Value {
                            place: Place::element(path, format!("face {number}")),
                            what: "a vertex index".into(),
                            given: index.to_string(),
                            allowed: "a whole number ≥ 0".into(),
                        });
                    }
                    match seen {
                        0 => first = corner,
                        1 => {}
                        _ => triangles.push([first, before, corner]),
                    }
                    before = corner;
                    seen += 1;
                    Ok(())
                })?;
            }
        }
        Ok(triangles)
    }

    fn skip(&mut self, element: &Element) -> Result<(), SceneError> {
        // An element without properties takes no bytes: there is nothing to walk over, however many there are.
        let count = if element.properties.is_empty() { 0 } else { element.count as usize };
        let mut row = vec![0.0; element.properties.len()];
        (0..count).try_for_each(|number| self.row(element, number, &mut row))
    }

    /// Hands the values of a list to `each`.
    fn list(
        &mut self,
        property: &Property,
        element: &Element,
        number: usize,
        mut each: impl FnMut(f64) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        let length = self.value(property.length.unwrap_or(Type::U8), element, number)?;
        if length < 0.0 || length.fract() != 0.0 {
            return Err(SceneError::Value {
                place: Place::element(self.path, format!("{} {number}", one_line(&element.name, 40))),
                what: format!("the length of list {}", quoted(&property.name)),
                given: length.to_string(),
                allowed: "a whole number ≥ 0".into(),
            });
        }
        // However long the list claims to be, it ends where the file does.
        for _ in 0..length as u64 {
            each(self.value(property.value, element, number)?)?;
        }
        Ok(())
    }

    #[inline]
    fn value(&mut self, kind: Type, element: &Element, number: usize) -> Result<f64, SceneError> {
        if self.encoding == Encoding::Ascii {
            return self.word(element, number);
        }
        let found = kind.decode(&self.bytes[self.at..], self.encoding == Encoding::Big);
        self.at = (self.at + kind.size()).min(self.bytes.len());
        found.ok_or_else(|| self.truncated(element, number))
    }

    /// The next number of a text.
    fn word(&mut self, element: &Element, number: usize) -> Result<f64, SceneError> {
        let rest = &self.bytes[self.at..];
        let start =
            rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(|| self.truncated(element, number))?;
        let rest = &rest[start..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = &rest[..length];
        let value = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let value = value.ok_or_else(|| SceneError::Malformed {
            place: Place::byte(self.path, (self.at + start) as u64),
            problem: format!(
                "{} in element {} {number}",
                quoted(&String::from_utf8_lossy(word)),
                one_line(&element.name, 40)
            ),
            allowed: "a number".into(),
        })?;
        self.at += start + length;
        Ok(value)
    }

    fn truncated(&self, element: &Element, number: usize) -> SceneError {
        SceneError::Truncated {
            place: Place::byte(self.path, self.bytes.len() as u64),
            within: format!("element {} {number} of {}", one_line(&element.name, 40), element.count),
            allowed: "as many as the header declares".into(),
        }
    }
}
