//! PLY: text or binary, any order and type of properties.
//!
//! A header declares elements with a count each, and their properties; the data follows. Of the element `vertex` the
//! properties x, y, z; nx, ny, nz; u, v (or s, t; texture_u, texture_v; u0, v0); red, green, blue or r, g, b are read; of
//! the element `face` the list vertex_indices or vertex_index, whose polygons are cut into fans. All else is skipped.
//! Every count is compared with the size of the file before memory is taken for it.
//! # References
//! - Turk 1994, The PLY polygon file format

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Notes;
use super::assembly::Parts;
use super::error::{Place, SceneError, listed, one_line, quoted};
use super::source;
use crate::math::color::Rgb;
use crate::scene::description::SceneDescription;
use crate::scene::material::Material;
use crate::scene::mesh::Mesh;
use crate::scene::shape::{Geometry, Shape};
use crate::scene::texture::Texture;

/// The longest header that is read [bytes].
const LONGEST_HEADER: usize = 1 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The largest value of an integer; colours of that type are shares of it.
    fn full(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// The value in the first bytes of `bytes`.
    #[inline]
    fn decode(self, bytes: &[u8], big: bool) -> Option<f64> {
        macro_rules! number {
            ($type:ty) => {{
                let raw = *bytes.first_chunk()?;
                f64::from(if big { <$type>::from_be_bytes(raw) } else { <$type>::from_le_bytes(raw) })
            }};
        }
        Some(match self {
            Self::I8 => number!(i8),
            Self::U8 => number!(u8),
            Self::I16 => number!(i16),
            Self::U16 => number!(u16),
            Self::I32 => number!(i32),
            Self::U32 => number!(u32),
            Self::F32 => number!(f32),
            Self::F64 => number!(f64),
        })
    }
}

#[derive(Clone, Debug)]
struct Property {
    name: String,
    value: Type,
    /// The type of the length, if it is a list.
    length: Option<Type>,
}

#[derive(Clone, Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
    line: u64,
}

impl Element {
    /// The fewest bytes that one takes.
    fn least_size(&self, encoding: Encoding) -> u64 {
        let sizes = self.properties.iter().map(|p| match encoding {
            // A digit and a space or the end of the line.
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.value).size() as u64,
        });
        sizes.sum::<u64>()
    }

    fn index(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.properties.iter().position(|p| p.name == *name && p.length.is_none()))
    }

    /// The properties with these names, all or none.
    fn all<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let found = names.map(|name| self.index(&[name]));
        found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
    }
}

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

/// The encoding, the elements, and where the data starts.
fn header(path: &Path, bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize), SceneError> {
    let bad = |line: u64, problem: String, allowed: &str| SceneError::Malformed {
        place: Place::line(path, line),
        problem,
        allowed: allowed.into(),
    };
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut at = 0;
    for line in 1.. {
        let rest = &bytes[at..bytes.len().min(LONGEST_HEADER)];
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            return Err(SceneError::Truncated {
                place: Place::line(path, line),
                within: "its header".into(),
                allowed: format!("at most {LONGEST_HEADER} bytes that end in end_header"),
            });
        };
        at += length + 1;
        let text = String::from_utf8_lossy(&rest[..length]);
        let words: Vec<&str> = text.split_whitespace().collect();
        match words.as_slice() {
            ["ply"] if line == 1 => {}
            _ if line == 1 => return Err(bad(line, quoted(&text), "the word `ply`")),
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _version] => {
                encoding = Some(match *name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    other => {
                        let allowed = "ascii, binary_little_endian, binary_big_endian";
                        return Err(bad(line, format!("format {}", quoted(other)), allowed));
                    }
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad(line, quoted(&text), "element NAME COUNT"))?;
                elements.push(Element { name: (*name).to_string(), count, properties: Vec::new(), line });
            }
            ["property", kind @ .., name] => {
                const ALLOWED: &str = "property TYPE NAME or property list TYPE TYPE NAME, after an element; types are \
                                       char, uchar, short, ushort, int, uint, float, double, or int8 to float64";
                let property = match kind {
                    [value] => Type::parse(value).map(|value| (value, None)),
                    ["list", length, value] => {
                        let length = Type::parse(length).filter(|t| !matches!(t, Type::F32 | Type::F64));
                        length.zip(Type::parse(value)).map(|(length, value)| (value, Some(length)))
                    }
                    _ => None,
                };
                let (Some((value, length)), Some(element)) = (property, elements.last_mut()) else {
                    return Err(bad(line, quoted(&text), ALLOWED));
                };
                element.properties.push(Property { name: (*name).to_string(), value, length });
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| bad(line, "no format".into(), "a line `format …`"))?;
                return Ok((encoding, elements, at));
            }
            _ => {
                let known = ["format", "comment", "obj_info", "element", "property", "end_header"];
                return Err(bad(line, quoted(&text), &listed(known)));
            }
        }
    }
    unreachable!("a file ends")
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file::testing::{Files, mutate};

    fn file(format: &str, vertex: &str, face: &str) -> String {
        format!("ply\nformat {format} 1.0\ncomment x\n{vertex}{face}end_header\n")
    }

    const XYZ: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    const FACE: &str = "element face 1\nproperty list uchar int vertex_indices\n";
    const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3";

    fn read(bytes: &[u8]) -> Result<Mesh, SceneError> {
        parse(Path::new("a.ply"), bytes)
    }

    fn error(text: &str) -> String {
        read(text.as_bytes()).unwrap_err().to_string()
    }

    /// The square with a property of every type in every encoding: skipped ones before, between and after.
    fn square(big: bool) -> Vec<u8> {
        let vertex = "element vertex 4\nproperty short a\nproperty double x\nproperty list uchar ushort l\nproperty float y\n\
                      property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\n\
                      property float t\nproperty float nx\nproperty float ny\nproperty float nz\n";
        let face = "element junk 2\nproperty int8 j\nelement face 1\nproperty float q\nproperty list int uint vertex_index\n\
                    property uint16 flags\n";
        let format = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = file(format, vertex, face).into_bytes();
        macro_rules! put {
            ($value:expr) => {
                bytes.extend(if big { $value.to_be_bytes().to_vec() } else { $value.to_le_bytes().to_vec() })
            };
        }
        for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1_u8)] {
            put!(7_i16);
            put!(f64::from(x));
            put!(2_u8);
            put!(1_u16);
            put!(2_u16);
            put!(f32::from(y));
            put!(0.5_f32);
            for c in [255, 0, 51_u8] {
                put!(c);
            }
            for v in [f32::from(x as u8), f32::from(y), 0.0, 0.0, 3.0] {
                put!(v);
            }
        }
        put!(-1_i8);
        put!(5_i8);
        put!(1.5_f32);
        put!(4_i32);
        for corner in [0, 1, 2, 3_u32] {
            put!(corner);
        }
        put!(9_u16);
        bytes
    }

    #[test]
    fn all_encodings_say_the_same() {
        let text = read(file("ascii", XYZ, FACE).replace("end_header\n", &format!("end_header\n{SQUARE}")).as_bytes());
        let text = text.unwrap();
        assert_eq!(text.triangles(), [[0, 1, 2], [0, 2, 3]]);
        for big in [false, true] {
            let mesh = read(&square(big)).unwrap();
            assert_eq!(mesh.triangles(), text.triangles());
            assert!(mesh.positions().iter().zip(text.positions()).all(|(a, b)| *a == *b + DVec3::Z * 0.5));
            assert_eq!(mesh.colors()[3], Rgb::new(1.0, 0.0, 0.2));
            assert_eq!((mesh.uvs()[2], mesh.normals()[0]), (DVec2::ONE, DVec3::Z));
        }
    }

    #[test]
    fn counts_are_compared_with_the_file() {
        let huge = XYZ.replace(" 4\n", " 1000000000\n");
        for format in ["ascii", "binary_little_endian"] {
            let found = error(&format!("{}{SQUARE}", file(format, &huge, FACE)));
            assert!(
                found.starts_with("a.ply: line 4: the count of element `vertex` = 1000000000 is not allowed"),
                "{found}"
            );
        }
        let faces = FACE.replace(" 1\n", " 18446744073709551615\n");
        assert!(error(&format!("{}{SQUARE}", file("ascii", XYZ, &faces))).contains("the count of element `face`"));
        // Elements without properties take no bytes and must take no time.
        let empty = "element nothing 4000000000\n";
        assert!(error(&format!("{}{SQUARE}", file("ascii", empty, ""))).contains("element vertex is missing"));
        // A list that claims to be longer than the file.
        let found = error(&format!("{}0 0 0\n1 0 0\n1 1 0\n0 1 0\n4000000000 0 1 2", file("ascii", XYZ, FACE)));
        assert!(found.contains("the file ends within element face 0 of 1"), "{found}");
    }

    #[test]
    fn bad_files_are_refused() {
        let with = |data: &str| error(&format!("{}{data}", file("ascii", XYZ, FACE)));
        for (found, expected) in [
            (error("plywood\n"), "a.ply: line 1: `plywood`; allowed is the word `ply`"),
            (error("ply\nformat ascii 1.0\n"), "a.ply: line 3: the file ends within its header"),
            (error("ply\nend_header\n"), "a.ply: line 2: no format"),
            (error("ply\nformat utf8 1.0\n"), "a.ply: line 2: format `utf8`; allowed is ascii"),
            (error("ply\nformat ascii 1.0\nproperty float x\nend_header\n"), "a.ply: line 3: `property float x`"),
            (error("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n"), "a.ply: line 3: `element vertex -1`"),
            (error("ply\nformat ascii 1.0\nelement v 1\nproperty half x\n"), "a.ply: line 4: `property half x`"),
            (error("ply\nformat ascii 1.0\nfrob\n"), "a.ply: line 3: `frob`; allowed is format, comment"),
            (error(&file("ascii", "", "")), "a.ply: element vertex is missing"),
            (error(&format!("{}1 2 3", file("ascii", &XYZ.replace(" x", " q"), FACE))), "a.ply: line 4: "),
            (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 4"), "a.ply: triangle 1 names vertex 4, but there are 4"),
            (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 -1"), "a.ply: face 0: a vertex index = -1"),
            (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 1.5"), "a.ply: face 0: a vertex index = 1.5"),
            (with("0 0 0\n1 0 0\nnan 1 0\n0 1 0\n4 0 1 2 3"), "a.ply: the position of vertex 2 is not finite"),
            (with("0 0 0\n1 0 0\n1e999 1 0\n0 1 0\n4 0 1 2 3"), "a.ply: the position of vertex 2 is not finite"),
            (with("0 0 0\n1 0 0\nfoo 1 0\n0 1 0\n4 0 1 2 3"), "a.ply: byte "),
            (with("0 0 0\n1 0 0\n1 1 0\n0 1 0\n"), "a.ply: byte "),
        ] {
            assert!(found.starts_with(expected), "{found}\n{expected}");
        }
        let mut short = square(false);
        short.truncate(short.len() - 3);
        let found = read(&short).unwrap_err().to_string();
        assert!(found.contains("the file ends within element face 0 of 1"), "{found}");
    }

    #[test]
    fn a_file_alone_is_a_scene() {
        let files = Files::new().with("a.ply", format!("{}{SQUARE}", file("ascii", XYZ, FACE)));
        let loaded = files.load("a.ply").unwrap();
        assert_eq!((loaded.scene.name.as_str(), loaded.scene.shapes.len(), loaded.warnings.len()), ("a", 1, 2));
    }

    #[test]
    fn damaged_files_never_panic() {
        mutate("a.ply", &square(false), &[], 500);
        mutate("a.ply", format!("{}{SQUARE}", file("ascii", XYZ, FACE)).as_bytes(), &[], 500);
    }
}
