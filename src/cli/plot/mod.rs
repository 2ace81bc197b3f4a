//! `whitefurnace plot`: one plot as a file.

mod curves;
mod studies;

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, bail};

use super::Status;
use super::args::{draws, finite, seed};
use super::job;
use super::subjects;
use crate::image::Image;
use crate::integrate::Side;
use crate::report::plot::{self, Figure};
use crate::report::probe;
use crate::report::save::Target;

const EXAMPLES: &str = "Examples:\n  \
    whitefurnace plot albedo phong:n=100,norm=n+1,divide=true -o two_sides.svg\n  \
    whitefurnace plot lobes ggx:alpha=0.3 -o lobes.png\n  \
    whitefurnace converge irradiance:unit-square --out study && whitefurnace plot convergence study/convergence.json\n  \
    whitefurnace render cornell-original -o box.exr && whitefurnace plot variance box.exr -o variance.png\n  \
    whitefurnace plot roulette --rho 0.9\n  \
    whitefurnace plot stores -o stores.png";

/// What `plot` takes.
#[derive(Debug, clap::Args)]
// A missing KIND is one line, as everywhere, and not the whole help.
#[command(arg_required_else_help = false, after_help = EXAMPLES)]
pub(super) struct PlotArgs {
    #[command(subcommand)]
    kind: Kind,
}

#[derive(Debug, clap::Subcommand)]
enum Kind {
    /// Error against number of samples, with σ/√N where σ is known and the slopes of theory
    #[command(after_help = "Examples:\n  whitefurnace plot convergence study/convergence.json -o figure.png")]
    Convergence {
        /// convergence.json of `converge --out`; convergence.csv holds no theory
        #[arg(value_name = "FILE")]
        file: PathBuf,
        #[command(flatten)]
        out: Out,
    },
    /// Albedo against angle, from the side of the eye and of the light
    #[command(after_help = "Examples:\n  whitefurnace plot albedo phong:n=100,norm=n+1,divide=true")]
    Albedo {
        #[command(flatten)]
        model: Model,
        #[command(flatten)]
        out: Out,
    },
    /// f·cos in the plane of incidence, for the eye at 0°, 30°, 60° and 80°
    #[command(after_help = "Examples:\n  whitefurnace plot lobes ggx:alpha=0.3 -o lobes.png")]
    Lobes {
        #[command(flatten)]
        model: Model,
        #[command(flatten)]
        out: Out,
    },
    /// Relative gap between f(a, b) and f(b, a)
    #[command(after_help = "Examples:\n  whitefurnace plot asymmetry phong:n=100,norm=n+1,divide=true")]
    Asymmetry {
        #[command(flatten)]
        model: Model,
        #[command(flatten)]
        out: Out,
    },
    /// Where a sampler's draws fall, against where its pdf says they do
    #[command(after_help = "Examples:\n  whitefurnace plot histogram ggx:alpha=0.1 --theta 80 -o ggx.png")]
    Histogram {
        #[command(flatten)]
        model: Model,
        /// Angle of the eye from the normal in degrees, 0 to 90
        #[arg(long, value_name = "DEG", value_parser = angle, default_value = "60")]
        theta: f64,
        /// Number of draws
        #[arg(short = 'n', value_name = "N", value_parser = draws, default_value = "100000")]
        n: u64,
        /// Seed of the random numbers
        #[arg(long, value_name = "N", value_parser = seed, default_value_t = 1)]
        seed: u64,
        #[command(flatten)]
        out: Out,
    },
    /// The variances of a rendering's pixels in false colours
    #[command(
        after_help = "The variance of the mean of each pixel, averaged over the channels: the planes Variance.R, .G and \
        .B that\n`render` writes into an EXR, or the colours of a PFM whose colours are variances.\n\nExamples:\n  \
        whitefurnace plot variance box.exr -o variance.png"
    )]
    Variance {
        /// An EXR with variances, or a PFM of variances
        #[arg(value_name = "IMAGE")]
        image: PathBuf,
        #[command(flatten)]
        out: Out,
    },
    /// Variance against the number of continuations of a path's first event, with the law V0 + V1/M
    #[command(
        after_help = "Without --scene: a pixel that sees a floor, its albedo growing from 0 to 1, under the light of \
        irradiance:unit-square;\nV0 and V1 are known there. With it: a pixel of the scene, rendered by the path \
        tracer.\n\nExamples:\n  whitefurnace plot first-split\n  \
        whitefurnace plot first-split --scene cornell-original --size 4x4 --pixel 1,2 -n 16384 -o split.png"
    )]
    FirstSplit(studies::FirstSplit),
    /// Variance of Russian roulette in a furnace against the probability of going on
    #[command(after_help = "Examples:\n  whitefurnace plot roulette --rho 0.9 -o roulette.png")]
    Roulette(studies::Roulette),
    /// Links of hierarchical radiosity against the number of elements, for errors held fixed, with the fitted exponents
    #[command(after_help = "Examples:\n  whitefurnace plot links -o links.png\n  \
        whitefurnace plot links --scene cube-one-emitter --most 20000")]
    Links(studies::Links),
    /// Seconds to find the nearest photons by scan, hash grid and k-d tree against the number of photons, with the fitted exponents
    #[command(
        after_help = "What is found is the same for all three, and for the same seed in every run; the seconds are not: of up to \
        five runs\nthe quickest counts. A search takes one thread, building all of them. A scan is asked fewer \
        times than the others.\nWhile photons are few it spends more on keeping the nearest than on looking at all: its slope \
        grows to 1.\n\nExamples:\n  whitefurnace plot stores -o stores.png\n  \
        whitefurnace plot stores --scene veach-mis -k 50 --most 10000000"
    )]
    Stores(studies::Stores),
}

#[derive(Debug, clap::Args)]
struct Model {
    /// A model, as for `validate`, or a file with one model
    #[arg(value_name = "SUBJECT")]
    subject: String,
}

#[derive(Debug, clap::Args)]
struct Out {
    /// Picture to write: .svg, or .png at double density. Default: the kind's name with .svg
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A file of a kind that is known to be writable.
struct Picture {
    target: Target,
    path: PathBuf,
    png: bool,
}

impl Out {
    /// Found before anything is computed.
    fn picture(&self, kind: &str) -> anyhow::Result<Picture> {
        let path = self.out.clone().unwrap_or_else(|| format!("{kind}.svg").into());
        let shown = path.display();
        let png = match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
            Some("svg") => false,
            Some("png") => true,
            _ => bail!("--out {shown}: allowed is a name that ends in .svg or .png"),
        };
        Ok(Picture { target: job::target("--out", path.clone())?, path, png })
    }
}

impl Picture {
    fn write(&self, figure: &Figure<'_>, out: &mut dyn Write) -> anyhow::Result<()> {
        let content = if self.png { figure.png()? } else { figure.svg()?.into_bytes() };
        let shown = self.path.display();
        self.target.write(&content).with_context(|| format!("--out {shown}: cannot be written"))?;
        writeln!(out, "wrote {shown}")?;
        Ok(())
    }
}

fn angle(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|deg| (0.0..=90.0).contains(deg)).ok_or_else(|| "allowed is a number from 0 to 90".into())
}

pub(super) fn run(args: &PlotArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    match &args.kind {
        Kind::Convergence { file, out: to } => {
            let picture = to.picture("convergence")?;
            picture.write(&plot::convergence(&curves::read(file)?), out)?;
        }
        Kind::Albedo { model, out: to } => {
            let (picture, bsdf) = (to.picture("albedo")?, subjects::load_one(&model.subject)?.bsdf);
            let [eye, light] = [Side::Eye, Side::Light].map(|side| probe::albedo_curve(&bsdf, side));
            picture.write(&plot::albedo(&eye, &light), out)?;
        }
        Kind::Lobes { model, out: to } => {
            let (picture, bsdf) = (to.picture("lobes")?, subjects::load_one(&model.subject)?.bsdf);
            let lobes = plot::LOBE_ANGLES.map(|deg| probe::lobe(&bsdf, deg.to_radians()));
            picture.write(&plot::lobes(&lobes), out)?;
        }
        Kind::Asymmetry { model, out: to } => {
            let (picture, bsdf) = (to.picture("asymmetry")?, subjects::load_one(&model.subject)?.bsdf);
            picture.write(&plot::asymmetry(&probe::asymmetry(&bsdf)), out)?;
        }
        Kind::Histogram { model, theta, n, seed, out: to } => {
            let (picture, bsdf) = (to.picture("histogram")?, subjects::load_one(&model.subject)?.bsdf);
            let histogram = probe::histogram(&bsdf, theta.to_radians(), *n, *seed);
            picture.write(&plot::histogram(&histogram), out)?;
        }
        Kind::Variance { image, out: to } => {
            let picture = to.picture("variance")?;
            let read = Image::read(image)?;
            let is_pfm = image.extension().is_some_and(|e| e.eq_ignore_ascii_case("pfm"));
            let planes = read.variance().or_else(|| read.colour().filter(|_| is_pfm));
            let [r, g, b] = planes.with_context(|| {
                let shown = image.display();
                format!("{shown}: holds no variances; allowed is an EXR with planes Variance.R, .G and .B, as render writes it")
            })?;
            let mean = |at: usize| [r, g, b].iter().map(|plane| f64::from(plane[at])).sum::<f64>() / 3.0;
            let values: Vec<f64> = (0..r.len()).map(mean).collect();
            picture.write(&plot::variance(read.width(), &values, "variance of the mean"), out)?;
        }
        Kind::FirstSplit(args) => studies::first_split(args, out)?,
        Kind::Roulette(args) => studies::roulette(args, out)?,
        Kind::Links(args) => studies::links(args, out)?,
        Kind::Stores(args) => studies::stores(args, out)?,
    }
    Ok(Status::Pass)
}
