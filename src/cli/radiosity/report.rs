//! A solved scene as text and as JSON.

use std::fmt::Write;

use serde::Serialize;

use super::answer::Answer;
use super::args::RadiosityArgs;
use crate::math::color::Rgb;
use crate::render::radiosity::factors::Report;
use crate::render::radiosity::factors::enforce::Repair;
use crate::render::radiosity::hierarchical::Statistics;
use crate::report::table::{Align, Table};

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    method: &'static str,
    patches: usize,
    surfaces: Vec<Surface>,
    energy: Energy,
    residual: f64,
    certified_bound: f64,
    converged: bool,
    iterations: u64,
    /// Residuals, as the solver counts them.
    history: &'a [f64],
    seconds: Seconds,
    #[serde(skip_serializing_if = "Option::is_none")]
    view_factors: Option<&'a Report>,
    repair: Option<Repair>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hierarchy: Option<&'a Statistics>,
    #[serde(skip_serializing_if = "Option::is_none")]
    per_patch: Option<Vec<Patch<'a>>>,
}

#[derive(Serialize)]
#[allow(non_snake_case, reason = "the symbols of the format")]
struct Surface {
    name: String,
    area: f64,
    B: [f64; 3],
    H: [f64; 3],
}

#[derive(Serialize)]
#[allow(non_snake_case, reason = "the symbols of the format")]
struct Patch<'a> {
    surface: &'a str,
    area: f64,
    centre: [f64; 3],
    reflectance: [f64; 3],
    E: [f64; 3],
    B: [f64; 3],
    H: [f64; 3],
}

#[derive(Serialize)]
struct Energy {
    emitted: f64,
    absorbed: f64,
    escaped: f64,
    rgb: EnergyRgb,
}

#[derive(Serialize)]
struct EnergyRgb {
    emitted: [f64; 3],
    absorbed: [f64; 3],
    escaped: [f64; 3],
}

#[derive(Serialize)]
struct Seconds {
    patches: f64,
    view_factors: f64,
    solve: f64,
}

pub(super) fn json(answer: &Answer, args: &RadiosityArgs) -> anyhow::Result<String> {
    let energy = answer.energy();
    let solved = answer.solved();
    let surfaces = answer.surfaces().into_iter().map(|surface| Surface {
        name: surface.name,
        area: surface.area,
        B: surface.radiosity.to_array(),
        H: surface.irradiance.to_array(),
    });
    let [patches, view_factors, solve] = answer.seconds();
    let (report, repair, hierarchy) = match answer {
        Answer::Matrix(found) => (Some(&found.report), found.repair, None),
        Answer::Hierarchical(found) => (None, None, Some(&found.statistics)),
    };
    let document = Document {
        schema: 1,
        method: args.solver().name(),
        patches: answer.patches().all().len(),
        surfaces: surfaces.collect(),
        energy: Energy {
            emitted: energy.emitted.mean(),
            absorbed: energy.absorbed.mean(),
            escaped: energy.escaped.mean(),
            rgb: EnergyRgb {
                emitted: energy.emitted.to_array(),
                absorbed: energy.absorbed.to_array(),
                escaped: energy.escaped.to_array(),
            },
        },
        residual: solved.residual,
        certified_bound: solved.certified_bound,
        converged: solved.converged,
        iterations: solved.iterations,
        history: &solved.history,
        seconds: Seconds { patches, view_factors, solve },
        view_factors: report,
        repair,
        hierarchy,
        per_patch: args.per_patch.then(|| patches_of(answer)),
    };
    Ok(serde_json::to_string_pretty(&document)?)
}

fn patches_of(answer: &Answer) -> Vec<Patch<'_>> {
    let patches = answer.patches();
    let all = patches.all().iter().zip(&answer.solved().radiosity).zip(answer.irradiance());
    all.map(|((patch, b), h)| Patch {
        surface: &patches.shapes()[patch.shape],
        area: patch.area,
        centre: patch.form.centre().to_array(),
        reflectance: patch.reflectance.to_array(),
        E: patch.emission.to_array(),
        B: b.to_array(),
        H: h.to_array(),
    })
    .collect()
}

pub(super) fn text(answer: &Answer, args: &RadiosityArgs) -> String {
    let right = |head| (head, Align::Right);
    let heads = [("surface", Align::Left), right("area"), right("B (r g b)"), right("H (r g b)")];
    let mut table = Table::new(&heads);
    let three = |rgb: Rgb| rgb.to_array().map(|x| format!("{x:.6}")).join(" ");
    for surface in answer.surfaces() {
        table.row([surface.name, format!("{:.6}", surface.area), three(surface.radiosity), three(surface.irradiance)]);
    }
    let mut text = table.text("");
    let energy = answer.energy();
    let [emitted, absorbed, escaped] = [energy.emitted, energy.absorbed, energy.escaped].map(Rgb::mean);
    if emitted == 0.0 {
        text.push_str("nothing emits: every radiosity is 0\n");
    }
    let share = |part: f64| if emitted > 0.0 { 100.0 * part / emitted } else { 0.0 };
    let out = &mut text;
    let _ = writeln!(
        out,
        "emitted {emitted:.6}, absorbed {absorbed:.6} ({:.3} %), escaped {escaped:.6} ({:.3} %), missing {:.1e}",
        share(absorbed),
        share(escaped),
        emitted - absorbed - escaped
    );
    match answer {
        Answer::Matrix(found) => factors(out, &found.report, found.repair),
        Answer::Hierarchical(found) => hierarchy(out, &found.statistics),
    }
    let solved = answer.solved();
    let state = match (args.bounces, solved.converged) {
        (Some(r), _) => format!("{r} reflections"),
        (None, true) => format!("{} iterations", solved.iterations),
        (None, false) => format!("{} iterations, NOT converged", solved.iterations),
    };
    let [cut, factors, solve] = answer.seconds();
    let _ = writeln!(
        out,
        "{}: {state}, residual {:.1e}, certified to {:.1e}; {cut:.2} s patches, {factors:.2} s {}, {solve:.2} s",
        args.solver().name(),
        solved.residual,
        solved.certified_bound,
        if matches!(answer, Answer::Matrix(_)) { "view factors" } else { "links" },
    );
    text
}

fn factors(out: &mut String, report: &Report, repair: Option<Repair>) {
    let _ = writeln!(
        out,
        "{} patches; view factors by {}, wrong by {:.1e} (rms){}; rows sum to {:.6} to {:.6}; reciprocal to {:.1e}",
        report.patches,
        report.method,
        report.error_rms,
        if report.occlusion { "" } else { ", WHAT IS IN BETWEEN IGNORED" },
        report.row_sums.min,
        report.row_sums.max,
        report.reciprocity_rms
    );
    if let Some(Repair { rms, max, left }) = repair {
        let _ = writeln!(
            out,
            "enforced: factors changed by {rms:.1e} (rms, relative), at most by {max:.1e}; left {left:.1e}"
        );
    }
}

fn hierarchy(out: &mut String, found: &Statistics) {
    let _ = writeln!(
        out,
        "{} patches of {} that there could be, {} links (all pairs: {}), {} rays; rows sum to {:.6} to {:.6}",
        found.leaves,
        found.finest,
        found.links,
        found.finest * found.finest,
        found.rays,
        found.row_sums[0],
        found.row_sums[1]
    );
    let reached = if found.estimated_error <= found.error { "" } else { ", NOT reached" };
    let _ = writeln!(
        out,
        "estimated error {:.3} % of {:.3} % asked for{reached}; of the size of the patches besides: {:.3} %",
        100.0 * found.estimated_error,
        100.0 * found.error,
        100.0 * found.discretisation
    );
    let levels = found.links_by_level.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    let _ = writeln!(out, "links by how often their receiver was cut: {levels}");
}
