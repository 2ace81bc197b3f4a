//! What `render` takes.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::cli::args::{positive, sampler, seed};
use crate::cli::photons;
use crate::cli::radiosity;
use crate::cli::scene_source::SceneArgs;
use crate::render::path::{Roulette, Strategy};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::SamplerKind;

/// What a pixel's count of samples may be asked to reach.
const MOST_SAMPLES: u64 = 1 << 40;

pub(in crate::cli) const HELP: &str = "SCENE is a file (Mitsuba XML, OBJ, PLY, glTF) or the name of a built-in scene (see `whitefurnace scenes`).\n\n\
    The strategies (all have the same mean):\n  mis             light by chance and by connection, weighted (the default)\n  \
    direct          a connection to a light at every surface\n  bsdf            no connection: bounce until a light is hit\n  \
    random-connect  one connection at a random bounce, then the path ends\n\n\
    Output formats by extension: .exr (float; R, G, B and the variance of each pixel's mean), .pfm, .hdr, .png\n\
    (sRGB, --exposure in stops; a preview). With a photon map .exr states the map's error, too: Map.StdErr and Map.Bias.\n\
    Ctrl-C writes what there is.\n\n\
    Examples:\n  whitefurnace render cornell-original -o box.exr -o box.png --spp 256\n  \
    whitefurnace render scene.xml -o a.exr --bounces 1 --strategy direct\n  \
    whitefurnace render scene.xml -o a.exr --rel-error 0.01 --checkpoint a.wfc\n  \
    whitefurnace render cornell-original -o patches.png --method radiosity --display gather-direct\n  \
    whitefurnace render cornell-original -o photons.png --method photon --photons 200000 --k 100\n  \
    whitefurnace render scene.xml -o caustics.exr --method sppm --photons 100000 --spp 256\n  \
    whitefurnace render scene.xml -o a.exr --spp 4096 --resume a.wfc --checkpoint a.wfc";

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct RenderArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// An image to write; may be given several times. Default: the scene's name with .exr and .png
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(super) outputs: Vec<PathBuf>,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(usize, usize)>,
    /// Samples per pixel. Default: what the scene asks for, else 64
    #[arg(long, value_name = "N", value_parser = samples, group = "stop")]
    pub(super) spp: Option<u64>,
    /// Seconds to render for
    #[arg(long, value_name = "S", value_parser = positive, group = "stop")]
    pub(super) time: Option<f64>,
    /// Go on until the estimated relative error of the image is down to this
    #[arg(long, value_name = "E", value_parser = positive, group = "stop")]
    pub(super) rel_error: Option<f64>,
    /// Largest number of reflections, or `inf`. Default: what the scene asks for, else inf
    #[arg(long, value_name = "R", value_parser = bounces)]
    pub(super) bounces: Option<Bounces>,
    /// The algorithm
    #[arg(long, value_enum, default_value = "path")]
    pub(super) method: MethodArg,
    #[command(flatten)]
    pub(super) radiosity: radiosity::DisplayArgs,
    #[command(flatten)]
    pub(super) photons: photons::MapArgs,
    #[command(flatten)]
    pub(super) gather: photons::FinalGatherArgs,
    /// How light is found
    #[arg(long, value_enum, default_value = "mis")]
    pub(super) strategy: StrategyArg,
    /// Continue every path this many times from its first surface
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..=1_000_000), default_value_t = 1)]
    pub(super) first_split: u32,
    /// Russian roulette: `off`, `albedo`, or `depth:N`, from the N-th reflection on
    #[arg(long, value_name = "HOW", value_parser = roulette, default_value = "depth:5")]
    pub(super) rr: Roulette,
    /// Where random numbers come from: independent, jittered, multi-jittered, halton, lattice, sobol or blue-sobol. With all
    /// but the first, the stated error is an upper bound
    #[arg(long, value_name = "NAME", value_parser = sampler, default_value = SamplerKind::default().name())]
    pub(super) sampler: SamplerKind,
    /// Reconstruction filter: box, tent, gaussian, mitchell, … Default: what the scene asks for
    #[arg(long, value_name = "FILTER", value_parser = filter)]
    pub(super) filter: Option<Filter>,
    /// Seed of all random numbers: the same seed gives the same image, bit by bit
    #[arg(long, value_name = "N", value_parser = seed, default_value = "1", allow_hyphen_values = true)]
    pub(super) seed: u64,
    /// Threads to use; the image does not depend on it. Default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Stops by which the PNG is made brighter
    #[arg(long, value_name = "EV", value_parser = exposure, default_value = "0", allow_hyphen_values = true)]
    pub(super) exposure: f64,
    /// Keep the samples in this file, so that the rendering can go on from there
    #[arg(long, value_name = "FILE")]
    pub(super) checkpoint: Option<PathBuf>,
    /// Go on from the samples in this file
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
    /// No progress and no summary
    #[arg(long)]
    pub(super) quiet: bool,
    /// Write seconds, samples, rays, memory, mean and error as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) stats_json: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArg {
    /// Path tracing
    Path,
    /// The radiosity equations of the scene's patches, which must be diffuse
    Radiosity,
    /// A photon map with final gather
    Photon,
    /// The density of photons at the first surface that is no mirror
    PhotonDirectView,
    /// Stochastic progressive photon mapping: a map for each sample, with radii that shrink
    Sppm,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum StrategyArg {
    Mis,
    Direct,
    Bsdf,
    RandomConnect,
}

impl From<StrategyArg> for Strategy {
    fn from(typed: StrategyArg) -> Self {
        match typed {
            StrategyArg::Mis => Self::Mis,
            StrategyArg::Direct => Self::Direct,
            StrategyArg::Bsdf => Self::Bsdf,
            StrategyArg::RandomConnect => Self::RandomConnect,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(in crate::cli) struct Bounces(pub(in crate::cli) Option<u32>);

fn exposure(text: &str) -> Result<f64, String> {
    let stops = text.parse().ok().filter(|stops: &f64| stops.abs() <= 100.0);
    stops.ok_or_else(|| "allowed is a number of stops from -100 to 100".into())
}

pub(in crate::cli) fn size(text: &str) -> Result<(usize, usize), String> {
    let pair = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    pair.filter(|&(w, h)| (1..=65536).contains(&w) && (1..=65536).contains(&h))
        .ok_or_else(|| "allowed is WxH, each from 1 to 65536".into())
}

fn samples(text: &str) -> Result<u64, String> {
    let n = text.parse().ok().filter(|n| (1..=MOST_SAMPLES).contains(n));
    n.ok_or_else(|| format!("allowed is a whole number from 1 to {MOST_SAMPLES}"))
}

pub(in crate::cli) fn bounces(text: &str) -> Result<Bounces, String> {
    match text {
        "inf" => Ok(Bounces(None)),
        _ => text.parse().map(|r| Bounces(Some(r))).map_err(|_| "allowed is a whole number ≥ 0, or inf".into()),
    }
}

fn roulette(text: &str) -> Result<Roulette, String> {
    match (text, text.strip_prefix("depth:").and_then(|n| n.parse().ok())) {
        ("off", _) => Ok(Roulette::Off),
        ("albedo", _) => Ok(Roulette::Albedo),
        (_, Some(n)) => Ok(Roulette::From(n)),
        _ => Err("allowed is off, albedo, or depth:N with a whole number N".into()),
    }
}

pub(in crate::cli) fn filter(text: &str) -> Result<Filter, String> {
    text.parse().map_err(|error: crate::sampling::filter::FilterError| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_outside_their_domain_are_refused() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for text in ["640", "0x1", "1x65537", "axb", "-1x2"] {
            assert!(size(text).is_err(), "{text}");
        }
        assert!(matches!(bounces("inf"), Ok(Bounces(None))) && matches!(bounces("0"), Ok(Bounces(Some(0)))));
        assert!(bounces("-1").is_err() && bounces("1.5").is_err());
        assert_eq!(roulette("depth:3"), Ok(Roulette::From(3)));
        assert!(roulette("depth").is_err() && roulette("depth:x").is_err());
        assert!(samples("0").is_err() && samples("64").is_ok());
    }
}
