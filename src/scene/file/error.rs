//! What can be wrong with a scene file, where, and what is allowed instead.

use std::fmt;
use std::path::Path;

use thiserror::Error;

use crate::bsdf::ParamError;
use crate::image::ImageError;
use crate::scene::mesh::MeshError;

/// The longest piece of a file that an error repeats, in characters.
const LONGEST_QUOTE: usize = 80;

/// The longest message of another error that an error repeats, in characters.
const LONGEST_SOURCE: usize = 400;

/// Where in a file something is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: Box<Path>,
    /// Where in it.
    pub at: At,
}

/// Where within a file something is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum At {
    /// The file as a whole.
    Whole,
    /// A line of text, from 1.
    Line(u64),
    /// A byte, from 0.
    Byte(u64),
    /// A named part, such as `meshes[0].primitives[1]`.
    Element(Box<str>),
}

impl Place {
    /// The file as a whole.
    pub fn whole(file: &Path) -> Self {
        Self { file: file.into(), at: At::Whole }
    }

    /// A line of it, from 1.
    pub fn line(file: &Path, line: u64) -> Self {
        Self { file: file.into(), at: At::Line(line) }
    }

    /// A byte of it, from 0.
    pub fn byte(file: &Path, byte: u64) -> Self {
        Self { file: file.into(), at: At::Byte(byte) }
    }

    /// A named part of it.
    pub fn element(file: &Path, element: impl Into<Box<str>>) -> Self {
        Self { file: file.into(), at: At::Element(element.into()) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", one_line(&self.file.to_string_lossy(), usize::MAX))?;
        match &self.at {
            At::Whole => Ok(()),
            At::Line(line) => write!(f, ": line {line}"),
            At::Byte(byte) => write!(f, ": byte {byte}"),
            At::Element(element) => write!(f, ": {element}"),
        }
    }
}

/// Why a scene file cannot be read. Each is shown as one line that names the file, the line, byte or element, and what
/// is allowed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be opened or read.
    #[error("{place}: cannot be read: {}", one_line(&source.to_string(), LONGEST_SOURCE))]
    Read {
        /// The file, and where it is asked for if another file does so.
        place: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file does not follow its format.
    #[error("{place}: {problem}; allowed is {allowed}")]
    Malformed {
        /// Where.
        place: Place,
        /// What was found.
        problem: String,
        /// What the format allows.
        allowed: String,
    },
    /// The file ends too early.
    #[error("{place}: the file ends within {within}; allowed is {allowed}")]
    Truncated {
        /// Where.
        place: Place,
        /// What is cut off.
        within: String,
        /// How long it must be.
        allowed: String,
    },
    /// The file asks for what this program does not have. With `lenient`, a warning.
    #[error("{place}: {what} is not supported; known are {known}")]
    Unsupported {
        /// Where.
        place: Place,
        /// What is asked for.
        what: String,
        /// What there is.
        known: String,
    },
    /// A value outside what it may be.
    #[error("{place}: {what} = {given} is not allowed; allowed is {allowed}")]
    Value {
        /// Where.
        place: Place,
        /// The name of the value.
        what: String,
        /// What was given.
        given: String,
        /// What is allowed.
        allowed: String,
    },
    /// Something that must be there is not.
    #[error("{place}: {what} is missing; allowed is {allowed}")]
    Missing {
        /// Where.
        place: Place,
        /// What is missing.
        what: String,
        /// What is expected.
        allowed: String,
    },
    /// More of something than is read, so that memory and time stay bounded.
    #[error("{place}: too many {what}; allowed are at most {most}")]
    TooMany {
        /// Where.
        place: Place,
        /// Of what there are too many.
        what: String,
        /// The limit.
        most: u64,
    },
    /// A mesh whose parts do not fit together.
    #[error("{place}: {}", one_line(&source.to_string(), LONGEST_SOURCE))]
    Mesh {
        /// Where.
        place: Place,
        /// What does not fit.
        source: MeshError,
    },
    /// An image that cannot be read.
    #[error("{place}: {}", one_line(&source.to_string(), LONGEST_SOURCE))]
    Image {
        /// Where it is asked for.
        place: Place,
        /// Why.
        source: Box<ImageError>,
    },
    /// A parameter outside the domain of a model of reflection.
    #[error("{place}: {}", one_line(&source.to_string(), LONGEST_SOURCE))]
    Model {
        /// Where.
        place: Place,
        /// Which parameter.
        source: Box<ParamError>,
    },
}

/// `text` in quotes as one short line, for errors.
pub(super) fn quoted(text: &str) -> String {
    format!("`{}`", one_line(text, LONGEST_QUOTE))
}

/// A list of names in one line, shortened where there are many.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 40;
    let mut names = names.into_iter().map(|name| one_line(name, LONGEST_QUOTE));
    let shown: Vec<String> = names.by_ref().take(MOST).collect();
    match (shown.is_empty(), names.count()) {
        (true, _) => "none".to_string(),
        (false, 0) => shown.join(", "),
        (false, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// At most `longest` characters of `text`, without control characters: files are not trusted with a terminal.
pub(super) fn one_line(text: &str, longest: usize) -> String {
    let mut line: String = text.chars().take(longest).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(longest).is_some() {
        line.push('…');
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_one_short_line() {
        let place = Place::line(Path::new("a\nb.xml"), 3);
        let given = quoted(&"\u{1b}[31m\n".repeat(1000));
        let error = SceneError::Value { place, what: "radius".into(), given, allowed: "a number > 0".into() };
        let shown = error.to_string();
        assert!(shown.len() < 250 && !shown.contains(char::is_control), "{shown}");
        assert!(shown.starts_with("a b.xml: line 3: radius = ") && shown.ends_with("allowed is a number > 0"));
    }

    #[test]
    fn lists_are_shortened() {
        assert_eq!(listed(["a", "b"]), "a, b");
        assert_eq!(listed([]), "none");
        assert!(listed(std::iter::repeat_n("x", 100)).ends_with(" and 60 more"));
    }
}
