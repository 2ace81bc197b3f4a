//! `converge scene:SCENE`: the whole image of a scene, or one pixel of it.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, anyhow, bail};
use indicatif::ProgressBar;

use super::files::Files;
use super::kept::Kept;
use super::rows::{self, Image as ImageRow, Row, Subject};
use super::{ConvergeArgs, counts};
use crate::cli::render::{Bounces, bounces, filter, size};
use crate::cli::scene_source::{self, SceneOptions};
use crate::cli::validate::print;
use crate::cli::{Status, args, progress};
use crate::converge::Study;
use crate::converge::image::{ImageLab, ImageStudy, Numbers, Reference, State, View, estimator};
use crate::image::Image;
use crate::render::film::Film;
use crate::render::path::{PathTracer, Strategy};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::SamplerKind;
use crate::scene::Scene;

/// What only a scene takes.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Of scene:SCENE")]
pub(super) struct ImageArgs {
    #[command(flatten)]
    options: SceneOptions,
    /// Size of the image in pixels. Default: that of the reference; else 32 wide, or for a pixel what the scene asks for
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(usize, usize)>,
    /// Largest number of reflections, or `inf`. Default: what the scene asks for, else inf
    #[arg(long, value_name = "R", value_parser = bounces)]
    bounces: Option<Bounces>,
    /// Reconstruction filter: box, tent, gaussian, … Default: what the scene asks for
    #[arg(long, value_name = "FILTER", value_parser = filter)]
    filter: Option<Filter>,
    /// What the floor is measured against: a picture, whose sides may be multiples of the image's; `own`, rendered by mis with
    /// other random numbers; or `none`. Default: own
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Root mean square error of the picture, where its own planes do not state it
    #[arg(long, value_name = "E", value_parser = args::positive, requires = "reference")]
    reference_error: Option<f64>,
    /// Begin anew, whatever an interrupted study has left in the folder
    #[arg(long, requires = "out")]
    restart: bool,
}

/// What takes a few seconds, and shows a rate and a bias.
const DEFAULT_WIDTH: usize = 32;
const DEFAULT_RANGE: (u64, u64) = (4, 256);
const DEFAULT_REPLICATES: u64 = 16;
/// Fewer say nothing of their own spread; more make images that no memory holds.
const REPLICATES: std::ops::RangeInclusive<u64> = 4..=4096;
/// Bytes of the images of one count.
const MOST_BYTES: usize = 1 << 32;
/// How often the state is kept while the work goes on, and how many times as long as keeping it takes at the least.
const KEEP_SECONDS: f64 = 5.0;
const KEEP_SHARE: f64 = 20.0;

impl ImageArgs {
    /// The first option that was typed.
    pub(super) fn any(&self) -> Option<&'static str> {
        let typed = [
            (self.options.any(), "--param, --lenient"),
            (self.size.is_some(), "--size"),
            (self.bounces.is_some(), "--bounces"),
            (self.filter.is_some(), "--filter"),
            (self.reference.is_some(), "--reference"),
            (self.restart, "--restart"),
        ];
        typed.into_iter().find(|(typed, _)| *typed).map(|(_, option)| option)
    }
}

/// The reference that was asked for.
enum Wanted {
    None,
    Own { samples: u64 },
    Picture { path: PathBuf, image: Image },
}

impl Wanted {
    fn new(args: &ImageArgs, replicates: u64, most: u64) -> anyhow::Result<Self> {
        let named = |name: &str| args.reference.as_ref().is_some_and(|path| path.as_os_str() == name);
        Ok(match &args.reference {
            Some(path) if !named("own") && !named("none") => {
                let image = Image::read(path).context("--reference")?;
                Self::Picture { path: path.clone(), image }
            }
            _ if args.reference_error.is_some() => bail!("--reference-error: the reference is no picture"),
            _ if named("none") => Self::None,
            // Its error is then not much more than that of the mean of the largest images, at a quarter of their time.
            _ => Self::Own { samples: most.max(replicates * most / 2) },
        })
    }
}

/// SCENE@X,Y: an @ may stand in the name of a file, too.
fn scene_and_pixel(text: &str) -> (&str, Option<[usize; 2]>) {
    let place = |place: &str| {
        let (x, y) = place.split_once(',')?;
        Some([x.trim().parse().ok()?, y.trim().parse().ok()?])
    };
    match text.rsplit_once('@').and_then(|(scene, rest)| Some((scene, place(rest)?))) {
        Some((scene, pixel)) => (scene, Some(pixel)),
        None => (text, None),
    }
}

/// The size of the image: as typed, else as the reference, else a small one of the scene's aspect.
fn view_size(args: &ImageArgs, wanted: &Wanted, scene: &Scene, is_pixel: bool) -> (usize, usize) {
    let film = scene.film();
    match (args.size, wanted) {
        (Some(size), _) => size,
        (None, Wanted::Picture { image, .. }) => (image.width(), image.height()),
        _ if is_pixel => (film.width, film.height),
        _ => {
            let width = DEFAULT_WIDTH.min(film.width);
            (width, ((width * film.height + film.width / 2) / film.width).clamp(1, 1 << 16))
        }
    }
}

/// The estimators by their names, each as a path tracer.
fn tracers(names: &[String], scene: &Scene, base: PathTracer) -> anyhow::Result<Vec<(String, PathTracer)>> {
    let one = |name: &String| {
        let name = name.trim();
        let tracer = estimator::tracer(name, base).map_err(|why| anyhow!("--estimator {name}: {why}"))?;
        if tracer.strategy == Strategy::Bsdf && scene.emitters().has_dirac() {
            bail!(
                "--estimator bsdf: the scene has a point, spot or directional light, which no ray hits by chance; \
                 allowed are the others"
            );
        }
        Ok((name.to_string(), tracer))
    };
    if names.is_empty() { Ok(vec![("mis".into(), base)]) } else { names.iter().map(one).collect() }
}

/// Everything that can be wrong is found before the first ray.
pub(super) fn run(args: &ConvergeArgs, typed: &str, out: &mut dyn Write) -> anyhow::Result<Status> {
    let (typed, pixel) = scene_and_pixel(typed);
    let defaults = if pixel.is_some() {
        (super::DEFAULT_RANGE, super::DEFAULT_REPLICATES)
    } else {
        (DEFAULT_RANGE, DEFAULT_REPLICATES)
    };
    let replicates = args.replicates.unwrap_or(defaults.1);
    if !REPLICATES.contains(&replicates) {
        let (least, most) = REPLICATES.into_inner();
        bail!("--replicates {replicates}: of an image, allowed are {least} to {most}");
    }
    let counts = counts(args.n.unwrap_or(defaults.0));
    let (Some(&first), Some(&most)) = (counts.first(), counts.last()) else {
        bail!("--n: there is no power of two from FROM to TO");
    };
    let wanted = Wanted::new(&args.image, replicates, most)?;
    let loaded = args.image.options.load(typed)?;
    scene_source::warn(&loaded)?;
    let scene = Scene::new(loaded.scene).with_context(|| typed.to_string())?;
    let (width, height) = view_size(&args.image, &wanted, &scene, pixel.is_some());
    let scene = scene.with_size(width, height);
    if let Some([x, y]) = pixel.filter(|[x, y]| *x >= width || *y >= height) {
        bail!("scene:{typed}@{x},{y}: the image is {width} x {height}; columns and rows count from 0");
    }
    let bounces = args.image.bounces.map_or_else(|| scene.render_settings().bounces.flatten(), |Bounces(r)| r);
    let base = PathTracer { bounces, ..PathTracer::default() };
    let tracers = tracers(&args.estimator, &scene, base)?;
    let filter = args.image.filter.as_ref().unwrap_or(&scene.film().filter);
    let view = View { scene: &scene, filter, pixel };
    let [columns, rows] = view.size();
    if columns * rows > MOST_BYTES / 24 / replicates as usize {
        bail!(
            "{replicates} images of {width} x {height} pixels fill more than {MOST_BYTES} bytes; take fewer, or smaller"
        );
    }

    let names = |all: Vec<&str>| all.join(",");
    let shown_bounces = bounces.map_or("inf".into(), |r| r.to_string());
    let how = format!(
        "{width} x {height} pixels{}, {filter} filter, bounces {shown_bounces}, {replicates} images of {first} to {most} samples",
        pixel.map_or(String::new(), |[x, y]| format!(", column {x} and row {y} of them"))
    );
    let reference = match &wanted {
        Wanted::None => None,
        Wanted::Own { samples } => Some(format!("own, {samples} samples")),
        Wanted::Picture { path, .. } => Some(path.display().to_string()),
    };
    let settings = format!(
        "whitefurnace {}; scene:{typed}{}; {how}; seed {}; {} by {}; reference {}{}",
        env!("CARGO_PKG_VERSION"),
        args.image.options,
        args.seed,
        names(tracers.iter().map(|(name, _)| name.as_str()).collect()),
        names(args.sampler.iter().map(|kind| kind.name()).collect()),
        reference.as_deref().unwrap_or("none"),
        args.image.reference_error.map_or(String::new(), |error| format!(" ± {error}"))
    );
    let files = args.out.as_deref().map(Files::new).transpose()?;
    let kept = args.out.as_deref().map(|folder| Kept::new(folder, &settings)).transpose()?;
    if let (Some(kept), true) = (&kept, args.image.restart) {
        kept.forget()?;
    }

    let interrupted = progress::interruption();
    let bar = progress::bar(false);
    let studies = args.sampler.iter().flat_map(|kind| tracers.iter().map(move |(_, tracer)| (*kind, tracer)));
    let studies = studies.enumerate().map(|(number, (sampler, tracer))| {
        let plan = Study { counts: counts.clone(), replicates, seed: args.seed, number: number as u64, sampler };
        ImageStudy { radiance: tracer, plan }
    });
    let mut lab = ImageLab { view, reference: None, studies: studies.collect() };
    let work = Work { start: Instant::now(), bar: &bar, interrupted: &interrupted, kept: kept.as_ref() };
    // What belongs to another study is refused before anything is rendered.
    let mut state = match &kept {
        Some(kept) => kept.state(lab.extent())?,
        None => State::default(),
    };
    let mut own = None;
    let known = match &wanted {
        Wanted::None => None,
        Wanted::Own { samples } => {
            let all = *samples + lab.work(&state).0;
            match work.reference(&view, &base, args.seed, *samples, all)? {
                Some(film) => {
                    let known = Reference::of_film(&film);
                    own = Some(film);
                    Some(known.context("--reference own: a pixel has no two samples that are finite")?)
                }
                None => return stopped(args, &bar, out),
            }
        }
        Wanted::Picture { path, image } => {
            let of = Reference::of_image(image, [width, height]);
            let of = of.map_err(|why| anyhow!("--reference {}: {why}", path.display()))?;
            let of = pixel.map_or_else(|| of.clone(), |[x, y]| of.pixel(y * width + x));
            Some(match args.image.reference_error {
                Some(error) => of.with_error(error),
                None => of,
            })
        }
    };
    lab.reference = known.as_ref();
    let first = if let Wanted::Own { samples } = wanted { samples } else { 0 };
    if !work.images(&lab, &mut state, first)? {
        return stopped(args, &bar, out);
    }
    bar.finish_and_clear();

    let level = args.level / (lab.studies.len() * if reference.is_some() { 2 } else { 1 }) as f64;
    let found = lab.found(&state);
    let names = args.sampler.iter().flat_map(|_| tracers.iter().map(|(name, _)| name));
    let rows: Vec<Row> = names.zip(&found).map(|(name, found)| Row::of_image(name, found, level)).collect();
    let subject = Subject {
        name: args.target.clone(),
        exact: known.as_ref().map_or(f64::NAN, Reference::mean),
        error: known.as_ref().and_then(Reference::error).unwrap_or(f64::NAN),
        seed: args.seed,
        replicates,
        image: Some(ImageRow {
            width,
            height,
            how,
            reference: reference.map(|name| (name, known.as_ref().and_then(Reference::error))),
        }),
    };
    print(out, &rows::text(&subject, &rows, args.equal_time))?;
    if let Some(files) = files {
        files.write(&subject, &rows)?;
    }
    if let Some(kept) = kept {
        kept.finish(own.as_ref(), scene.name(), reference_seed(args.seed))?;
    }
    Ok(rows::status(&rows))
}

/// What is said where there is no verdict yet.
fn stopped(args: &ConvergeArgs, bar: &ProgressBar, out: &mut dyn Write) -> anyhow::Result<Status> {
    bar.finish_and_clear();
    let how = match &args.out {
        Some(folder) => format!("interrupted; the same command goes on from what is in {}\n", folder.display()),
        None => "interrupted; with --out DIR it could go on\n".into(),
    };
    print(out, &how)?;
    Ok(Status::Inconclusive)
}

/// The long part.
struct Work<'a> {
    start: Instant,
    bar: &'a ProgressBar,
    interrupted: &'a AtomicBool,
    kept: Option<&'a Kept>,
}

impl Work<'_> {
    /// Our own reference, from where it was left; None if it was interrupted. `all` is the work in samples of a pixel.
    fn reference(
        &self,
        view: &View,
        tracer: &PathTracer,
        seed: u64,
        samples: u64,
        all: u64,
    ) -> anyhow::Result<Option<Film>> {
        let scene = view.scene.name();
        let seed = reference_seed(seed);
        let mut film = match self.kept {
            Some(kept) => kept.reference(scene, seed)?.unwrap_or_else(|| view.blank()),
            None => view.blank(),
        };
        let numbers = Numbers { sampler: SamplerKind::Independent, seed, samples };
        let mut keeping = Keeping::new();
        view.raise(tracer, numbers, &mut film, self.interrupted, &mut |film, now| {
            let share = now.samples as f64 / all as f64;
            progress::show(self.bar, "the reference", self.start.elapsed().as_secs_f64(), 0.0, share);
            if let Some(kept) = self.kept {
                keeping.if_due(|| kept.keep_reference(film, scene, seed));
            }
        });
        if let Some(kept) = self.kept {
            kept.keep_reference(&film, scene, seed)?;
        }
        Ok((!self.interrupted.load(Ordering::Relaxed)).then_some(film))
    }

    /// All images that `state` lacks, after `first` samples of a reference; false if it was interrupted.
    fn images(&self, lab: &ImageLab, state: &mut State, first: u64) -> anyhow::Result<bool> {
        let share = |state: &State| {
            let (all, done) = lab.work(state);
            (first + done) as f64 / (first + all) as f64
        };
        let (begun, at_first) = (Instant::now(), share(state));
        let mut keeping = Keeping::new();
        lab.go_on(state, self.interrupted, &mut |state| {
            progress::show(self.bar, "images", begun.elapsed().as_secs_f64(), at_first, share(state));
            if let Some(kept) = self.kept {
                keeping.if_due(|| kept.keep(state));
            }
        });
        if let Some(kept) = self.kept {
            kept.keep(state)?;
        }
        Ok(state.measured.len() == lab.extent().measured)
    }
}

/// Keeps a state now and then, at a small part of the time.
struct Keeping {
    last: Instant,
    pause: f64,
}

impl Keeping {
    fn new() -> Self {
        Self { last: Instant::now(), pause: KEEP_SECONDS }
    }

    fn if_due(&mut self, keep: impl FnOnce() -> anyhow::Result<()>) {
        if self.last.elapsed().as_secs_f64() > self.pause {
            let begun = Instant::now();
            // If it cannot be written now, the end will say so.
            let _ = keep();
            self.pause = KEEP_SECONDS.max(KEEP_SHARE * begun.elapsed().as_secs_f64());
            self.last = Instant::now();
        }
    }
}

/// No image has this one: a study's number is far below.
fn reference_seed(seed: u64) -> u64 {
    use rand::Rng;
    crate::sampling::stream::stream(seed, u64::MAX, 0).next_u64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_stands_after_the_last_at() {
        assert_eq!(scene_and_pixel("box"), ("box", None));
        assert_eq!(scene_and_pixel("box@3,4"), ("box", Some([3, 4])));
        assert_eq!(scene_and_pixel("a@b.xml"), ("a@b.xml", None));
        assert_eq!(scene_and_pixel("a@1,2@3,4"), ("a@1,2", Some([3, 4])));
    }
}
