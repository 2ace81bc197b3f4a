//! The film: mean, variance and count of the samples of every pixel and channel.
//!
//! Each pixel keeps n, the mean and M2 = Σ (x − mean)² per channel (Welford). Two films merge into what one film of
//! all samples would hold, to rounding. Nothing is clamped.
//!
//! Samples that know of each other (see [`points`](crate::sampling::points)) spread far more than their mean errs. Those of
//! a sequence are therefore gathered in batches: M2 = Σ m (x − mean)² over the means x of batches of m samples. The K batches of one net
//! complement each other, so their covariance c is negative, and with variance v of one batch's mean the estimate is
//! (v − c) / K on average where the truth is (v + (K − 1) c) / K: the error bars stay an upper bound, and come nearer the
//! truth the larger the batches are. Batches of 1, for independent samples, make it exact.
//!
//! A sample with a channel that is NaN or infinite has no value: it is left out of n, mean and M2 of all three
//! channels and counted in `nonfinite`, which every output states. What is left is the mean given a finite sample, so
//! any number above 0 says that the estimator is at fault. A pixel without a finite sample is NaN.
//! # References
//! - Welford 1962, Technometrics 4(3)
//! - Chan, Golub & LeVeque 1983, The American Statistician 37(3), eq. 1.5

use std::collections::BTreeMap;

use glam::DVec3;

use crate::image::Image;
use crate::math::color::Rgb;
use crate::math::sum::Neumaier;

/// The samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Finite samples.
    pub n: u64,
    /// Samples left out because a channel was NaN or infinite.
    pub nonfinite: u64,
    /// Batches that are full.
    pub batches: u64,
    /// Mean of the finite samples of full batches per channel; 0 for none.
    pub mean: DVec3,
    /// Sum over full batches of the number of their samples times the squared deviation of theirs from the mean, per
    /// channel.
    pub m2: DVec3,
    /// The batch that is not full.
    pub open: Open,
}

/// The samples of a batch that is not full.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Open {
    /// Finite samples.
    pub n: u64,
    /// Their sum per channel.
    pub sum: DVec3,
}

impl Pixel {
    /// Adds one sample, every so many being a batch: a power of two.
    #[inline]
    pub fn add(&mut self, sample: Rgb, batch: u64) {
        if sample.is_finite() {
            self.n += 1;
            if batch == 1 {
                self.close(1.0, sample.0);
                return;
            }
            self.open.n += 1;
            self.open.sum += sample.0;
        } else {
            self.nonfinite += 1;
        }
        if self.open.n > 0 && self.drawn() & (batch - 1) == 0 {
            let Open { n, sum } = std::mem::take(&mut self.open);
            self.close(n as f64, sum / n as f64);
        }
    }

    /// All samples, finite or not.
    pub fn drawn(&self) -> u64 {
        self.n + self.nonfinite
    }

    /// Takes the mean of a batch of so many samples, which are counted in n.
    #[inline]
    fn close(&mut self, samples: f64, mean: DVec3) {
        self.batches += 1;
        let delta = mean - self.mean;
        self.mean += delta * samples / (self.n - self.open.n) as f64;
        self.m2 += delta * (mean - self.mean) * samples;
    }

    /// The same with the open batch counted as a full one.
    #[must_use]
    pub fn closed(&self) -> Self {
        let Open { n, sum } = self.open;
        let mut closed = Self { open: Open::default(), ..*self };
        if n > 0 {
            closed.close(n as f64, sum / n as f64);
        }
        closed
    }

    /// The samples of both, with their open batches closed.
    #[must_use]
    pub fn merge(&self, other: &Self) -> Self {
        let (one, other) = (self.closed(), other.closed());
        let nonfinite = one.nonfinite + other.nonfinite;
        if one.n == 0 || other.n == 0 {
            let filled = if one.n == 0 { other } else { one };
            return Self { nonfinite, ..filled };
        }
        let (a, b) = (one.n as f64, other.n as f64);
        let delta = other.mean - one.mean;
        Self {
            n: one.n + other.n,
            nonfinite,
            batches: one.batches + other.batches,
            mean: one.mean + delta * (b / (a + b)),
            m2: one.m2 + other.m2 + delta * delta * (a * b / (a + b)),
            open: Open::default(),
        }
    }

    /// The mean; NaN without a finite sample.
    pub fn mean(&self) -> Rgb {
        if self.n == 0 { Rgb::grey(f64::NAN) } else { Rgb(self.closed().mean) }
    }

    /// The estimate of the mean's variance, M2 / (n (K − 1)) for K batches, unbiased if they are independent and as large
    /// as each other; infinite for fewer than two.
    pub fn variance_of_mean(&self) -> Rgb {
        let closed = self.closed();
        if closed.batches < 2 {
            return Rgb::grey(f64::INFINITY);
        }
        Rgb(closed.m2 / (closed.n as f64 * (closed.batches - 1) as f64))
    }
}

/// Why two films do not merge, or an image is no film.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum FilmError {
    /// Films of different size.
    #[error("the sizes differ: {} x {} and {} x {}", .0[0], .0[1], .1[0], .1[1])]
    Size([usize; 2], [usize; 2]),
    /// The image lacks a plane that a film has.
    #[error("there is no plane {0}: a film has R, G, B, Variance.R, Variance.G, Variance.B and Samples")]
    Plane(&'static str),
    /// A plane holds what no film would.
    #[error("plane {plane}: {value} in column {x}, row {y}; allowed is {allowed}")]
    Value {
        /// The plane.
        plane: &'static str,
        /// Its value.
        value: f32,
        /// Where, from the left.
        x: usize,
        /// Where, from the top.
        y: usize,
        /// What it may be.
        allowed: &'static str,
    },
}

/// The samples of an image. Row 0 is the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: usize,
    height: usize,
    batch: u64,
    pixels: Vec<Pixel>,
}

impl Film {
    /// A film without samples, for independent ones.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, batch: 1, pixels: vec![Pixel::default(); width * height] }
    }

    /// The same for samples whose error is to be judged from batches of so many: 1, or a power of two.
    ///
    /// Panics for other numbers.
    #[must_use]
    pub fn with_batches(self, samples: u64) -> Self {
        assert!(samples.is_power_of_two(), "a batch of {samples} samples; allowed are powers of two");
        Self { batch: samples, ..self }
    }

    /// A film of these pixels, row by row; None unless there are `width` x `height`.
    pub fn from_pixels(width: usize, height: usize, pixels: Vec<Pixel>) -> Option<Self> {
        (width.checked_mul(height) == Some(pixels.len())).then_some(Self { width, height, batch: 1, pixels })
    }

    /// Samples of a batch.
    pub fn batch(&self) -> u64 {
        self.batch
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// The pixels, to be split among threads: each pixel's samples must come in one order for the bits to be the same.
    pub fn pixels_mut(&mut self) -> &mut [Pixel] {
        &mut self.pixels
    }

    /// Adds a sample to the pixel in column `x` and row `y`. Panics where there is none.
    pub fn add(&mut self, x: usize, y: usize, sample: Rgb) {
        assert!(x < self.width && y < self.height, "no pixel ({x}, {y}) on a film of {} x {}", self.width, self.height);
        self.pixels[y * self.width + x].add(sample, self.batch);
    }

    /// The pixel in column `x` and row `y`. Panics where there is none.
    pub fn pixel(&self, x: usize, y: usize) -> &Pixel {
        assert!(x < self.width && y < self.height, "no pixel ({x}, {y}) on a film of {} x {}", self.width, self.height);
        &self.pixels[y * self.width + x]
    }

    /// The mean of a pixel; NaN without a finite sample.
    pub fn mean(&self, x: usize, y: usize) -> Rgb {
        self.pixel(x, y).mean()
    }

    /// The estimated variance of that mean; infinite for fewer than two samples.
    pub fn variance_of_mean(&self, x: usize, y: usize) -> Rgb {
        self.pixel(x, y).variance_of_mean()
    }

    /// Finite samples of the whole film.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(|pixel| pixel.n).sum()
    }

    /// Samples that were drawn for some pixel, and for no pixel more.
    pub fn most_drawn(&self) -> u64 {
        self.pixels.iter().map(Pixel::drawn).max().unwrap_or(0)
    }

    /// Samples of the whole film that were NaN or infinite.
    pub fn nonfinite(&self) -> u64 {
        self.pixels.iter().map(|pixel| pixel.nonfinite).sum()
    }

    /// The mean over all pixels; NaN if some pixel has no finite sample, or there is no pixel.
    pub fn image_mean(&self) -> Rgb {
        self.average(Pixel::mean)
    }

    /// The expected root of the mean squared error against the converged image: the root of the mean over pixels and
    /// channels of the variance of the mean. Infinite while some pixel has fewer than two batches.
    pub fn rmse_estimate(&self) -> f64 {
        // A compensated sum of infinities would be ∞ − ∞.
        let known = self.pixels.iter().all(|pixel| pixel.batches + u64::from(pixel.open.n > 0) >= 2);
        if known { self.average(Pixel::variance_of_mean).mean().sqrt() } else { f64::INFINITY }
    }

    /// [`Self::rmse_estimate`] over the mean of the image, over all pixels and channels; 0 where the former is 0.
    ///
    /// It is itself an estimate: light that no sample has found yet is not in it.
    pub fn relative_error(&self) -> f64 {
        let rmse = self.rmse_estimate();
        if rmse == 0.0 { 0.0 } else { rmse / self.image_mean().mean().abs() }
    }

    fn average(&self, value: impl Fn(&Pixel) -> Rgb) -> Rgb {
        let mut sums = [Neumaier::default(); 3];
        for pixel in &self.pixels {
            for (sum, x) in sums.iter_mut().zip(value(pixel).to_array()) {
                sum.add(x);
            }
        }
        Rgb::from(sums.map(|sum| sum.value())) / self.pixels.len() as f64
    }

    /// Adds the samples of another film of the same size.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(FilmError::Size([self.width, self.height], [other.width, other.height]));
        }
        for (pixel, more) in self.pixels.iter_mut().zip(&other.pixels) {
            *pixel = pixel.merge(more);
        }
        Ok(())
    }

    /// The planes R, G, B (means), Variance.R, .G, .B (variances of the means), Samples, Batches unless every sample is one,
    /// and NonFinite where any sample was; with `metadata` and the key `nonfinite`.
    ///
    /// The image holds f32: means and variances are rounded to 24 bits.
    pub fn to_image(&self, metadata: &BTreeMap<String, String>) -> Image {
        let mut image = Image::new(self.width, self.height);
        let mut plane = |name: &str, value: &dyn Fn(&Pixel) -> f64| {
            let samples = self.pixels.iter().map(|pixel| value(pixel) as f32).collect();
            // The names differ, and every plane has a sample for each pixel: nothing can be refused.
            let pushed = image.push(name, samples);
            debug_assert!(pushed.is_ok(), "{pushed:?}");
        };
        for channel in 0..3 {
            plane(COLOUR[channel], &|pixel| pixel.mean().0[channel]);
            plane(VARIANCE[channel], &|pixel| pixel.variance_of_mean().0[channel]);
        }
        plane(SAMPLES, &|pixel| pixel.n as f64);
        if self.pixels.iter().any(|pixel| pixel.closed().batches != pixel.n) {
            plane(BATCHES, &|pixel| pixel.closed().batches as f64);
        }
        if self.nonfinite() > 0 {
            plane(NONFINITE, &|pixel| pixel.nonfinite as f64);
        }
        for (key, value) in metadata {
            image.set_metadata(key, value.as_str());
        }
        image.set_metadata("nonfinite", self.nonfinite().to_string());
        image
    }

    /// The film that [`Self::to_image`] made, as exactly as f32 holds it.
    pub fn from_image(image: &Image) -> Result<Self, FilmError> {
        let find = |name: &'static str| image.plane(name).ok_or(FilmError::Plane(name));
        let three = |[r, g, b]: [&'static str; 3]| Ok::<_, FilmError>([find(r)?, find(g)?, find(b)?]);
        let (means, variances) = (three(COLOUR)?, three(VARIANCE)?);
        let (samples, batches, nonfinite) = (find(SAMPLES)?, image.plane(BATCHES), image.plane(NONFINITE));
        let mut film = Self::new(image.width(), image.height());
        for (at, pixel) in film.pixels.iter_mut().enumerate() {
            let checked = |plane: &'static str, value: f32, allowed: &'static str, good: bool| {
                let (x, y) = (at % image.width(), at / image.width());
                if good { Ok(f64::from(value)) } else { Err(FilmError::Value { plane, value, x, y, allowed }) }
            };
            let count = |plane: &'static str, value: f32| {
                let whole = value >= 0.0 && value.fract() == 0.0 && value.is_finite();
                checked(plane, value, "a whole number", whole).map(|count| count as u64)
            };
            pixel.n = count(SAMPLES, samples[at])?;
            pixel.batches = batches.map_or(Ok(pixel.n), |plane| {
                let allowed = "a whole number from 1 to that of samples";
                let good = (1.0..=samples[at]).contains(&plane[at]) && plane[at].fract() == 0.0;
                checked(BATCHES, plane[at], allowed, good || pixel.n == 0).map(|count| count as u64)
            })?;
            pixel.nonfinite = nonfinite.map_or(Ok(0), |plane| count(NONFINITE, plane[at]))?;
            if pixel.n == 0 {
                continue;
            }
            let n = pixel.n as f64;
            for channel in 0..3 {
                let (mean, variance) = (means[channel][at], variances[channel][at]);
                pixel.mean[channel] = checked(COLOUR[channel], mean, "a finite number", mean.is_finite())?;
                if pixel.batches > 1 {
                    // A variance beyond f32 is infinite, and stays so.
                    let variance = checked(VARIANCE[channel], variance, "a number from 0", variance >= 0.0)?;
                    pixel.m2[channel] = variance * n * (pixel.batches - 1) as f64;
                }
            }
        }
        Ok(film)
    }
}

const COLOUR: [&str; 3] = ["R", "G", "B"];
const VARIANCE: [&str; 3] = ["Variance.R", "Variance.G", "Variance.B"];
const SAMPLES: &str = "Samples";
const BATCHES: &str = "Batches";
const NONFINITE: &str = "NonFinite";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use approx::assert_relative_eq;

    /// `n` samples of a skewed distribution about 1 in pixel `at`.
    fn samples(at: u64, n: u64) -> Vec<Rgb> {
        let mut rng = stream(11, at, 0);
        (0..n).map(|_| Rgb::new(-uniform(&mut rng).ln(), uniform(&mut rng), 0.25)).collect()
    }

    fn film(counts: [u64; 2], seed: u64) -> Film {
        let mut film = Film::new(2, 1);
        for (x, n) in counts.into_iter().enumerate() {
            for sample in samples(seed + x as u64, n) {
                film.add(x, 0, sample);
            }
        }
        film
    }

    #[test]
    fn moments_are_those_of_the_textbook() {
        let film = film([50, 2], 0);
        let values: Vec<f64> = samples(0, 50).iter().map(|s| s.0.x).collect();
        let mean = values.iter().sum::<f64>() / 50.0;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 49.0 / 50.0;
        // Fifty roundings of either sum.
        assert_relative_eq!(film.mean(0, 0).0.x, mean, max_relative = 1e-14);
        assert_relative_eq!(film.variance_of_mean(0, 0).0.x, variance, max_relative = 1e-13);
        assert_eq!(film.variance_of_mean(0, 0).0.z, 0.0, "a constant has no variance");
        assert_eq!(film.mean(0, 0).0.z, 0.25);
    }

    #[test]
    fn a_large_offset_does_not_eat_the_variance() {
        let mut film = Film::new(1, 1);
        for i in 0..1000 {
            film.add(0, 0, Rgb::grey(1e8 + f64::from(i % 2)));
        }
        // The textbook's Σx² − n mean² has no digit left here. Variance 1/4 · 1000/999 of one sample.
        assert_relative_eq!(film.variance_of_mean(0, 0).0.x, 0.25 / 999.0, max_relative = 1e-7);
    }

    #[test]
    fn merging_is_adding_all() {
        let (mut a, b) = (film([30, 0], 0), film([70, 5], 0));
        let mut whole = Film::new(2, 1);
        for sample in samples(0, 30).into_iter().chain(samples(0, 70)) {
            whole.add(0, 0, sample);
        }
        for sample in samples(1, 5) {
            whole.add(1, 0, sample);
        }
        a.merge(&b).unwrap();
        for (merged, all) in a.pixels().iter().zip(whole.pixels()) {
            assert_eq!(merged.n, all.n);
            // A hundred roundings.
            assert!(merged.mean.abs_diff_eq(all.mean, 1e-14) && merged.m2.abs_diff_eq(all.m2, 1e-12), "{merged:?}");
        }
        let naive = f64::midpoint(film([30, 0], 0).mean(0, 0).0.x, b.mean(0, 0).0.x);
        assert!((naive - whole.mean(0, 0).0.x).abs() > 1e-3, "a plain average must fail, or this test shows nothing");
        assert_eq!(a.merge(&Film::new(1, 2)), Err(FilmError::Size([2, 1], [1, 2])));
    }

    #[test]
    fn the_stated_error_is_the_error() {
        let mut film = Film::new(2000, 1);
        for (at, pixel) in film.pixels_mut().iter_mut().enumerate() {
            let mut rng = stream(5, at as u64, 1);
            (0..8).for_each(|_| pixel.add(Rgb::grey(uniform(&mut rng)), 1));
        }
        // Var of a sample variance is (κ − 1 + 2/(n−1))σ⁴/n with κ = 1.8: 0.136 σ⁴; over 2000 pixels 0.8 %. Its root
        // deviates by half of that, and five such deviations are 2 %.
        let expected = (1.0 / 12.0 / 8.0_f64).sqrt();
        assert_relative_eq!(film.rmse_estimate(), expected, max_relative = 0.02);
        let actual = film.pixels().iter().map(|p| (p.mean.x - 0.5).powi(2)).sum::<f64>() / 2000.0;
        // A mean of 2000 squared near-Gaussians deviates by sqrt(2/2000) = 3 %, its root by 1.6 %; five of these.
        assert_relative_eq!(film.rmse_estimate(), actual.sqrt(), max_relative = 0.08);
        assert_relative_eq!(film.relative_error(), expected / 0.5, max_relative = 0.03);
    }

    /// 8 samples that complement each other, one in each eighth of [0, 1): any 2 or 4 from the first on are as even.
    fn complementary(at: u64) -> [Rgb; 8] {
        let mut rng = stream(6, at, 1);
        // A flip of the first digit, of each half's second, and of each quarter's third.
        let flips: [u8; 7] = std::array::from_fn(|_| u8::from(uniform(&mut rng) < 0.5));
        std::array::from_fn(|i| {
            let eighth = (i as u8).reverse_bits() >> 5;
            let flip = flips[0] << 2 | flips[1 + usize::from(eighth / 4)] << 1 | flips[3 + usize::from(eighth / 2)];
            Rgb::grey((f64::from(eighth ^ flip) + uniform(&mut rng)) / 8.0)
        })
    }

    #[test]
    fn batches_bound_the_error_of_samples_that_know_of_each_other() {
        const PIXELS: usize = 20_000;
        // The mean of n strata has the variance v(n) = 1 / (12 n³). With K batches of m the truth v(8) = (v(m) + (K − 1) c) / K
        // tells c, and (v(m) − c) / K is 73, 21 and 7 times the truth for m = 1, 2 and 4.
        let v = |n: f64| 1.0 / (12.0 * n.powi(3));
        for (batch, expected) in [(1, 73.0), (2, 21.0), (4, 7.0)] {
            let mut film = Film::new(PIXELS, 1).with_batches(batch);
            for at in 0..PIXELS {
                for sample in complementary(at as u64) {
                    film.add(at, 0, sample);
                }
            }
            let errors = film.pixels().iter().map(|p| (p.mean().0.x - 0.5).powi(2));
            // 20 000 squares of nearly normal values spread by 1 %, variances from K batches by √(2 / (K − 1)) of that.
            assert_relative_eq!(errors.sum::<f64>() / PIXELS as f64, v(8.0), max_relative = 0.05);
            assert_relative_eq!(film.rmse_estimate().powi(2) / v(8.0), expected, max_relative = 0.05);
        }
    }

    #[test]
    fn a_batch_that_is_not_full_counts_as_one() {
        let values = samples(0, 11);
        let mut film = Film::new(1, 1).with_batches(4);
        for sample in &values {
            film.add(0, 0, *sample);
        }
        let pixel = film.pixel(0, 0);
        assert_eq!((pixel.n, pixel.batches, pixel.open.n, pixel.closed().batches), (11, 2, 3, 3));
        let mean_of = |part: &[Rgb]| part.iter().map(|s| s.0.x).sum::<f64>() / part.len() as f64;
        let mean = mean_of(&values);
        // Sixteen roundings.
        assert_relative_eq!(film.mean(0, 0).0.x, mean, max_relative = 1e-14);
        let m2: f64 = values.chunks(4).map(|part| part.len() as f64 * (mean_of(part) - mean).powi(2)).sum();
        assert_relative_eq!(film.variance_of_mean(0, 0).0.x, m2 / (11.0 * 2.0), max_relative = 1e-12);
        // A lost sample is in its batch and counts for nothing.
        film.add(0, 0, Rgb::grey(f64::NAN));
        assert_eq!((film.pixel(0, 0).batches, film.pixel(0, 0).open.n), (3, 0));
        let image = film.to_image(&BTreeMap::new());
        assert_eq!(image.plane("Batches").unwrap(), [3.0]);
        let back = Film::from_image(&image).unwrap();
        assert_eq!(back.pixel(0, 0).batches, 3);
        assert_relative_eq!(back.variance_of_mean(0, 0).0.x, m2 / 22.0, max_relative = 1e-6);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_not_hidden() {
        let mut film = Film::new(2, 1);
        for sample in [1.0, f64::NAN, 3.0, f64::INFINITY] {
            film.add(0, 0, Rgb::new(sample, 1.0, 1.0));
        }
        assert_eq!((film.pixel(0, 0).n, film.pixel(0, 0).nonfinite, film.nonfinite()), (2, 2, 2));
        assert_eq!(film.mean(0, 0), Rgb::new(2.0, 1.0, 1.0));
        assert!(film.mean(1, 0).0.x.is_nan() && film.image_mean().0.x.is_nan());
        assert_eq!((film.rmse_estimate(), film.samples()), (f64::INFINITY, 2));
        let image = film.to_image(&BTreeMap::new());
        assert_eq!(image.metadata()["nonfinite"], "2");
        assert_eq!(image.plane("NonFinite").unwrap(), [2.0, 0.0]);
        assert_eq!(Film::from_image(&image).unwrap(), film);
    }

    #[test]
    fn images_keep_a_film_to_single_precision() {
        let film = film([50, 3], 0);
        let image = film.to_image(&[("scene".to_string(), "box".to_string())].into());
        assert_eq!(image.metadata()["scene"], "box");
        let back = Film::from_image(&image).unwrap();
        for (a, b) in film.pixels().iter().zip(back.pixels()) {
            assert_eq!(a.n, b.n);
            for channel in 0..3 {
                assert_relative_eq!(a.mean[channel], b.mean[channel], max_relative = 6e-8);
                assert_relative_eq!(a.m2[channel], b.m2[channel], max_relative = 6e-8);
            }
        }
    }

    #[test]
    fn images_that_are_no_film_say_why() {
        let mut image = Image::from_rgb(1, 1, &[[1.0; 3]]).unwrap();
        image.push("Samples", vec![2.0]).unwrap();
        assert_eq!(Film::from_image(&image), Err(FilmError::Plane("Variance.R")));
        for channel in VARIANCE {
            image.push(channel, vec![-1.0]).unwrap();
        }
        let error = Film::from_image(&image).unwrap_err().to_string();
        assert_eq!(error, "plane Variance.R: -1 in column 0, row 0; allowed is a number from 0");
    }
}
