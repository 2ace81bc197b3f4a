//! `whitefurnace list`: every model with its parameters, and every check.

use std::io::Write;

use serde::Serialize;

use super::Status;
use super::args::ListArgs;
use crate::bsdf::catalog::{self, Entry};
use crate::report::table::{Align, Table};
use crate::validate::CHECKS;

#[derive(Serialize)]
struct List {
    schema: u32,
    version: &'static str,
    models: Vec<Model>,
    checks: Vec<CheckName>,
}

#[derive(Serialize)]
struct Model {
    name: &'static str,
    summary: &'static str,
    params: Vec<Param>,
    examples: Vec<Example>,
}

#[derive(Serialize)]
struct Param {
    name: &'static str,
    allowed: String,
    meaning: &'static str,
    default: Option<&'static str>,
    required: bool,
}

#[derive(Serialize)]
struct Example {
    subject: &'static str,
    breaks: &'static [&'static str],
}

#[derive(Serialize)]
struct CheckName {
    name: &'static str,
    meaning: &'static str,
}

pub(super) fn run(args: &ListArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    if args.json { json(out) } else { text(out) }?;
    Ok(Status::Pass)
}

fn json(out: &mut dyn Write) -> anyhow::Result<()> {
    let list = List {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        models: catalog::MODELS.iter().map(model).collect(),
        checks: CHECKS.iter().map(|&(name, meaning)| CheckName { name, meaning }).collect(),
    };
    writeln!(out, "{}", serde_json::to_string_pretty(&list)?)?;
    Ok(())
}

fn model(entry: &Entry) -> Model {
    let params = entry.params.iter().map(|p| Param {
        name: p.name,
        allowed: p.domain.to_string(),
        meaning: p.doc,
        default: p.default,
        required: p.default.is_none() && !p.optional,
    });
    let examples = entry.examples.iter().map(|e| Example { subject: e.subject, breaks: e.breaks });
    Model { name: entry.name, summary: entry.summary, params: params.collect(), examples: examples.collect() }
}

fn text(out: &mut dyn Write) -> anyhow::Result<()> {
    writeln!(out, "Models (SUBJECT is name:key=value,…)")?;
    for entry in catalog::MODELS {
        writeln!(out, "\n{}: {}", entry.name, entry.summary)?;
        let mut params = Table::new(&[("", Align::Left); 4]);
        for p in entry.params {
            let default = match p.default {
                Some(value) => format!("default {value}"),
                None if p.optional => "may be absent".into(),
                None => "required".into(),
            };
            params.row([p.name.into(), p.domain.to_string(), default, p.doc.into()]);
        }
        write!(out, "{}", params.text("    "))?;
        if let Some(example) = entry.examples.first() {
            writeln!(out, "    e.g. {}", example.subject)?;
        }
    }
    writeln!(out, "\nChecks (validate --check NAME…)\n")?;
    let mut checks = Table::new(&[("", Align::Left); 2]);
    for &(name, meaning) in CHECKS {
        checks.row([name.into(), meaning.into()]);
    }
    write!(out, "{}", checks.text("    "))?;
    Ok(())
}
