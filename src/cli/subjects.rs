//! From the text of a SUBJECT to its models: a name of the catalog, or a file.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use anyhow::{Context, anyhow, bail};

use crate::bsdf::measured::load_fits;
use crate::bsdf::subject::SubjectError;
use crate::bsdf::{Bsdf, catalog, subject};

/// Largest file that is read, in bytes: a table of fits has some 50 kB, a list of subjects less.
const MAX_FILE: u64 = 16 * 1024 * 1024;
/// Most subjects in one file.
const MAX_SUBJECTS: usize = 100_000;

/// A model, and what the user called it.
#[derive(Debug)]
pub(super) struct Subject {
    pub(super) name: String,
    pub(super) bsdf: Box<dyn Bsdf>,
}

/// All models that `text` stands for, at least one.
pub(super) fn load(text: &str) -> anyhow::Result<Vec<Subject>> {
    let name = text.split(':').next().unwrap_or_default().trim();
    let path = Path::new(text);
    if catalog::find(name).is_none() && fs::symlink_metadata(path).is_ok() {
        return load_file(path);
    }
    match subject::parse(text) {
        Ok(bsdf) => Ok(vec![Subject { name: text.trim().into(), bsdf }]),
        // The first half of "no such model or file" is known; say it of the text as it was typed.
        Err(SubjectError::UnknownModel { hint, .. }) => {
            let typed: String = text.chars().take(200).collect();
            Err(anyhow!("{typed}: no such model or file; {hint}"))
        }
        Err(error) => Err(error.into()),
    }
}

/// The one model that `text` stands for.
pub(super) fn load_one(text: &str) -> anyhow::Result<Subject> {
    let mut all = load(text)?;
    if all.len() > 1 {
        bail!("{text}: holds {} subjects; this command takes one, only validate takes many", all.len());
    }
    all.pop().with_context(|| format!("{text}: holds no subject"))
}

fn load_file(path: &Path) -> anyhow::Result<Vec<Subject>> {
    let shown = path.display();
    let file = File::open(path).map_err(|error| anyhow!("{shown}: cannot be read: {error}"))?;
    let kind = file.metadata().map_err(|error| anyhow!("{shown}: cannot be read: {error}"))?;
    if kind.is_dir() {
        bail!("{shown}: is a directory; allowed is a text file of subjects or a CSV table of fits");
    }
    let mut bytes = Vec::new();
    // One byte more than allowed, so that a pipe or a device, which tells no length, is bounded too.
    let read = file.take(MAX_FILE + 1).read_to_end(&mut bytes);
    read.map_err(|error| anyhow!("{shown}: cannot be read: {error}"))?;
    if bytes.len() as u64 > MAX_FILE {
        bail!("{shown}: is larger than {} MiB, the most that is allowed", MAX_FILE >> 20);
    }
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        anyhow!(
            "{shown}: byte {} is not UTF-8 text; allowed is a text file of subjects or a CSV table of fits",
            error.valid_up_to()
        )
    })?;
    if let Some(at) = text.find('\0') {
        bail!("{shown}: byte {at} is NUL; allowed is a text file of subjects or a CSV table of fits");
    }
    let subjects = if is_table_of_fits(text) {
        let fits = load_fits(path)?.into_iter();
        fits.map(|(name, bsdf)| Subject { name, bsdf }).collect()
    } else {
        load_lines(text).with_context(|| shown.to_string())?
    };
    if subjects.is_empty() {
        bail!("{shown}: holds no subject; allowed is one subject per line, or a CSV table of fits");
    }
    Ok(subjects)
}

/// A table starts with its header, whose first column is the material's name.
fn is_table_of_fits(text: &str) -> bool {
    statements(text).next().is_some_and(|(_, line)| line.split(',').next() == Some("name"))
}

/// The lines that say something, with their numbers.
fn statements(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    lines.map(|(at, line)| (at + 1, without_comment(line).trim())).filter(|(_, line)| !line.is_empty())
}

/// A `#` starts a comment at the start of a line or after a blank, so that a file's name may hold one.
fn without_comment(line: &str) -> &str {
    let mut blank = true;
    for (at, c) in line.char_indices() {
        if c == '#' && blank {
            return &line[..at];
        }
        blank = c.is_whitespace();
    }
    line
}

fn load_lines(text: &str) -> anyhow::Result<Vec<Subject>> {
    let mut subjects = Vec::new();
    for (number, line) in statements(text) {
        if subjects.len() == MAX_SUBJECTS {
            bail!("line {number}: more than {MAX_SUBJECTS} subjects; split the file");
        }
        let bsdf = subject::parse(line).with_context(|| format!("line {number}"))?;
        subjects.push(Subject { name: line.into(), bsdf });
    }
    Ok(subjects)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn file(content: &[u8]) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(content).unwrap();
        file
    }

    fn error_of(content: &[u8]) -> String {
        let file = file(content);
        let error = format!("{:#}", load(file.path().to_str().unwrap()).unwrap_err());
        assert!(error.contains(file.path().to_str().unwrap()), "names the file: {error}");
        error
    }

    #[test]
    fn a_file_of_subjects_keeps_their_order() {
        let file = file(b"# two\nlambert:rho=0.25  # grey\n\n  lambert:rho=1/0.5/0\n");
        let subjects = load(file.path().to_str().unwrap()).unwrap();
        let names: Vec<&str> = subjects.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["lambert:rho=0.25", "lambert:rho=1/0.5/0"]);
        let error = load_one(file.path().to_str().unwrap()).unwrap_err().to_string();
        assert!(error.contains("holds 2 subjects"), "{error}");
    }

    #[test]
    fn errors_name_the_file_and_the_line() {
        let error = error_of(b"lambert:rho=1\nlambrt:rho=1\n");
        assert!(error.contains("line 2: lambrt: no such model") && error.contains("did you mean lambert?"), "{error}");
        assert!(error_of(b"").contains("holds no subject"));
        assert!(error_of(b"# nothing\n").contains("holds no subject"));
        assert!(error_of(&[0xff, 0xfe, 1, 2]).contains("byte 0 is not UTF-8"));
        assert!(error_of(b"lambert\0").contains("byte 7 is NUL"));
        assert!(error_of(&vec![b'#'; MAX_FILE as usize + 1]).contains("larger than 16 MiB"));
        assert!(load("/").unwrap_err().to_string().contains("is a directory"));
    }

    #[test]
    fn only_a_header_makes_a_table() {
        assert!(is_table_of_fits("# fits\nname,kD_r\nx,1\n"));
        assert!(!is_table_of_fits("lambert:rho=1\n") && !is_table_of_fits("# name,x\n") && !is_table_of_fits(""));
    }
}
