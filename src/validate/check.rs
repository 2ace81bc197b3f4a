//! What a check returns, and a sheet of them.

use std::collections::BTreeMap;
use std::fmt;

use glam::DVec3;

/// The verdict of a check or of a whole sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing wrong was found, and [`Check::detects`] says what would have been.
    Pass,
    /// The model breaks the law that the check is named after.
    Fail,
    /// The check could not decide.
    Inconclusive,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Inconclusive => "inconclusive",
        })
    }
}

/// The result of one check.
#[derive(Clone, Debug)]
#[must_use]
pub struct Check {
    /// The law that was checked, by its name on the sheet: `reciprocity`, `energy_eye`, …
    pub name: &'static str,
    /// The verdict.
    pub outcome: Outcome,
    /// What was measured: the largest asymmetry, the supremum of the albedo, a chi-square, …
    pub statistic: f64,
    /// The p-value of a statistical check, corrected within the check.
    pub p_value: Option<f64>,
    /// What the statistic (or, for a statistical check, the p-value) is compared with.
    pub bound: f64,
    /// The worst pair of directions (wo, wi) found.
    pub worst: Option<(DVec3, DVec3)>,
    /// One sentence that says what was found.
    pub detail: String,
    /// The smallest errors that this check would have caught with 99 % probability: kind of error -> size.
    pub detects: BTreeMap<&'static str, f64>,
}

impl Check {
    /// An undecided check: its author fills in what was found.
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            name,
            outcome: Outcome::Inconclusive,
            statistic: 0.0,
            p_value: None,
            bound: 0.0,
            worst: None,
            detail: String::new(),
            detects: BTreeMap::new(),
        }
    }

    /// The same, undecided because of what happens at `wo`.
    pub(crate) fn inconclusive(self, wo: DVec3, why: &str) -> Self {
        Self { worst: Some((wo, wo)), ..self.inconclusive_here(why) }
    }

    /// The same, undecided everywhere.
    pub(crate) fn inconclusive_here(self, why: &str) -> Self {
        Self { outcome: Outcome::Inconclusive, p_value: None, detail: why.into(), ..self }
    }
}

/// All checks of one BRDF, with the settings under which they can be repeated.
#[derive(Clone, Debug)]
#[must_use]
pub struct Sheet {
    /// What was checked.
    pub subject: String,
    /// The checks that apply to it.
    pub checks: Vec<Check>,
    /// The seed of every random number behind the sheet.
    pub seed: u64,
    /// The probability that a correct model fails anywhere on the sheet.
    pub level: f64,
}

impl Sheet {
    /// Fail if any check fails; else inconclusive if any is, or if there is none; else pass.
    pub fn outcome(&self) -> Outcome {
        let any = |outcome| self.checks.iter().any(|check| check.outcome == outcome);
        if any(Outcome::Fail) {
            Outcome::Fail
        } else if any(Outcome::Inconclusive) || self.checks.is_empty() {
            Outcome::Inconclusive
        } else {
            Outcome::Pass
        }
    }

    /// The check called `name`, if it is on the sheet.
    pub fn check(&self, name: &str) -> Option<&Check> {
        self.checks.iter().find(|check| check.name == name)
    }
}
