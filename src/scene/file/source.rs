//! Reading files whole, within limits.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::error::{Place, SceneError, one_line};
use crate::image::{Image, MAX_FILE_BYTES};

/// The largest file of text that describes a scene [bytes]: markup takes a multiple of it in memory.
pub(super) const LARGEST_TEXT: u64 = 64 << 20;
/// The largest file of geometry [bytes].
pub(super) const LARGEST_DATA: u64 = 8 << 30;

/// The bytes of `path`, at most `largest`; `asked` is where another file names it.
pub(super) fn read(path: &Path, largest: u64, asked: Option<&Place>) -> Result<Vec<u8>, SceneError> {
    let (file, length) = open(path, asked)?;
    let too_large = || SceneError::TooMany { place: Place::whole(path), what: "bytes".into(), most: largest };
    if length > largest {
        return Err(too_large());
    }
    // The file may grow while it is read.
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|e| failed(path, asked, io::Error::other(e)))?;
    file.take(largest + 1).read_to_end(&mut bytes).map_err(|e| failed(path, asked, e))?;
    if bytes.len() as u64 > largest { Err(too_large()) } else { Ok(bytes) }
}

fn failed(path: &Path, asked: Option<&Place>, source: io::Error) -> SceneError {
    let file = Place::whole(path);
    let place = asked.map_or_else(|| file.to_string(), |by| format!("{by}: {file}"));
    SceneError::Read { place, source }
}

/// The file `path` and its length. Folders, devices and pipes are refused before they are opened: some never end.
fn open(path: &Path, asked: Option<&Place>) -> Result<(File, u64), SceneError> {
    let metadata = fs::metadata(path).map_err(|e| failed(path, asked, e))?;
    if !metadata.is_file() {
        let kind = if metadata.is_dir() { "a folder" } else { "a device or pipe" };
        return Err(failed(path, asked, io::Error::other(format!("it is {kind}; allowed is a file"))));
    }
    Ok((File::open(path).map_err(|e| failed(path, asked, e))?, metadata.len()))
}

/// The first bytes of `path`, by which formats are known.
pub(super) fn read_start(path: &Path) -> Result<Vec<u8>, SceneError> {
    let mut start = Vec::new();
    open(path, None)?.0.take(64).read_to_end(&mut start).map_err(|e| failed(path, None, e))?;
    Ok(start)
}

/// The image `path`, which is named at `asked`. Its colours are finite and ≥ 0.
pub(super) fn read_image(path: &Path, asked: &Place) -> Result<Image, SceneError> {
    decode_image(&read(path, MAX_FILE_BYTES, Some(asked))?, path, asked)
}

/// The same, of bytes that `path` names.
pub(super) fn decode_image(bytes: &[u8], path: &Path, asked: &Place) -> Result<Image, SceneError> {
    let image = Image::decode(bytes, path)
        .map_err(|source| SceneError::Image { place: asked.clone(), source: Box::new(source) })?;
    let bad = |problem: String, allowed: &str| SceneError::Malformed {
        place: asked.clone(),
        problem: format!("{}: {problem}", one_line(&path.to_string_lossy(), usize::MAX)),
        allowed: allowed.into(),
    };
    let Some(planes) = image.colour() else {
        return Err(bad("no colours".into(), "an image with planes R, G and B, or one"));
    };
    let wrong = planes.iter().find_map(|plane| plane.iter().position(|x| !(0.0..=f32::MAX).contains(x)));
    match wrong {
        None => Ok(image),
        Some(at) => {
            let (x, y) = (at % image.width(), at / image.width());
            Err(bad(format!("pixel {x}, {y} is negative or no number"), "finite colours ≥ 0"))
        }
    }
}

/// The same as text in UTF-8.
pub(super) fn read_text(path: &Path, asked: Option<&Place>) -> Result<String, SceneError> {
    let bytes = read(path, LARGEST_TEXT, asked)?;
    String::from_utf8(bytes).map_err(|e| SceneError::Malformed {
        place: Place::byte(path, e.utf8_error().valid_up_to() as u64),
        problem: "this is not UTF-8".into(),
        allowed: "text in UTF-8".into(),
    })
}
