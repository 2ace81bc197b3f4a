//! What `render` writes: images, statistics, a summary.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use serde_json::json;

use super::RenderArgs;
use crate::cli::job::Sink;
use crate::cli::picture::{MapErrors, Named};
use crate::image::Format;
use crate::render::checkpoint::Checkpoint;
use crate::render::film::Film;
use crate::render::photon::stated::OfMap;
use crate::render::progressive::Cost;
use crate::report::save::Target;
use crate::scene::Scene;

/// A finished rendering.
#[derive(Debug)]
pub(super) struct Report {
    pub(super) state: Checkpoint,
    /// Planes with the error of a photon map.
    pub(super) map_errors: Option<MapErrors>,
    pub(super) cost: Cost,
    /// Seconds for reading the scene.
    pub(super) load: f64,
    /// Seconds for building it.
    pub(super) build: f64,
}

/// Where everything goes.
#[derive(Debug)]
pub(super) struct Outputs {
    images: Vec<Named>,
    checkpoint: Option<Target>,
    statistics: Option<Sink>,
    exposure: f64,
}

impl Outputs {
    /// Found now, not after the minutes that the image may take: paths that cannot be written, formats that are not known.
    pub(super) fn new(args: &RenderArgs) -> anyhow::Result<Self> {
        let paths = if args.outputs.is_empty() {
            let stem = Path::new(args.scene.typed()).file_stem().map_or_else(|| "image".into(), PathBuf::from);
            vec![stem.with_extension("exr"), stem.with_extension("png")]
        } else {
            args.outputs.clone()
        };
        let statistics = match &args.stats_json {
            None => None,
            Some(path) if path.as_os_str() == "-" => Some(Sink::Stdout),
            Some(path) => Some(Sink::File(target("--stats-json", path)?)),
        };
        let checkpoint = args.checkpoint.as_ref().map(|path| target("--checkpoint", path)).transpose()?;
        Ok(Self { images: images(&paths)?, checkpoint, statistics, exposure: args.exposure })
    }

    /// Whether standard output carries the statistics, and so nothing else.
    pub(super) fn statistics_on_stdout(&self) -> bool {
        matches!(self.statistics, Some(Sink::Stdout))
    }

    /// The error of a photon map, for images that have room for it.
    pub(super) fn map_errors(
        &self,
        scene: &Scene,
        light: &dyn OfMap,
        film: &Film,
        args: &RenderArgs,
    ) -> Option<MapErrors> {
        MapErrors::of(scene, light, &self.images, film.most_drawn(), (args.seed, args.quiet))
    }

    /// Where one of them cannot be written, the samples are put where they can be, so that nothing is lost.
    pub(super) fn checkpoint_and_images(&self, report: &Report) -> anyhow::Result<()> {
        self.checkpoint(&report.state).and_then(|()| self.images(report)).map_err(|error| {
            let rescue = std::env::temp_dir().join(format!("whitefurnace-{}.wfc", std::process::id()));
            let kept = Target::new(rescue.clone()).and_then(|target| target.write(&report.state.encode()));
            match kept {
                Ok(()) => error.context(format!("the samples are kept in {}, for --resume", rescue.display())),
                Err(_) => error,
            }
        })
    }

    pub(super) fn checkpoint(&self, state: &Checkpoint) -> anyhow::Result<()> {
        let written = self.checkpoint.as_ref().map_or(Ok(()), |target| target.write(&state.encode()));
        written.context("--checkpoint: cannot be written")
    }

    fn images(&self, report: &Report) -> anyhow::Result<()> {
        let Checkpoint { film, provenance } = &report.state;
        let mut image = film.to_image(&provenance.metadata());
        if let Some(errors) = &report.map_errors {
            errors.push(&mut image)?;
        }
        for (target, format, path) in &self.images {
            let bytes = image.encode(*format, self.exposure)?;
            target.write(&bytes).with_context(|| format!("-o {}: cannot be written", path.display()))?;
        }
        Ok(())
    }

    pub(super) fn statistics(&self, report: &Report, out: &mut dyn Write) -> anyhow::Result<()> {
        match &self.statistics {
            None => Ok(()),
            Some(Sink::Stdout) => writeln!(out, "{}", report.statistics()).map_err(Into::into),
            Some(Sink::File(target)) => {
                target.write(report.statistics().as_bytes()).context("--stats-json: cannot be written")
            }
        }
    }

    pub(super) fn summary(&self, report: &Report, interrupted: bool, out: &mut dyn Write) -> anyhow::Result<()> {
        let Report { state: Checkpoint { film, .. }, cost, .. } = report;
        let (width, height) = (film.width(), film.height());
        let drawn = film.samples() + film.nonfinite();
        if interrupted {
            writeln!(out, "interrupted; this is what there is")?;
        }
        let each = drawn as f64 / (width * height) as f64;
        let rate = |n: u64| n as f64 / cost.seconds * 1e-6;
        writeln!(
            out,
            "{width} x {height} pixels, {each} samples each, {:.2} s ({:.3} million samples/s, {:.2} million rays/s)",
            cost.seconds,
            rate(drawn),
            rate(cost.rays)
        )?;
        let [r, g, b] = film.image_mean().to_array();
        let (error, relative) = (film.rmse_estimate(), 100.0 * film.relative_error());
        writeln!(out, "mean {r:.6} {g:.6} {b:.6}; root mean square error of a pixel {error:.3e} ({relative:.3} %)")?;
        if film.nonfinite() > 0 {
            writeln!(out, "{} samples were NaN or infinite and are left out", film.nonfinite())?;
        }
        let names: Vec<String> = self.images.iter().map(|(_, _, path)| path.display().to_string()).collect();
        writeln!(out, "wrote {}", names.join(", "))?;
        Ok(())
    }
}

/// Where images go, and in which format.
pub(in crate::cli) fn images(paths: &[PathBuf]) -> anyhow::Result<Vec<Named>> {
    if let Some(twice) = (1..paths.len()).find(|&i| paths[..i].contains(&paths[i])) {
        bail!("-o {}: the same file is named twice", paths[twice].display());
    }
    let image = |path: &PathBuf| {
        let format = Format::of(path).with_context(|| format!("-o {}", path.display()))?;
        Ok((target("-o", path)?, format, path.clone()))
    };
    paths.iter().map(image).collect()
}

pub(super) fn target(option: &str, path: &Path) -> anyhow::Result<Target> {
    Target::new(path.into()).map_err(|error| anyhow!("{option} {}: cannot be written: {error}", path.display()))
}

impl Report {
    fn statistics(&self) -> String {
        let Self { state: Checkpoint { film, .. }, cost, load, build, .. } = self;
        let statistics = json!({
            "schema": 1,
            "seconds": { "load": load, "build": build, "render": cost.seconds },
            "samples": film.samples() + film.nonfinite(),
            "rays": cost.rays,
            "peak_memory_bytes": peak_memory(),
            "mean": film.image_mean().to_array(),
            "rmse_estimate": film.rmse_estimate(),
            "nonfinite": film.nonfinite(),
        });
        statistics.to_string()
    }
}

/// The most memory that the process has held, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| kib * 1024)
}
