//! `whitefurnace render`: an image of a scene, with the error of every pixel.

mod args;
mod output;

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, anyhow, bail};
use indicatif::ProgressBar;

use super::{Status, progress, scene_source};
use crate::render::Radiance;
use crate::render::checkpoint::Checkpoint;
use crate::render::film::Film;
use crate::render::path::{PathTracer, Strategy};
use crate::render::photon::progressive::Sppm;
use crate::render::photon::stated::OfMap;
use crate::render::progressive::{self, Cost, Job, Progress, Stop};
use crate::render::provenance::{Provenance, Run};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{AnySampler, SamplerKind};
use crate::scene::Scene;

pub(super) use args::{Bounces, HELP, RenderArgs, bounces, filter, size};

use args::MethodArg;
pub(super) use output::images;
use output::{Outputs, Report};

/// Samples per pixel where neither the command line nor the scene says how many.
const DEFAULT_SAMPLES: u32 = 64;
/// How often the samples are kept while the work goes on.
const KEEP_SECONDS: f64 = 60.0;

/// Everything that can be wrong is found before the first ray.
pub(super) fn run(args: &RenderArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    let outputs = Outputs::new(args)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build()?;
    let (report, interrupted) = pool.install(|| rendered(args, &outputs))?;
    outputs.statistics(&report, out)?;
    if !args.quiet && !outputs.statistics_on_stdout() {
        outputs.summary(&report, interrupted, out)?;
    }
    Ok(Status::Pass)
}

/// Loads, builds, renders and writes the images; whether it was interrupted.
fn rendered(args: &RenderArgs, outputs: &Outputs) -> anyhow::Result<(Report, bool)> {
    let start = Instant::now();
    let loaded = args.scene.load()?;
    if !args.quiet {
        scene_source::warn(&loaded)?;
    }
    let load = start.elapsed().as_secs_f64();
    let scene = Scene::new(loaded.scene).with_context(|| args.scene.typed().to_string())?;
    let scene = match args.size {
        Some((width, height)) => scene.with_size(width, height),
        None => scene,
    };
    let build = start.elapsed().as_secs_f64() - load;
    let (light, algorithm) = algorithm(args, &scene)?;
    let filter = args.filter.as_ref().unwrap_or(&scene.film().filter);
    let stop = stop(args, &scene);
    let known = match stop {
        Stop::Samples(samples) => Some(samples),
        Stop::Seconds(_) | Stop::RelativeError(_) => None,
    };
    let planned = known.unwrap_or(DEFAULT_SAMPLES.into());
    let sampler = args.sampler.sampler(args.seed, planned, scene.film().width as u64);
    // The others go on with the same points, however many there are to be.
    let grid = match args.sampler {
        SamplerKind::Independent | SamplerKind::Lattice | SamplerKind::Sobol => String::new(),
        _ => format!(" for {planned} samples"),
    };
    let how = format!("{algorithm}, filter {filter}, sampler {:?}{grid}", args.sampler);
    let state = begin(args, &scene, &how, progressive::batch_for(args.sampler, known))?;

    let interrupted = progress::interruption();
    let bar = progress::bar(args.quiet);
    let Checkpoint { mut film, mut provenance } = state;
    let mut kept = Instant::now();
    let mut look = |film: &Film, now: Progress| {
        show(&bar, film, now);
        if kept.elapsed().as_secs_f64() > KEEP_SECONDS {
            // If it cannot be written now, the end will say so, and the samples are not lost before.
            let _ =
                outputs.checkpoint(&Checkpoint { film: film.clone(), provenance: up_to(&provenance, film, args.seed) });
            kept = Instant::now();
        }
    };
    let mut rendered = |radiance: &dyn Radiance, film: &mut Film| {
        let job = Job { scene: &scene, radiance, filter, sampler: &sampler };
        progressive::render(&job, film, stop, &interrupted, &mut look)
    };
    let cost = match &light {
        Algorithm::Same(radiance) => rendered(&**radiance, &mut film),
        Algorithm::OfMap(light) => rendered(&**light, &mut film),
        Algorithm::OfPasses(plan) => {
            passes(plan, &scene, (filter, &sampler), &mut film, (stop, &interrupted), &mut look)?
        }
    };
    bar.finish_and_clear();

    provenance = up_to(&provenance, &film, args.seed);
    provenance.seconds += cost.seconds;
    let was_interrupted = interrupted.load(Ordering::Relaxed);
    let state = Checkpoint { film, provenance };
    let map_errors = match &light {
        Algorithm::OfMap(light) if !was_interrupted => {
            // If it cannot be written now, the end will say so.
            let _ = outputs.checkpoint(&state);
            outputs.map_errors(&scene, &**light, &state.film, args)
        }
        _ => None,
    };
    let report = Report { state, map_errors, cost, load, build };
    outputs.checkpoint_and_images(&report)?;
    Ok((report, was_interrupted))
}

/// A film without samples, in batches of so many, or the one that is gone on with, in its own batches.
fn begin(args: &RenderArgs, scene: &Scene, how: &str, batch: u64) -> anyhow::Result<Checkpoint> {
    let (width, height) = (scene.film().width, scene.film().height);
    let settings = format!("{width}x{height}, {how}");
    let Some(path) = &args.resume else {
        let run = Run { seed: args.seed, first: 0, count: 0 };
        let provenance = Provenance::new(scene.name(), &settings, run, 0.0);
        return Ok(Checkpoint { film: Film::new(width, height).with_batches(batch), provenance });
    };
    let state = Checkpoint::read(path).context("--resume")?;
    let resumable = state.resumable(scene.name(), &settings, args.seed);
    resumable.map_err(|why| anyhow!("--resume {}: {why}", path.display()))?;
    Ok(state)
}

/// `before`, with the samples that are on the film now.
fn up_to(before: &Provenance, film: &Film, seed: u64) -> Provenance {
    // Where the work was cut short, some pixels have fewer: the numbers in between count as taken.
    let run = Run { seed, first: 0, count: film.most_drawn() };
    Provenance { runs: vec![run], ..before.clone() }
}

/// What renders.
enum Algorithm {
    /// The same for all samples.
    Same(Box<dyn Radiance>),
    /// The same, with the error of a map in all of them.
    OfMap(Box<dyn OfMap>),
    /// Another for each sample of a pixel.
    OfPasses(Sppm),
}

/// One sample of each pixel after the other, each with the light of its own pass.
fn passes(
    plan: &Sppm,
    scene: &Scene,
    (filter, sampler): (&Filter, &AnySampler),
    film: &mut Film,
    (stop, interrupted): (Stop, &AtomicBool),
    look: &mut dyn FnMut(&Film, Progress),
) -> anyhow::Result<Cost> {
    let start = Instant::now();
    let (first, mut rays) = (progressive::least_samples(film), 0);
    loop {
        let pass = progressive::least_samples(film);
        let seconds = start.elapsed().as_secs_f64();
        let share = match stop {
            Stop::Samples(n) => pass as f64 / n as f64,
            Stop::Seconds(most) => seconds / most,
            Stop::RelativeError(bound) if pass >= progressive::LEAST_SAMPLES => bound / film.relative_error(),
            Stop::RelativeError(_) => 0.0,
        };
        if share >= 1.0 || interrupted.load(Ordering::Relaxed) {
            return Ok(Cost { rays, seconds });
        }
        if pass > first {
            look(film, Progress { samples: pass, seconds, share: share.clamp(0.0, 1.0) });
        }
        let light = plan.pass(scene, pass).context("--method sppm")?;
        let job = Job { scene, radiance: &light, filter, sampler };
        rays += progressive::render(&job, film, Stop::Samples(pass + 1), interrupted, &mut |_, _| {}).rays;
    }
}

/// What renders, and how in words: where they are the same, the expectation of every sample is.
fn algorithm(args: &RenderArgs, scene: &Scene) -> anyhow::Result<(Algorithm, String)> {
    match args.method {
        MethodArg::Path => {
            let tracer = tracer(args, scene)?;
            Ok((Algorithm::Same(Box::new(tracer)), format!("{tracer:?}")))
        }
        MethodArg::Radiosity => {
            let clock = progress::clock(args.quiet, "radiosity".into());
            let (solution, how) = args.radiosity.solve(scene, args.bounces.and_then(|Bounces(r)| r), args.seed)?;
            clock.finish_and_clear();
            Ok((Algorithm::Same(Box::new(solution)), how))
        }
        MethodArg::Photon => {
            let clock = progress::clock(args.quiet, "photons".into());
            let (light, how) = args.photons.gathered(scene, args.gather, limit(args, scene), args.seed)?;
            clock.finish_and_clear();
            Ok((Algorithm::OfMap(Box::new(light)), how))
        }
        MethodArg::Sppm => {
            let (plan, how) = args.photons.progressive(scene, args.gather, limit(args, scene), args.seed)?;
            Ok((Algorithm::OfPasses(plan), how))
        }
        MethodArg::PhotonDirectView => {
            let clock = progress::clock(args.quiet, "photons".into());
            let (light, how) = args.photons.viewed(scene, limit(args, scene), args.seed)?;
            clock.finish_and_clear();
            Ok((Algorithm::OfMap(Box::new(light)), how))
        }
    }
}

fn tracer(args: &RenderArgs, scene: &Scene) -> anyhow::Result<PathTracer> {
    let strategy = args.strategy.into();
    if strategy == Strategy::Bsdf && scene.emitters().has_dirac() {
        bail!(
            "--strategy bsdf: the scene has a point, spot or directional light, which no ray hits by chance; \
             allowed are mis, direct, random-connect"
        );
    }
    let bounces = limit(args, scene);
    Ok(PathTracer { strategy, bounces, first_split: args.first_split, roulette: args.rr, ..PathTracer::default() })
}

/// The largest number of reflections; None for no limit.
fn limit(args: &RenderArgs, scene: &Scene) -> Option<u32> {
    args.bounces.map_or_else(|| scene.render_settings().bounces.flatten(), |Bounces(r)| r)
}

fn stop(args: &RenderArgs, scene: &Scene) -> Stop {
    match (args.time, args.rel_error) {
        (Some(seconds), _) => Stop::Seconds(seconds),
        (_, Some(bound)) => Stop::RelativeError(bound),
        _ => Stop::Samples(
            args.spp.unwrap_or_else(|| scene.render_settings().samples.unwrap_or(DEFAULT_SAMPLES).max(1).into()),
        ),
    }
}

fn show(bar: &ProgressBar, film: &Film, now: Progress) {
    if bar.is_hidden() {
        return;
    }
    let (Progress { samples, seconds, share }, relative_error) = (now, film.relative_error());
    let error = if relative_error.is_finite() { format!("{:.2} % error", 100.0 * relative_error) } else { "-".into() };
    progress::show(bar, &format!("{samples} samples per pixel  {error}"), seconds, 0.0, share);
}
