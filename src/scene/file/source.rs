//! Reading files whole, within limits.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::error::{Place, SceneError};

/// The largest file of text that describes a scene [bytes]: markup takes a multiple of it in memory.
pub(super) const LARGEST_TEXT: u64 = 64 << 20;
/// The largest file of geometry [bytes].
pub(super) const LARGEST_DATA: u64 = 8 << 30;

/// The bytes of `path`, at most `largest`; `asked` is where another file names it.
pub(super) fn read(path: &Path, largest: u64, asked: Option<&Place>) -> Result<Vec<u8>, SceneError> {
    let failed = |source: io::Error| {
        let file = Place::whole(path);
        let place = asked.map_or_else(|| file.to_string(), |by| format!("{by}: {file}"));
        SceneError::Read { place, source }
    };
    let metadata = fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        let kind = if metadata.is_dir() { "a folder" } else { "a device or pipe" };
        return Err(failed(io::Error::other(format!("it is {kind}; allowed is a file"))));
    }
    let too_large = || SceneError::TooMany { place: Place::whole(path), what: "bytes".into(), most: largest };
    if metadata.len() > largest {
        return Err(too_large());
    }
    // The file may grow while it is read.
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(metadata.len() as usize).map_err(|e| failed(io::Error::other(e)))?;
    File::open(path).map_err(failed)?.take(largest + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > largest { Err(too_large()) } else { Ok(bytes) }
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
