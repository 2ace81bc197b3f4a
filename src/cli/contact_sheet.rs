//! `whitefurnace contact-sheet`: the lecture's pictures of samples and bounces on one sheet.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, bail};

use super::progress;
use super::scene_source::{self, SceneOptions};
use super::{Status, args, job};
use crate::report::contact_sheet::{Settings, Shot, draw, shoot};
use crate::report::table::{Align, Table, short};
use crate::scene::Scene;

pub(super) const HELP: &str = "SCENE is a file (Mitsuba XML, OBJ, PLY, glTF) or the name of a built-in scene (see \
    `whitefurnace scenes`).\n\n\
    First row: 1, 5, 10, 20, 40 and 80 samples with one bounce. Second: 1, 2 and 3 bounces with 5 and with 80 samples.\n\
    Third: 1 and 3 bounces with 80 samples, and their difference, scaled as its caption says.\n\n\
    A bounce is one of the lecture's: light is connected to at every surface, and a random ray is followed from there.\n\
    b bounces are b + 1 reflections: `render --strategy direct --rr off --bounces` b + 1.\n\n\
    Examples:\n  whitefurnace contact-sheet\n  whitefurnace contact-sheet veach-mis --size 240 -o plates.png\n  \
    whitefurnace contact-sheet scene.xml --exposure 1.5";

/// What `contact-sheet` takes.
#[derive(Debug, clap::Args)]
pub(super) struct ContactSheetArgs {
    /// A scene file, or the name of a built-in scene
    #[arg(default_value = "cornell-original")]
    scene: String,
    #[command(flatten)]
    options: SceneOptions,
    /// The PNG to write
    #[arg(short = 'o', long = "output", value_name = "FILE", default_value = "contact_sheet.png")]
    output: PathBuf,
    /// Height of a small picture in pixels, 64 to 1024; the width follows from the scene
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(64..=1024), default_value_t = 160)]
    size: u16,
    /// Seed of all random numbers: the same seed gives the same sheet, bit by bit
    #[arg(long, value_name = "N", value_parser = args::seed, default_value = "1", allow_hyphen_values = true)]
    seed: u64,
    /// Stops by which all pictures are made brighter
    #[arg(long, value_name = "EV", value_parser = args::stops, default_value = "0", allow_hyphen_values = true)]
    exposure: f64,
    /// Threads to use; the sheet does not depend on it. Default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// No progress and no table
    #[arg(long)]
    quiet: bool,
}

/// A small picture may be so many times wider than high, and the other way round.
const MOST_OBLONG: f64 = 8.0;

pub(super) fn run(args: &ContactSheetArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        bail!("-o {}: allowed is a name that ends in .png", args.output.display());
    }
    let target = job::target("-o", args.output.clone())?;
    let loaded = args.options.load(&args.scene)?;
    if !args.quiet {
        scene_source::warn(&loaded)?;
    }
    let scene = Scene::new(loaded.scene).with_context(|| args.scene.clone())?;
    let shape = scene.film().width as f64 / scene.film().height as f64;
    let size = (
        ((f64::from(args.size) * shape.clamp(1.0 / MOST_OBLONG, MOST_OBLONG)).round() as usize).max(1),
        args.size.into(),
    );
    let settings = Settings { size, seed: args.seed, exposure: args.exposure };
    let name = scene.name().to_string();

    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build()?;
    let (bar, interrupted) = (progress::bar(args.quiet), progress::interruption());
    let shots =
        pool.install(|| shoot(scene, &settings, &interrupted, &mut |share| bar.set_position((1000.0 * share) as u64)));
    bar.finish_and_clear();
    let Some(shots) = shots else { bail!("interrupted; no sheet was written") };
    target.write(&draw(&name, &shots, &settings)?).with_context(|| format!("-o {}", args.output.display()))?;
    if !args.quiet {
        write!(out, "{}", table(shots.small.iter().chain(&shots.large)))?;
        writeln!(out, "wrote {}", args.output.display())?;
    }
    Ok(Status::Pass)
}

/// What each picture took.
fn table<'a>(shots: impl Iterator<Item = &'a Shot>) -> String {
    let heads = ["size", "samples", "bounces", "seconds", "error/%"];
    let mut table = Table::new(&heads.map(|name| (name, Align::Right)));
    for Shot { samples, bounces, film, seconds } in shots {
        let error = 100.0 * film.relative_error();
        table.row([
            format!("{}x{}", film.width(), film.height()),
            samples.to_string(),
            bounces.to_string(),
            format!("{seconds:.2}"),
            if error.is_finite() { short(error) } else { "-".into() },
        ]);
    }
    table.text("")
}
