//! Wavefront OBJ: polygons with texture coordinates and normals, in groups of one material.
//!
//! Indices count from 1, or backwards from the last if negative. Polygons are cut into fans. Positions may carry a colour
//! (three more numbers) or a weight w, which is not used. A name may follow any statement that this reader does not know:
//! points, lines and free-form surfaces are errors, or warnings if lenient.
//! # References
//! - Wavefront, Advanced Visualizer manual, appendix B1 (object files)

mod mtl;
mod scene;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec2, DVec3};

use super::Notes;
use super::error::{Place, SceneError, listed, quoted};
use super::source;
use crate::math::color::Rgb;
use crate::scene::mesh::{Mesh, MeshError};

pub(super) use scene::load;

/// A corner of a polygon: position, texture coordinate and normal, from 0; [`NONE`] where there is none.
type Corner = [u32; 3];
const NONE: u32 = u32::MAX;

/// Statements that change nothing in a picture made of polygons.
const NO_EFFECT: [&str; 3] = ["s", "mg", "shadow_obj"];
const KNOWN: [&str; 9] = ["v", "vt", "vn", "f", "o", "g", "s", "usemtl", "mtllib"];

/// What an OBJ file holds.
#[derive(Debug, Default)]
pub(super) struct Obj {
    positions: Vec<DVec3>,
    colors: Vec<Option<Rgb>>,
    uvs: Vec<DVec2>,
    normals: Vec<DVec3>,
    /// The polygons, cut into triangles, by group.
    pub(super) groups: Vec<Group>,
    /// The files of materials, with the lines that name them.
    pub(super) libraries: Vec<(String, u64)>,
}

/// Triangles of one object or group and of one material.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) name: String,
    pub(super) material: String,
    /// The line of its first polygon.
    pub(super) line: u64,
    triangles: Vec<[Corner; 3]>,
}

/// Reads `path`. `asked` is where another file names it.
pub(super) fn read(path: &Path, asked: Option<&Place>, notes: &Notes) -> Result<Obj, SceneError> {
    let bytes = source::read(path, source::LARGEST_DATA, asked)?;
    parse(path, &bytes, notes)
}

impl Obj {
    /// All groups as one mesh.
    pub(super) fn whole(&self) -> Result<Mesh, MeshError> {
        self.mesh(self.groups.iter().flat_map(|group| &group.triangles))
    }

    /// One group as a mesh.
    pub(super) fn group(&self, group: &Group) -> Result<Mesh, MeshError> {
        self.mesh(group.triangles.iter())
    }

    /// Whether any position has a colour.
    fn is_coloured(&self) -> bool {
        self.colors.iter().any(Option::is_some)
    }

    /// Corners that agree in all three indices become one vertex.
    fn mesh<'a>(&self, triangles: impl Iterator<Item = &'a [Corner; 3]>) -> Result<Mesh, MeshError> {
        let mut numbers: HashMap<Corner, u32> = HashMap::new();
        let mut corners: Vec<Corner> = Vec::new();
        let mut number = |corner: Corner| {
            *numbers.entry(corner).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            })
        };
        let triangles: Vec<[u32; 3]> = triangles.map(|triangle| triangle.map(&mut number)).collect();
        let positions = corners.iter().map(|c| self.positions[c[0] as usize]).collect();
        let mut mesh = Mesh::new(positions, triangles)?;
        // A mesh in which some corners lack one is a mesh without.
        if !corners.is_empty() && corners.iter().all(|c| c[1] != NONE) {
            mesh = mesh.with_uvs(corners.iter().map(|c| self.uvs[c[1] as usize]).collect())?;
        }
        if !corners.is_empty() && corners.iter().all(|c| c[2] != NONE) {
            mesh = mesh.with_normals(corners.iter().map(|c| self.normals[c[2] as usize]).collect())?;
        }
        if corners.iter().any(|c| self.colors[c[0] as usize].is_some()) {
            let color = |c: &Corner| self.colors[c[0] as usize].unwrap_or(Rgb::WHITE);
            mesh = mesh.with_colors(corners.iter().map(color).collect())?;
        }
        Ok(mesh)
    }
}

fn parse(path: &Path, bytes: &[u8], notes: &Notes) -> Result<Obj, SceneError> {
    let mut obj = Obj::default();
    let (mut name, mut material, mut fresh) = (String::new(), String::new(), true);
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let place = || Place::line(path, number as u64 + 1);
        let line = std::str::from_utf8(line.split(|&b| b == b'#').next().unwrap_or_default()).map_err(|_| {
            SceneError::Malformed { place: place(), problem: "this is not UTF-8".into(), allowed: "text".into() }
        })?;
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword {
            "v" => {
                let (values, count) = floats::<7>(words, &place)?;
                let [x, y, z, r, g, b, _] = values;
                if !(3..=7).contains(&count) || count == 5 {
                    return Err(bad(place(), line, "v x y z, then w, or r g b, or nothing"));
                }
                obj.positions.push(DVec3::new(x, y, z));
                obj.colors.push((count >= 6).then(|| Rgb::new(r, g, b)));
            }
            "vt" => {
                let (values, count) = floats::<3>(words, &place)?;
                if count == 0 {
                    return Err(bad(place(), line, "vt u v"));
                }
                obj.uvs.push(DVec2::new(values[0], values[1]));
            }
            "vn" => match floats::<3>(words, &place)? {
                (values, 3) => obj.normals.push(DVec3::from_array(values)),
                _ => return Err(bad(place(), line, "vn x y z")),
            },
            "f" => {
                if std::mem::take(&mut fresh) {
                    let (name, material) = (name.clone(), material.clone());
                    obj.groups.push(Group { name, material, line: number as u64 + 1, triangles: Vec::new() });
                }
                polygon(&mut obj, words, &|| bad(place(), line, "f with three or more of v, v/vt, v//vn or v/vt/vn"))
                    .map_err(|problem| problem.unwrap_or_else(|| out_of_range(place(), line, &obj)))?;
            }
            "o" | "g" => (name, fresh) = (words.collect::<Vec<_>>().join(" "), true),
            "usemtl" => (material, fresh) = (words.collect::<Vec<_>>().join(" "), true),
            "mtllib" => {
                let library = line.trim().strip_prefix("mtllib").unwrap_or_default().trim().to_string();
                obj.libraries.push((library, number as u64 + 1));
            }
            other if NO_EFFECT.contains(&other) => {}
            other => {
                let (what, known) = (format!("the statement {}", quoted(other)), listed(KNOWN));
                notes.unsupported(SceneError::Unsupported { place: place(), what, known }, "it is ignored")?;
            }
        }
    }
    Ok(obj)
}

/// Up to N numbers, and how many there were.
fn floats<'a, const N: usize>(
    words: impl Iterator<Item = &'a str>,
    place: &dyn Fn() -> Place,
) -> Result<([f64; N], usize), SceneError> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in words {
        let value = word.parse().ok().filter(|x: &f64| x.is_finite());
        let value = value.ok_or_else(|| bad(place(), word, "a finite number"))?;
        *values.get_mut(count).ok_or_else(|| bad(place(), word, &format!("at most {N} numbers")))? = value;
        count += 1;
    }
    Ok((values, count))
}

/// Adds a polygon. The error is None where an index is out of range.
fn polygon<'a>(
    obj: &mut Obj,
    words: impl Iterator<Item = &'a str>,
    malformed: &dyn Fn() -> SceneError,
) -> Result<(), Option<SceneError>> {
    let counts = [obj.positions.len(), obj.uvs.len(), obj.normals.len()];
    let (mut first, mut before, mut seen) = ([NONE; 3], [NONE; 3], 0_usize);
    for word in words {
        let mut corner = [NONE; 3];
        for (at, part) in word.split('/').enumerate() {
            if at == 3 || (at == 0 && part.is_empty()) {
                return Err(Some(malformed()));
            }
            if part.is_empty() {
                continue;
            }
            let index: i64 = part.parse().map_err(|_| Some(malformed()))?;
            let steps = usize::try_from(index.unsigned_abs()).unwrap_or(usize::MAX);
            let from_zero = if index < 0 { counts[at].checked_sub(steps) } else { steps.checked_sub(1) };
            let from_zero = from_zero.filter(|&i| i < counts[at].min(NONE as usize)).ok_or(None)?;
            corner[at] = from_zero as u32;
        }
        match seen {
            0 => first = corner,
            1 => {}
            _ => obj.groups.last_mut().ok_or(None)?.triangles.push([first, before, corner]),
        }
        before = corner;
        seen += 1;
    }
    if seen >= 3 { Ok(()) } else { Err(Some(malformed())) }
}

fn bad(place: Place, found: &str, allowed: &str) -> SceneError {
    SceneError::Malformed { place, problem: quoted(found.trim()), allowed: allowed.into() }
}

fn out_of_range(place: Place, line: &str, obj: &Obj) -> SceneError {
    let [v, vt, vn] = [obj.positions.len(), obj.uvs.len(), obj.normals.len()];
    SceneError::Value {
        place,
        what: "an index".into(),
        given: quoted(line.trim()),
        allowed: format!("1 to {v} for v, 1 to {vt} for vt, 1 to {vn} for vn, or negative, counted from the end"),
    }
}
