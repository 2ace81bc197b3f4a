//! `whitefurnace view-factors`: the view factors of a scene, and what is known of their error.

use std::io::Write;

use anyhow::Context;
use serde::Serialize;

use super::ViewFactorsArgs;
use crate::cli::{Status, progress};
use crate::render::radiosity::factors::enforce::Repair;
use crate::render::radiosity::factors::{self, Report};
use crate::render::radiosity::matrix::FactorMatrix;
use crate::render::radiosity::patches::Patches;
use crate::report::table::{Align, Table};

/// Number of patches where nothing is said: few enough for their rows to be read.
const DEFAULT_PATCHES: usize = 100;

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    report: &'a Report,
    repair: Option<Repair>,
    patches: Vec<Patch<'a>>,
    row_sums: &'a [f64],
    rows: Vec<&'a [f64]>,
}

#[derive(Serialize)]
struct Patch<'a> {
    surface: &'a str,
    area: f64,
    centre: [f64; 3],
}

pub(in crate::cli) fn run(args: &ViewFactorsArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    let scene = args.scene.open(None, false)?;
    let patches = Patches::new(&scene, args.mesh.fineness(DEFAULT_PATCHES), args.mesh.materials())
        .with_context(|| args.scene.typed().to_string())?;
    let method = args.factors.method(args.method);
    let clock = progress::clock(false, format!("view factors by {}", method.name()));
    let (matrix, report, repair) =
        factors::find(&*method, &scene, &patches, args.factors.enforce(), args.factors.memory())?;
    clock.finish_and_clear();
    let sums = matrix.row_sums();
    let name = |i: usize| patches.shapes()[patches.all()[i].shape].as_str();
    if args.json {
        let listed = patches.all().iter().enumerate();
        let document = Document {
            schema: 1,
            report: &report,
            repair,
            patches: listed
                .map(|(i, patch)| Patch { surface: name(i), area: patch.area, centre: patch.form.centre().to_array() })
                .collect(),
            row_sums: &sums,
            rows: (0..matrix.n()).map(|i| matrix.row(i)).collect(),
        };
        writeln!(out, "{}", serde_json::to_string(&document)?)?;
    } else if args.csv {
        writeln!(out, "from,to,from_surface,to_surface,from_area,F")?;
        for i in 0..matrix.n() {
            for (j, factor) in matrix.row(i).iter().enumerate().filter(|(_, factor)| **factor > 0.0) {
                writeln!(out, "{i},{j},{},{},{:e},{factor:e}", name(i), name(j), patches.all()[i].area)?;
            }
        }
    } else {
        write!(out, "{}", by_surface(&patches, &matrix))?;
        summary(out, &report, repair)?;
    }
    Ok(Status::Pass)
}

/// View factors between whole surfaces: the sums over their patches, means by area.
fn by_surface(patches: &Patches, matrix: &FactorMatrix) -> String {
    let shapes = patches.shapes();
    let mut areas = vec![0.0; shapes.len()];
    let mut exchanges = vec![vec![0.0; shapes.len()]; shapes.len()];
    for (i, patch) in patches.all().iter().enumerate() {
        areas[patch.shape] += patch.area;
        for (j, factor) in matrix.row(i).iter().enumerate() {
            exchanges[patch.shape][patches.all()[j].shape] += patch.area * factor;
        }
    }
    let mut table = Table::new(&[("from", Align::Left), ("to", Align::Left), ("F", Align::Right)]);
    for (i, from) in shapes.iter().enumerate().filter(|(i, _)| areas[*i] > 0.0) {
        let row = |exchange: f64| format!("{:.9}", exchange / areas[i]);
        for (j, to) in shapes.iter().enumerate().filter(|(j, _)| exchanges[i][*j] > 0.0) {
            table.row([from.clone(), to.clone(), row(exchanges[i][j])]);
        }
        table.row([from.clone(), "(all)".into(), row(exchanges[i].iter().sum())]);
    }
    table.text("")
}

fn summary(out: &mut dyn Write, report: &Report, repair: Option<Repair>) -> anyhow::Result<()> {
    let Report { method, patches, occlusion, row_sums, escape, reciprocity_rms, reciprocity_max, .. } = report;
    writeln!(out, "\n{patches} patches by {method}, {:.3} s, {} rays", report.seconds, report.rays)?;
    if !occlusion {
        writeln!(out, "what is in between is ignored")?;
    }
    writeln!(out, "row sums {:.9} to {:.9}, mean {:.9}", row_sums.min, row_sums.max, row_sums.mean)?;
    writeln!(out, "escape {escape:.9}: the share that reaches no patch")?;
    writeln!(
        out,
        "reciprocity: A_i F_ij and A_j F_ji differ by {reciprocity_rms:.2e} (rms, relative), {reciprocity_max:.2e} at most"
    )?;
    if report.error_rms.is_finite() {
        writeln!(out, "error of a factor {:.2e} (rms), {:.2e} in the worst row", report.error_rms, report.error_max)?;
    } else {
        writeln!(out, "error of a factor: unknown, a single point cannot judge itself")?;
    }
    if let Some(Repair { rms, max, left }) = repair {
        writeln!(out, "enforced: changed by {rms:.2e} (rms, relative), {max:.2e} at most; left to do {left:.2e}")?;
    }
    Ok(())
}
