//! What was typed: options with their own domains, and the help texts.

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};

use super::compare::{self, CompareArgs};
use super::contact_sheet::{self, ContactSheetArgs};
use super::converge::ConvergeArgs;
use super::furnace::FurnaceArgs;
use super::merge::{self, MergeArgs};
use super::notebooks_data::{self, NotebooksDataArgs};
use super::photons::{self, PhotonsArgs};
use super::plot::PlotArgs;
use super::radiosity::{self, RadiosityArgs, ViewFactorsArgs};
use super::render::{self, RenderArgs};
use super::scenes::ScenesArgs;
use crate::bsdf::subject::nearest_name;
use crate::sampling::sampler::SamplerKind;
use crate::validate::Suite;

const SUBJECTS: &str = "\
A SUBJECT is
  name:key=value,…      a model of `whitefurnace list`; a colour is one number or r/g/b;
                        a subject as a value stands in parentheses
  FILE                  a text file with one subject per line (# starts a comment),
                        or a CSV table of SGD or ABC fits: all its materials";

const ESTIMATORS: &str = "\
The estimators of a scene: mis, direct, bsdf, random-connect (see `whitefurnace render --help`), balance and power (mis
with that heuristic), first-split=M or split=M, roulette=Q (every path goes on with probability Q)";

const STATUS: &str = "Exit status: 0 pass, 1 fail, 3 inconclusive, 2 bad usage or input";

/// Checks any BRDF, and the numbers behind it: samplers, certified integrals, one sheet of verdicts.
#[derive(Debug, Parser)]
#[command(name = "whitefurnace", version, subcommand_required = true, after_help = SUBJECTS)]
#[command(after_long_help = format!("{SUBJECTS}\n\n{STATUS}\n\nExamples:\n  whitefurnace validate ggx:alpha=0.3\n  \
    whitefurnace albedo ggx:alpha=0.3 --mu 0.1,0.5,1 --tol 1e-9\n  whitefurnace list"))]
pub(super) struct Args {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Lists every model with its parameters, and every check
    #[command(after_help = "Examples:\n  whitefurnace list\n  whitefurnace list --json | jq -r '.models[].name'")]
    List(ListArgs),
    /// Runs the sheet of checks on one or more BRDFs
    #[command(after_help = format!("{SUBJECTS}\n\nExit status: 0 all pass, 1 some check fails, \
        3 none fails but some are inconclusive, 2 bad usage or input\n\nExamples:\n  \
        whitefurnace validate ggx:alpha=0.3\n  \
        whitefurnace validate ggx:alpha=0.3 phong:n=100,norm=n+2 --check energy_eye energy_light\n  \
        whitefurnace validate my_subjects.txt --json sheets.json --html sheets.html"))]
    Validate(ValidateArgs),
    /// Integrates the directional albedo, with an error bound for each value
    #[command(after_help = format!("{SUBJECTS}\n\nExit status: 0, or 3 where a row is not resolved to the tolerance, \
        2 bad usage or input\n\nExamples:\n  whitefurnace albedo ggx:alpha=0.3 --mu 0.01,0.1,0.5,1\n  \
        whitefurnace albedo phong:n=100,norm=n+1,divide=true --mu 0.1 --side light\n  \
        whitefurnace albedo ward:alpha_x=0.1,alpha_y=0.3,variant=duer --mu 0.5 --phi 0,45,90 --average --format json"))]
    Albedo(AlbedoArgs),
    /// Evaluates f, f·cos and the sampler's pdf for one pair of directions
    #[command(after_help = format!("{SUBJECTS}\n\nPrints one `key values…` a line: f (1/sr, red green blue, without \
        the cosine), f_cos, pdf (1/sr), wo, wi.\n\nExamples:\n  \
        whitefurnace eval lambert:rho=0.5 --wo 30,0 --wi 60,180\n  \
        whitefurnace eval ggx:alpha=0.1 --wo 45,0 --wi 44,-179.5"))]
    Eval(EvalArgs),
    /// Draws directions with the model's own sampler
    #[command(after_help = format!("{SUBJECTS}\n\nColumns: wi_x,wi_y,wi_z,theta_deg,phi_deg,weight_r,weight_g,\
        weight_b,pdf. A lost draw is a row with weight 0\nand all other fields empty, so the mean of a weight column \
        estimates the albedo. The density of a Dirac lobe is\nwritten as `dirac:PROBABILITY`. The first rows do not \
        depend on N.\n\nExamples:\n  whitefurnace sample ggx:alpha=0.3 --wo 60,0 -n 1000 --format csv > draws.csv\n  \
        whitefurnace sample burley:rho=0.8,roughness=1 --wo 80,0 -n 5 --seed 7"))]
    Sample(SampleArgs),
    /// Puts the path tracer through scenes whose answer is known, or a sphere of each SUBJECT into constant light
    #[command(after_help = format!("{SUBJECTS}\n\nExit status: 0 all pass, 1 some check fails, \
        3 none fails but some are inconclusive, 2 bad usage or input\n\nExamples:\n  \
        whitefurnace furnace\n  whitefurnace furnace ggx:alpha=0.3 burley:rho=0.8,roughness=0.5 --samples 100000\n  \
        whitefurnace furnace --json -"))]
    Furnace(FurnaceArgs),
    /// Measures how the error of estimators falls with the number of samples, and compares the rate with theory
    #[command(after_help = format!("{SUBJECTS}\n\nColumns: the fitted exponent with its 99 % interval, the exponents of \
        theory (smooth to worst), the standard\ndeviation of one sample, measured and known, nanoseconds a sample, and \
        1 / (variance x seconds). Of an\nimage, the mean of all pixels and channels; in place of what is known stands the \
        floor, the mean square\ndistance from the reference that more samples do not take away.\n\n{ESTIMATORS}\n\n\
        Exit status: 0 all agree, 1 some rate differs from theory or some estimator is biased, 3 no verdict\non some, \
        or interrupted, 2 bad usage or input\n\nExamples:\n  \
        whitefurnace converge scene:cornell-original --sampler independent,sobol --out study\n  \
        whitefurnace converge scene:box.xml --reference box.exr --size 64x64 --estimator mis,direct,split=4\n  \
        whitefurnace converge scene:veach-mis@640,360 --reference none\n  \
        whitefurnace converge irradiance:unit-square --out study\n  \
        whitefurnace converge albedo:ggx:alpha=0.3@0.5 --estimator bsdf,cosine\n  \
        whitefurnace converge albedo:lambert@0.5 --n 64..4096 --replicates 256"))]
    Converge(ConvergeArgs),
    /// Lists every built-in scene with its parameters, and what is known about it in closed form
    #[command(after_help = "Examples:\n  whitefurnace scenes\n  whitefurnace scenes --json | jq -r '.scenes[].name'")]
    Scenes(ScenesArgs),
    /// Renders a scene by path tracing, radiosity or photon maps
    #[command(after_help = render::HELP)]
    Render(RenderArgs),
    /// Solves the radiosity equations of a diffuse scene
    #[command(after_help = radiosity::RADIOSITY_HELP)]
    Radiosity(RadiosityArgs),
    /// Finds the view factors between the patches of a scene
    #[command(after_help = radiosity::VIEW_FACTORS_HELP)]
    ViewFactors(ViewFactorsArgs),
    /// Sends photons out, and says where their light goes
    #[command(after_help = photons::HELP)]
    Photons(PhotonsArgs),
    /// Compares two pictures: error metrics, and whether noise explains the difference
    #[command(after_help = compare::HELP)]
    Compare(CompareArgs),
    /// Merges renderings of one scene: mean, variance and count of all samples together
    #[command(after_help = merge::HELP)]
    Merge(MergeArgs),
    /// Renders the lecture's pictures of samples and bounces as one sheet
    #[command(after_help = contact_sheet::HELP)]
    ContactSheet(ContactSheetArgs),
    /// Makes the data behind the figures and notebooks again
    #[command(after_help = notebooks_data::HELP)]
    NotebooksData(NotebooksDataArgs),
    /// Draws one plot as SVG or PNG
    Plot(PlotArgs),
    /// Runs every known-broken model through the sheet: each must be rejected, each correct original must pass
    #[command(after_help = "Exit status: 0 if all is as it must be, else 1\n\nExamples:\n  whitefurnace selftest")]
    Selftest,
}

#[derive(Debug, clap::Args)]
pub(super) struct ListArgs {
    /// Print JSON instead of text
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Debug, clap::Args)]
pub(super) struct ValidateArgs {
    /// Models or files
    #[arg(value_name = "SUBJECT")]
    pub(super) subjects: Vec<String>,
    /// Probability that a correct model fails anywhere on its sheet
    #[arg(long, value_name = "P", value_parser = level, default_value_t = Suite::default().level, allow_hyphen_values = true)]
    pub(super) level: f64,
    /// Seed of every random number; it is printed on the sheet
    #[arg(long, value_name = "N", value_parser = seed, default_value_t = Suite::default().seed, allow_hyphen_values = true)]
    pub(super) seed: u64,
    /// How hard to look
    #[arg(long, value_enum, default_value = "default")]
    pub(super) effort: EffortArg,
    /// Run only these checks (see `whitefurnace list`); names up to the next option, or separated by commas
    #[arg(long = "check", value_name = "NAME", num_args = 1..)]
    pub(super) checks: Vec<String>,
    /// Write the sheets as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write the sheets with their plots as one HTML page
    #[arg(long, value_name = "FILE")]
    pub(super) html: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum EffortArg {
    Quick,
    Default,
    Deep,
}

#[derive(Debug, clap::Args)]
pub(super) struct AlbedoArgs {
    /// A model, or a file with one model
    pub(super) subject: String,
    /// Cosines of the fixed direction, each in [−1, 1] and not 0; negative ones lie below the surface, inside of glass
    #[arg(long, value_name = "M,…", value_delimiter = ',', value_parser = mu, required = true, allow_hyphen_values = true)]
    pub(super) mu: Vec<f64>,
    /// Azimuths of the fixed direction in degrees
    #[arg(long, value_name = "DEG,…", value_delimiter = ',', value_parser = finite, default_value = "0", allow_hyphen_values = true)]
    pub(super) phi: Vec<f64>,
    /// Which direction is held fixed
    #[arg(long, value_enum, default_value = "eye")]
    pub(super) side: SideArg,
    /// Also the cosine-weighted average over the hemisphere of fixed directions
    #[arg(long)]
    pub(super) average: bool,
    /// Largest error that is asked for: absolute below a value of 1, relative above
    #[arg(long, value_name = "T", value_parser = positive, default_value = "1e-6", allow_hyphen_values = true)]
    pub(super) tol: f64,
    /// Form of the output
    #[arg(long, value_enum, default_value = "table")]
    pub(super) format: AlbedoFormat,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum SideArg {
    /// The eye: light of radiance 1 from everywhere
    Eye,
    /// The light: the share of its energy that leaves
    Light,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum AlbedoFormat {
    Table,
    Csv,
    Json,
}

#[derive(Debug, clap::Args)]
pub(super) struct EvalArgs {
    /// A model, or a file with one model
    pub(super) subject: String,
    /// Direction to the eye, degrees from the normal and around it
    #[arg(long, value_name = "THETA,PHI", value_parser = two_angles, allow_hyphen_values = true)]
    pub(super) wo: [f64; 2],
    /// Direction to the light, degrees from the normal and around it
    #[arg(long, value_name = "THETA,PHI", value_parser = two_angles, allow_hyphen_values = true)]
    pub(super) wi: [f64; 2],
}

#[derive(Debug, clap::Args)]
pub(super) struct SampleArgs {
    /// A model, or a file with one model
    pub(super) subject: String,
    /// Direction to the eye, degrees from the normal and around it
    #[arg(long, value_name = "THETA,PHI", value_parser = two_angles, allow_hyphen_values = true)]
    pub(super) wo: [f64; 2],
    /// Number of draws, 1 to 1 000 000 000
    #[arg(short = 'n', value_name = "N", value_parser = draws, allow_hyphen_values = true)]
    pub(super) n: u64,
    /// Form of the output
    #[arg(long, value_enum, default_value = "csv")]
    pub(super) format: SampleFormat,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", value_parser = seed, default_value = "1", allow_hyphen_values = true)]
    pub(super) seed: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum SampleFormat {
    Csv,
}

/// The number in `text` if it is `good`, else a sentence that says what is `allowed`.
fn number(text: &str, allowed: &str, good: impl Fn(f64) -> bool) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|x| x.is_finite() && good(*x));
    value.ok_or_else(|| format!("allowed is {allowed}"))
}

pub(super) fn level(text: &str) -> Result<f64, String> {
    number(text, "a number in (0, 1)", |x| x > 0.0 && x < 1.0)
}

fn mu(text: &str) -> Result<f64, String> {
    number(text, "a number in (0, 1], or in [-1, 0) for a model that is lit from below", |x| {
        x.abs() > 0.0 && x.abs() <= 1.0
    })
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text, "a number > 0", |x| x > 0.0)
}

/// Brightness in stops: factors of 2.
pub(super) fn stops(text: &str) -> Result<f64, String> {
    number(text, "a number of stops from -100 to 100", |x| x.abs() <= 100.0)
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text, "a finite number of degrees", |_| true)
}

pub(super) fn sampler(text: &str) -> Result<SamplerKind, String> {
    let names = || SamplerKind::ALL.iter().map(|(name, _)| *name);
    let found = SamplerKind::ALL.iter().find(|(name, _)| *name == text.trim()).map(|(_, kind)| *kind);
    found.ok_or_else(|| format!("there is no such sampler; {}", nearest_name(text, names())))
}

pub(super) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("allowed is a whole number from 0 to {}", u64::MAX))
}

pub(super) fn draws(text: &str) -> Result<u64, String> {
    let n = text.parse().ok().filter(|n| (1..=1_000_000_000).contains(n));
    n.ok_or_else(|| "allowed is a whole number from 1 to 1000000000".into())
}

fn two_angles(text: &str) -> Result<[f64; 2], String> {
    let pair = text.split_once(',').ok_or("allowed is THETA,PHI: two numbers of degrees")?;
    Ok([finite(pair.0)?, finite(pair.1)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn a_sampler_that_is_misspelt_is_guessed() {
        assert_eq!(sampler("blue-sobol"), Ok(SamplerKind::BlueSobol));
        assert!(sampler("indepedent").unwrap_err().contains("did you mean independent"));
    }

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn numbers_outside_their_domain_are_refused() {
        for text in ["0", "-1.1", "1.0000001", "NaN", "inf", "", "half"] {
            assert!(mu(text).is_err(), "{text}");
        }
        assert_eq!((mu("1"), mu("-0.5")), (Ok(1.0), Ok(-0.5)));
        assert_eq!(two_angles("-30, 1e2"), Ok([-30.0, 100.0]));
        assert!(two_angles("30").is_err() && two_angles("30,40,50").is_err() && two_angles("a,b").is_err());
        assert!(level("1").is_err() && level("0").is_err() && positive("0").is_err());
    }
}
