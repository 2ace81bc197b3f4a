//! A solved scene as text and as JSON.

use std::fmt::Write;

use serde::Serialize;

use crate::math::color::Rgb;
use crate::render::radiosity::factors::Report;
use crate::render::radiosity::factors::enforce::Repair;
use crate::render::radiosity::model::SolvedScene;
use crate::render::radiosity::solve::Method;
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
    view_factors: &'a Report,
    repair: Option<Repair>,
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

pub(super) fn json(solved: &SolvedScene, method: Method, per_patch: bool) -> anyhow::Result<String> {
    let energy = solved.energy();
    let surfaces = solved.surfaces().into_iter().map(|surface| Surface {
        name: surface.name,
        area: surface.area,
        B: surface.radiosity.to_array(),
        H: surface.irradiance.to_array(),
    });
    let [patches, view_factors, solve] = solved.seconds;
    let document = Document {
        schema: 1,
        method: method.name(),
        patches: solved.patches.all().len(),
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
        residual: solved.solved.residual,
        certified_bound: solved.solved.certified_bound,
        converged: solved.solved.converged,
        iterations: solved.solved.iterations,
        history: &solved.solved.history,
        seconds: Seconds { patches, view_factors, solve },
        view_factors: &solved.report,
        repair: solved.repair,
        per_patch: per_patch.then(|| patches_of(solved)),
    };
    Ok(serde_json::to_string_pretty(&document)?)
}

fn patches_of(solved: &SolvedScene) -> Vec<Patch<'_>> {
    let all = solved.patches.all().iter().zip(&solved.solved.radiosity).zip(&solved.irradiance);
    all.map(|((patch, b), h)| Patch {
        surface: &solved.patches.shapes()[patch.shape],
        area: patch.area,
        centre: patch.form.centre().to_array(),
        reflectance: patch.reflectance.to_array(),
        E: patch.emission.to_array(),
        B: b.to_array(),
        H: h.to_array(),
    })
    .collect()
}

pub(super) fn text(solved: &SolvedScene, method: Method, bounces: Option<u32>) -> String {
    let right = |head| (head, Align::Right);
    let heads = [("surface", Align::Left), right("area"), right("B (r g b)"), right("H (r g b)")];
    let mut table = Table::new(&heads);
    let three = |rgb: Rgb| rgb.to_array().map(|x| format!("{x:.6}")).join(" ");
    for surface in solved.surfaces() {
        table.row([surface.name, format!("{:.6}", surface.area), three(surface.radiosity), three(surface.irradiance)]);
    }
    let mut text = table.text("");
    let energy = solved.energy();
    let [emitted, absorbed, escaped] = [energy.emitted, energy.absorbed, energy.escaped].map(Rgb::mean);
    if emitted == 0.0 {
        text.push_str("nothing emits: every radiosity is 0\n");
    }
    let share = |part: f64| if emitted > 0.0 { 100.0 * part / emitted } else { 0.0 };
    let report = &solved.report;
    let out = &mut text;
    let _ = writeln!(
        out,
        "emitted {emitted:.6}, absorbed {absorbed:.6} ({:.3} %), escaped {escaped:.6} ({:.3} %), missing {:.1e}",
        share(absorbed),
        share(escaped),
        emitted - absorbed - escaped
    );
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
    if let Some(Repair { rms, max, left }) = solved.repair {
        let _ = writeln!(
            out,
            "enforced: factors changed by {rms:.1e} (rms, relative), at most by {max:.1e}; left {left:.1e}"
        );
    }
    let state = match (bounces, solved.solved.converged) {
        (Some(r), _) => format!("{r} reflections"),
        (None, true) => format!("{} iterations", solved.solved.iterations),
        (None, false) => format!("{} iterations, NOT converged", solved.solved.iterations),
    };
    let [cut, factors, solve] = solved.seconds;
    let _ = writeln!(
        out,
        "{method}: {state}, residual {:.1e}, certified to {:.1e}; {cut:.2} s patches, {factors:.2} s view factors, {solve:.2} s",
        solved.solved.residual, solved.solved.certified_bound
    );
    text
}
