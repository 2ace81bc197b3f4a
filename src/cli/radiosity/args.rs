//! What `radiosity` and `view-factors` take, and what `render --method radiosity` shares with them.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, bail};
use clap::ValueEnum;

use crate::cli::args::{positive, seed, stops};
use crate::cli::render::size;
use crate::cli::scene_source::SceneArgs;
use crate::render::radiosity::factors::enforce::Enforce;
use crate::render::radiosity::factors::{Contour, Hemicube, MonteCarlo, Points, Rectangles, ViewFactors, Visibility};
use crate::render::radiosity::model::{DEFAULT_PATCHES, Radiosity};
use crate::render::radiosity::patches::{Fineness, Materials};
use crate::render::radiosity::solution::{Display, RadiositySolution};
use crate::render::radiosity::solve::{Method, Settings, SolveError};
use crate::scene::Scene;

pub(in crate::cli) const RADIOSITY_HELP: &str = "\
The surfaces must be diffuse, or be taken for it (--diffuse-approximation). Names of view factors: see\n\
`whitefurnace view-factors --help`.\n\n\
--json FILE: {\"schema\": 1, \"method\", \"patches\": N, \"surfaces\": [{\"name\", \"area\", \"B\": [r, g, b], \"H\": [r, g, b]}],\n\
\"energy\": {\"emitted\", \"absorbed\", \"escaped\"}, \"residual\", \"certified_bound\", \"iterations\", \"seconds\": {…}, …}. B and H are\n\
radiosity and irradiance, π times the radiance; an energy is the mean of the three channels, in energy.rgb by channel.\n\n\
Exit status: 0, or 3 where the tolerance or the error was not reached, 2 bad usage or input\n\n\
Examples:\n  whitefurnace radiosity cornell-original -o box.png\n  \
whitefurnace radiosity cornell-original -o gathered.exr --display gather --spp 64\n  \
whitefurnace radiosity cube-one-emitter --method jacobi --bounces 3 --json -\n  \
whitefurnace radiosity cornell-original --patches 16000 --method hierarchical --error 0.01";

pub(in crate::cli) const VIEW_FACTORS_HELP: &str = "\
The methods:\n  \
visibility   without occlusion by quadrature or contour, times the share of rays that get through (the default)\n  \
monte-carlo  rays by the cosine from all over the patch\n  \
hemicube     a picture of the scene from the patch's centre, randomly turned\n  \
point        projection onto the hemisphere of points of the patch\n  \
contour      contour integral of plane patches; what is in between is ignored\n  \
rectangles   closed form of rectangles in one frame; what is in between is ignored\n\n\
F_ij is the share of what patch i sends out that reaches patch j. Nothing is repaired but by --enforce, which says by how much.\n\n\
Examples:\n  whitefurnace view-factors cube-one-emitter --method rectangles --patches 6\n  \
whitefurnace view-factors cornell-original --method hemicube --patches 200 --csv > factors.csv\n  \
whitefurnace view-factors cornell-original --method monte-carlo --rays 100000 --json | jq .row_sums";

/// How a scene is cut, and what is taken for diffuse.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct MeshArgs {
    /// About how many patches the scene is cut into
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 22), group = "fineness")]
    patches: Option<u64>,
    /// Area of a patch, instead of their number
    #[arg(long, value_name = "A", value_parser = positive, group = "fineness")]
    patch_area: Option<f64>,
    /// Take every material for a diffuse one of the same albedo
    #[arg(long)]
    diffuse_approximation: bool,
}

impl MeshArgs {
    pub(in crate::cli) fn fineness(&self, default: usize) -> Fineness {
        match (self.patches, self.patch_area) {
            (_, Some(area)) => Fineness::Area(area),
            (count, None) => Fineness::Count(count.map_or(default, |count| count as usize)),
        }
    }

    pub(in crate::cli) fn materials(&self) -> Materials {
        if self.diffuse_approximation { Materials::Approximated } else { Materials::Diffuse }
    }
}

/// How view factors are found, the method apart.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct FactorArgs {
    /// Rays from each patch, for monte-carlo
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 32), default_value_t = MonteCarlo::default().rays)]
    rays: u64,
    /// Cells along the side of a hemicube
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=4096), default_value_t = Hemicube::default().resolution)]
    resolution: u16,
    /// Points along each side of a patch, for point
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), default_value_t = Points::default().across)]
    points: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", value_parser = seed, default_value = "1", allow_hyphen_values = true)]
    pub(super) seed: u64,
    /// Make the factors obey a law, and say by how much that changes them
    #[arg(long, value_enum)]
    enforce: Option<EnforceArg>,
    /// The most that view factors or links may take, in MiB
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 24), default_value = "2048")]
    max_memory: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(in crate::cli) enum FactorMethod {
    Visibility,
    MonteCarlo,
    Hemicube,
    Point,
    Contour,
    Rectangles,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum EnforceArg {
    /// A_i F_ij = A_j F_ji
    Reciprocity,
    /// The same, and rows sum to what reaches any patch
    Closure,
}

impl FactorArgs {
    pub(in crate::cli) fn method(&self, name: FactorMethod) -> Box<dyn ViewFactors> {
        match name {
            FactorMethod::Visibility => Box::new(Visibility { seed: self.seed, ..Visibility::default() }),
            FactorMethod::MonteCarlo => Box::new(MonteCarlo { rays: self.rays, seed: self.seed }),
            FactorMethod::Hemicube => Box::new(Hemicube { resolution: self.resolution, seed: self.seed }),
            FactorMethod::Point => Box::new(Points { across: self.points, seed: self.seed }),
            FactorMethod::Contour => Box::new(Contour),
            FactorMethod::Rectangles => Box::new(Rectangles),
        }
    }

    pub(in crate::cli) fn enforce(&self) -> Option<Enforce> {
        self.enforce.map(|typed| match typed {
            EnforceArg::Reciprocity => Enforce::Reciprocity,
            EnforceArg::Closure => Enforce::Closure,
        })
    }

    /// Bytes.
    pub(in crate::cli) fn memory(&self) -> u64 {
        self.max_memory << 20
    }
}

/// What solves the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Solver {
    /// A matrix of all view factors, and a solver of its equations.
    Matrix(Method),
    Hierarchical,
}

impl Solver {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Matrix(method) => method.name(),
            Self::Hierarchical => "hierarchical",
        }
    }
}

impl FromStr for Solver {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name == Self::Hierarchical.name() {
            return Ok(Self::Hierarchical);
        }
        name.parse().map(Self::Matrix).map_err(|error: SolveError| format!("{error}, and hierarchical"))
    }
}

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct RadiosityArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
    /// Make patches finer where the light changes, at borders of shadows and along edges; as many in the end
    #[arg(long)]
    pub(super) adaptive: bool,
    /// The solver: dense, jacobi, gauss-seidel, cg, southwell or hierarchical. Default: jacobi with --bounces, else gauss-seidel
    #[arg(long, value_name = "NAME")]
    method: Option<Solver>,
    /// Error to be reached by hierarchical: root mean square by area, relative to what is reflected, against patches that are all
    /// as small as --patches allows. Default: 0.01
    #[arg(long, value_name = "E", value_parser = positive, allow_hyphen_values = true)]
    pub(super) error: Option<f64>,
    /// Where the view factors come from. Default: visibility
    #[arg(long, value_enum, value_name = "NAME")]
    view_factors: Option<FactorMethod>,
    #[command(flatten)]
    pub(super) factors: FactorArgs,
    /// Exactly so many reflections (jacobi, hierarchical)
    #[arg(long, value_name = "R")]
    pub(super) bounces: Option<u32>,
    /// Certified error of the solution of the equations, relative to the largest radiosity
    #[arg(long, value_name = "T", value_parser = positive, default_value = "1e-10", allow_hyphen_values = true)]
    pub(super) tol: f64,
    /// Write the light of each surface as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Add every patch to the JSON
    #[arg(long)]
    pub(super) per_patch: bool,
    /// An image to write (.exr, .pfm, .hdr, .png); may be given several times
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(super) outputs: Vec<PathBuf>,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(usize, usize)>,
    /// Samples per pixel of the image
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 24), default_value = "16")]
    pub(super) spp: u64,
    /// How the solution is shown
    #[arg(long, value_enum, default_value = "patches")]
    pub(super) display: DisplayArg,
    /// Stops by which the PNG is made brighter
    #[arg(long, value_name = "EV", value_parser = stops, default_value = "0", allow_hyphen_values = true)]
    pub(super) exposure: f64,
    /// No summary
    #[arg(long)]
    pub(super) quiet: bool,
}

impl RadiosityArgs {
    pub(super) fn solver(&self) -> Solver {
        let default = if self.bounces.is_some() { Method::Jacobi } else { Method::GaussSeidel };
        self.method.unwrap_or(Solver::Matrix(default))
    }

    pub(super) fn view_factors(&self) -> FactorMethod {
        self.view_factors.unwrap_or(FactorMethod::Visibility)
    }

    /// Refuses what the solver would not heed.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let unheeded = match self.solver() {
            Solver::Matrix(_) => [("--error", self.error.is_some())].to_vec(),
            Solver::Hierarchical => [
                ("--view-factors", self.view_factors.is_some()),
                ("--adaptive", self.adaptive),
                ("--enforce", self.factors.enforce.is_some()),
            ]
            .to_vec(),
        };
        match unheeded.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => bail!("{option}: means nothing to --method {}", self.solver().name()),
            None => Ok(()),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum DisplayArg {
    /// Each patch in its own radiosity
    Patches,
    /// Interpolated between corners: cosmetic
    Smooth,
    /// One final gather
    Gather,
    /// One final gather of what is reflected, with direct light by connections
    GatherDirect,
}

impl From<DisplayArg> for Display {
    fn from(typed: DisplayArg) -> Self {
        match typed {
            DisplayArg::Patches => Self::Patches,
            DisplayArg::Smooth => Self::Smooth,
            DisplayArg::Gather => Self::Gather,
            DisplayArg::GatherDirect => Self::GatherDirect,
        }
    }
}

/// A solution that is to be rendered.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct DisplayArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// Make patches finer where the light changes, at borders of shadows and along edges; as many in the end
    #[arg(long)]
    adaptive: bool,
    /// How a radiosity solution is shown
    #[arg(long, value_enum, default_value = "patches")]
    display: DisplayArg,
}

impl DisplayArgs {
    /// The solution for the scene, of exactly so many reflections or all, and what it is, in words.
    pub(in crate::cli) fn solve(
        &self,
        scene: &Scene,
        bounces: Option<u32>,
        seed: u64,
    ) -> anyhow::Result<(RadiositySolution, String)> {
        let model = Radiosity {
            fineness: self.mesh.fineness(DEFAULT_PATCHES),
            adaptive: self.adaptive,
            materials: self.mesh.materials(),
            factors: Box::new(Visibility { seed, ..Visibility::default() }),
            method: if bounces.is_some() { Method::Jacobi } else { Method::GaussSeidel },
            settings: Settings { bounces, ..Settings::default() },
            ..Radiosity::default()
        };
        let solved = model.solve(scene).context("--method radiosity")?;
        let how =
            format!("radiosity of {} patches, {bounces:?} bounces, {:?}", solved.patches.all().len(), self.display);
        Ok((solved.shown(self.display.into()), how))
    }
}

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct ViewFactorsArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
    /// How they are found
    #[arg(long, value_enum, default_value = "visibility")]
    pub(super) method: FactorMethod,
    #[command(flatten)]
    pub(super) factors: FactorArgs,
    /// Print everything as JSON
    #[arg(long, group = "form")]
    pub(super) json: bool,
    /// Print the factors that are not 0 as CSV
    #[arg(long, group = "form")]
    pub(super) csv: bool,
}
