//! `whitefurnace albedo`: directional albedo with an error bound for each value.
//!
//! A row that does not meet the tolerance is marked in every format, and the exit status is then 3.

use std::io::Write;

use rayon::prelude::*;
use serde::Serialize;

use super::Status;
use super::args::AlbedoFormat;
use super::job::Albedo;
use crate::integrate::{Integral, Side};
use crate::math::sphere::direction_mu;
use crate::report::table::{Align, Table, exact};

/// The JSON of `albedo`. `average` is null unless it was asked for.
#[derive(Serialize)]
struct Report<'a> {
    schema: u32,
    subject: &'a str,
    side: &'static str,
    rows: Vec<Row>,
    average: Option<[f64; 3]>,
    average_error: Option<f64>,
    average_resolved: Option<bool>,
}

#[derive(Serialize)]
struct Row {
    mu: f64,
    phi_deg: f64,
    albedo: [f64; 3],
    error: f64,
    resolved: bool,
}

pub(super) fn run(job: &Albedo, out: &mut dyn Write) -> anyhow::Result<Status> {
    let fixed: Vec<(f64, f64)> = job.mu.iter().flat_map(|&mu| job.phi_deg.iter().map(move |&phi| (mu, phi))).collect();
    let row = |&(mu, phi_deg): &(f64, f64)| {
        let w = direction_mu(mu, (phi_deg % 360.0).to_radians());
        let Integral { value, error, resolved, .. } = job.hemisphere.albedo(&job.subject.bsdf, job.side, w);
        Row { mu, phi_deg, albedo: value.to_array(), error, resolved }
    };
    let rows: Vec<Row> = fixed.par_iter().map(row).collect();
    let average = job.average.then(|| job.hemisphere.average(&job.subject.bsdf, job.side));
    let report = Report {
        schema: 1,
        subject: &job.subject.name,
        side: match job.side {
            Side::Eye => "eye",
            Side::Light => "light",
        },
        rows,
        average: average.map(|a| a.value.to_array()),
        average_error: average.map(|a| a.error),
        average_resolved: average.map(|a| a.resolved),
    };
    match job.format {
        AlbedoFormat::Json => writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?,
        AlbedoFormat::Csv => csv(&report, out)?,
        AlbedoFormat::Table => table(&report, job.hemisphere.tol, out)?,
    }
    let resolved = report.rows.iter().all(|row| row.resolved) && report.average_resolved != Some(false);
    Ok(if resolved { Status::Pass } else { Status::Inconclusive })
}

/// The average comes last, as a row whose `mu` is the word `average` and whose azimuth is empty.
fn csv(report: &Report, out: &mut dyn Write) -> anyhow::Result<()> {
    let head = ["mu", "phi_deg", "albedo_r", "albedo_g", "albedo_b", "error", "resolved"];
    let mut table = Table::new(&head.map(|name| (name, Align::Right)));
    for row in &report.rows {
        table.row(cells(row.mu.to_string(), row.phi_deg.to_string(), row.albedo, row.error, row.resolved));
    }
    if let (Some(value), Some(error), Some(resolved)) = (report.average, report.average_error, report.average_resolved)
    {
        table.row(cells("average".into(), String::new(), value, error, resolved));
    }
    write!(out, "{}", table.csv())?;
    Ok(())
}

fn cells(mu: String, phi: String, [r, g, b]: [f64; 3], error: f64, resolved: bool) -> [String; 7] {
    [mu, phi, exact(r), exact(g), exact(b), exact(error), resolved.to_string()]
}

fn table(report: &Report, tol: f64, out: &mut dyn Write) -> anyhow::Result<()> {
    writeln!(out, "{}: directional albedo, {} fixed", report.subject, report.side)?;
    let head = ["mu", "phi/deg", "red", "green", "blue", "error", ""];
    let mut table = Table::new(&head.map(|name| (name, if name.is_empty() { Align::Left } else { Align::Right })));
    let mut row = |mu: String, phi: String, albedo: [f64; 3], error: f64, resolved: bool| {
        let [r, g, b] = albedo.map(|x| format!("{x:.12}"));
        let mark = if resolved { "" } else { "UNRESOLVED" };
        table.row([mu, phi, r, g, b, format!("{error:.1e}"), mark.into()]);
    };
    for r in &report.rows {
        row(r.mu.to_string(), r.phi_deg.to_string(), r.albedo, r.error, r.resolved);
    }
    if let (Some(value), Some(error), Some(resolved)) = (report.average, report.average_error, report.average_resolved)
    {
        row("average".into(), String::new(), value, error, resolved);
    }
    write!(out, "{}", table.text(""))?;
    if report.rows.iter().any(|row| !row.resolved) || report.average_resolved == Some(false) {
        writeln!(out, "UNRESOLVED: not certified to the tolerance {tol:e}")?;
    }
    Ok(())
}
