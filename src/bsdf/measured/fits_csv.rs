//! Tables of fitted parameters: comma-separated text, `#` comments, a header line, one material a row.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::bsdf::subject::{SubjectError, nearest_name};
use crate::math::color::Rgb;

/// Largest table, in bytes: a hundred times the published ones.
const MAX_BYTES: u64 = 4 << 20;

const SGD: [&str; 11] = ["rhoD", "rhoS", "alpha", "p", "f0", "f1", "kap", "lambda", "c", "k", "theta0"];
const ABC: [&str; 2] = ["kD", "A"];
const ABC_NUMBERS: [&str; 3] = ["B", "C", "ior"];

/// Which model a table holds, told by its header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Sgd,
    Abc,
}

impl Kind {
    /// The columns that a table of this kind must have beside `name`.
    fn columns(self) -> Vec<String> {
        let colours: &[&str] = if self == Self::Sgd { &SGD } else { &ABC };
        let numbers: &[&str] = if self == Self::Sgd { &[] } else { &ABC_NUMBERS };
        let channels = colours.iter().flat_map(|colour| ["r", "g", "b"].map(|c| format!("{colour}_{c}")));
        channels.chain(numbers.iter().map(ToString::to_string)).collect()
    }
}

/// One material.
#[derive(Clone, Debug)]
pub(super) struct Row {
    line: usize,
    pub(super) name: String,
    fields: Vec<String>,
}

/// A table of fits whose header is that of one of the two kinds.
#[derive(Clone, Debug)]
pub(super) struct FitsCsv {
    path: PathBuf,
    columns: Vec<String>,
    pub(super) kind: Kind,
    pub(super) rows: Vec<Row>,
}

impl FitsCsv {
    /// Reads the table at `path`.
    pub(super) fn read(path: &Path) -> Result<Self, SubjectError> {
        let fail = |reason: String| SubjectError::File { path: path.display().to_string(), reason };
        let cannot =
            |error: std::io::Error| fail(format!("cannot be read: {error}; allowed is a CSV of SGD or ABC fits"));
        let file = File::open(path).map_err(cannot)?;
        if !file.metadata().map_err(cannot)?.is_file() {
            return Err(fail("is not a file; allowed is a CSV of SGD or ABC fits".into()));
        }
        let mut bytes = Vec::new();
        file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(cannot)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(fail(format!("is longer than {} MiB, the largest table allowed", MAX_BYTES >> 20)));
        }
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = bytes[..error.valid_up_to()].split(|&byte| byte == b'\n').count();
            fail(format!("line {line}: not UTF-8 text; allowed is a CSV of SGD or ABC fits"))
        })?;
        Self::parse(path, text)
    }

    /// Reads the table in `text`, which came from `path`.
    pub(super) fn parse(path: &Path, text: &str) -> Result<Self, SubjectError> {
        let fail = |line: usize, reason: String| SubjectError::File {
            path: path.display().to_string(),
            reason: format!("line {line}: {reason}"),
        };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = (1..).zip(text.lines().map(str::trim)).filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
        let (line, header) = lines
            .next()
            .ok_or_else(|| fail(1, "no header; the first is name,rhoD_r,… (SGD) or name,kD_r,… (ABC)".into()))?;
        let columns: Vec<String> = header.split(',').map(|c| c.trim().to_owned()).collect();
        let has = |name: &str| columns.iter().any(|c| c == name);
        let missing = |kind: Kind| {
            let wanted = ["name".to_owned()].into_iter().chain(kind.columns());
            wanted.filter(|c| !has(c)).collect::<Vec<_>>()
        };
        let (sgd, abc) = (missing(Kind::Sgd), missing(Kind::Abc));
        let (kind, lacks) = if sgd.len() <= abc.len() { (Kind::Sgd, sgd) } else { (Kind::Abc, abc) };
        if let Some(first) = lacks.first() {
            let known = kind.columns().join(",");
            let name = if kind == Kind::Sgd { "SGD" } else { "ABC" };
            return Err(fail(line, format!("no column {first}; a table of {name} fits has the columns name,{known}")));
        }
        let mut rows: Vec<Row> = Vec::new();
        let name_at = columns.iter().position(|c| c == "name").unwrap_or_default();
        for (line, text) in lines {
            let fields: Vec<String> = text.split(',').map(|field| field.trim().to_owned()).collect();
            if fields.len() != columns.len() {
                return Err(fail(line, format!("{} fields, but the header has {}", fields.len(), columns.len())));
            }
            let name = fields[name_at].clone();
            if let Some(other) = rows.iter().find(|row| row.name == name) {
                return Err(fail(line, format!("column name: {} is already on line {}", shown(&name), other.line)));
            }
            rows.push(Row { line, name, fields });
        }
        if rows.is_empty() {
            return Err(fail(line, "a header without materials; each further line is one".into()));
        }
        Ok(Self { path: path.into(), columns, kind, rows })
    }

    /// The row of `material`; the error gives the nearest name.
    pub(super) fn find(&self, material: &str) -> Result<&Row, SubjectError> {
        self.rows.iter().find(|row| row.name == material).ok_or_else(|| SubjectError::File {
            path: self.path.display().to_string(),
            reason: format!(
                "no material {}; {}",
                shown(material),
                nearest_name(material, self.rows.iter().map(|row| row.name.as_str()))
            ),
        })
    }

    /// What is wrong with `row`.
    pub(super) fn error(&self, row: &Row, reason: impl fmt::Display) -> SubjectError {
        SubjectError::File { path: self.path.display().to_string(), reason: format!("line {}: {reason}", row.line) }
    }

    /// The number in `column` of `row`.
    pub(super) fn number(&self, row: &Row, column: &str) -> Result<f64, SubjectError> {
        let at = self.columns.iter().position(|c| c == column);
        let text = at.and_then(|at| row.fields.get(at)).map_or("", String::as_str);
        text.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
            self.error(row, format!("column {column}: '{}' is not allowed; allowed is a finite number", shown(text)))
        })
    }

    /// The colour in the columns `name_r`, `name_g`, `name_b` of `row`.
    pub(super) fn colour(&self, row: &Row, name: &str) -> Result<Rgb, SubjectError> {
        let channel = |c: &str| self.number(row, &format!("{name}_{c}"));
        Ok(Rgb::new(channel("r")?, channel("g")?, channel("b")?))
    }
}

/// The start of a text from a file, fit for one line of an error.
fn shown(text: &str) -> String {
    text.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect()
}
