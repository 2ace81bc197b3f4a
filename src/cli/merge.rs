//! `whitefurnace merge`: the samples of several renderings as one, exactly pooled.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};

use super::Status;
use super::job::target;
use super::validate::print;
use crate::image::{Format, Image};
use crate::render::checkpoint::Checkpoint;
use crate::render::film::Film;
use crate::render::provenance::Provenance;
use crate::report::save::Target;
use crate::report::table::{Align, Table, short};

pub(super) const HELP: &str = "\
Merged are checkpoints (exact) and EXR files of `whitefurnace render` (to the rounding of f32), told apart by content.
They must be of one scene and one setting, and no two may hold the same samples: the same seed with overlapping ranges.
The output is .exr, .pfm, .hdr, .png, or .checkpoint. A single input is allowed: it is converted.

Examples:
  whitefurnace merge night1.exr night2.exr -o both.exr
  whitefurnace merge running.checkpoint -o look.png";

#[derive(Debug, clap::Args)]
pub(super) struct MergeArgs {
    /// Checkpoints or EXR files
    #[arg(required = true, value_name = "FILE")]
    pub(super) files: Vec<PathBuf>,
    /// The merged file; may be given more than once
    #[arg(short = 'o', long = "output", required = true, value_name = "FILE")]
    pub(super) outputs: Vec<PathBuf>,
    /// Brightness of a PNG in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = super::args::stops, allow_hyphen_values = true)]
    pub(super) exposure: f64,
}

/// What a file is written as.
#[derive(Clone, Copy, Debug)]
enum Output {
    Checkpoint,
    Picture(Format),
}

/// Which files, and where their sum goes.
#[derive(Debug)]
pub(super) struct Job {
    parts: Vec<(PathBuf, Checkpoint)>,
    outputs: Vec<(Target, Output)>,
    exposure: f64,
}

pub(super) fn job(args: MergeArgs) -> anyhow::Result<Job> {
    let mut outputs = Vec::new();
    for path in args.outputs {
        let output = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("checkpoint")) {
            Output::Checkpoint
        } else {
            Output::Picture(Format::of(&path).map_err(|error| anyhow!("{error}, or .checkpoint"))?)
        };
        outputs.push((target("-o", path)?, output));
    }
    let mut parts = Vec::new();
    for path in args.files {
        let part = read(&path)?;
        parts.push((path, part));
    }
    Ok(Job { parts, outputs, exposure: args.exposure })
}

/// A checkpoint, or an EXR that holds what one holds.
fn read(path: &Path) -> anyhow::Result<Checkpoint> {
    let shown = path.display();
    let mut start = Vec::new();
    let file = File::open(path).with_context(|| format!("{shown}: cannot be read"))?;
    file.take(8).read_to_end(&mut start).with_context(|| format!("{shown}: cannot be read"))?;
    if Checkpoint::is_one(&start) {
        return Ok(Checkpoint::read(path)?);
    }
    let image = Image::read(path)?;
    let film = Film::from_image(&image).map_err(|error| anyhow!("{shown}: {error}"))?;
    let provenance = Provenance::from_metadata(image.metadata()).map_err(|error| anyhow!("{shown}: {error}"))?;
    Ok(Checkpoint { film, provenance })
}

pub(super) fn run(job: Job, out: &mut dyn Write) -> anyhow::Result<Status> {
    let head = ["", "samples", "mean", "relative error", "not finite"];
    let mut table = Table::new(&head.map(|name| (name, if name.is_empty() { Align::Left } else { Align::Right })));
    let mut row = |name: String, part: &Checkpoint| {
        let film = &part.film;
        let error = format!("{} %", short(100.0 * film.relative_error()));
        let samples = part.provenance.samples().to_string();
        table.row([name, samples, short(film.image_mean().mean()), error, film.nonfinite().to_string()]);
    };
    let mut merged: Option<(PathBuf, Checkpoint)> = None;
    let many = job.parts.len() > 1;
    for (path, part) in job.parts {
        row(path.display().to_string(), &part);
        let Some((first, whole)) = &mut merged else {
            merged = Some((path, part));
            continue;
        };
        let both = || format!("{} and {}", first.display(), path.display());
        whole.provenance.merge(&part.provenance).with_context(both)?;
        whole.film.merge(&part.film).with_context(both)?;
    }
    let Some((_, whole)) = merged else { bail!("no FILE is given") };
    if many {
        row("merged".into(), &whole);
    }
    let runs: Vec<String> = whole.provenance.runs.iter().map(ToString::to_string).collect();
    for (target, output) in &job.outputs {
        let bytes = match output {
            Output::Checkpoint => whole.encode(),
            Output::Picture(format) => {
                whole.film.to_image(&whole.provenance.metadata()).encode(*format, job.exposure)?
            }
        };
        target.write(&bytes).context("-o: cannot be written")?;
    }
    print(out, &format!("{}{}\n", table.text(""), runs.join("; ")))?;
    Ok(Status::Pass)
}
