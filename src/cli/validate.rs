//! `whitefurnace validate`: the sheet of checks, on the terminal, as JSON and as HTML.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::mpsc;
use std::thread;

use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;

use super::job::{Sink, Validate};
use super::subjects::Subject;
use super::{Status, ignore_closed_pipe};
use crate::report::text::{self, Style};
use crate::report::{Judged, html, json};
use crate::validate::{CHECKS, Outcome, Suite};

pub(super) fn run(job: Validate, out: &mut dyn Write, terminal: bool) -> anyhow::Result<Status> {
    let style = if terminal && colour_is_welcome() { Style::Colour } else { Style::Plain };
    // Standard output carries either the sheets for reading or the JSON, never both.
    let readable = !matches!(job.json, Some(Sink::Stdout));
    let many = job.subjects.len() > 1;
    let bar = progress_bar(job.subjects.len() * checks_per_sheet(&job.suite.only), "checks");
    let judged = judge(job.subjects, &job.suite, &bar, |one| {
        let shown = if many { text::brief(one, style) } else { text::sheet(one, style) };
        if readable { bar.suspend(|| print(out, &shown)) } else { Ok(()) }
    })?;
    bar.finish_and_clear();
    if readable && many {
        print(out, &text::summary(&judged, style))?;
    }
    match &job.json {
        Some(Sink::Stdout) => print(out, &json::sheets(&judged, job.suite.seed, job.suite.level))?,
        Some(Sink::File(target)) => {
            let written = target.write(json::sheets(&judged, job.suite.seed, job.suite.level).as_bytes());
            written.context("--json: cannot be written")?;
        }
        None => {}
    }
    if let Some(target) = &job.html {
        let written = target.write(html::page(&judged, job.suite.seed, job.suite.level).as_bytes());
        written.context("--html: cannot be written")?;
    }
    Ok(status(&judged))
}

/// Judges all subjects, as many at a time as there are threads, and shows each as soon as all before it are shown.
///
/// A sheet depends on its subject and the seed alone, so neither the verdicts nor their order depend on the threads.
fn judge(
    subjects: Vec<Subject>,
    suite: &Suite,
    bar: &ProgressBar,
    mut show: impl FnMut(&Judged) -> anyhow::Result<()>,
) -> anyhow::Result<Vec<Judged>> {
    let one = |subject: Subject| {
        bar.set_message(subject.name.clone());
        let mut sheet = suite.run_reporting(&subject.bsdf, &|_| bar.inc(1));
        sheet.subject.clone_from(&subject.name);
        Judged { name: subject.name, bsdf: subject.bsdf, sheet }
    };
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        scope.spawn(move || {
            // Where the receiver has gone, an error has ended the run.
            subjects
                .into_par_iter()
                .enumerate()
                .for_each_with(sender, |to, (at, subject)| drop(to.send((at, one(subject)))));
        });
        let (mut judged, mut waiting) = (Vec::new(), BTreeMap::new());
        for (at, ready) in receiver {
            waiting.insert(at, ready);
            while let Some(next) = waiting.remove(&judged.len()) {
                show(&next)?;
                judged.push(next);
            }
        }
        Ok(judged)
    })
}

/// Fail where any sheet fails, else inconclusive where any is.
fn status(judged: &[Judged]) -> Status {
    let any = |outcome| judged.iter().any(|j| j.sheet.outcome() == outcome);
    if any(Outcome::Fail) {
        Status::Fail
    } else if any(Outcome::Inconclusive) {
        Status::Inconclusive
    } else {
        Status::Pass
    }
}

/// A reader who goes away changes neither the verdict nor the files: `validate … | head` still judges.
pub(super) fn print(out: &mut dyn Write, text: &str) -> anyhow::Result<()> {
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    Ok(ignore_closed_pipe(written)?)
}

/// See no-color.org: any value but the empty one turns colour off.
pub(super) fn colour_is_welcome() -> bool {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    set("NO_COLOR").is_none() && set("TERM").is_none_or(|term| term != "dumb")
}

fn checks_per_sheet(only: &[&str]) -> usize {
    CHECKS.iter().filter(|(name, _)| only.is_empty() || only.contains(name)).count()
}

/// A bar on standard error, which draws nothing where that is not a terminal.
pub(super) fn progress_bar(steps: usize, unit: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
    match ProgressStyle::with_template(&format!("{{bar:30}} {{pos}}/{{len}} {unit}, {{elapsed}}  {{wide_msg}}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
