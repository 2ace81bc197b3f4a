//! `whitefurnace selftest`: the sheet must reject every broken twin, for the right reason, and no correct original.

use std::io::Write;

use rayon::prelude::*;

use super::Status;
use super::validate::progress_bar;
use crate::report::table::{Align, Table};
use crate::validate::broken::{Twin, twins};
use crate::validate::{Outcome, Sheet, Suite};

/// How one twin and its original fared.
struct Trial {
    twin: &'static Twin,
    rejected_by: Vec<&'static str>,
    original_fails: Vec<&'static str>,
}

impl Trial {
    fn of(twin: &'static Twin) -> Self {
        let fails = |sheet: Sheet| {
            let failed = sheet.checks.into_iter().filter(|check| check.outcome == Outcome::Fail);
            failed.map(|check| check.name).collect()
        };
        let suite = Suite::default();
        Self {
            twin,
            rejected_by: fails(suite.run(&(twin.broken)())),
            original_fails: fails(suite.run(&(twin.original)())),
        }
    }

    /// Rejected by a check that is named for this defect.
    fn caught(&self) -> bool {
        self.twin.caught_by.iter().any(|name| self.rejected_by.contains(name))
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
    // Each trial has its own seeds, and `collect` keeps the order: the table does not depend on the threads.
    let bar = progress_bar(twins().len(), "twins");
    let trials: Vec<Trial> = twins().into_par_iter().map(Trial::of).inspect(|_| bar.inc(1)).collect();
    bar.finish_and_clear();
    let mut table = Table::new(&["broken twin", "rejected by", "expected", "verdict"].map(|head| (head, Align::Left)));
    for trial in &trials {
        let rejected = if trial.rejected_by.is_empty() { "-".into() } else { trial.rejected_by.join(" ") };
        let expected = trial.twin.caught_by.join("|");
        table.row([trial.twin.name.into(), rejected, expected, trial.verdict()]);
    }
    write!(out, "{}", table.text(""))?;
    let good = trials.iter().filter(|trial| trial.caught() && trial.original_fails.is_empty()).count();
    writeln!(out, "\n{good} of {} twins are rejected for the right reason while their originals pass", trials.len())?;
    for trial in trials.iter().filter(|trial| !trial.caught()) {
        writeln!(out, "not caught: {}: {}", trial.twin.name, trial.twin.why)?;
    }
    Ok(if good == trials.len() && good > 0 { Status::Pass } else { Status::Fail })
}
