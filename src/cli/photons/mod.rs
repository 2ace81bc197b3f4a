//! `whitefurnace photons`: a photon map, and where the light of a scene goes.

mod args;
mod ply;
mod report;

use std::io::Write;
use std::time::Instant;

use anyhow::Context;

use super::job::{Sink, sink, target};
use super::picture::{MapErrors, Named, Picture};
use super::{Status, render};
use crate::render::photon::map::PhotonMap;
use crate::render::photon::view::DirectView;
use crate::scene::Scene;

pub(super) use args::{FinalGatherArgs, HELP, MapArgs, PhotonsArgs};
use report::Report;

pub(super) fn run(args: &PhotonsArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build()?;
    let images = render::images(&args.outputs)?;
    let json = args.json.clone().map(|path| sink("--json", path)).transpose()?;
    let ply = args.ply.clone().map(|path| target("--ply", path)).transpose()?;
    let scene = args.scene.open(args.size, args.quiet)?;
    let start = Instant::now();
    let shooting = args.of_map.shooting(args.map.into(), None, args.seed);
    let (shot, gather) =
        pool.install(|| args.of_map.shot(&scene, shooting)).with_context(|| args.scene.typed().to_string())?;
    let shoot = start.elapsed().as_secs_f64();
    let tally = shot.tally;
    let map = pool
        .install(|| PhotonMap::new(&scene, &shot.photons, gather))
        .with_context(|| args.scene.typed().to_string())?;
    drop(shot.photons);
    let sort = start.elapsed().as_secs_f64() - shoot;
    let report = Report { scene: &scene, map: &map, tally: &tally, kept: args.map.into(), shoot, sort };
    match &json {
        Some(Sink::Stdout) => writeln!(out, "{}", report.json()?)?,
        Some(Sink::File(target)) => target.write(report.json()?.as_bytes()).context("--json: cannot be written")?,
        None => {}
    }
    if !args.quiet && !matches!(json, Some(Sink::Stdout)) {
        write!(out, "{}", report.text())?;
    }
    if let Some(target) = ply {
        target.write(&ply::encode(&map)).context("--ply: cannot be written")?;
    }
    if !images.is_empty() {
        pool.install(|| draw(args, &scene, map, &images))?;
    }
    Ok(Status::Pass)
}

fn draw(args: &PhotonsArgs, scene: &Scene, map: PhotonMap, images: &[Named]) -> anyhow::Result<()> {
    let how = format!("{} photons seen, {:?}", args.of_map.photons, map.gather());
    let view = DirectView::new(map, None);
    let PhotonsArgs { spp: samples, seed, exposure, quiet, .. } = *args;
    let map_errors = MapErrors::of(scene, &view, images, samples, (seed, quiet));
    Picture { scene, light: &view, map_errors, how, samples, seed, exposure, quiet }.write(images)
}
