//! The JSON of `validate` and of `furnace`, schema 1.
//!
//! ```text
//! {"schema": 1, "version", "seed", "level",
//!  "subjects": [{"subject", "verdict": "pass|fail|inconclusive",
//!                "checks": [{"name", "verdict", "statistic", "p_value", "bound", "detects": {kind: size},
//!                            "worst": {"wo": [x, y, z], "wi": [x, y, z]}, "detail"}]}]}
//! ```
//! `subjects` are in the order in which they were given. `p_value` is null for a check that is no statistical test,
//! `worst` is null where no pair of directions stands out, and a number that is NaN or infinite is null. A later
//! version may add fields; one that changes or removes a field changes `schema`.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use super::Judged;
use crate::validate::{Check, Outcome, Sheet};

#[derive(Serialize)]
struct Report<'a> {
    schema: u32,
    version: &'static str,
    seed: u64,
    level: f64,
    subjects: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    subject: &'a str,
    verdict: &'static str,
    checks: Vec<Line<'a>>,
}

#[derive(Serialize)]
struct Line<'a> {
    name: &'static str,
    verdict: &'static str,
    statistic: f64,
    p_value: Option<f64>,
    bound: f64,
    detects: &'a BTreeMap<&'static str, f64>,
    worst: Option<Pair>,
    detail: &'a str,
}

#[derive(Serialize)]
struct Pair {
    wo: [f64; 3],
    wi: [f64; 3],
}

/// All sheets of one run as JSON text, with a final line break.
pub fn sheets(judged: &[Judged], seed: u64, level: f64) -> String {
    named_sheets(judged.iter().map(|j| (j.name.as_str(), &j.sheet)), seed, level)
}

/// The same of sheets that need not be of models.
pub fn named_sheets<'a>(all: impl Iterator<Item = (&'a str, &'a Sheet)>, seed: u64, level: f64) -> String {
    let subjects = all.map(|(subject, sheet)| Entry {
        subject,
        verdict: word(sheet.outcome()),
        checks: sheet.checks.iter().map(line).collect(),
    });
    let report = Report { schema: 1, version: env!("CARGO_PKG_VERSION"), seed, level, subjects: subjects.collect() };
    // Plain data without maps of odd keys: serialising it has no way to fail.
    serde_json::to_string_pretty(&report).unwrap_or_default() + "\n"
}

fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "fail",
        Outcome::Inconclusive => "inconclusive",
    }
}

fn line(check: &Check) -> Line<'_> {
    Line {
        name: check.name,
        verdict: word(check.outcome),
        statistic: check.statistic,
        p_value: check.p_value,
        bound: check.bound,
        detects: &check.detects,
        worst: check.worst.map(|(wo, wi): (DVec3, DVec3)| Pair { wo: wo.to_array(), wi: wi.to_array() }),
        detail: &check.detail,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lambert;

    #[test]
    fn numbers_that_json_lacks_become_null() {
        let check = Check {
            name: "chi2",
            outcome: Outcome::Fail,
            statistic: f64::INFINITY,
            p_value: Some(f64::NAN),
            bound: 0.01,
            worst: Some((DVec3::Z, DVec3::X)),
            detail: "says \"why\"".into(),
            detects: [("leak", 0.001)].into(),
        };
        let sheet = Sheet { subject: "x".into(), checks: vec![check], seed: 3, level: 0.01 };
        let judged = [Judged { name: "mine".into(), bsdf: Box::new(Lambert::new(0.5).unwrap()), sheet }];
        let json: serde_json::Value = serde_json::from_str(&sheets(&judged, 3, 0.01)).unwrap();
        assert_eq!(json["schema"], 1);
        assert_eq!(json["subjects"][0]["verdict"], "fail");
        let check = &json["subjects"][0]["checks"][0];
        assert!(check["statistic"].is_null() && check["p_value"].is_null());
        assert_eq!(check["worst"]["wi"], serde_json::json!([1.0, 0.0, 0.0]));
        assert_eq!(check["detects"]["leak"], 0.001);
        assert_eq!(check["detail"], "says \"why\"");
    }
}
