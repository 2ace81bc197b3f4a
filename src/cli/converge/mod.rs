//! `whitefurnace converge`: the error of estimators against the number of samples.

mod files;
mod image;
mod kept;
mod rows;

use std::io::Write;
use std::path::PathBuf;

use anyhow::{anyhow, bail};

use super::Status;
use super::args;
use super::subjects::{self, Subject};
use super::validate::print;
use crate::bsdf::subject::nearest_name;
use crate::converge::{Estimator, Study, Target, albedo, irradiance};
use crate::integrate::is_two_faced;
use crate::math::sphere::direction_mu;
use crate::sampling::sampler::SamplerKind;

use files::Files;
use rows::{Row, Subject as Studied};

/// What `converge` takes.
#[derive(Debug, clap::Args)]
pub(super) struct ConvergeArgs {
    /// albedo:SUBJECT@MU, irradiance:NAME, scene:SCENE or scene:SCENE@X,Y
    #[arg(value_name = "TARGET")]
    target: String,
    /// Estimators, separated by commas. Default: all that the target has; of a scene, mis
    #[arg(long, value_name = "E,…", value_delimiter = ',')]
    estimator: Vec<String>,
    /// Samplers, separated by commas: those of `render`
    #[arg(long, value_name = "S,…", value_delimiter = ',', value_parser = args::sampler, default_value = "independent")]
    sampler: Vec<SamplerKind>,
    /// Numbers of samples: every power of two from FROM to TO. Default: 16..16384; of a whole image, 4..256
    #[arg(long, value_name = "FROM..TO", value_parser = range)]
    n: Option<(u64, u64)>,
    /// Means or images of each number of samples, 2 to 65536. Default: 64; of a whole image, 16
    #[arg(long, value_name = "R", value_parser = replicates)]
    replicates: Option<u64>,
    /// Probability that any rate that is as theory says is called different
    #[arg(long, value_name = "P", value_parser = args::level, default_value_t = 1e-3, allow_hyphen_values = true)]
    level: f64,
    /// Seed of every random number
    #[arg(long, value_name = "N", value_parser = args::seed, default_value_t = 1)]
    seed: u64,
    /// Folder for convergence.csv, .json, .svg and .png; it is made where it is not there. A study of a scene that was
    /// interrupted goes on from what it has left there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Rank by the error at equal time, not at equal numbers of samples
    #[arg(long)]
    equal_time: bool,
    #[command(flatten)]
    image: image::ImageArgs,
}

const DEFAULT_RANGE: (u64, u64) = (16, 16_384);
const DEFAULT_REPLICATES: u64 = 64;

/// A mean takes no more samples: 2³⁰.
const MOST_SAMPLES: u64 = 1 << 30;

fn range(text: &str) -> Result<(u64, u64), String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some((from.trim().parse().ok()?, to.trim().parse().ok()?)));
    ends.filter(|&(from, to)| 1 <= from && from <= to && to <= MOST_SAMPLES)
        .ok_or_else(|| format!("allowed is FROM..TO with 1 <= FROM <= TO <= {MOST_SAMPLES}"))
}

fn replicates(text: &str) -> Result<u64, String> {
    let n = text.parse().ok().filter(|n| (2..=65_536).contains(n));
    n.ok_or_else(|| "allowed is a whole number from 2 to 65536".into())
}

/// The powers of two from the one to the other.
fn counts((from, to): (u64, u64)) -> Vec<u64> {
    (0..=MOST_SAMPLES.ilog2()).map(|k| 1 << k).filter(|n| (from..=to).contains(n)).collect()
}

pub(super) fn run(args: &ConvergeArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    if let Some(scene) = args.target.strip_prefix("scene:") {
        return image::run(args, scene, out);
    }
    if let Some(option) = args.image.any() {
        bail!("{option}: {} is no scene:SCENE", args.target);
    }
    let subject;
    let target = match args.target.split_once(':') {
        Some(("albedo", rest)) => {
            let (model, mu) = subject_and_mu(rest)?;
            subject = model;
            albedo::albedo(&format!("albedo:{}@{mu}", subject.name), &subject.bsdf, direction_mu(mu, 0.0))
        }
        Some(("irradiance", name)) => irradiance::irradiance(name).ok_or_else(|| {
            let known = irradiance::NAMES.iter().map(|(name, _)| *name);
            anyhow!("irradiance:{name}: no such light; {}", nearest_name(name, known))
        })?,
        _ => bail!("{}: no such target; allowed are albedo:SUBJECT@MU, irradiance:NAME and scene:SCENE", args.target),
    };
    let estimators = chosen(&target, &args.estimator)?;
    let files = args.out.as_deref().map(Files::new).transpose()?;
    let counts = counts(args.n.unwrap_or(DEFAULT_RANGE));
    let replicates = args.replicates.unwrap_or(DEFAULT_REPLICATES);
    let level = args.level / (args.sampler.len() * estimators.len()) as f64;
    let mut rows = Vec::new();
    for &sampler in &args.sampler {
        for estimator in &estimators {
            let number = rows.len() as u64;
            let study = Study { counts: counts.clone(), replicates, seed: args.seed, number, sampler };
            let found = study.run(estimator, target.exact, target.error);
            rows.push(Row::of_target(estimator, &found, level));
        }
    }
    let studied = Studied {
        name: target.name.clone(),
        exact: target.exact,
        error: target.error,
        seed: args.seed,
        replicates,
        image: None,
    };
    print(out, &rows::text(&studied, &rows, args.equal_time))?;
    if let Some(files) = files {
        files.write(&studied, &rows)?;
    }
    Ok(rows::status(&rows))
}

fn subject_and_mu(text: &str) -> anyhow::Result<(Subject, f64)> {
    // A file's name may hold an @ too; the last one counts.
    let (model, mu) = text.rsplit_once('@').unwrap_or((text, "0.5"));
    let subject = subjects::load_one(model)?;
    let lit_from_below = is_two_faced(&subject.bsdf);
    let value = mu.parse().ok().filter(|mu: &f64| mu.abs() <= 1.0 && (*mu > 0.0 || (lit_from_below && *mu < 0.0)));
    match value {
        Some(mu) => Ok((subject, mu)),
        None => bail!(
            "albedo:{model}@{mu}: allowed after @ is a cosine in (0, 1]{}",
            if lit_from_below { ", or in [-1, 0)" } else { "" }
        ),
    }
}

fn chosen<'a>(target: &'a Target<'a>, names: &[String]) -> anyhow::Result<Vec<&'a Estimator<'a>>> {
    if names.is_empty() {
        return Ok(target.estimators.iter().collect());
    }
    let find = |name: &String| {
        target.estimators.iter().find(|estimator| estimator.name == name.trim()).ok_or_else(|| {
            let known = target.estimators.iter().map(|estimator| estimator.name);
            anyhow!("--estimator {name}: {} has no such estimator; {}", target.name, nearest_name(name, known))
        })
    };
    names.iter().map(find).collect()
}
