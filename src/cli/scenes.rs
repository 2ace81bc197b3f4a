//! `whitefurnace scenes`: every built-in scene with its parameters, and what is known about it.

use std::io::Write;

use serde::Serialize;

use super::Status;
use crate::bsdf::subject::ParamSpec;
use crate::report::table::{Align, Table};
use crate::scene::builtin::{self, Builtin};

/// What `scenes` takes.
#[derive(Debug, clap::Args)]
pub(super) struct ScenesArgs {
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct List {
    schema: u32,
    version: &'static str,
    scenes: Vec<Scene>,
}

#[derive(Serialize)]
struct Scene {
    name: &'static str,
    summary: &'static str,
    params: Vec<Param>,
    closed_form: Option<&'static str>,
}

#[derive(Serialize)]
struct Param {
    name: &'static str,
    allowed: String,
    meaning: &'static str,
    default: Option<&'static str>,
}

pub(super) fn run(args: &ScenesArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    if args.json { json(out) } else { text(out) }?;
    Ok(Status::Pass)
}

fn json(out: &mut dyn Write) -> anyhow::Result<()> {
    let scenes = builtin::list().iter().map(|&Builtin { name, summary, params, closed_form, .. }| Scene {
        name,
        summary,
        params: params.iter().map(param).collect(),
        closed_form,
    });
    let list = List { schema: 1, version: env!("CARGO_PKG_VERSION"), scenes: scenes.collect() };
    writeln!(out, "{}", serde_json::to_string_pretty(&list)?)?;
    Ok(())
}

fn param(spec: &ParamSpec) -> Param {
    Param { name: spec.name, allowed: spec.domain.to_string(), meaning: spec.doc, default: spec.default }
}

fn text(out: &mut dyn Write) -> anyhow::Result<()> {
    writeln!(out, "Built-in scenes (a SCENE is one of these names or a file; --param name=value)")?;
    for scene in builtin::list() {
        writeln!(out, "\n{}: {}", scene.name, scene.summary)?;
        let mut params = Table::new(&[("", Align::Left); 4]);
        for spec in scene.params {
            let default = spec.default.map_or_else(|| "required".into(), |value| format!("default {value}"));
            params.row([spec.name.into(), spec.domain.to_string(), default, spec.doc.into()]);
        }
        write!(out, "{}", params.text("    "))?;
        if let Some(closed_form) = scene.closed_form {
            writeln!(out, "    exact: {closed_form}")?;
        }
    }
    Ok(())
}
