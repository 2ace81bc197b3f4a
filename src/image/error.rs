//! What can be wrong with an image file.

use std::io;
use std::path::PathBuf;

/// Why an image could not be read, made or written. The message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The content is that of no known format.
    #[error("{}: is no image; read are PNG, JPEG, OpenEXR, Radiance HDR and PFM", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// The content is damaged, or something that is not read.
    #[error("{}: {format}: {reason}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What it claims to be.
        format: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// A name for output that tells no format.
    #[error("{}: no image format has this extension; allowed are .exr, .pfm, .hdr and .png", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// A plane of the wrong size.
    #[error("plane {name}: {samples} samples for {width} x {height} pixels")]
    Plane {
        /// The plane.
        name: String,
        /// What it has.
        samples: usize,
        /// Columns of the image.
        width: usize,
        /// Rows of the image.
        height: usize,
    },
    /// Two planes of one name.
    #[error("plane {name}: there are two")]
    PlaneTwice {
        /// The plane.
        name: String,
    },
    /// The format does not hold this image.
    #[error("{format}: cannot be written: {reason}")]
    Encode {
        /// The format.
        format: &'static str,
        /// Why not.
        reason: String,
    },
}
