//! The files of a study, all in one folder.
//!
//! convergence.json is of schema 1:
//!
//! ```text
//! {"schema": 1, "target", "exact", "error", "seed", "replicates",
//!  "image": null or {"width", "height", "settings", "reference", "reference_error"},
//!  "studies": [{"estimator", "sampler", "slope", "slope_half_width", "confidence", "theory": [steepest, flattest], "verdict",
//!               "sigma", "sigma_exact", "excess_kurtosis", "seconds_per_sample", "efficiency",
//!               "bias", "bias_z", "nonfinite",
//!               "points": [{"n", "rmse", "log_std_err", "mean", "std_err", "floor", "floor_std_err"}]}]}
//! ```
//! What is not known is null. Of an image, `exact` is the mean of the reference and `rmse` is without the floor, which is a mean
//! square; `bias_z` is of squares relative to the brightness of pixels: see [`Floor`](crate::converge::image::Floor).

use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::Serialize;

use super::rows::{Row, Subject, verdict};
use crate::cli::job;
use crate::converge::study::CONFIDENCE;
use crate::report::plot::{Curve, convergence};
use crate::report::save::Target;
use crate::report::table::{Align, Table, exact};

#[derive(Debug)]
pub(super) struct Files {
    csv: Target,
    json: Target,
    svg: Target,
    png: Target,
}

#[derive(Serialize)]
struct Report<'a> {
    schema: u32,
    target: &'a str,
    exact: f64,
    error: f64,
    seed: u64,
    replicates: u64,
    image: Option<ImageEntry<'a>>,
    studies: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct ImageEntry<'a> {
    width: usize,
    height: usize,
    settings: &'a str,
    reference: Option<&'a str>,
    reference_error: Option<f64>,
}

#[derive(Serialize)]
struct Entry<'a> {
    estimator: &'a str,
    sampler: &'a str,
    slope: Option<f64>,
    slope_half_width: Option<f64>,
    confidence: f64,
    theory: [f64; 2],
    verdict: &'static str,
    sigma: f64,
    sigma_exact: Option<f64>,
    excess_kurtosis: f64,
    seconds_per_sample: f64,
    efficiency: f64,
    bias: Option<&'static str>,
    bias_z: Option<f64>,
    nonfinite: u64,
    points: Vec<Measured>,
}

#[derive(Serialize)]
struct Measured {
    n: u64,
    rmse: f64,
    log_std_err: f64,
    mean: f64,
    std_err: f64,
    floor: Option<f64>,
    floor_std_err: Option<f64>,
}

impl Files {
    pub(super) fn new(folder: &Path) -> anyhow::Result<Self> {
        let shown = folder.display();
        fs::create_dir_all(folder).with_context(|| format!("--out {shown}: cannot be made"))?;
        let file = |name: &str| job::target("--out", folder.join(name));
        Ok(Self {
            csv: file("convergence.csv")?,
            json: file("convergence.json")?,
            svg: file("convergence.svg")?,
            png: file("convergence.png")?,
        })
    }

    pub(super) fn write(&self, subject: &Subject, rows: &[Row]) -> anyhow::Result<()> {
        let image = subject.image.as_ref().map(|image| ImageEntry {
            width: image.width,
            height: image.height,
            settings: &image.how,
            reference: image.reference.as_ref().map(|(name, _)| name.as_str()),
            reference_error: image.reference.as_ref().and_then(|(_, error)| *error),
        });
        let report = Report {
            schema: 1,
            target: &subject.name,
            exact: subject.exact,
            error: subject.error,
            seed: subject.seed,
            replicates: subject.replicates,
            image,
            studies: rows.iter().map(entry).collect(),
        };
        let json = serde_json::to_string_pretty(&report)? + "\n";
        self.json.write(json.as_bytes()).context("--out: cannot be written")?;
        self.csv.write(csv(rows).as_bytes()).context("--out: cannot be written")?;
        let one_sampler = rows.iter().all(|row| row.sampler == rows[0].sampler);
        let curves: Vec<Curve> = rows.iter().map(|row| curve(row, !one_sampler)).collect();
        let figure = convergence(&curves);
        self.svg.write(figure.svg()?.as_bytes()).context("--out: cannot be written")?;
        self.png.write(&figure.png()?).context("--out: cannot be written")
    }
}

fn entry(row: &Row) -> Entry<'_> {
    let measured = |p: &super::rows::Point| Measured {
        n: p.n,
        rmse: p.rmse,
        log_std_err: p.log_std_err,
        mean: p.mean,
        std_err: p.std_err,
        floor: p.floor.map(|floor| floor.value),
        floor_std_err: p.floor.map(|floor| floor.std_err),
    };
    Entry {
        estimator: &row.estimator,
        sampler: row.sampler.name(),
        slope: row.fit.map(|fit| fit.slope),
        slope_half_width: row.fit.map(|fit| fit.half_width(CONFIDENCE)),
        confidence: CONFIDENCE,
        theory: [row.theory.steepest, row.theory.flattest],
        verdict: verdict(&row.verdict),
        sigma: row.sigma,
        sigma_exact: row.sigma_exact,
        excess_kurtosis: row.excess_kurtosis,
        seconds_per_sample: row.seconds,
        efficiency: row.efficiency,
        bias: row.bias.map(|bias| bias.verdict()),
        bias_z: row.bias.and_then(|bias| bias.floor.z),
        nonfinite: row.nonfinite,
        points: row.points.iter().map(measured).collect(),
    }
}

fn csv(rows: &[Row]) -> String {
    let heads = ["estimator", "sampler", "n", "rmse", "log_std_err", "mean", "std_err", "floor", "floor_std_err"];
    let mut table = Table::new(&heads.map(|name| (name, Align::Right)));
    for row in rows {
        for p in &row.points {
            table.row([
                row.estimator.clone(),
                row.sampler.name().into(),
                p.n.to_string(),
                exact(p.rmse),
                exact(p.log_std_err),
                exact(p.mean),
                exact(p.std_err),
                p.floor.map_or_else(String::new, |floor| exact(floor.value)),
                p.floor.map_or_else(String::new, |floor| exact(floor.std_err)),
            ]);
        }
    }
    table.csv()
}

fn curve(row: &Row, name_sampler: bool) -> Curve {
    Curve {
        name: if name_sampler { format!("{}, {}", row.estimator, row.sampler.name()) } else { row.estimator.clone() },
        points: row.points.iter().map(|p| (p.n as f64, p.rmse, p.log_std_err)).collect(),
        sigma: row.line(),
        theory: [row.theory.steepest, row.theory.flattest],
    }
}
