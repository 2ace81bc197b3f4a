//! What was meant: loaded models, directions in radians, known checks. Everything that can be wrong is found here.

use std::f64::consts::TAU;
use std::path::PathBuf;

use anyhow::{anyhow, bail};
use glam::DVec3;

use super::args::{AlbedoArgs, AlbedoFormat, EffortArg, EvalArgs, SampleArgs, SideArg, ValidateArgs};
use super::subjects::{self, Subject};
use crate::bsdf::subject::nearest_name;
use crate::integrate::{Hemisphere, Side, is_two_faced};
use crate::math::sphere::direction;
use crate::report::save::Target;
use crate::validate::{CHECKS, Effort, Suite};

/// `validate`: which models, how, and where the reports go.
#[derive(Debug)]
pub(super) struct Validate {
    pub(super) subjects: Vec<Subject>,
    pub(super) suite: Suite,
    pub(super) json: Option<Sink>,
    pub(super) html: Option<Target>,
}

/// Where a report goes.
#[derive(Debug)]
pub(super) enum Sink {
    Stdout,
    File(Target),
}

pub(super) fn validate(args: ValidateArgs) -> anyhow::Result<Validate> {
    let mut typed = args.subjects;
    let mut only = Vec::new();
    for text in args.checks {
        let names: Vec<_> = text.split(',').map(check_name).collect();
        match names.iter().find_map(|name| name.as_ref().err()) {
            None => only.extend(names.into_iter().flatten()),
            // `--check` takes all words up to the next option, so a subject may stand among them.
            Some(_) if subjects::load(&text).is_ok() => typed.push(text),
            Some(error) => bail!("{error}"),
        }
    }
    if typed.is_empty() {
        bail!("validate: no SUBJECT is given; a subject is name:key=value,… or a file");
    }
    let mut loaded = Vec::new();
    for text in &typed {
        loaded.extend(subjects::load(text)?);
    }
    let suite = Suite {
        seed: args.seed,
        level: args.level,
        effort: match args.effort {
            EffortArg::Quick => Effort::Quick,
            EffortArg::Default => Effort::Default,
            EffortArg::Deep => Effort::Deep,
        },
        only,
    };
    if args.json.is_some() && args.json == args.html {
        bail!("--json and --html name the same file");
    }
    let json = args.json.map(|path| sink("--json", path)).transpose()?;
    let html = args.html.map(|path| target("--html", path)).transpose()?;
    Ok(Validate { subjects: loaded, suite, json, html })
}

/// Where the report asked for by `option` goes: `-` is standard output.
pub(super) fn sink(option: &str, path: PathBuf) -> anyhow::Result<Sink> {
    Ok(if path.as_os_str() == "-" { Sink::Stdout } else { Sink::File(target(option, path)?) })
}

pub(super) fn target(option: &str, path: PathBuf) -> anyhow::Result<Target> {
    let shown = path.display().to_string();
    // Found now, not after the minutes that the sheets may take.
    Target::new(path).map_err(|error| anyhow!("{option} {shown}: cannot be written: {error}"))
}

fn check_name(text: &str) -> Result<&'static str, String> {
    let known = CHECKS.iter().map(|(name, _)| *name);
    known.clone().find(|name| *name == text.trim()).ok_or_else(|| {
        let typed: String = text.chars().take(80).collect();
        format!("--check {typed}: no such check; {}", nearest_name(&typed, known))
    })
}

/// `albedo`: the fixed directions, the side on which they lie, and the accuracy.
#[derive(Debug)]
pub(super) struct Albedo {
    pub(super) subject: Subject,
    pub(super) mu: Vec<f64>,
    pub(super) phi_deg: Vec<f64>,
    pub(super) side: Side,
    pub(super) average: bool,
    pub(super) hemisphere: Hemisphere,
    pub(super) format: AlbedoFormat,
}

pub(super) fn albedo(args: AlbedoArgs) -> anyhow::Result<Albedo> {
    let subject = subjects::load_one(&args.subject)?;
    if let Some(mu) = args.mu.iter().find(|&&mu| mu < 0.0 && !is_two_faced(&subject.bsdf)) {
        bail!("--mu {mu}: {} is not lit from below; allowed is a number in (0, 1]", subject.name);
    }
    Ok(Albedo {
        subject,
        mu: args.mu,
        phi_deg: args.phi,
        side: match args.side {
            SideArg::Eye => Side::Eye,
            SideArg::Light => Side::Light,
        },
        average: args.average,
        hemisphere: Hemisphere { tol: args.tol, ..Hemisphere::default() },
        format: args.format,
    })
}

/// `eval`: one pair of directions.
#[derive(Debug)]
pub(super) struct Eval {
    pub(super) subject: Subject,
    pub(super) wo: DVec3,
    pub(super) wi: DVec3,
}

pub(super) fn eval(args: &EvalArgs) -> anyhow::Result<Eval> {
    let subject = subjects::load_one(&args.subject)?;
    Ok(Eval { subject, wo: direction_deg(args.wo), wi: direction_deg(args.wi) })
}

/// `sample`: how many draws for which direction.
#[derive(Debug)]
pub(super) struct Sample {
    pub(super) subject: Subject,
    pub(super) wo: DVec3,
    pub(super) n: u64,
    pub(super) seed: u64,
}

pub(super) fn sample(args: &SampleArgs) -> anyhow::Result<Sample> {
    let subject = subjects::load_one(&args.subject)?;
    Ok(Sample { subject, wo: direction_deg(args.wo), n: args.n, seed: args.seed })
}

/// The direction at these degrees from the normal and around it.
fn direction_deg([theta, phi]: [f64; 2]) -> DVec3 {
    // Whole turns are dropped in degrees, where that is exact.
    direction((theta % 360.0).to_radians(), (phi % 360.0) / 360.0 * TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_check_is_known_or_the_nearest_is_named() {
        assert_eq!(check_name("energy_eye"), Ok("energy_eye"));
        let error = check_name("enrgy_eye").unwrap_err();
        assert_eq!(error, "--check enrgy_eye: no such check; did you mean energy_eye?");
    }

    #[test]
    fn whole_turns_do_not_matter() {
        // One rounding of 2π·(φ/360) is below 1e-15.
        assert_abs_diff_eq!(direction_deg([30.0, -45.0]), direction_deg([30.0, 315.0]), epsilon = 1e-15);
        assert_abs_diff_eq!(direction_deg([30.0, 3.6e9 + 10.0]), direction_deg([30.0, 10.0]), epsilon = 1e-15);
        assert!(direction_deg([1e308, -1e308]).is_finite());
    }
}
