//! `whitefurnace radiosity`: the light of diffuse surfaces by the radiosity equations.

mod answer;
mod args;
mod report;
mod view_factors;

use std::io::Write;

use anyhow::Context;

use super::job::{Sink, sink};
use super::picture::{Named, Picture};
use super::{Status, progress, render};
use crate::scene::Scene;

use answer::Answer;
pub(super) use args::{DisplayArgs, RADIOSITY_HELP, RadiosityArgs, VIEW_FACTORS_HELP, ViewFactorsArgs};
pub(super) use view_factors::run as run_view_factors;

pub(super) fn run(args: &RadiosityArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    args.check()?;
    let images = render::images(&args.outputs)?;
    let json = args.json.clone().map(|path| sink("--json", path)).transpose()?;
    let scene = args.scene.open(args.size, args.quiet)?;
    let clock = progress::clock(args.quiet, format!("radiosity by {}", args.solver().name()));
    let answer = Answer::of(args, &scene).with_context(|| args.scene.typed().to_string())?;
    clock.finish_and_clear();
    match &json {
        Some(Sink::Stdout) => writeln!(out, "{}", report::json(&answer, args)?)?,
        Some(Sink::File(target)) => {
            target.write(report::json(&answer, args)?.as_bytes()).context("--json: cannot be written")?;
        }
        None => {}
    }
    let status = if answer.is_reached(args.bounces) { Status::Pass } else { Status::Inconclusive };
    if !args.quiet && !matches!(json, Some(Sink::Stdout)) {
        write!(out, "{}", report::text(&answer, args))?;
    }
    if !images.is_empty() {
        draw(args, &scene, answer, &images)?;
    }
    Ok(status)
}

fn draw(args: &RadiosityArgs, scene: &Scene, answer: Answer, images: &[Named]) -> anyhow::Result<()> {
    let count = answer.patches().all().len();
    let how = format!("radiosity of {count} patches by {}, {:?}", args.solver().name(), args.display);
    let solution = answer.shown(args.display.into());
    let RadiosityArgs { spp: samples, exposure, quiet, .. } = *args;
    Picture { scene, light: &solution, map_errors: None, how, samples, seed: args.factors.seed, exposure, quiet }
        .write(images)
}
