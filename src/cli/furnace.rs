//! `whitefurnace furnace`: the path tracer in scenes whose answer is known; or a sphere of each SUBJECT in constant light.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;

use super::job::{Sink, sink};
use super::subjects::{self, Subject};
use super::validate::{colour_is_welcome, print, progress_bar};
use super::{Status, args};
use crate::bsdf::Bsdf;
use crate::render::furnace::{ENGINE_CHECKS, Furnace};
use crate::report::json;
use crate::report::text::{self, Style};
use crate::validate::{Outcome, Sheet};

/// What `furnace` takes.
#[derive(Debug, clap::Args)]
pub(super) struct FurnaceArgs {
    /// Models or files; none for the path tracer itself
    #[arg(value_name = "SUBJECT")]
    subjects: Vec<String>,
    /// Probability that anything correct fails anywhere in the run
    #[arg(long, value_name = "P", value_parser = args::level, default_value_t = Furnace::default().level, allow_hyphen_values = true)]
    level: f64,
    /// Seed of every random number; it is printed on the sheet
    #[arg(long, value_name = "N", value_parser = args::seed, default_value_t = Furnace::default().seed, allow_hyphen_values = true)]
    seed: u64,
    /// Samples of each estimate, 1 to 1 000 000 000
    #[arg(long, value_name = "N", value_parser = args::draws, default_value_t = Furnace::default().samples, allow_hyphen_values = true)]
    samples: u64,
    /// Write the sheets as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(super) fn run(typed: FurnaceArgs, out: &mut dyn Write, terminal: bool) -> anyhow::Result<Status> {
    let FurnaceArgs { subjects, level, seed, samples, json } = typed;
    let mut models = Vec::new();
    for text in &subjects {
        models.extend(subjects::load(text)?);
    }
    let json = json.map(|path| sink("--json", path)).transpose()?;
    let furnace = Furnace { seed, level, samples, only: Vec::new() };
    let sheets = if subjects.is_empty() { of_the_path_tracer(&furnace) } else { of_models(&furnace, models) };
    if !matches!(json, Some(Sink::Stdout)) {
        let style = if terminal && colour_is_welcome() { Style::Colour } else { Style::Plain };
        let shown = sheets.iter().map(|(name, sheet)| text::named_sheet(name, sheet, style));
        print(out, &shown.collect::<Vec<_>>().join("\n"))?;
    }
    let report = || json::named_sheets(sheets.iter().map(|(name, sheet)| (name.as_str(), sheet)), seed, level);
    match &json {
        Some(Sink::Stdout) => print(out, &report())?,
        Some(Sink::File(target)) => target.write(report().as_bytes()).context("--json: cannot be written")?,
        None => {}
    }
    let any = |outcome| sheets.iter().any(|(_, sheet)| sheet.outcome() == outcome);
    Ok(if any(Outcome::Fail) {
        Status::Fail
    } else if any(Outcome::Inconclusive) {
        Status::Inconclusive
    } else {
        Status::Pass
    })
}

fn of_the_path_tracer(furnace: &Furnace) -> Vec<(String, Sheet)> {
    let bar = progress_bar(ENGINE_CHECKS.len(), "checks");
    let sheet = furnace.path_tracer_reporting(&|settings| Box::new(settings), &|_| bar.inc(1));
    bar.finish_and_clear();
    vec![(sheet.subject.clone(), sheet)]
}

fn of_models(furnace: &Furnace, subjects: Vec<Subject>) -> Vec<(String, Sheet)> {
    let bar = progress_bar(subjects.len(), "subjects");
    let (names, models): (Vec<String>, Vec<Arc<dyn Bsdf>>) =
        subjects.into_iter().map(|subject| (subject.name, Arc::from(subject.bsdf))).unzip();
    let sheets = furnace.subjects_reporting(&models, &|_| bar.inc(1));
    bar.finish_and_clear();
    names.into_iter().zip(sheets).collect()
}
