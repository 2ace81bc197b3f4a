//! The plots that measure what they show: the first split, Russian roulette, the links of hierarchical radiosity, and stores of
//! photons.

use std::io::Write;

use anyhow::{Context, bail};

use super::Out;
use crate::cli::args::{draws, seed};
use crate::cli::progress;
use crate::cli::scene_source::SceneOptions;
use crate::converge::first_split::{Fit, Floor, Law, Pixel, Point};
use crate::converge::roulette::Furnace;
use crate::converge::variance::variance_std_err;
use crate::render::path::PathTracer;
use crate::render::photon::stores::{Store, Trial, exponents};
use crate::render::radiosity::hierarchical::{Growth, Hierarchical};
use crate::report::plot::{self, RoulettePoint};
use crate::report::table::{Align, Table, short};
use crate::scene::Scene;

#[derive(Debug, clap::Args)]
pub(super) struct FirstSplit {
    /// A pixel of this scene: a file, or the name of a built-in scene
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    /// Size of the scene's image in pixels: a large pixel has much of V0
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "8x8", requires = "scene")]
    size: [usize; 2],
    /// Column and row of the pixel. Default: the middle
    #[arg(long, value_name = "X,Y", value_parser = pixel, requires = "scene")]
    pixel: Option<[usize; 2]>,
    /// Largest number of continuations; every power of two up to it is measured
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(4..=65_536), default_value_t = 64)]
    most: u32,
    /// Samples for each number of continuations, 2 to 1 000 000 000. Default: 65536, with a scene 8192
    #[arg(short = 'n', value_name = "N", value_parser = samples)]
    n: Option<u64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", value_parser = seed, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    out: Out,
}

#[derive(Debug, clap::Args)]
pub(super) struct Roulette {
    /// Albedo of the furnace, in (0, 1)
    #[arg(long, value_name = "RHO", default_value_t = 0.9)]
    rho: f64,
    /// Paths for each probability, 2 to 1 000 000 000
    #[arg(short = 'n', value_name = "N", value_parser = samples, default_value = "200000")]
    n: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", value_parser = seed, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    out: Out,
}

#[derive(Debug, clap::Args)]
pub(super) struct Links {
    /// A file, or the name of a built-in scene, of diffuse surfaces
    #[arg(long, value_name = "SCENE", default_value = "cornell-original")]
    scene: String,
    /// Largest number of elements; it is halved down to 250
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1000..=1 << 22), default_value_t = 16_000)]
    most: u64,
    #[command(flatten)]
    out: Out,
}

#[derive(Debug, clap::Args)]
pub(super) struct Stores {
    /// A file, or the name of a built-in scene, with a light that emits
    #[arg(long, value_name = "SCENE", default_value = "cornell-original")]
    scene: String,
    /// Largest number of photons, from 1000 in steps of half a decade or less; 10000000 take 1.6 GB of memory
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(FEWEST_PHOTONS..=10_000_000), default_value_t = 1_000_000)]
    most: u64,
    /// Photons that are searched for
    #[arg(short = 'k', value_name = "K", value_parser = clap::value_parser!(u64).range(1..=FEWEST_PHOTONS), default_value_t = 100)]
    k: u64,
    /// Seed of the photons
    #[arg(long, value_name = "N", value_parser = seed, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    out: Out,
}

/// Errors that are held fixed.
const ERRORS: [f64; 3] = [0.1, 0.03, 0.01];
/// The smallest number of elements.
const FEWEST: u64 = 250;

pub(super) fn links(args: &Links, out: &mut dyn Write) -> anyhow::Result<()> {
    let picture = args.out.picture("links")?;
    let scene = Scene::new(SceneOptions::default().load(&args.scene)?.scene)?;
    let halved = std::iter::successors(Some(args.most), |size| Some(size / 2)).take_while(|&size| size >= FEWEST);
    let mut sizes: Vec<usize> = halved.map(|size| size as usize).collect();
    sizes.reverse();
    let mut growths = Vec::new();
    let mut table = Table::new(&["error", "elements", "leaves", "links"].map(|name| (name, Align::Right)));
    for error in ERRORS {
        let model = Hierarchical { error, ..Hierarchical::default() };
        let growth = Growth::measure(&model, &scene, &sizes).context(args.scene.clone())?;
        for size in &growth.points {
            table.row([short(error), size.finest.to_string(), size.leaves.to_string(), size.links.to_string()]);
        }
        growths.push(growth);
    }
    write!(out, "{}", table.text("  "))?;
    for growth in &growths {
        if let Some([p, std_err]) = growth.exponent() {
            writeln!(out, "error {}: links as n^p, p = {p:.3} ± {std_err:.3}", short(growth.error))?;
        }
    }
    picture.write(&plot::links(scene.name(), &growths), out)
}

/// The smallest number of photons, and the most that are searched for.
const FEWEST_PHOTONS: u64 = 1000;

pub(super) fn stores(args: &Stores, out: &mut dyn Write) -> anyhow::Result<()> {
    let picture = args.out.picture("stores")?;
    let scene = Scene::new(SceneOptions::default().load(&args.scene)?.scene)?;
    let growth = args.most as f64 / FEWEST_PHOTONS as f64;
    let steps = (2.0 * growth.log10()).ceil();
    let sizes = (0..=steps as i32).map(|step| FEWEST_PHOTONS as f64 * growth.powf(f64::from(step) / steps.max(1.0)));
    let (most, k) = (args.most as usize, args.k as usize);
    let clock = progress::clock(false, "photons".into());
    let trial = Trial::new(&scene, most, k, args.seed).context(args.scene.clone())?;
    let timings: Vec<_> = sizes
        .map(|size| {
            clock.set_message(format!("{size:.0} photons"));
            trial.measure(size.round() as usize)
        })
        .collect();
    clock.finish_and_clear();
    let mut table = Table::new(
        &["photons", "scan (s)", "grid (s)", "tree (s)", "build grid (s/photon)", "build tree (s/photon)"]
            .map(|name| (name, Align::Right)),
    );
    for timing in &timings {
        let [scan, grid, tree] = timing.costs;
        let build = |seconds: f64| short(seconds / timing.photons as f64);
        table.row([
            timing.photons.to_string(),
            short(scan.query),
            short(grid.query),
            short(tree.query),
            build(grid.build),
            build(tree.build),
        ]);
    }
    write!(out, "{}", table.text("  "))?;
    for (store, exponent) in Store::ALL.iter().zip(exponents(&timings)) {
        if let Some([p, std_err]) = exponent {
            writeln!(out, "{}: seconds as n^p, p = {p:.3}, standard error {std_err:.3}", store.name())?;
        }
    }
    picture.write(&plot::stores(scene.name(), k, &timings), out)
}

fn samples(text: &str) -> Result<u64, String> {
    draws(text).ok().filter(|&n| n > 1).ok_or_else(|| "allowed is a whole number from 2 to 1000000000".into())
}

/// Two whole numbers around `sign`.
fn pair(text: &str, sign: char) -> Option<[usize; 2]> {
    let (a, b) = text.split_once(sign)?;
    Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = pair(text, 'x').filter(|sides| sides.iter().all(|side| (1..=65_536).contains(side)));
    sides.ok_or_else(|| "allowed is WxH, each from 1 to 65536".into())
}

fn pixel(text: &str) -> Result<[usize; 2], String> {
    pair(text, ',').ok_or_else(|| "allowed is X,Y: two whole numbers".into())
}

pub(super) fn first_split(args: &FirstSplit, out: &mut dyn Write) -> anyhow::Result<()> {
    let picture = args.out.picture("first-split")?;
    let splits: Vec<u32> = (0..=args.most.ilog2()).map(|k| 1 << k).collect();
    let (points, exact): (Vec<Point>, Option<Law>) = match &args.scene {
        None => match Floor::new() {
            Some(floor) => (floor.measure(&splits, args.n.unwrap_or(65_536), args.seed), Some(floor.law())),
            None => bail!("first-split: the light is not there"),
        },
        Some(name) => {
            let loaded = SceneOptions::default().load(name)?;
            let [width, height] = args.size;
            let at = args.pixel.unwrap_or([width / 2, height / 2]);
            if at[0] >= width || at[1] >= height {
                bail!("--pixel {},{}: outside of an image of {width}x{height}", at[0], at[1]);
            }
            let tracer = PathTracer { bounces: loaded.scene.render.bounces.flatten(), ..PathTracer::default() };
            let scene = Scene::new(loaded.scene)?.with_size(width, height);
            (Pixel { scene: &scene, at, tracer }.measure(&splits, args.n.unwrap_or(8192), args.seed), None)
        }
    };
    let mut table = Table::new(&["M", "variance", "std_err"].map(|name| (name, Align::Right)));
    for p in &points {
        table.row([p.m.to_string(), short(p.variance), short(p.std_err)]);
    }
    write!(out, "{}", table.text("  "))?;
    let Some(fit) = Fit::of(&points) else { bail!("first-split: nothing spreads, so that no law can be fitted") };
    let Fit { law, std_err, .. } = fit;
    let known = |value: Option<f64>| value.map_or(String::new(), |value| format!(" (exact {})", short(value)));
    writeln!(out, "V0 = {} ± {}{}", short(law.v0), short(std_err.v0), known(exact.map(|e| e.v0)))?;
    writeln!(out, "V1 = {} ± {}{}", short(law.v1), short(std_err.v1), known(exact.map(|e| e.v1)))?;
    writeln!(out, "V0 + V1/M fits with p = {}", short(fit.p_value()))?;
    if let Some(exact) = exact {
        writeln!(out, "the exact law is met with p = {}", short(fit.p_value_of(&exact)))?;
    }
    picture.write(&plot::first_split(&points, &fit, exact), out)
}

/// Where roulette is measured: shares of the way from ρ² to 1.
const SHARES: [f64; 10] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.92];

pub(super) fn roulette(args: &Roulette, out: &mut dyn Write) -> anyhow::Result<()> {
    let picture = args.out.picture("roulette")?;
    let pole = args.rho * args.rho;
    let mut points = Vec::new();
    let mut table = Table::new(&["q", "variance", "std_err", "exact"].map(|name| (name, Align::Right)));
    table.row([format!("<= {}", short(pole)), "-".into(), "-".into(), "inf".into()]);
    for (number, share) in (0..).zip(SHARES) {
        let furnace = Furnace::new(args.rho, pole + (1.0 - pole) * share)?;
        let moments = furnace.measure(args.n, args.seed, number);
        let variance = moments.variance();
        let std_err = furnace.has_fourth_moment().then(|| variance_std_err(&moments));
        let error = std_err.map_or("unknown".into(), short);
        table.row([short(furnace.survival()), short(variance), error, short(furnace.variance())]);
        points.push(RoulettePoint { furnace, variance, std_err });
    }
    write!(out, "{}", table.text("  "))?;
    picture.write(&plot::roulette(args.rho, &points), out)
}
