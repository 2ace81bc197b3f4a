//! What was found, row by row, whatever the target: as text and as a verdict on all.

use std::fmt::Write as _;

use crate::cli::Status;
use crate::converge::image::{Floor, ImageConvergence};
use crate::converge::study::CONFIDENCE;
use crate::converge::{Convergence, Estimator, Theory, Verdict};
use crate::integrate::RateFit;
use crate::report::table::{Align, Table, exact, short};
use crate::sampling::sampler::SamplerKind;
use statrs::distribution::{ContinuousCDF, Normal};

/// What was studied.
#[derive(Debug)]
pub(super) struct Subject {
    /// As it was typed.
    pub(super) name: String,
    /// The mean; NaN where it is not known.
    pub(super) exact: f64,
    /// How far it may be off.
    pub(super) error: f64,
    pub(super) seed: u64,
    pub(super) replicates: u64,
    pub(super) image: Option<Image>,
}

/// What else is to be said of an image.
#[derive(Debug)]
pub(super) struct Image {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Size, counts, filter and bounces, in words.
    pub(super) how: String,
    /// The reference in words, with the root mean square of its own error where that is known.
    pub(super) reference: Option<(String, Option<f64>)>,
}

/// One estimator with one sampler.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) estimator: String,
    pub(super) sampler: SamplerKind,
    pub(super) theory: Theory,
    pub(super) verdict: Verdict,
    pub(super) fit: Option<RateFit>,
    /// The standard deviation of one sample, measured and known.
    pub(super) sigma: f64,
    pub(super) sigma_exact: Option<f64>,
    pub(super) excess_kurtosis: f64,
    /// Processor seconds for a sample.
    pub(super) seconds: f64,
    /// Of one independent sample of the same error.
    pub(super) variance: f64,
    pub(super) efficiency: f64,
    pub(super) points: Vec<Point>,
    /// Samples that were NaN or infinite.
    pub(super) nonfinite: u64,
    /// Of an image with a reference.
    pub(super) bias: Option<Bias>,
}

/// The error at one number of samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) n: u64,
    pub(super) rmse: f64,
    pub(super) log_std_err: f64,
    pub(super) mean: f64,
    pub(super) std_err: f64,
    pub(super) floor: Option<Floor>,
}

/// Whether the floor is what the error of the reference lets one expect.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bias {
    pub(super) floor: Floor,
    /// None where the error of the reference is not known.
    pub(super) explained: Option<bool>,
}

impl Bias {
    /// At this probability that an estimator without bias is said to have one.
    fn new(floor: Floor, level: f64) -> Self {
        // NaN never passes.
        let explained = floor.z.map(|z| Normal::standard().sf(z) >= level);
        Self { floor, explained }
    }

    /// What it is called.
    pub(super) fn verdict(&self) -> &'static str {
        match self.explained {
            None => "not known",
            Some(true) => "none seen",
            Some(false) => "biased",
        }
    }
}

impl Row {
    pub(super) fn of_target(estimator: &Estimator, found: &Convergence, level: f64) -> Self {
        let theory = Theory::of(found.sampler);
        let point = |p: &crate::converge::Point| Point {
            n: p.n,
            rmse: p.rmse,
            log_std_err: p.log_std_err,
            mean: p.mean,
            std_err: p.std_err,
            floor: None,
        };
        Self {
            estimator: estimator.name.into(),
            sampler: found.sampler,
            verdict: found.verdict(&theory, level),
            theory,
            fit: found.fit,
            sigma: found.samples.variance().sqrt(),
            sigma_exact: estimator.sigma,
            excess_kurtosis: found.samples.excess_kurtosis(),
            seconds: found.seconds,
            variance: found.variance(),
            efficiency: found.efficiency(),
            points: found.points.iter().map(point).collect(),
            nonfinite: 0,
            bias: None,
        }
    }

    pub(super) fn of_image(estimator: &str, found: &ImageConvergence, level: f64) -> Self {
        let theory = Theory::of(found.sampler);
        let point = |(n, measured): &(u64, crate::converge::image::Measured)| Point {
            n: *n,
            rmse: measured.spread.variance.sqrt(),
            log_std_err: 0.5 * measured.spread.log_variance.sqrt(),
            mean: measured.spread.mean,
            std_err: measured.spread.std_err,
            floor: measured.spread.floor,
        };
        Self {
            estimator: estimator.into(),
            sampler: found.sampler,
            verdict: theory.verdict(found.fit.as_ref(), found.heavy, level),
            theory,
            fit: found.fit,
            sigma: found.variance().sqrt(),
            sigma_exact: None,
            // Of the samples of a pixel only mean and variance are kept.
            excess_kurtosis: f64::NAN,
            seconds: found.seconds,
            variance: found.variance(),
            efficiency: found.efficiency(),
            points: found.points.iter().map(point).collect(),
            nonfinite: found.points.iter().map(|(_, measured)| measured.nonfinite).sum(),
            bias: found.floor().map(|floor| Bias::new(floor, level)),
        }
    }

    /// The standard deviation to which the theory of independent samples holds, where it is known and they are.
    pub(super) fn line(&self) -> Option<f64> {
        // A logarithmic axis has no place for 0.
        self.sigma_exact.filter(|&sigma| sigma > 0.0 && self.sampler == SamplerKind::Independent)
    }
}

/// What the verdict is called.
pub(super) fn verdict(verdict: &Verdict) -> &'static str {
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

/// Of all rows together.
pub(super) fn status(rows: &[Row]) -> Status {
    let differs = |row: &Row| {
        matches!(row.verdict, Verdict::Differs) || row.bias.is_some_and(|bias| bias.explained == Some(false))
    };
    if rows.iter().any(differs) {
        Status::Fail
    } else if rows.iter().any(|row| !matches!(row.verdict, Verdict::Agrees)) {
        Status::Inconclusive
    } else {
        Status::Pass
    }
}

pub(super) fn text(subject: &Subject, rows: &[Row], equal_time: bool) -> String {
    let mut text = match &subject.image {
        None => format!("{}: {} ± {:.0e}\n", subject.name, exact(subject.exact), subject.error),
        Some(image) => of_image(subject, image),
    };
    let of_image = subject.image.is_some();
    // The last but three: what is known in closed form, or what stands in the way of it.
    let eighth = if of_image { "floor" } else { "known" };
    let heads = ["estimator", "sampler", "slope", "theory", "sigma", eighth, "ns", "efficiency", "verdict"];
    let mut table = Table::new(
        &heads.map(|h| (h, if ["estimator", "sampler", "verdict"].contains(&h) { Align::Left } else { Align::Right })),
    );
    for row in rows {
        let slope = row.fit.map_or("-".into(), |f| format!("{:.3} ± {:.3}", f.slope, f.half_width(CONFIDENCE)));
        let known = if of_image {
            row.bias.map(|bias| format!("{} ± {}", digits(bias.floor.value), digits(bias.floor.std_err)))
        } else {
            row.sigma_exact.map(short)
        };
        table.row([
            row.estimator.clone(),
            row.sampler.name().into(),
            slope,
            theory(&row.theory),
            short(row.sigma),
            known.unwrap_or("-".into()),
            format!("{:.0}", row.seconds * 1e9),
            short(row.efficiency),
            verdict(&row.verdict).into(),
        ]);
    }
    text.push_str(&table.text("  "));
    for row in rows {
        let mut say = |what: &str| {
            let _ = writeln!(text, "  {} with {}: {what}", row.estimator, row.sampler.name());
        };
        if let Verdict::Insufficient(why) = &row.verdict {
            say(why);
        }
        let good = row.sampler.good_counts();
        if row.points.iter().any(|point| !good.contains(point.n)) {
            say(&format!("its points are at their best for {good}, which not all N here are"));
        }
        if row.nonfinite > 0 {
            say(&format!("{} samples were NaN or infinite and are left out", row.nonfinite));
        }
        if let Some(bias) = &row.bias {
            say(&bias_in_words(bias));
        }
    }
    let cost = |row: &Row| row.variance * if equal_time { row.seconds } else { 1.0 };
    if let Some(best) = rows.iter().filter(|row| cost(row).is_finite()).min_by(|a, b| cost(a).total_cmp(&cost(b))) {
        let at = if equal_time { "time" } else { "number of samples" };
        let _ = writeln!(text, "  the least error at equal {at}: {} with {}", best.estimator, best.sampler.name());
    }
    text
}

/// Two significant digits.
fn digits(x: f64) -> String {
    format!("{x:.1e}")
}

fn of_image(subject: &Subject, image: &Image) -> String {
    let mut text = format!("{}: {}\n", subject.name, image.how);
    let _ = match &image.reference {
        None => writeln!(text, "  no reference: the spread of {} images is all that is measured", subject.replicates),
        Some((name, Some(error))) => writeln!(text, "  reference: {name}, root mean square error {}", short(*error)),
        Some((name, None)) => writeln!(text, "  reference: {name}, whose error is not stated"),
    };
    text
}

fn bias_in_words(bias: &Bias) -> String {
    let explained = |z: f64| format!("z = {:.1}", if z.abs() < 0.05 { 0.0 } else { z });
    match (bias.explained, bias.floor.z) {
        (Some(true), Some(z)) => {
            format!("no bias is seen; the reference's own error explains the floor ({})", explained(z))
        }
        (Some(false), Some(z)) => {
            format!(
                "a bias; relative to the brightness of pixels, the floor is above what the reference's own error explains ({})",
                explained(z)
            )
        }
        _ => "the floor is bias² and the square of the reference's error, which is not stated".into(),
    }
}
