//! glTF 2.0 and its binary form .glb.
//!
//! Read are meshes (triangles, strips, fans) with normals, texture coordinates and colours, the nodes that place them,
//! metallic-roughness materials, cameras, and the extensions KHR_lights_punctual, KHR_materials_emissive_strength and
//! KHR_texture_transform. Surfaces are seen from both sides and shine from both; the one light a format without units of
//! radiance has, `emissiveFactor`, is a radiance, and candelas and luxes count as W/sr and W/m².
//! # References
//! - Khronos Group 2021, glTF 2.0 specification

mod buffers;
mod json;
mod light;
mod material;
mod metallic_roughness;
mod scene;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::Notes;
use super::error::{Place, SceneError, listed, one_line, quoted};
use super::source;
use crate::scene::description::SceneDescription;
use json::Root;

/// The extensions that are read.
const EXTENSIONS: [&str; 3] = ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_texture_transform"];
/// "JSON" and "BIN\0", little-endian.
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;

/// Reads the scene in `path`.
pub(super) fn load(path: &Path, notes: &Notes) -> Result<SceneDescription, SceneError> {
    let bytes = source::read(path, source::LARGEST_DATA, None)?;
    let (text, binary) = if bytes.starts_with(b"glTF") { chunks(path, &bytes)? } else { (bytes.as_slice(), None) };
    let root: Root = serde_json::from_slice(text).map_err(|error| SceneError::Malformed {
        place: Place::line(path, error.line() as u64),
        problem: one_line(&error.to_string(), 200),
        allowed: "JSON as glTF 2.0 has it".into(),
    })?;
    if !root.asset.version.starts_with("2.") {
        return Err(SceneError::Unsupported {
            place: Place::element(path, "asset"),
            what: format!("version {}", quoted(&root.asset.version)),
            known: "2.0".into(),
        });
    }
    for extension in root.extensions_used.iter().chain(&root.extensions_required) {
        if !EXTENSIONS.contains(&extension.as_str()) {
            let place = Place::element(path, "extensionsUsed");
            let what = format!("the extension {}", quoted(extension));
            let error = SceneError::Unsupported { place, what, known: listed(EXTENSIONS) };
            notes.unsupported(error, "it is ignored")?;
        }
    }
    if !root.animations.is_empty() {
        let place = Place::element(path, "animations[0]");
        let error = SceneError::Unsupported { place, what: "an animation".into(), known: "what stands still".into() };
        notes.unsupported(error, "its nodes are where the file puts them")?;
    }
    scene::build(path, &root, binary, notes)
}

/// The JSON and the binary chunk of a .glb.
fn chunks<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    let word = |at: usize| bytes.get(at..).and_then(|rest| rest.first_chunk()).map(|raw| u32::from_le_bytes(*raw));
    let truncated = |within: &str| SceneError::Truncated {
        place: Place::byte(path, bytes.len() as u64),
        within: within.into(),
        allowed: "a header of 12 bytes and chunks as long as they say".into(),
    };
    let version = word(4).ok_or_else(|| truncated("its header"))?;
    if version != 2 {
        let place = Place::byte(path, 4);
        return Err(SceneError::Unsupported { place, what: format!("version {version}"), known: "2".into() });
    }
    let length = word(8).ok_or_else(|| truncated("its header"))? as usize;
    if length > bytes.len() {
        return Err(truncated(&format!("the {length} bytes that it declares")));
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while at < length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else { return Err(truncated("the head of a chunk")) };
        let start = at + 8;
        let end = start.checked_add(size as usize).filter(|end| *end <= length);
        let end = end.ok_or_else(|| truncated(&format!("a chunk of {size} bytes at byte {at}")))?;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(&bytes[start..end]),
            BINARY_CHUNK if binary.is_none() => binary = Some(&bytes[start..end]),
            // Others are to be ignored, the specification says.
            _ => {}
        }
        // Chunks are padded to four bytes; the padding is part of them.
        at = end;
    }
    let json = json.ok_or_else(|| SceneError::Missing {
        place: Place::byte(path, 12),
        what: "the chunk JSON".into(),
        allowed: "the chunks JSON and BIN".into(),
    })?;
    Ok((json, binary))
}
