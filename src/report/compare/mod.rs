//! `compare`: how far two pictures are apart, and whether noise explains it.
//!
//! [`compare`] computes; [`text`], [`json`] and [`picture`] show. Unlike the rest of `report`, this decides: see
//! [`Comparison::verdict`].

pub mod flip;
pub mod json;
pub mod metrics;
pub mod noise;
pub mod picture;
pub mod text;

use std::fmt;

use crate::image::Image;
use crate::math::sum::Neumaier;

use metrics::Metric;
use noise::{Noise, NoiseTest, Pair};

/// One picture with what is known of its noise.
#[derive(Clone, Debug)]
pub struct Side {
    /// Its name, as the user gave it.
    pub name: String,
    /// The picture.
    pub image: Image,
    /// Its noise; None if nothing is known.
    pub noise: Option<Noise>,
    /// Where the noise comes from, or why there is none, in words.
    pub noise_source: String,
}

/// How to judge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The probability that two pictures of equal expectation are said to differ.
    pub level: f64,
    /// The share of pixels that may lie beyond their bound.
    pub outliers: f64,
    /// For FLIP.
    pub pixels_per_degree: f64,
}

impl Default for Settings {
    /// Level 1 %, and the share of outliers that Mitsuba's own tests of its renderings allow, a quarter of a percent.
    fn default() -> Self {
        Self { level: 0.01, outliers: 0.0025, pixels_per_degree: flip::PIXELS_PER_DEGREE }
    }
}

/// Why two pictures cannot be compared.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum CompareError {
    /// The sizes differ.
    #[error("the sizes differ: {} is {} x {}, {} is {} x {}", .0.0, .0.1[0], .0.1[1], .1.0, .1.1[0], .1.1[1])]
    Size((String, [usize; 2]), (String, [usize; 2])),
    /// A picture without colours.
    #[error("{name}: no planes are a colour; it has {planes}")]
    NoColour {
        /// The picture.
        name: String,
        /// Its planes.
        planes: String,
    },
}

/// What came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No test rejects, or all samples are the same.
    Equal,
    /// Some test rejects, or a pixel is NaN or infinite.
    Differ,
    /// Nothing is known of the noise of some pixels, and nothing else rejects.
    Undecided,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Equal => "equal",
            Self::Differ => "differ",
            Self::Undecided => "undecided",
        })
    }
}

/// Two pictures side by side.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Test less reference, per pixel and channel, row by row.
    pub difference: Vec<[f64; 3]>,
    /// Mean colours of test and reference over the pixels where both are finite.
    pub means: [[f64; 3]; 2],
    /// Pixels of test and reference with a channel that is NaN or infinite.
    pub nonfinite: [usize; 2],
    /// Whether every sample of the one is that of the other.
    pub identical: bool,
    /// Over the pixels where both are finite.
    pub metrics: Vec<Metric>,
    /// Mean of LDR-FLIP; None where some pixel is not finite.
    pub flip: Option<f64>,
    /// Bias against noise; None where nothing is known of the noise.
    pub noise: Option<NoiseTest>,
    /// How it was judged.
    pub settings: Settings,
}

impl Comparison {
    /// Whether the pictures are equal within noise.
    pub fn verdict(&self) -> Verdict {
        let finite = self.nonfinite == [0, 0];
        match &self.noise {
            _ if !finite => Verdict::Differ,
            _ if self.identical => Verdict::Equal,
            Some(test) if !test.holds() => Verdict::Differ,
            Some(test) if test.untested == 0 => Verdict::Equal,
            _ => Verdict::Undecided,
        }
    }
}

/// The least variance of one sample in a picture of them, as in Mitsuba's tests. Such pictures are differences of two
/// estimates, E\[x²\] − E\[x\]², and come out as low as −0.4.
pub const LEAST_VARIANCE: f64 = 1e-4;

/// The noise that the planes Variance.R, .G and .B state, with the counts of the plane Batches or Samples where there is
/// one.
pub fn stated_noise(image: &Image) -> Option<Noise> {
    let [r, g, b] = image.variance()?;
    let variance = (0..r.len()).map(|at| [r[at], g[at], b[at]].map(known)).collect();
    let samples = image.plane("Batches").or_else(|| image.plane("Samples"));
    let samples = samples.map(|plane| plane.iter().map(|n| f64::from(*n)).collect());
    Some(Noise { variance, samples })
}

/// The noise of means of `spp` samples where `per_sample` is a picture of the variance of one sample, as Mitsuba's
/// tests keep it. It counts as exact, and as [`LEAST_VARIANCE`] where it is less.
pub fn noise_of_samples(per_sample: &Image, spp: f64) -> Noise {
    let least = |v: f32| if v.is_nan() { f64::INFINITY } else { f64::from(v).max(LEAST_VARIANCE) };
    let pixel = |rgb: &[f32; 3]| rgb.map(|v| least(v) / spp);
    Noise { variance: per_sample.pixels_rgb().iter().map(pixel).collect(), samples: None }
}

/// The noise of means of `spp` samples where one sample has the variance that `other` states for means of `other_spp`.
pub fn noise_scaled(other: &Noise, other_spp: f64, spp: f64) -> Noise {
    let variance = other.variance.iter().map(|v| v.map(|v| v * other_spp / spp)).collect();
    Noise { variance, samples: other.samples.clone() }
}

/// A variance, or infinity in place of what is none.
fn known(variance: f32) -> f64 {
    if variance >= 0.0 { f64::from(variance) } else { f64::INFINITY }
}

/// Compares a test picture with a reference.
pub fn compare(test: &Side, reference: &Side, settings: Settings) -> Result<Comparison, CompareError> {
    let size = |side: &Side| [side.image.width(), side.image.height()];
    if size(test) != size(reference) {
        return Err(CompareError::Size((test.name.clone(), size(test)), (reference.name.clone(), size(reference))));
    }
    let (a, b) = (colours(test)?, colours(reference)?);
    let finite = |pixel: &[f64; 3]| pixel.iter().all(|v| v.is_finite());
    let pairs: Vec<Colours> =
        a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| finite(a) && finite(b)).collect();
    let mean =
        |value: &dyn Fn(&Colours) -> f64| pairs.iter().map(value).collect::<Neumaier>().value() / pairs.len() as f64;
    let nonfinite = [&a, &b].map(|pixels| pixels.iter().filter(|pixel| !finite(pixel)).count());
    let rounding: Vec<[f64; 3]> = (0..a.len()).map(|at| rounding([(test, &a[at]), (reference, &b[at])])).collect();
    let noise = [test.noise.as_ref(), reference.noise.as_ref()];
    let width = test.image.width();
    let pair = Pair { width, a: &a, b: &b, noise, rounding: &rounding };
    Ok(Comparison {
        width,
        height: test.image.height(),
        difference: a.iter().zip(&b).map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect(),
        means: [[0, 1, 2].map(|c| mean(&|pair| pair.0[c])), [0, 1, 2].map(|c| mean(&|pair| pair.1[c]))],
        nonfinite,
        identical: a == b,
        metrics: metrics::metrics(&pairs),
        flip: (nonfinite == [0, 0]).then(|| {
            let map = flip::map(&b, &a, width, settings.pixels_per_degree);
            map.iter().copied().collect::<Neumaier>().value() / map.len() as f64
        }),
        noise: if noise == [None, None] { None } else { pair.test(settings.level, settings.outliers) },
        settings,
    })
}

/// The colours of one pixel in test and reference.
type Colours = ([f64; 3], [f64; 3]);

fn colours(side: &Side) -> Result<Vec<[f64; 3]>, CompareError> {
    if !side.image.has_colour() {
        let planes = side.image.names().collect::<Vec<_>>().join(", ");
        return Err(CompareError::NoColour { name: side.name.clone(), planes });
    }
    Ok(side.image.pixels_linear_rgb().into_iter().map(|rgb| rgb.map(f64::from)).collect())
}

/// The variance by which the files of both have rounded one pixel: an error uniform in ±r has the variance r²/3.
fn rounding(sides: [(&Side, &[f64; 3]); 2]) -> [f64; 3] {
    let one = |(side, pixel): (&Side, &[f64; 3]), channel: usize| {
        let brightest = pixel[0].max(pixel[1]).max(pixel[2]);
        side.image.storage().rounding(pixel[channel], brightest).powi(2) / 3.0
    };
    [0, 1, 2].map(|channel| sides.into_iter().map(|side| one(side, channel)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(values: &[f32], variance: Option<f32>) -> Side {
        let pixels: Vec<[f32; 3]> = values.iter().map(|v| [*v; 3]).collect();
        let mut image = Image::from_rgb(values.len(), 1, &pixels).unwrap();
        for name in ["Variance.R", "Variance.G", "Variance.B"] {
            if let Some(variance) = variance {
                image.push(name, vec![variance; values.len()]).unwrap();
            }
        }
        let noise = stated_noise(&image);
        Side { name: "x".into(), image, noise, noise_source: String::new() }
    }

    fn verdict(a: &Side, b: &Side) -> Verdict {
        compare(a, b, Settings { outliers: 0.0, ..Settings::default() }).unwrap().verdict()
    }

    #[test]
    fn verdicts() {
        let noisy = |v: f32| side(&[v, 1.0], Some(1e-4));
        let plain = |v: f32| side(&[v, 1.0], None);
        assert_eq!(verdict(&noisy(1.01), &noisy(1.0)), Verdict::Equal);
        assert_eq!(verdict(&noisy(1.1), &noisy(1.0)), Verdict::Differ);
        assert_eq!(verdict(&noisy(1.01), &plain(1.0)), Verdict::Equal);
        assert_eq!(verdict(&plain(1.01), &plain(1.0)), Verdict::Undecided);
        assert_eq!(verdict(&plain(1.0), &plain(1.0)), Verdict::Equal);
        assert_eq!(verdict(&side(&[1.0, 1.01], Some(f32::INFINITY)), &plain(1.0)), Verdict::Undecided);
    }

    #[test]
    fn a_nan_never_passes_even_against_itself() {
        let bad = side(&[f32::NAN, 1.0], Some(1.0));
        assert_eq!(verdict(&bad, &bad), Verdict::Differ);
        let result = compare(&bad, &side(&[1.0, 1.0], None), Settings::default()).unwrap();
        assert_eq!((result.nonfinite, result.flip, result.metrics[0].value), ([1, 0], None, 0.0));
    }

    #[test]
    fn what_files_round_away_is_no_difference() {
        let exact = side(&[0.3, 0.7], Some(0.0));
        let bytes = exact.image.encode(crate::image::Format::Hdr, 0.0).unwrap();
        let image = Image::decode(&bytes, std::path::Path::new("x")).unwrap();
        let rounded = Side { image, noise: None, ..exact.clone() };
        assert_ne!(rounded.image.rgb(0, 0), exact.image.rgb(0, 0));
        assert_eq!(verdict(&exact, &rounded), Verdict::Equal);
    }

    #[test]
    fn variances_of_samples_become_those_of_means() {
        let per_sample = side(&[4.0, -1.0], None).image;
        assert_eq!(noise_of_samples(&per_sample, 16.0).variance, [[0.25; 3], [1e-4 / 16.0; 3]]);
        let scaled = noise_scaled(&noise_of_samples(&per_sample, 16.0), 16.0, 64.0);
        assert_eq!(scaled.variance[0], [0.0625; 3]);
    }

    #[test]
    fn pictures_of_different_size_or_without_colour_are_refused() {
        let error = compare(&side(&[1.0], None), &side(&[1.0; 2], None), Settings::default()).unwrap_err();
        assert_eq!(error.to_string(), "the sizes differ: x is 1 x 1, x is 2 x 1");
        let mut image = Image::new(1, 1);
        image.push("n.X", vec![0.0]).unwrap();
        image.push("n.Y", vec![0.0]).unwrap();
        let normals = Side { image, ..side(&[1.0], None) };
        let error = compare(&normals, &side(&[1.0], None), Settings::default()).unwrap_err();
        assert_eq!(error.to_string(), "x: no planes are a colour; it has n.X, n.Y");
    }
}
