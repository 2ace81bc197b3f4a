//! Mitsuba's own format of meshes, versions 3 and 4.
//!
//! Little-endian throughout. Every mesh is u16 0x041C, u16 version, and a zlib stream of: u32 flags; in version 4 a name that
//! ends in 0; u64 counts of vertices and triangles; positions; by the flags normals (1), texture coordinates (2),
//! colours (8), in single (0x1000) or double (0x2000) precision; indices of triangles, u32 (u64 from 2³² vertices on). The
//! file ends with where each mesh begins (u64, or u32 in version 3) and a u32 of how many there are.
//! # References
//! - Jakob 2014, Mitsuba 0.5 documentation, section 8.2.4 (serialized mesh loader)

use std::io::{self, Read};
use std::path::Path;

use flate2::read::ZlibDecoder;
use glam::{DVec2, DVec3};

use super::error::{Place, SceneError};
use super::source;
use crate::math::color::Rgb;
use crate::scene::mesh::Mesh;

const MAGIC: u16 = 0x041c;
/// The most bytes that a byte of a zlib stream can stand for.
const BEST_COMPRESSION: u64 = 1032;
/// The longest name of a mesh.
const LONGEST_NAME: usize = 4096;

/// Mesh number `index` in `path`. `asked` is where another file names it.
pub(super) fn load(path: &Path, index: usize, asked: Option<&Place>) -> Result<Mesh, SceneError> {
    parse(path, &source::read(path, source::LARGEST_DATA, asked)?, index)
}

fn parse(path: &Path, bytes: &[u8], index: usize) -> Result<Mesh, SceneError> {
    let malformed = |byte: usize, problem: String, allowed: &str| SceneError::Malformed {
        place: Place::byte(path, byte as u64),
        problem,
        allowed: allowed.into(),
    };
    let truncated = |within: &str| SceneError::Truncated {
        place: Place::byte(path, bytes.len() as u64),
        within: within.into(),
        allowed: "a header, meshes, and the list of where they begin".into(),
    };
    let word = |at: usize| bytes.get(at..).and_then(|rest| rest.first_chunk()).map(|raw| u16::from_le_bytes(*raw));
    let head = |at: usize| match (word(at), word(at + 2)) {
        (Some(MAGIC), Some(version @ (3 | 4))) => Ok(version),
        (Some(magic), Some(version)) => {
            let problem = format!("the identifier {magic:#06x} and the version {version}");
            Err(malformed(at, problem, "0x041c and 3 or 4"))
        }
        _ => Err(truncated("a header")),
    };
    let version = head(0)?;
    let end = bytes.len().checked_sub(4).ok_or_else(|| truncated("the list of meshes"))?;
    let count = bytes[end..].first_chunk().map_or(0, |raw| u32::from_le_bytes(*raw)) as usize;
    let width = if version == 4 { 8 } else { 4 };
    let list = count.checked_mul(width).and_then(|size| end.checked_sub(size));
    let list = list.ok_or_else(|| malformed(end, format!("{count} meshes"), "as many as the file has room for"))?;
    if index >= count {
        return Err(malformed(end, format!("mesh {index} is asked for"), &format!("meshes 0 to {count}, exclusive")));
    }
    let begin = |index: usize| {
        let raw = &bytes[list + index * width..];
        let wide = raw.first_chunk().map(|raw| u64::from_le_bytes(*raw));
        let narrow = raw.first_chunk().map(|raw| u64::from(u32::from_le_bytes(*raw)));
        if version == 4 { wide } else { narrow }
    };
    let start = begin(index).and_then(|at| usize::try_from(at).ok()).filter(|at| *at < list);
    let start = start.ok_or_else(|| {
        malformed(list + index * width, format!("mesh {index} begins outside"), "a place before the list of meshes")
    })?;
    let version = head(start)?;
    let stream = bytes.get(start + 4..list).ok_or_else(|| truncated("a mesh"))?;
    Stream { path, index, version, size: stream.len() as u64, zlib: ZlibDecoder::new(stream) }.mesh()
}

/// One compressed mesh.
struct Stream<'a> {
    path: &'a Path,
    index: usize,
    version: u16,
    size: u64,
    zlib: ZlibDecoder<&'a [u8]>,
}

impl Stream<'_> {
    fn place(&self) -> Place {
        Place::element(self.path, format!("mesh {}", self.index))
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), SceneError> {
        self.zlib.read_exact(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => SceneError::Truncated {
                place: self.place(),
                within: "its data".into(),
                allowed: "as much as it declares".into(),
            },
            _ => SceneError::Malformed {
                place: self.place(),
                problem: error.to_string(),
                allowed: "a zlib stream".into(),
            },
        })
    }

    fn number(&mut self) -> Result<u64, SceneError> {
        let mut raw = [0; 8];
        self.fill(&mut raw)?;
        Ok(u64::from_le_bytes(raw))
    }

    fn mesh(mut self) -> Result<Mesh, SceneError> {
        let mut raw = [0; 4];
        self.fill(&mut raw)?;
        let flags = u32::from_le_bytes(raw);
        let wide = match flags & 0x3000 {
            0x1000 => false,
            0x2000 => true,
            _ => {
                let problem = format!("the flags {flags:#x}");
                let allowed = "single (0x1000) or double (0x2000) precision".into();
                return Err(SceneError::Malformed { place: self.place(), problem, allowed });
            }
        };
        if self.version == 4 {
            self.skip_name()?;
        }
        let (vertices, triangles) = (self.number()?, self.number()?);
        let per_vertex =
            3 + 3 * u64::from(flags & 1 != 0) + 2 * u64::from(flags & 2 != 0) + 3 * u64::from(flags & 8 != 0);
        let needed = vertices.saturating_mul(per_vertex * if wide { 8 } else { 4 });
        let needed = needed.saturating_add(triangles.saturating_mul(12));
        let room = self.size.saturating_mul(BEST_COMPRESSION);
        if needed > room || vertices.max(triangles) > u64::from(u32::MAX) {
            return Err(SceneError::Value {
                place: self.place(),
                what: "the counts of vertices and triangles".into(),
                given: format!("{vertices} and {triangles}"),
                allowed: format!("what its {} compressed bytes can hold, and is below 2^32", self.size),
            });
        }
        let count = vertices as usize;
        let positions = triples(&self.floats(3 * count, wide)?);
        let normals = if flags & 1 == 0 { Vec::new() } else { triples(&self.floats(3 * count, wide)?) };
        let uvs = if flags & 2 == 0 { Vec::new() } else { self.floats(2 * count, wide)? };
        let colors = if flags & 8 == 0 { Vec::new() } else { triples(&self.floats(3 * count, wide)?) };
        let triangles = self.triangles(triangles as usize)?;
        let build = || {
            let mut mesh = Mesh::new(positions, triangles)?;
            if !normals.is_empty() {
                mesh = mesh.with_normals(normals)?;
            }
            if !uvs.is_empty() {
                mesh = mesh.with_uvs(uvs.chunks_exact(2).map(|uv| DVec2::new(uv[0], uv[1])).collect())?;
            }
            if colors.is_empty() { Ok(mesh) } else { mesh.with_colors(colors.into_iter().map(Rgb).collect()) }
        };
        let place = self.place();
        build().map_err(|source| SceneError::Mesh { place, source })
    }

    fn skip_name(&mut self) -> Result<(), SceneError> {
        let mut byte = [0];
        for _ in 0..LONGEST_NAME {
            self.fill(&mut byte)?;
            if byte == [0] {
                return Ok(());
            }
        }
        Err(SceneError::TooMany {
            place: self.place(),
            what: "bytes in the name of a mesh".into(),
            most: LONGEST_NAME as u64,
        })
    }

    fn floats(&mut self, count: usize, wide: bool) -> Result<Vec<f64>, SceneError> {
        let mut values = Vec::with_capacity(count);
        let mut block = vec![0; 1 << 16];
        while values.len() < count {
            let size = if wide { 8 } else { 4 };
            let bytes = &mut block[..(size * (count - values.len())).min(1 << 16)];
            self.fill(bytes)?;
            if wide {
                values.extend(bytes.as_chunks().0.iter().map(|raw| f64::from_le_bytes(*raw)));
            } else {
                values.extend(bytes.as_chunks().0.iter().map(|raw| f64::from(f32::from_le_bytes(*raw))));
            }
        }
        Ok(values)
    }

    fn triangles(&mut self, count: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let mut triangles = Vec::with_capacity(count);
        let mut block = vec![0; 12 * 4096];
        while triangles.len() < count {
            let bytes = &mut block[..12 * (count - triangles.len()).min(4096)];
            self.fill(bytes)?;
            let words = bytes.as_chunks::<4>().0.as_chunks::<3>().0;
            triangles.extend(words.iter().map(|corners| corners.map(u32::from_le_bytes)));
        }
        Ok(triangles)
    }
}

fn triples(values: &[f64]) -> Vec<DVec3> {
    values.as_chunks().0.iter().map(|&[x, y, z]| DVec3::new(x, y, z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    /// A triangle at height `z`: version 4 with a name in double precision, version 3 in single.
    fn stream(version: u16, z: f32, vertices: u64) -> Vec<u8> {
        let mut data = Vec::new();
        let wide = version == 4;
        data.extend((if wide { 0x2003_u32 } else { 0x1003 }).to_le_bytes());
        if wide {
            data.extend(b"name\0");
        }
        data.extend(vertices.to_le_bytes());
        data.extend(1_u64.to_le_bytes());
        let positions = [0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z];
        let normals = [0.0, 0.0, 1.0].repeat(3);
        let uvs = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
        for value in positions.into_iter().chain(normals).chain(uvs) {
            if wide { data.extend(f64::from(value).to_le_bytes()) } else { data.extend(value.to_le_bytes()) }
        }
        for corner in [0, 1, 2_u32] {
            data.extend(corner.to_le_bytes());
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&data).unwrap();
        let mut bytes = [MAGIC.to_le_bytes(), version.to_le_bytes()].concat();
        bytes.extend(encoder.finish().unwrap());
        bytes
    }

    fn file(version: u16, streams: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut list: Vec<u8> = Vec::new();
        for stream in streams {
            let at = bytes.len();
            let place = (at as u64).to_le_bytes();
            list.extend(&place[..if version == 4 { 8 } else { 4 }]);
            bytes.extend(stream);
        }
        bytes.extend(list);
        bytes.extend((streams.len() as u32).to_le_bytes());
        bytes
    }

    fn read(bytes: &[u8], index: usize) -> Result<Mesh, SceneError> {
        parse(Path::new("a.serialized"), bytes, index)
    }

    #[test]
    fn both_versions() {
        for version in [3, 4] {
            let bytes = file(version, &[stream(version, 0.0, 3), stream(version, 2.0, 3)]);
            let mesh = read(&bytes, 1).unwrap();
            assert_eq!((mesh.positions()[1], mesh.triangles()), (DVec3::new(1.0, 0.0, 2.0), [[0, 1, 2]].as_slice()));
            assert_eq!((mesh.normals()[0], mesh.uvs()[2]), (DVec3::Z, DVec2::Y));
        }
    }

    #[test]
    fn lies_are_refused() {
        let error = |bytes: &[u8], index| read(bytes, index).unwrap_err().to_string();
        let good = file(4, &[stream(4, 0.0, 3)]);
        assert!(error(&good, 1).contains("mesh 1 is asked for; allowed is meshes 0 to 1, exclusive"));
        let huge = file(4, &[stream(4, 0.0, 1_000_000_000)]);
        assert!(error(&huge, 0).contains("mesh 0: the counts of vertices and triangles = 1000000000 and 1"));
        let long = file(4, &[stream(4, 0.0, 4)]);
        assert!(error(&long, 0).contains("the file ends within its data"), "{}", error(&long, 0));
        let mut magic = good.clone();
        magic[0] = 0;
        assert!(error(&magic, 0).starts_with("a.serialized: byte 0: the identifier 0x0400 and the version 4"));
        for end in 0..good.len() {
            assert!(read(&good[..end], 0).is_err(), "cut at {end}");
        }
        for at in 0..good.len() {
            let mut damaged = good.clone();
            damaged[at] ^= 0x55;
            // The checksum of zlib is not asked for; all that counts is that nothing panics.
            let _ = read(&damaged, 0);
        }
    }
}
