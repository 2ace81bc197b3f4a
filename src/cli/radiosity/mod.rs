//! `whitefurnace radiosity`: the light of diffuse surfaces by the radiosity equations.

mod answer;
mod args;
mod report;
mod view_factors;

use std::io::Write;
use std::path::PathBuf;

use anyhow::Context;

use super::job::{Sink, sink};
use super::{Status, progress, render, scene_source};
use crate::image::Format;
use crate::render::film::Film;
use crate::render::progressive::{self, Job, Stop};
use crate::render::provenance::{Provenance, Run};
use crate::report::save::Target;
use crate::sampling::sampler::SamplerKind;
use crate::scene::Scene;

use answer::Answer;
pub(super) use args::{DisplayArgs, RADIOSITY_HELP, RadiosityArgs, VIEW_FACTORS_HELP, ViewFactorsArgs};
pub(super) use view_factors::run as run_view_factors;

pub(super) fn run(args: &RadiosityArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    args.check()?;
    let images = render::images(&args.outputs)?;
    let json = args.json.clone().map(|path| sink("--json", path)).transpose()?;
    let loaded = args.scene.load()?;
    if !args.quiet {
        scene_source::warn(&loaded)?;
    }
    let scene = Scene::new(loaded.scene).with_context(|| args.scene.typed().to_string())?;
    let scene = match args.size {
        Some((width, height)) => scene.with_size(width, height),
        None => scene,
    };
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

fn draw(
    args: &RadiosityArgs,
    scene: &Scene,
    answer: Answer,
    images: &[(Target, Format, PathBuf)],
) -> anyhow::Result<()> {
    let (width, height) = (scene.film().width, scene.film().height);
    let count = answer.patches().all().len();
    let solution = answer.shown(args.display.into());
    let kind = SamplerKind::default();
    let sampler = kind.sampler(args.factors.seed, args.spp, width as u64);
    let job = Job { scene, radiance: &solution, filter: &scene.film().filter, sampler: &sampler };
    let mut film = Film::new(width, height).with_batches(progressive::batch_for(kind, Some(args.spp)));
    let interrupted = progress::interruption();
    let bar = progress::bar(args.quiet);
    let cost = progressive::render(&job, &mut film, Stop::Samples(args.spp), &interrupted, &mut |_, now| {
        progress::show(&bar, &format!("{} samples per pixel", now.samples), now.seconds, 0.0, now.share);
    });
    bar.finish_and_clear();
    let settings =
        format!("{width}x{height}, radiosity of {count} patches by {}, {:?}", args.solver().name(), args.display);
    let run = Run { seed: args.factors.seed, first: 0, count: film.most_drawn() };
    let image = film.to_image(&Provenance::new(scene.name(), &settings, run, cost.seconds).metadata());
    for (target, format, path) in images {
        let bytes = image.encode(*format, args.exposure)?;
        target.write(&bytes).with_context(|| format!("-o {}: cannot be written", path.display()))?;
    }
    Ok(())
}
