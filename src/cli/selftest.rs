//! `whitefurnace selftest`: every broken twin, model or path tracer, must be rejected for the right reason, and no correct
//! original.

use std::io::Write;

use rayon::prelude::*;

use super::Status;
use super::validate::progress_bar;
use crate::render::furnace::{Furnace, broken};
use crate::report::table::{Align, Table};
use crate::validate::broken::{Twin, twins};
use crate::validate::{Outcome, Sheet, Suite};

/// Of each estimate: these mistakes are large.
const FURNACE_SAMPLES: u64 = 4096;

/// How one twin and its original fared.
struct Trial {
    name: &'static str,
    why: &'static str,
    caught_by: &'static [&'static str],
    rejected_by: Vec<&'static str>,
    original_fails: Vec<&'static str>,
}

/// A twin of the sheet of a model, or of the furnace tests of a path tracer.
#[derive(Clone, Copy)]
enum Any {
    Model(&'static Twin),
    Furnace(&'static broken::Twin),
}

impl Trial {
    fn of(twin: Any) -> Self {
        let fails = |sheet: Sheet| -> Vec<&'static str> {
            let failed = sheet.checks.into_iter().filter(|check| check.outcome == Outcome::Fail);
            failed.map(|check| check.name).collect()
        };
        match twin {
            Any::Model(&Twin { name, why, caught_by, original, broken }) => {
                let suite = Suite::default();
                let (rejected_by, original_fails) = (fails(suite.run(&broken())), fails(suite.run(&original())));
                Self { name, why, caught_by, rejected_by, original_fails }
            }
            Any::Furnace(twin) => {
                let furnace = Furnace { samples: FURNACE_SAMPLES, ..Furnace::default() };
                let (rejected_by, original_fails) = (fails(twin.broken(&furnace)), fails(twin.original(&furnace)));
                let &broken::Twin { name, why, caught_by, .. } = twin;
                Self { name, why, caught_by, rejected_by, original_fails }
            }
        }
    }

    /// Rejected by a check that is named for this defect.
    fn caught(&self) -> bool {
        self.caught_by.iter().any(|name| self.rejected_by.contains(name))
    }

    fn verdict(&self) -> String {
        match (self.caught(), self.original_fails.is_empty()) {
            (true, true) => "ok".into(),
            (false, _) => "NOT CAUGHT".into(),
            (_, false) => format!("ORIGINAL FAILS {}", self.original_fails.join(" ")),
        }
    }
}

pub(super) fn run(out: &mut dyn Write) -> anyhow::Result<Status> {
    let all: Vec<Any> = twins().into_iter().map(Any::Model).chain(broken::twins().iter().map(Any::Furnace)).collect();
    // Each trial has its own seeds, and `collect` keeps the order: the table does not depend on the threads.
    let bar = progress_bar(all.len(), "twins");
    let trials: Vec<Trial> = all.into_par_iter().map(Trial::of).inspect(|_| bar.inc(1)).collect();
    bar.finish_and_clear();
    let mut table = Table::new(&["broken twin", "rejected by", "expected", "verdict"].map(|head| (head, Align::Left)));
    for trial in &trials {
        let rejected = if trial.rejected_by.is_empty() { "-".into() } else { trial.rejected_by.join(" ") };
        table.row([trial.name.into(), rejected, trial.caught_by.join("|"), trial.verdict()]);
    }
    write!(out, "{}", table.text(""))?;
    let good = trials.iter().filter(|trial| trial.caught() && trial.original_fails.is_empty()).count();
    writeln!(out, "\n{good} of {} twins are rejected for the right reason while their originals pass", trials.len())?;
    for trial in trials.iter().filter(|trial| !trial.caught()) {
        writeln!(out, "not caught: {}: {}", trial.name, trial.why)?;
    }
    Ok(if good == trials.len() && good > 0 { Status::Pass } else { Status::Fail })
}
