//! The data behind the figures and the notebooks: small tables that anyone can make again, bit by bit.
//!
//! Their makers depend on nothing: no argument, no clock, no number of threads. [`SETS`] is all of them, [`index`] says what
//! the columns mean.

pub mod bounces;
pub mod cosine;
pub mod lights;
pub mod phong;
pub mod pictures;
pub mod points;
mod rates;
pub mod split;

use std::fmt::Debug;

use serde::Serialize;

use super::table;
use crate::bsdf::Bsdf;
use crate::bsdf::subject::parse;
use crate::scene::Scene;
use crate::scene::builtin::builtin;

/// Files that are made together, from the same numbers.
#[derive(Clone, Copy, Debug)]
pub struct Set {
    /// What they are about, in a few words.
    pub name: &'static str,
    /// The files.
    pub files: &'static [File],
    /// Makes their contents, in the order of the files.
    pub make: fn() -> Vec<String>,
}

/// A file of a set.
#[derive(Clone, Copy, Debug)]
pub struct File {
    /// Its name in the folder.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub about: &'static str,
    /// The columns with their meanings; none for a drawing.
    pub columns: &'static [(&'static str, &'static str)],
}

/// All sets, in the order of the lecture.
pub const SETS: &[Set] = &[
    bounces::SET,
    cosine::SET,
    lights::IRRADIANCE,
    lights::HIGHLIGHTS,
    points::SET,
    pictures::SET,
    split::SET,
    phong::SET,
];

/// The name of the file that says what the others are.
pub const INDEX: &str = "index.json";

/// The seed of all files.
const SEED: u64 = 1;
/// Digits of what is measured: far more than its noise leaves, and fewer than an elementary function's last bit reaches,
/// which may differ from machine to machine.
const MEASURED: usize = 7;
/// Digits of what is known.
const KNOWN: usize = 12;

#[derive(Serialize)]
struct Index {
    schema: u32,
    made_by: &'static str,
    seed: u64,
    files: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    name: &'static str,
    about: &'static str,
    columns: Vec<Column>,
}

#[derive(Serialize)]
struct Column {
    name: &'static str,
    meaning: &'static str,
}

/// [`INDEX`]: every file with its columns, as JSON.
pub fn index() -> String {
    let entry = |file: &File| Entry {
        name: file.name,
        about: file.about,
        columns: file.columns.iter().map(|&(name, meaning)| Column { name, meaning }).collect(),
    };
    let files = SETS.iter().flat_map(|set| set.files).map(entry).collect();
    let index = Index { schema: 1, made_by: "whitefurnace notebooks-data", seed: SEED, files };
    serde_json::to_string_pretty(&index).map_or_else(|error| unreachable!("plain texts: {error}"), |text| text + "\n")
}

/// The rows under the names of the columns.
fn csv(columns: &[(&'static str, &str)], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let heads: Vec<String> = columns.iter().map(|(name, _)| (*name).to_string()).collect();
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    debug_assert!(rows.iter().all(|row| row.len() == heads.len()), "a row has lost a cell: {heads:?}");
    std::iter::once(&heads).chain(&rows).map(|row| table::csv_line(row)).collect()
}

/// `x` to so many significant digits, as the shortest text that reads back as that number.
fn rounded(x: f64, digits: usize) -> String {
    let text = format!("{x:.*e}", digits - 1);
    text.parse().map_or(text, table::exact)
}

/// What cannot fail, because it is made of literals of this crate.
fn literal<T, E: Debug>(made: Result<T, E>) -> T {
    made.unwrap_or_else(|error| panic!("a literal of this crate is wrong: {error:?}"))
}

fn subject(text: &str) -> Box<dyn Bsdf> {
    literal(parse(text))
}

fn scene(name: &str, params: &[(&str, String)]) -> Scene {
    let params: Vec<_> = params.iter().map(|(key, value)| ((*key).to_string(), value.clone())).collect();
    literal(Scene::new(literal(builtin(name, &params).ok_or(name).map(literal))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_digits_and_read_back() {
        assert_eq!([1.0 / 3.0, 2.0, 1.23456789e-7, 0.0].map(|x| rounded(x, 4)), ["0.3333", "2.0", "1.235e-7", "0.0"]);
        assert_eq!(rounded(f64::INFINITY, 4), "inf");
    }

    #[test]
    fn names_are_unique_and_the_index_knows_them_all() {
        let index = index();
        let files: Vec<&File> = SETS.iter().flat_map(|set| set.files).collect();
        for (i, file) in files.iter().enumerate() {
            assert!(files[..i].iter().all(|other| other.name != file.name), "{}", file.name);
            assert!(index.contains(&format!("\"name\": \"{}\"", file.name)), "{}", file.name);
            assert_eq!(file.columns.is_empty(), file.name.rsplit('.').next() != Some("csv"), "{}", file.name);
        }
    }
}
