//! `whitefurnace converge`: the error of estimators against the number of samples.

use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use serde::Serialize;

use super::Status;
use super::args;
use super::job;
use super::subjects::{self, Subject};
use super::validate::print;
use crate::bsdf::subject::nearest_name;
use crate::converge::study::CONFIDENCE;
use crate::converge::{Convergence, Estimator, Study, Target, Theory, Verdict, albedo, irradiance};
use crate::integrate::is_two_faced;
use crate::math::sphere::direction_mu;
use crate::report::plot::{Curve, convergence};
use crate::report::table::{Align, Table, exact, short};
use crate::sampling::sampler::SamplerKind;

/// What `converge` takes.
#[derive(Debug, clap::Args)]
pub(super) struct ConvergeArgs {
    /// albedo:SUBJECT@MU or irradiance:NAME
    #[arg(value_name = "TARGET")]
    target: String,
    /// Estimators, separated by commas. Default: all that the target has
    #[arg(long, value_name = "E,…", value_delimiter = ',')]
    estimator: Vec<String>,
    /// Samplers, separated by commas
    #[arg(long, value_name = "S,…", value_delimiter = ',', default_value = "independent")]
    sampler: Vec<String>,
    /// Numbers of samples: every power of two from FROM to TO
    #[arg(long, value_name = "FROM..TO", value_parser = range, default_value = "16..16384")]
    n: (u64, u64),
    /// Means of each number of samples, 2 to 65536
    #[arg(long, value_name = "R", value_parser = replicates, default_value_t = 64)]
    replicates: u64,
    /// Probability that any rate that is as theory says is called different
    #[arg(long, value_name = "P", value_parser = args::level, default_value_t = 1e-3, allow_hyphen_values = true)]
    level: f64,
    /// Seed of every random number
    #[arg(long, value_name = "N", value_parser = args::seed, default_value_t = 1)]
    seed: u64,
    /// Folder for convergence.csv, .json, .svg and .png; it is made where it is not there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Rank by the error at equal time, not at equal numbers of samples
    #[arg(long)]
    equal_time: bool,
}

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

/// One estimator with one sampler.
struct Row<'a> {
    estimator: &'a Estimator<'a>,
    sampler: &'static str,
    theory: Theory,
    found: Convergence,
    verdict: Verdict,
}

pub(super) fn run(args: &ConvergeArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
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
        _ => bail!("{}: no such target; allowed are albedo:SUBJECT@MU and irradiance:NAME", args.target),
    };
    let estimators = chosen(&target, &args.estimator)?;
    let samplers = args.sampler.iter().map(|name| sampler(name)).collect::<anyhow::Result<Vec<_>>>()?;
    let files = args.out.as_deref().map(Files::new).transpose()?;
    let counts: Vec<u64> =
        (0..=MOST_SAMPLES.ilog2()).map(|k| 1 << k).filter(|n| (args.n.0..=args.n.1).contains(n)).collect();
    let mut rows = Vec::new();
    for &(name, sampler) in &samplers {
        for estimator in &estimators {
            let number = rows.len() as u64;
            let study = Study { counts: counts.clone(), replicates: args.replicates, seed: args.seed, number, sampler };
            let found = study.run(estimator, target.exact, target.error);
            let theory = Theory::of(sampler);
            let verdict = found.verdict(&theory, args.level / (samplers.len() * estimators.len()) as f64);
            rows.push(Row { estimator, sampler: name, theory, found, verdict });
        }
    }
    print(out, &text(&target, &rows, args.equal_time))?;
    if let Some(files) = files {
        files.write(&target, &rows, args)?;
    }
    let any = |wanted: fn(&Verdict) -> bool| rows.iter().any(|row| wanted(&row.verdict));
    Ok(if any(|v| matches!(v, Verdict::Differs)) {
        Status::Fail
    } else if any(|v| !matches!(v, Verdict::Agrees)) {
        Status::Inconclusive
    } else {
        Status::Pass
    })
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

fn sampler(name: &str) -> anyhow::Result<(&'static str, SamplerKind)> {
    SamplerKind::ALL.iter().copied().find(|(known, _)| *known == name.trim()).ok_or_else(|| {
        let known = SamplerKind::ALL.iter().map(|(name, _)| *name);
        anyhow!("--sampler {name}: no such sampler; {}", nearest_name(name, known))
    })
}

/// What the verdict is called.
fn verdict(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "agrees",
        Verdict::Differs => "differs",
        Verdict::HeavyTail => "heavy tail",
        Verdict::Insufficient(_) => "insufficient data",
    }
}

fn theory(theory: &Theory) -> String {
    if theory.steepest == theory.flattest {
        format!("{}", theory.flattest)
    } else if theory.steepest.is_infinite() {
        format!("{} or less", theory.flattest)
    } else {
        format!("{} to {}", theory.steepest, theory.flattest)
    }
}

fn text(target: &Target, rows: &[Row], equal_time: bool) -> String {
    let mut text = format!("{}: {} ± {:.0e}\n", target.name, exact(target.exact), target.error);
    let heads = ["estimator", "sampler", "slope", "theory", "sigma", "known", "ns", "efficiency", "verdict"];
    let mut table = Table::new(
        &heads.map(|h| (h, if ["estimator", "sampler", "verdict"].contains(&h) { Align::Left } else { Align::Right })),
    );
    for row in rows {
        let slope = row.found.fit.map_or("-".into(), |f| format!("{:.3} ± {:.3}", f.slope, f.half_width(CONFIDENCE)));
        table.row([
            row.estimator.name.into(),
            row.sampler.into(),
            slope,
            theory(&row.theory),
            short(row.found.samples.variance().sqrt()),
            row.estimator.sigma.map_or("-".into(), short),
            format!("{:.0}", row.found.seconds * 1e9),
            short(row.found.efficiency()),
            verdict(&row.verdict).into(),
        ]);
    }
    text.push_str(&table.text("  "));
    for row in rows {
        if let Verdict::Insufficient(why) = &row.verdict {
            let _ = writeln!(text, "  {} with {}: {why}", row.estimator.name, row.sampler);
        }
    }
    let cost = |row: &Row| row.found.variance() * if equal_time { row.found.seconds } else { 1.0 };
    if let Some(best) = rows.iter().filter(|row| cost(row).is_finite()).min_by(|a, b| cost(a).total_cmp(&cost(b))) {
        let at = if equal_time { "time" } else { "number of samples" };
        let _ = writeln!(text, "  the least error at equal {at}: {} with {}", best.estimator.name, best.sampler);
    }
    text
}

/// The files of a study, all in one folder.
struct Files {
    csv: crate::report::save::Target,
    json: crate::report::save::Target,
    svg: crate::report::save::Target,
    png: crate::report::save::Target,
}

#[derive(Serialize)]
struct Report<'a> {
    schema: u32,
    target: &'a str,
    exact: f64,
    error: f64,
    seed: u64,
    replicates: u64,
    studies: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    estimator: &'a str,
    sampler: &'a str,
    slope: Option<f64>,
    slope_half_width: Option<f64>,
    confidence: f64,
    theory: [f64; 2],
    verdict: &'static str,
    sigma: f64,
    sigma_exact: Option<f64>,
    excess_kurtosis: f64,
    seconds_per_sample: f64,
    efficiency: f64,
    points: Vec<Measured>,
}

#[derive(Serialize)]
struct Measured {
    n: u64,
    rmse: f64,
    log_std_err: f64,
    mean: f64,
    std_err: f64,
}

impl Files {
    fn new(folder: &Path) -> anyhow::Result<Self> {
        let shown = folder.display();
        fs::create_dir_all(folder).with_context(|| format!("--out {shown}: cannot be made"))?;
        let file = |name: &str| job::target("--out", folder.join(name));
        Ok(Self {
            csv: file("convergence.csv")?,
            json: file("convergence.json")?,
            svg: file("convergence.svg")?,
            png: file("convergence.png")?,
        })
    }

    fn write(&self, target: &Target, rows: &[Row], args: &ConvergeArgs) -> anyhow::Result<()> {
        let entry = |row: &Row| Entry {
            estimator: row.estimator.name,
            sampler: row.sampler,
            slope: row.found.fit.map(|fit| fit.slope),
            slope_half_width: row.found.fit.map(|fit| fit.half_width(CONFIDENCE)),
            confidence: CONFIDENCE,
            theory: [row.theory.steepest, row.theory.flattest],
            verdict: verdict(&row.verdict),
            sigma: row.found.samples.variance().sqrt(),
            sigma_exact: row.estimator.sigma,
            excess_kurtosis: row.found.samples.excess_kurtosis(),
            seconds_per_sample: row.found.seconds,
            efficiency: row.found.efficiency(),
            points: row
                .found
                .points
                .iter()
                .map(|p| Measured {
                    n: p.n,
                    rmse: p.rmse,
                    log_std_err: p.log_std_err,
                    mean: p.mean,
                    std_err: p.std_err,
                })
                .collect(),
        };
        let report = Report {
            schema: 1,
            target: &target.name,
            exact: target.exact,
            error: target.error,
            seed: args.seed,
            replicates: args.replicates,
            studies: rows.iter().map(entry).collect(),
        };
        let json = serde_json::to_string_pretty(&report)? + "\n";
        self.json.write(json.as_bytes()).context("--out: cannot be written")?;
        self.csv.write(csv(rows).as_bytes()).context("--out: cannot be written")?;
        let curves: Vec<Curve> = rows.iter().map(|row| curve(row, args.sampler.len() > 1)).collect();
        let figure = convergence(&curves);
        self.svg.write(figure.svg()?.as_bytes()).context("--out: cannot be written")?;
        self.png.write(&figure.png()?).context("--out: cannot be written")
    }
}

fn csv(rows: &[Row]) -> String {
    let heads = ["estimator", "sampler", "n", "rmse", "log_std_err", "mean", "std_err"];
    let mut table = Table::new(&heads.map(|name| (name, Align::Right)));
    for row in rows {
        for p in &row.found.points {
            table.row([
                row.estimator.name.into(),
                row.sampler.into(),
                p.n.to_string(),
                exact(p.rmse),
                exact(p.log_std_err),
                exact(p.mean),
                exact(p.std_err),
            ]);
        }
    }
    table.csv()
}

fn curve(row: &Row, name_sampler: bool) -> Curve {
    Curve {
        name: if name_sampler { format!("{}, {}", row.estimator.name, row.sampler) } else { row.estimator.name.into() },
        points: row.found.points.iter().map(|p| (p.n as f64, p.rmse, p.log_std_err)).collect(),
        // A logarithmic axis has no place for 0.
        sigma: row.estimator.sigma.filter(|&sigma| sigma > 0.0 && row.found.sampler == SamplerKind::Independent),
        theory: [row.theory.steepest, row.theory.flattest],
    }
}
