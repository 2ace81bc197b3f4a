//! The curves in the files that `converge --out` writes.

use std::fs;
use std::path::Path;

use anyhow::{Context, anyhow, bail};
use serde::Deserialize;

use crate::report::plot::Curve;

#[derive(Deserialize)]
struct Report {
    studies: Vec<Study>,
}

#[derive(Deserialize)]
struct Study {
    estimator: String,
    sampler: String,
    /// From the steepest, null where there is none, to the flattest.
    theory: [Option<f64>; 2],
    #[serde(default)]
    sigma_exact: Option<f64>,
    points: Vec<Point>,
}

#[derive(Deserialize)]
struct Point {
    n: f64,
    rmse: Option<f64>,
    log_std_err: Option<f64>,
}

pub(super) fn read(file: &Path) -> anyhow::Result<Vec<Curve>> {
    let shown = file.display();
    let text = fs::read_to_string(file).map_err(|error| anyhow!("{shown}: cannot be read: {error}"))?;
    let is_csv = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let studies = if is_csv { from_csv(&text) } else { from_json(&text) }.with_context(|| shown.to_string())?;
    if studies.is_empty() {
        bail!("{shown}: holds no study");
    }
    let several = studies.iter().any(|study| study.sampler != studies[0].sampler);
    Ok(studies.into_iter().map(|study| curve(study, several)).collect())
}

fn from_json(text: &str) -> anyhow::Result<Vec<Study>> {
    let report: Report = serde_json::from_str(text).context("is no JSON of converge")?;
    Ok(report.studies)
}

/// Rows of one estimator with one sampler follow each other. The table holds no theory.
fn from_csv(text: &str) -> anyhow::Result<Vec<Study>> {
    const COLUMNS: [&str; 5] = ["estimator", "sampler", "n", "rmse", "log_std_err"];
    let mut lines = text.lines().enumerate();
    let heads: Vec<&str> = lines.next().map_or(Vec::new(), |(_, line)| line.split(',').collect());
    let column = |name: &str| heads.iter().position(|head| *head == name);
    let found: Vec<usize> = COLUMNS.iter().filter_map(|name| column(name)).collect();
    if found.len() < COLUMNS.len() {
        bail!("is no table of converge; allowed is one with the columns {}", COLUMNS.join(", "));
    }
    let mut studies: Vec<Study> = Vec::new();
    for (at, line) in lines.filter(|(_, line)| !line.is_empty()) {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |i: usize| cells.get(found[i]).copied().unwrap_or_default();
        let number =
            |i: usize| cell(i).parse::<f64>().with_context(|| format!("line {}: {} is no number", at + 1, COLUMNS[i]));
        let point = Point { n: number(2)?, rmse: Some(number(3)?), log_std_err: Some(number(4)?) };
        match studies.last_mut().filter(|study| study.estimator == cell(0) && study.sampler == cell(1)) {
            Some(study) => study.points.push(point),
            None => studies.push(Study {
                estimator: cell(0).into(),
                sampler: cell(1).into(),
                theory: [Some(0.0); 2],
                sigma_exact: None,
                points: vec![point],
            }),
        }
    }
    Ok(studies)
}

fn curve(study: Study, name_sampler: bool) -> Curve {
    let points = study.points.iter().filter_map(|p| Some((p.n, p.rmse?, p.log_std_err.unwrap_or(0.0))));
    Curve {
        points: points.collect(),
        // σ/√N is the error of independent points alone.
        sigma: study.sigma_exact.filter(|_| study.sampler == "independent"),
        theory: [study.theory[0].unwrap_or(f64::NEG_INFINITY), study.theory[1].unwrap_or(0.0)],
        name: if name_sampler { format!("{}, {}", study.estimator, study.sampler) } else { study.estimator },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_files_give_the_same_points() {
        let json = r#"{"schema": 1, "studies": [{"estimator": "area", "sampler": "sobol", "theory": [null, -0.5],
            "sigma_exact": 0.1, "points": [{"n": 4, "rmse": 0.5, "log_std_err": 0.1, "mean": 1.0, "std_err": 0.1}]}]}"#;
        let table = "estimator,sampler,n,rmse,log_std_err,mean,std_err\narea,sobol,4,0.5,0.1,1,0.1\n";
        let [json, table] =
            [from_json(json).unwrap(), from_csv(table).unwrap()].map(|mut all| curve(all.remove(0), true));
        assert_eq!(json.points, table.points);
        assert_eq!((json.name.as_str(), json.sigma, json.theory), ("area, sobol", None, [f64::NEG_INFINITY, -0.5]));
        assert!(
            from_csv("a,b\n1,2\n").is_err() && from_csv("estimator,sampler,n,rmse,log_std_err\na,b,x,1,1\n").is_err()
        );
        assert!(from_json("{}").is_err());
    }
}
