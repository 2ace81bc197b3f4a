//! `whitefurnace compare`: how far two pictures are apart, and whether noise explains it.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};

use super::Status;
use super::job::{Sink, target};
use super::validate::{colour_is_welcome, print};
use crate::image::{Format, Image};
use crate::report::compare::noise::Noise;
use crate::report::compare::{
    Settings, Side, Verdict, compare, json, noise_of_samples, noise_scaled, picture, stated_noise, text,
};
use crate::report::save::Target;
use crate::report::text::Style;

pub(super) const HELP: &str = "\
Read are EXR, HDR, PFM, PNG and JPEG, told apart by content. The variance of each pixel's mean comes from, in this order:
  --variance-a FILE --spp-a N  FILE holds the variance of one sample, as Mitsuba's tests keep it, at least 1e-4;
                               A is the mean of N of them
  the file itself              planes Variance.R, .G, .B, as whitefurnace writes them
  --spp-a N                    A is the mean of N samples with the variance of B's: B's times its own count over N
and likewise for B. Without any for both there is no z. A file without a variance beside one with it counts as exact.

Exit status: 0 equal within noise, or bit for bit; 1 the pictures differ: a test rejects, or a pixel is NaN or infinite;
  3 the noise is not known, so nothing can be said; 2 bad usage or input

Examples:
  whitefurnace compare mine.exr reference.exr
  whitefurnace compare mine.exr mitsuba.exr --variance-b mitsuba_var.exr --spp-b 4096 --z-image z.png
  whitefurnace compare a.exr b.exr --json - | jq .verdict";

#[derive(Debug, clap::Args)]
pub(super) struct CompareArgs {
    /// A picture
    pub(super) a: PathBuf,
    /// Another picture of the same size; it is the reference, unless --reference says A
    pub(super) b: PathBuf,
    /// Samples per pixel of A, where its file does not say
    #[arg(long, value_name = "N", value_parser = spp, allow_hyphen_values = true)]
    pub(super) spp_a: Option<f64>,
    /// Samples per pixel of B, where its file does not say
    #[arg(long, value_name = "N", value_parser = spp, allow_hyphen_values = true)]
    pub(super) spp_b: Option<f64>,
    /// Variance of one sample of A, as a picture; needs --spp-a
    #[arg(long, value_name = "FILE", requires = "spp_a")]
    pub(super) variance_a: Option<PathBuf>,
    /// Variance of one sample of B, as a picture; needs --spp-b
    #[arg(long, value_name = "FILE", requires = "spp_b")]
    pub(super) variance_b: Option<PathBuf>,
    /// Which of the two is the reference: A, B, or its path
    #[arg(long, value_name = "A|B", default_value = "B")]
    pub(super) reference: PathBuf,
    /// Probability that pictures of equal expectation are said to differ
    #[arg(long, value_name = "P", value_parser = super::args::level, default_value_t = Settings::default().level, allow_hyphen_values = true)]
    pub(super) level: f64,
    /// Share of pixels that may lie beyond their bound, since the variances are themselves estimates
    #[arg(long, value_name = "SHARE", value_parser = share, default_value_t = Settings::default().outliers, allow_hyphen_values = true)]
    pub(super) outliers: f64,
    /// Write the comparison as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write z of every pixel: .png in colours from -4 to +4, .exr or .pfm as numbers
    #[arg(long, value_name = "FILE")]
    pub(super) z_image: Option<PathBuf>,
    /// Write the error of every pixel: .png in colours, .exr or .pfm as numbers
    #[arg(long, value_name = "FILE")]
    pub(super) error_image: Option<PathBuf>,
}

fn spp(text: &str) -> Result<f64, String> {
    let n = text.parse().ok().filter(|n| (1..=1_u64 << 53).contains(n));
    n.map(|n: u64| n as f64).ok_or_else(|| "allowed is a whole number from 1 on".into())
}

fn share(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| (0.0..1.0).contains(x)).ok_or_else(|| "allowed is a number in [0, 1)".into())
}

/// Which pictures, how, and where the reports go.
#[derive(Debug)]
pub(super) struct Job {
    sides: [Side; 2],
    reference_first: bool,
    settings: Settings,
    json: Option<Sink>,
    z_image: Option<(Target, Format)>,
    error_image: Option<(Target, Format)>,
}

pub(super) fn job(args: CompareArgs) -> anyhow::Result<Job> {
    let reference_first = match &args.reference {
        letter if letter.as_os_str().eq_ignore_ascii_case("a") => true,
        letter if letter.as_os_str().eq_ignore_ascii_case("b") => false,
        path if *path == args.b => false,
        path if *path == args.a => true,
        other => bail!("--reference {}: allowed is A, B, or the path of one of the two", other.display()),
    };
    let json = match args.json {
        Some(path) if path.as_os_str() == "-" => Some(Sink::Stdout),
        Some(path) => Some(Sink::File(target("--json", path)?)),
        None => None,
    };
    let z_image = args.z_image.map(|path| picture_target("--z-image", path)).transpose()?;
    let error_image = args.error_image.map(|path| picture_target("--error-image", path)).transpose()?;
    let images = [Image::read(&args.a)?, Image::read(&args.b)?];
    let given = [(args.variance_a, args.spp_a), (args.variance_b, args.spp_b)];
    let paths = [args.a, args.b];
    let mut known: Vec<Option<(Noise, String)>> = Vec::new();
    for (image, (file, spp)) in images.iter().zip(&given) {
        known.push(match (file, spp) {
            (Some(file), Some(spp)) => Some(noise_file(image, file, *spp)?),
            _ => stated_noise(image).map(|noise| {
                let many = samples(image).map_or_else(String::new, |n| format!(" of {n} samples"));
                (noise, format!("variance of the mean{many} by its own planes"))
            }),
        });
    }
    let mut sides = Vec::new();
    for (at, (image, path)) in images.iter().zip(&paths).enumerate() {
        let other_count = given[1 - at].1.or_else(|| samples(&images[1 - at]));
        let scaled = || -> anyhow::Result<Option<(Noise, String)>> {
            let (Some(spp), Some((other, _))) = (given[at].1, &known[1 - at]) else { return Ok(None) };
            let letter = ["a", "b"][1 - at];
            let count = other_count
                .ok_or_else(|| anyhow!("give --spp-{letter} too: {} does not say it", paths[1 - at].display()))?;
            let source = format!("variance of {spp} samples, scaled from the other file's {count}");
            Ok(Some((noise_scaled(other, count, spp), source)))
        };
        let noise = match &known[at] {
            Some(found) => Some(found.clone()),
            None => scaled()?,
        };
        let (noise, noise_source) = match noise {
            Some((noise, source)) => (Some(noise), source),
            None if known[1 - at].is_some() => (None, "no variance: taken as exact".into()),
            None => (None, "no variance".into()),
        };
        sides.push(Side { name: path.display().to_string(), image: image.clone(), noise, noise_source });
    }
    if z_image.is_some() && sides.iter().all(|side| side.noise.is_none()) {
        bail!("--z-image: neither file has a variance, so there is no z");
    }
    let sides = <[Side; 2]>::try_from(sides).map_err(|_| anyhow!("two pictures are compared"))?;
    let settings = Settings { level: args.level, outliers: args.outliers, ..Settings::default() };
    Ok(Job { sides, reference_first, settings, json, z_image, error_image })
}

/// Samples per pixel, where the file says it and all pixels have as many.
fn samples(image: &Image) -> Option<f64> {
    let plane = image.plane("Samples")?;
    let first = *plane.first()?;
    (first > 0.0 && plane.iter().all(|n| *n == first)).then_some(f64::from(first))
}

fn noise_file(image: &Image, file: &Path, spp: f64) -> anyhow::Result<(Noise, String)> {
    let variance = Image::read(file)?;
    let (size, expected) = ((variance.width(), variance.height()), (image.width(), image.height()));
    if size != expected || !variance.has_colour() {
        let name = file.display();
        bail!("{name}: {} x {} pixels are no variance of {} x {}", size.0, size.1, expected.0, expected.1);
    }
    let source = format!("variance of one sample by a file of its own, over {spp}");
    Ok((noise_of_samples(&variance, spp), source))
}

fn picture_target(option: &str, path: PathBuf) -> anyhow::Result<(Target, Format)> {
    let format = Format::of(&path).ok().filter(|format| *format != Format::Hdr);
    // HDR holds no negative numbers.
    let format = format.ok_or_else(|| anyhow!("{option} {}: allowed are .png, .exr and .pfm", path.display()))?;
    Ok((target(option, path)?, format))
}

pub(super) fn run(job: &Job, out: &mut dyn Write, terminal: bool) -> anyhow::Result<Status> {
    let style = if terminal && colour_is_welcome() { Style::Colour } else { Style::Plain };
    let [a, b] = &job.sides;
    let (test, reference) = if job.reference_first { (b, a) } else { (a, b) };
    let result = compare(test, reference, job.settings)?;
    let as_json = || json::comparison(&result, [a, b], job.reference_first);
    match &job.json {
        Some(Sink::Stdout) => print(out, &as_json())?,
        sink => {
            print(out, &text::comparison(&result, [a, b], job.reference_first, style))?;
            if let Some(Sink::File(target)) = sink {
                target.write(as_json().as_bytes()).context("--json: cannot be written")?;
            }
        }
    }
    if let Some((target, format)) = &job.z_image {
        let image = picture::z_image(&result, *format).context("--z-image: no pixel has a z")??;
        target.write(&image.encode(*format, 0.0)?).context("--z-image: cannot be written")?;
    }
    if let Some((target, format)) = &job.error_image {
        let image = picture::error_image(&result, *format)?;
        target.write(&image.encode(*format, 0.0)?).context("--error-image: cannot be written")?;
    }
    Ok(match result.verdict() {
        Verdict::Equal => Status::Pass,
        Verdict::Differ => Status::Fail,
        Verdict::Undecided => Status::Inconclusive,
    })
}
