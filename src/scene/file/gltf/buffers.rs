//! Buffers, views of them, and accessors: every length is checked against the bytes that are there.

use std::path::Path;

use super::json::{Accessor, Root};
use crate::scene::file::error::{Place, SceneError, quoted};
use crate::scene::file::source;

/// The bytes of all buffers.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    path: &'a Path,
    root: &'a Root,
    bytes: Vec<Vec<u8>>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers of `root`; `binary` is the chunk of a .glb.
    pub(super) fn load(path: &'a Path, root: &'a Root, binary: Option<&[u8]>) -> Result<Self, SceneError> {
        let mut all = Vec::new();
        for (index, buffer) in root.buffers.iter().enumerate() {
            let place = Place::element(path, format!("buffers[{index}]"));
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => resource(path, uri, &place)?,
                (None, Some(binary)) if index == 0 => binary.to_vec(),
                (None, _) => {
                    let allowed = "a uri, or for the first one of a .glb its binary chunk".into();
                    return Err(SceneError::Missing { place, what: "uri".into(), allowed });
                }
            };
            if buffer.byte_length > bytes.len() as u64 {
                return Err(SceneError::Value {
                    place,
                    what: "byteLength".into(),
                    given: buffer.byte_length.to_string(),
                    allowed: format!("at most the {} bytes that are there", bytes.len()),
                });
            }
            all.push(bytes);
        }
        Ok(Self { path, root, bytes: all })
    }

    /// The bytes of a view, and its stride.
    pub(super) fn view(&self, index: usize, asked: &Place) -> Result<(&[u8], Option<u64>), SceneError> {
        let view = get(&self.root.buffer_views, index, "bufferView", asked)?;
        let place = Place::element(self.path, format!("bufferViews[{index}]"));
        let bytes = get(&self.bytes, view.buffer, "buffer", &place)?;
        let range = usize::try_from(view.byte_offset).ok().zip(usize::try_from(view.byte_length).ok());
        let range = range.and_then(|(start, length)| bytes.get(start..start.checked_add(length)?));
        let range = range.ok_or_else(|| SceneError::Value {
            place,
            what: "byteOffset + byteLength".into(),
            given: format!("{} + {}", view.byte_offset, view.byte_length),
            allowed: format!("at most the {} bytes of its buffer", bytes.len()),
        })?;
        Ok((range, view.byte_stride))
    }

    /// The values of an accessor whose type is one of `kinds`, in rows of N; values that are not there are 1.
    pub(super) fn rows<const N: usize>(
        &self,
        index: usize,
        kinds: &[&str],
        asked: &Place,
    ) -> Result<Vec<[f64; N]>, SceneError> {
        let accessor = get(&self.root.accessors, index, "accessor", asked)?;
        let place = Place::element(self.path, format!("accessors[{index}]"));
        let mut rows = Vec::new();
        let elements = Elements::new(self, accessor, kinds, &place)?;
        rows.try_reserve_exact(elements.count).map_err(|_| elements.too_many(&place))?;
        for at in 0..elements.count {
            let mut row = [1.0; N];
            for (component, value) in row.iter_mut().take(elements.components).enumerate() {
                *value = elements.value(at, component);
            }
            rows.push(row);
        }
        Ok(rows)
    }

    /// The whole numbers of an accessor.
    pub(super) fn indices(&self, index: usize, asked: &Place) -> Result<Vec<u32>, SceneError> {
        let accessor = get(&self.root.accessors, index, "accessor", asked)?;
        let place = Place::element(self.path, format!("accessors[{index}]"));
        if ![5121, 5123, 5125].contains(&accessor.component_type) || accessor.normalized {
            return Err(SceneError::Value {
                place,
                what: "componentType of indices".into(),
                given: accessor.component_type.to_string(),
                allowed: "5121, 5123, 5125, not normalized".into(),
            });
        }
        let elements = Elements::new(self, accessor, &["SCALAR"], &place)?;
        // Every value of these types is a whole number below 2³².
        Ok((0..elements.count).map(|at| elements.value(at, 0) as u32).collect())
    }
}

/// The elements of one accessor.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    components: usize,
    component_type: u32,
    normalized: bool,
}

impl<'a> Elements<'a> {
    fn new(buffers: &'a Buffers<'_>, accessor: &Accessor, kinds: &[&str], place: &Place) -> Result<Self, SceneError> {
        let bad = |what: &str, given: String, allowed: String| SceneError::Value {
            place: place.clone(),
            what: what.into(),
            given,
            allowed,
        };
        let size: usize = match accessor.component_type {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            other => return Err(bad("componentType", other.to_string(), "5120 to 5123, 5125, 5126".into())),
        };
        if !kinds.contains(&accessor.kind.as_str()) {
            return Err(bad("type", quoted(&accessor.kind), kinds.join(", ")));
        }
        let components = match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
            let what = "an accessor that is sparse or has no bufferView".to_string();
            return Err(SceneError::Unsupported { place: place.clone(), what, known: "a bufferView".into() });
        };
        let (view, stride) = buffers.view(view, place)?;
        let element = (components * size) as u64;
        let stride = stride.unwrap_or(element);
        if !(element..=252).contains(&stride) {
            return Err(bad("byteStride", stride.to_string(), format!("{element} to 252")));
        }
        // The last element needs no more than itself.
        let last = accessor.count.saturating_sub(1).saturating_mul(stride);
        let needed = if accessor.count == 0 { 0 } else { last.saturating_add(element) };
        let needed = needed.saturating_add(accessor.byte_offset);
        if needed > view.len() as u64 || accessor.count > u64::from(u32::MAX) {
            let allowed = format!("what fits into the {} bytes of its bufferView, and is below 2^32", view.len());
            return Err(bad("count", accessor.count.to_string(), allowed));
        }
        Ok(Self {
            bytes: &view[accessor.byte_offset as usize..],
            stride: stride as usize,
            count: accessor.count as usize,
            components,
            component_type: accessor.component_type,
            normalized: accessor.normalized,
        })
    }

    fn too_many(&self, place: &Place) -> SceneError {
        SceneError::TooMany { place: place.clone(), what: "elements for the memory".into(), most: self.count as u64 }
    }

    /// One value; 0 where there are no bytes, which the constructor excludes.
    fn value(&self, at: usize, component: usize) -> f64 {
        macro_rules! number {
            ($type:ty) => {{
                const SIZE: usize = size_of::<$type>();
                let start = at * self.stride + component * SIZE;
                let raw = self.bytes.get(start..start + SIZE).and_then(|raw| raw.try_into().ok());
                let value = raw.map_or(0.0, |raw| f64::from(<$type>::from_le_bytes(raw)));
                // Of signed values the smallest but one stands for −1.
                if self.normalized { (value / f64::from(<$type>::MAX)).max(-1.0) } else { value }
            }};
        }
        match self.component_type {
            5120 => number!(i8),
            5121 => number!(u8),
            5122 => number!(i16),
            5123 => number!(u16),
            5125 => number!(u32),
            _ => {
                let start = at * self.stride + component * 4;
                let raw = self.bytes.get(start..start + 4).and_then(|raw| raw.try_into().ok());
                raw.map_or(0.0, |raw| f64::from(f32::from_le_bytes(raw)))
            }
        }
    }
}

/// Entry `index` of a list of the file.
pub(super) fn get<'t, T>(list: &'t [T], index: usize, what: &str, asked: &Place) -> Result<&'t T, SceneError> {
    list.get(index).ok_or_else(|| SceneError::Value {
        place: asked.clone(),
        what: what.into(),
        given: index.to_string(),
        allowed: format!("below {}, of which there are so many", list.len()),
    })
}

/// The bytes that a uri names: those in itself, or those of a file beside the scene.
pub(super) fn resource(path: &Path, uri: &str, place: &Place) -> Result<Vec<u8>, SceneError> {
    let bad = |allowed: &str| SceneError::Value {
        place: place.clone(),
        what: "uri".into(),
        given: quoted(uri),
        allowed: allowed.into(),
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        return encoded.and_then(from_base64).ok_or_else(|| bad("data:…;base64, and base64"));
    }
    let name = unescaped(uri).filter(|name| !name.contains("://"));
    let name = name.ok_or_else(|| bad("the name of a file beside this one, or data:…;base64,…"))?;
    source::read(&path.with_file_name(name), source::LARGEST_DATA, Some(place))
}

/// `%20` and the like as what they stand for.
fn unescaped(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, behind)) = rest.split_first() {
        rest = behind;
        if first == b'%' {
            let (digits, behind) = rest.split_at_checked(2)?;
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = behind;
        } else {
            bytes.push(first);
        }
    }
    String::from_utf8(bytes).ok()
}

/// The bytes that `text` encodes (RFC 4648), with or without padding.
fn from_base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut bits = 0_u32;
        for &letter in group {
            let value = match letter {
                b'A'..=b'Z' => letter - b'A',
                b'a'..=b'z' => letter - b'a' + 26,
                b'0'..=b'9' => letter - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bits <<= 6 * (4 - group.len());
        let whole = match group.len() {
            4 => 3,
            3 => 2,
            2 => 1,
            _ => return None,
        };
        bytes.extend(&bits.to_be_bytes()[1..=whole]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        // The test vectors of RFC 4648.
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg", "foob"), ("Zm9vYmFy", "foobar")]
        {
            assert_eq!(from_base64(text).unwrap(), bytes.as_bytes(), "{text}");
        }
        assert!(from_base64("A").is_none() && from_base64("Zm9v!A==").is_none());
    }

    #[test]
    fn escapes_of_uris() {
        assert_eq!(unescaped("a%20b%C3%A9.bin").as_deref(), Some("a bé.bin"));
        assert!(unescaped("%").is_none() && unescaped("%zz").is_none() && unescaped("%ff").is_none());
    }
}
