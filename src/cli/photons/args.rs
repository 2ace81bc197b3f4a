//! What `photons` takes, and what `render --method photon` shares with it.

use std::path::PathBuf;

use anyhow::Context;
use clap::ValueEnum;

use crate::cli::args::{positive, seed, stops};
use crate::cli::render::size;
use crate::cli::scene_source::SceneArgs;
use crate::render::photon::gather::FinalGather;
use crate::render::photon::kernel::Estimator;
use crate::render::photon::map::{Around, Gather, PhotonMap};
use crate::render::photon::progressive::{ALPHA, First, Sppm};
use crate::render::photon::shoot::{Shooting, Shot};
use crate::render::photon::view::DirectView;
use crate::render::photon::{Kept, PhotonError};
use crate::scene::Scene;

pub(in crate::cli) const HELP: &str = "\
Photons start at the lights in proportion to their power, are scattered by the models of the surfaces, and are kept where\n\
they meet one that is no mirror or glass. The image is the bare map: the density of photons at the first such surface. As .exr it\n\
states the map's own error, too: Map.StdErr, the standard deviation over maps, and Map.Bias, for the curvature of the light.\n\n\
The estimators, over the k nearest photons within r, u = (distance / r)^2:\n  \
k             k / (pi r^2): the textbook's, too large by k / (k - 1)\n  \
k-1           (k - 1) / (pi r^2): without the last, and unbiased (the default)\n  \
epanechnikov  2 (1 - u)\n  cone          3 (1 - sqrt u)\n  biweight      3 (1 - u)^2\n\n\
--json FILE: {\"schema\": 1, \"photons\", \"stored\", \"escaped\", \"absorbed\", \"hits\": {\"mean\", \"std_err\"}, \"flux\": {\"emitted\",\n\
\"absorbed\", \"escaped\", \"missing\"}, \"surfaces\": [{\"name\", \"area\", \"hits\", \"incident\", \"first\", \"absorbed\"}], \"seconds\": {…}}; flux\n\
is [r, g, b] in watts. --ply FILE: x y z, the direction to where it came from nx ny nz, red green blue in watts, bounces, shape.\n\n\
Examples:\n  whitefurnace photons cornell-original\n  \
whitefurnace photons cornell-original --photons 1000000 --k 200 --estimator epanechnikov -o map.png\n  \
whitefurnace photons scene.xml --map caustic --radius 0.02 -o caustic.exr --ply caustic.ply\n  \
whitefurnace photons cube-one-emitter --json - | jq .hits.mean";

/// The radius beyond which nothing is looked for, as a share of the scene's.
const REACH: f64 = 0.1;

/// A photon map: how many photons, and how their density is estimated.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(in crate::cli) struct MapArgs {
    /// Photons to be emitted, for a photon map; with --method sppm for each sample of a pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 36), default_value_t = 100_000)]
    pub(super) photons: u64,
    /// Take the K nearest photons (but none farther than a tenth of the scene's radius). Default: 50
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..), group = "around")]
    k: Option<u32>,
    /// Take all photons within this radius
    #[arg(long, value_name = "R", value_parser = positive, group = "around", allow_hyphen_values = true)]
    radius: Option<f64>,
    /// How photons are weighed
    #[arg(long, value_enum, default_value = "k-1")]
    pub(super) estimator: EstimatorArg,
}

/// How `render --method photon` gathers.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(in crate::cli) struct FinalGatherArgs {
    /// Rays of final gather from each surface that is seen, for --method photon
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..=1_000_000), default_value_t = 4)]
    gather_rays: u32,
    /// How fast the radius of --method sppm falls: its square with the passes to the power of A - 1, A in (0, 1)
    #[arg(long, value_name = "A", value_parser = exponent, default_value_t = ALPHA)]
    alpha: f64,
}

fn exponent(text: &str) -> Result<f64, String> {
    let inside = text.parse().ok().filter(|alpha: &f64| *alpha > 0.0 && *alpha < 1.0);
    inside.ok_or_else(|| "allowed is a number above 0 and below 1".into())
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(in crate::cli) enum EstimatorArg {
    K,
    #[value(name = "k-1")]
    KMinusOne,
    Epanechnikov,
    Cone,
    Biweight,
}

impl From<EstimatorArg> for Estimator {
    fn from(typed: EstimatorArg) -> Self {
        match typed {
            EstimatorArg::K => Self::K,
            EstimatorArg::KMinusOne => Self::KMinusOne,
            EstimatorArg::Epanechnikov => Self::Epanechnikov,
            EstimatorArg::Cone => Self::Cone,
            EstimatorArg::Biweight => Self::Biweight,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(in crate::cli) enum KeptArg {
    /// All photons
    Global,
    /// Those that met mirrors and glass alone, at least one
    Caustic,
    /// Those that were scattered by another surface before
    Indirect,
}

impl From<KeptArg> for Kept {
    fn from(typed: KeptArg) -> Self {
        match typed {
            KeptArg::Global => Self::Global,
            KeptArg::Caustic => Self::Caustic,
            KeptArg::Indirect => Self::Indirect,
        }
    }
}

impl MapArgs {
    pub(super) fn shooting(&self, kept: Kept, bounces: Option<u32>, seed: u64) -> Shooting {
        // Of r reflections the last is the estimate's.
        let bounces = bounces.map(|r| r.saturating_sub(1));
        Shooting { photons: self.photons, kept, bounces, seed, ..Shooting::default() }
    }

    /// The photons, at least one, and how they are gathered.
    pub(super) fn shot(&self, scene: &Scene, shooting: Shooting) -> Result<(Shot, Gather), PhotonError> {
        let shot = shooting.shoot(scene)?;
        if shot.photons.is_empty() {
            return Err(PhotonError::NothingReached { emitted: shooting.photons, map: shooting.kept.name() });
        }
        let estimator = Estimator::from(self.estimator);
        let around = match (self.radius, self.k) {
            (Some(radius), _) => Around::Radius(radius),
            (None, k) => {
                // Where none is asked for, as many as there are will do.
                let k = k.map_or(50.min(shot.photons.len()), |k| k as usize);
                let (_, radius) = scene.bounding_sphere();
                Around::Nearest { k, reach: if radius > 0.0 { REACH * radius } else { f64::INFINITY } }
            }
        };
        Ok((shot, Gather { around, estimator, ..Gather::default() }))
    }

    /// The map with final gather, and what it is, in words.
    pub(in crate::cli) fn gathered(
        &self,
        scene: &Scene,
        rays: FinalGatherArgs,
        bounces: Option<u32>,
        seed: u64,
    ) -> anyhow::Result<(FinalGather, String)> {
        let (shot, gather) = self.shot(scene, self.shooting(Kept::Global, bounces, seed)).context("--method photon")?;
        let rays = rays.gather_rays;
        let light = FinalGather::new(scene, &shot.photons, gather, rays, bounces).context("--method photon")?;
        Ok((light, format!("{} photons, {gather:?}, {rays} gather rays, {bounces:?} bounces", self.photons)))
    }

    /// A new map for every sample, and what that is, in words.
    pub(in crate::cli) fn progressive(
        &self,
        scene: &Scene,
        how: FinalGatherArgs,
        bounces: Option<u32>,
        seed: u64,
    ) -> anyhow::Result<(Sppm, String)> {
        let first = match (self.radius, self.k) {
            (Some(radius), _) => First::Radius(radius),
            (None, k) => First::Holds(k.unwrap_or(50) as usize),
        };
        let shooting = Shooting { photons: self.photons, seed, ..Shooting::default() };
        let plan = Sppm::new(scene, shooting, (first, self.estimator.into()), how.alpha, bounces);
        let plan = plan.context("--method sppm")?;
        Ok((plan, format!("{plan:?}")))
    }

    /// The map itself, and what it is, in words.
    pub(in crate::cli) fn viewed(
        &self,
        scene: &Scene,
        bounces: Option<u32>,
        seed: u64,
    ) -> anyhow::Result<(DirectView, String)> {
        let shooting = self.shooting(Kept::Global, bounces, seed);
        let (shot, gather) = self.shot(scene, shooting).context("--method photon-direct-view")?;
        let map = PhotonMap::new(scene, &shot.photons, gather).context("--method photon-direct-view")?;
        Ok((DirectView::new(map, bounces), format!("{} photons seen, {gather:?}, {bounces:?} bounces", self.photons)))
    }
}

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct PhotonsArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) of_map: MapArgs,
    /// Which photons are kept
    #[arg(long, value_enum, default_value = "global")]
    pub(super) map: KeptArg,
    /// An image of the density of photons to write (.exr, .pfm, .hdr, .png); may be given several times
    #[arg(short = 'o', long = "output", value_name = "IMAGE")]
    pub(super) outputs: Vec<PathBuf>,
    /// Write the photons as PLY
    #[arg(long, value_name = "FILE")]
    pub(super) ply: Option<PathBuf>,
    /// Write counts and flux as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(usize, usize)>,
    /// Samples per pixel of the image
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 24), default_value = "4")]
    pub(super) spp: u64,
    /// Stops by which the PNG is made brighter
    #[arg(long, value_name = "EV", value_parser = stops, default_value = "0", allow_hyphen_values = true)]
    pub(super) exposure: f64,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", value_parser = seed, default_value = "1", allow_hyphen_values = true)]
    pub(super) seed: u64,
    /// Threads to use; the result does not depend on it. Default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// No summary
    #[arg(long)]
    pub(super) quiet: bool,
}
