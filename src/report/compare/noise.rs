//! Bias against noise: is the difference of two pictures what their variances let one expect?
//!
//! With the variances of both means, every pixel and channel has z = (a − b) / √(var a + var b). For equal
//! expectations z has mean 0 and mean square 1. Three tests share the level, each at a third of it:
//! - **pixels**: |z| of each pixel and channel against Šidák's bound for their number. A pixel's variance is itself
//!   estimated, so for known counts z follows Student's t (degrees of freedom by Welch and Satterthwaite). The sample
//!   variance of skewed values is still unreliable: a pixel that has missed a rare bright path is dark *and* claims a
//!   small variance. A small share of pixels beyond the bound is therefore allowed.
//! - **blocks**: the sum of differences over blocks of 16 x 16 pixels, of which no one may be beyond Šidák's bound. Sums
//!   are nearer to the normal distribution, so this sees a small object that is wrong.
//! - **image**: the difference of the means of the whole pictures in each channel. This sees a bias of a tenth of a
//!   percent that no pixel shows.
//!
//! Mean z and mean z² are shown and not judged: the pixel that has missed a bright path makes the one negative and the
//! other large in a correct picture. A mean z² well above what is expected says that variances are stated too small, that
//! a picture taken as exact is not, or that pixels differ in many places by less than their noise.
//!
//! Sums take pixels for independent: true where every sample belongs to one pixel, not where a wide filter spreads each
//! sample over several, which makes the noise of a block look smaller than it is.
//! # References
//! - Šidák 1967, J. Am. Stat. Assoc. 62
//! - Welch 1947, Biometrika 34
//! - Subr & Arvo 2007, Statistical hypothesis testing for assessing Monte Carlo estimators, Pacific Graphics

use std::fmt;

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::math::sum::Neumaier;

/// Rows and columns of a block.
pub const BLOCK: usize = 16;

/// What is known of the noise of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Variance of each pixel's mean, per channel, row by row; infinite where it is not known.
    pub variance: Vec<[f64; 3]>,
    /// Samples or batches of each pixel that its variance was estimated from; None if the variances count as exact.
    pub samples: Option<Vec<f64>>,
}

/// One place of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Column from the left, of a block its first.
    pub x: usize,
    /// Row from the top, of a block its first.
    pub y: usize,
    /// 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// The largest |z|, with its sign.
    pub z: f64,
}

/// Many z at once, under Šidák's bound for their number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManyTests {
    /// How many pixels or blocks were tested, in three channels each.
    pub tested: usize,
    /// How many of them have a channel beyond the bound.
    pub failing: usize,
    /// How many may.
    pub allowed: usize,
    /// The bound on |z|, at the worst one's degrees of freedom.
    pub bound: f64,
    /// The largest |z|.
    pub worst: Worst,
}

impl ManyTests {
    /// Whether no more than the allowed number are beyond the bound.
    pub fn holds(&self) -> bool {
        self.failing <= self.allowed
    }
}

/// The difference of the means of the whole pictures in one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelTest {
    /// Mean of a less mean of b, over the pixels tested.
    pub difference: f64,
    /// Its standard error.
    pub std_err: f64,
    /// The one over the other; 0 for 0 over 0.
    pub z: f64,
    /// Mean of the reference over the pixels tested.
    pub reference: f64,
}

/// What became of all tests.
#[derive(Clone, PartialEq)]
pub struct NoiseTest {
    /// z of each pixel and channel, row by row; NaN where there is none.
    pub z: Vec<[f64; 3]>,
    /// Pixels without a test: fewer than two samples, or not finite.
    pub untested: usize,
    /// Mean of z over the pixels and channels tested: 0 is expected.
    pub mean_z: f64,
    /// Mean of z².
    pub mean_z2: f64,
    /// What is expected of [`Self::mean_z2`]: 1, or the mean of ν/(ν − 2) over degrees of freedom ν; None where a ν
    /// is not above 2.
    pub expected_z2: Option<f64>,
    /// Pixel by pixel.
    pub pixels: ManyTests,
    /// Block by block.
    pub blocks: ManyTests,
    /// The whole picture, red, green and blue.
    pub image: [ChannelTest; 3],
    /// The bound on |z| in [`Self::image`].
    pub image_bound: f64,
}

impl fmt::Debug for NoiseTest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NoiseTest")
            .field("mean_z", &self.mean_z)
            .field("mean_z2", &self.mean_z2)
            .field("pixels", &self.pixels)
            .field("blocks", &self.blocks)
            .field("image", &self.image)
            .finish_non_exhaustive()
    }
}

impl NoiseTest {
    /// Whether the whole pictures have the same means.
    pub fn image_holds(&self) -> bool {
        self.image.iter().all(|channel| channel.z.abs() <= self.image_bound)
    }

    /// Whether all three tests hold.
    pub fn holds(&self) -> bool {
        self.pixels.holds() && self.blocks.holds() && self.image_holds()
    }
}

/// The two pictures of a test, row by row, b the reference; None is a picture taken as exact.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// Columns.
    pub width: usize,
    /// Linear colours of a.
    pub a: &'a [[f64; 3]],
    /// Linear colours of b.
    pub b: &'a [[f64; 3]],
    /// Noise of either.
    pub noise: [Option<&'a Noise>; 2],
    /// Variances by which files have rounded both, for each pixel and channel.
    pub rounding: &'a [[f64; 3]],
}

impl Pair<'_> {
    fn variance(&self, at: usize, channel: usize) -> f64 {
        let known = self.noise.iter().flatten().map(|noise| noise.variance[at][channel]);
        known.sum::<f64>() + self.rounding[at][channel]
    }

    /// Degrees of freedom of the variance of one pixel; infinite where it counts as exact.
    fn freedom(&self, at: usize, channel: usize) -> f64 {
        let spread = |noise: &&Noise| {
            let samples = noise.samples.as_ref()?[at];
            Some(noise.variance[at][channel].powi(2) / (samples - 1.0))
        };
        let uncertain: f64 = self.noise.iter().flatten().filter_map(spread).sum();
        // No variance at all: nothing is uncertain.
        if uncertain > 0.0 { self.variance(at, channel).powi(2) / uncertain } else { f64::INFINITY }
    }

    fn testable(&self, at: usize) -> bool {
        let finite = |v: &[f64; 3]| v.iter().all(|x| x.is_finite());
        let known = self.noise.iter().flatten().all(|noise| finite(&noise.variance[at]));
        known && finite(&self.a[at]) && finite(&self.b[at])
    }

    /// Runs all tests at the family-wise `level`, with the share `outliers` of pixels allowed beyond their bound.
    ///
    /// None where no pixel can be tested.
    pub fn test(&self, level: f64, outliers: f64) -> Option<NoiseTest> {
        let level = level / 3.0;
        let tested: Vec<bool> = (0..self.a.len()).map(|at| self.testable(at)).collect();
        let count = tested.iter().filter(|t| **t).count();
        if count == 0 {
            return None;
        }
        let ratio = |difference: f64, variance: f64| if difference == 0.0 { 0.0 } else { difference / variance.sqrt() };
        let z_of = |at: usize, c: usize| ratio(self.a[at][c] - self.b[at][c], self.variance(at, c));
        let z: Vec<[f64; 3]> = (0..self.a.len())
            .map(|at| if tested[at] { [0, 1, 2].map(|c| z_of(at, c)) } else { [f64::NAN; 3] })
            .collect();
        let flat = || (0..z.len()).filter(|at| tested[*at]).flat_map(|at| (0..3).map(move |c| (at, c)));
        let mean = |value: &dyn Fn(usize, usize) -> f64| {
            let values = || flat().map(|(at, c)| value(at, c));
            // A compensated sum of infinities would be ∞ − ∞.
            let infinite = values().find(|v| v.is_infinite());
            infinite.unwrap_or_else(|| values().collect::<Neumaier>().value() / (3 * count) as f64)
        };
        let freedom_counts = self.noise.iter().flatten().any(|noise| noise.samples.is_some());
        let inflation = |at: usize, c: usize| {
            let freedom = self.freedom(at, c);
            if freedom > 2.0 { 1.0 / (1.0 - 2.0 / freedom) } else { f64::INFINITY }
        };
        let expected_z2 = if freedom_counts { mean(&inflation) } else { 1.0 };
        Some(NoiseTest {
            untested: self.a.len() - count,
            mean_z: mean(&|at, c| z[at][c]),
            mean_z2: mean(&|at, c| z[at][c] * z[at][c]),
            expected_z2: expected_z2.is_finite().then_some(expected_z2),
            pixels: self.pixel_test(&z, count, level, outliers),
            blocks: self.block_test(&tested, level),
            image: [0, 1, 2].map(|c| {
                let over = |value: &dyn Fn(usize) -> f64| {
                    let values = (0..z.len()).filter(|at| tested[*at]).map(value);
                    values.collect::<Neumaier>().value() / count as f64
                };
                let difference = over(&|at| self.a[at][c] - self.b[at][c]);
                let variance = over(&|at| self.variance(at, c)) / count as f64;
                let (z, reference) = (ratio(difference, variance), over(&|at| self.b[at][c]));
                ChannelTest { difference, std_err: variance.sqrt(), z, reference }
            }),
            image_bound: normal_bound(sidak(level, 3)),
            z,
        })
    }

    fn pixel_test(&self, z: &[[f64; 3]], count: usize, level: f64, outliers: f64) -> ManyTests {
        let p = sidak(level, 3 * count);
        let bound = normal_bound(p);
        let mut failing = 0;
        let mut worst = Worst { x: 0, y: 0, channel: 0, z: 0.0 };
        for (at, pixel) in z.iter().enumerate() {
            let mut fails = false;
            for (channel, &z) in pixel.iter().enumerate().filter(|(_, z)| !z.is_nan()) {
                if z.abs() > worst.z.abs() {
                    worst = Worst { x: at % self.width, y: at / self.width, channel, z };
                }
                // Student's t has heavier tails than the normal: what is within the normal bound is within its own.
                fails |= z.abs() > bound && t_p(z, self.freedom(at, channel)) < p;
            }
            failing += usize::from(fails);
        }
        let allowed = (outliers * count as f64).floor() as usize;
        let bound = t_bound(p, self.freedom(worst.y * self.width + worst.x, worst.channel));
        ManyTests { tested: count, failing, allowed, bound, worst }
    }

    fn block_test(&self, tested: &[bool], level: f64) -> ManyTests {
        let across = self.width.div_ceil(BLOCK);
        let rows = tested.len() / self.width;
        // Per block: tested pixels, and the sums of difference and variance in each channel.
        let mut blocks = vec![(0_usize, [(0.0, 0.0); 3]); across * rows.div_ceil(BLOCK)];
        for at in (0..tested.len()).filter(|at| tested[*at]) {
            let block = &mut blocks[at / self.width / BLOCK * across + at % self.width / BLOCK];
            block.0 += 1;
            for (c, sums) in block.1.iter_mut().enumerate() {
                sums.0 += self.a[at][c] - self.b[at][c];
                sums.1 += self.variance(at, c);
            }
        }
        let count = blocks.iter().filter(|block| block.0 > 0).count();
        let bound = normal_bound(sidak(level, 3 * count));
        let mut failing = 0;
        let mut worst = Worst { x: 0, y: 0, channel: 0, z: 0.0 };
        for (at, (_, sums)) in blocks.iter().enumerate() {
            let mut fails = false;
            for (channel, &(difference, variance)) in sums.iter().enumerate() {
                let z: f64 = if difference == 0.0 { 0.0 } else { difference / f64::sqrt(variance) };
                if z.abs() > worst.z.abs() {
                    worst = Worst { x: at % across * BLOCK, y: at / across * BLOCK, channel, z };
                }
                fails |= z.abs() > bound;
            }
            failing += usize::from(fails);
        }
        ManyTests { tested: count, failing, allowed: 0, bound, worst }
    }
}

/// The level of each of `n` independent tests that together are held to `level`.
fn sidak(level: f64, n: usize) -> f64 {
    // 1 − (1 − level)^(1/n) without losing the digits of a small result.
    -((-level).ln_1p() / n as f64).exp_m1()
}

/// |z| that a normal deviate exceeds with probability `p`.
fn normal_bound(p: f64) -> f64 {
    -Normal::standard().inverse_cdf(0.5 * p)
}

/// Student's t; None from where it agrees with the normal distribution to the last digit that matters.
fn student(freedom: f64) -> Option<StudentsT> {
    if freedom < 1e6 { StudentsT::new(0.0, 1.0, freedom).ok() } else { None }
}

/// Two-sided p-value of Student's t.
fn t_p(z: f64, freedom: f64) -> f64 {
    2.0 * student(freedom).map_or_else(|| Normal::standard().sf(z.abs()), |student| student.sf(z.abs()))
}

/// The inverse: the |z| that has this two-sided p-value.
fn t_bound(p: f64, freedom: f64) -> f64 {
    student(freedom).map_or_else(|| normal_bound(p), |student| -student.inverse_cdf(0.5 * p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use approx::assert_relative_eq;

    const WIDTH: usize = 128;
    const SPP: u64 = 32;

    /// Pixels of expectation 1 · `gain`, each the mean of uniform samples, with the noise that they state.
    fn rendered(seed: u64, gain: impl Fn(usize) -> f64) -> (Vec<[f64; 3]>, Noise) {
        let mut colours = Vec::new();
        let mut variance = Vec::new();
        for at in 0..WIDTH * WIDTH {
            let mut rng = stream(seed, at as u64, 0);
            let samples: Vec<f64> = (0..SPP).map(|_| 2.0 * uniform(&mut rng) * gain(at)).collect();
            let mean = samples.iter().sum::<f64>() / SPP as f64;
            let m2: f64 = samples.iter().map(|x| (x - mean).powi(2)).sum();
            colours.push([mean; 3]);
            variance.push([m2 / (SPP * (SPP - 1)) as f64; 3]);
        }
        let samples = Some(vec![SPP as f64; colours.len()]);
        (colours, Noise { variance, samples })
    }

    fn test(a: &(Vec<[f64; 3]>, Noise), b: &(Vec<[f64; 3]>, Option<Noise>)) -> NoiseTest {
        let rounding = vec![[0.0; 3]; a.0.len()];
        let noise = [Some(&a.1), b.1.as_ref()];
        Pair { width: WIDTH, a: &a.0, b: &b.0, noise, rounding: &rounding }.test(0.01, 0.0).unwrap()
    }

    fn with_noise((colours, noise): (Vec<[f64; 3]>, Noise)) -> (Vec<[f64; 3]>, Option<Noise>) {
        (colours, Some(noise))
    }

    fn exact() -> (Vec<[f64; 3]>, Option<Noise>) {
        (vec![[1.0; 3]; WIDTH * WIDTH], None)
    }

    #[test]
    fn renderings_of_one_scene_are_equal_within_noise() {
        for seed in 0..5 {
            // Ten such runs give a false alarm with probability below 10 %; the seeds are the first ones.
            let test_result = test(&rendered(2 * seed, |_| 1.0), &with_noise(rendered(2 * seed + 1, |_| 1.0)));
            assert!(test_result.holds(), "{seed}: {test_result:?}");
            // 16384 pixels (the channels are copies): deviations 1/128 of the mean, √2/128 of the square; five of each.
            assert!(test_result.mean_z.abs() <= 0.04, "{}", test_result.mean_z);
            let expected = test_result.expected_z2.unwrap();
            assert!((test_result.mean_z2 - expected).abs() <= 0.06, "{} for {expected}", test_result.mean_z2);
            assert!(test(&rendered(seed, |_| 1.0), &exact()).holds());
        }
    }

    #[test]
    fn a_small_bias_everywhere_is_seen_only_by_the_image() {
        // Standard error of the whole picture: √(1/3)/√(32 · 16384) = 0.0008, and the bound is at 3.3 of it. That of a
        // block is 0.0064, and its bound is at 3.9.
        let result = test(&rendered(3, |_| 1.005), &exact());
        assert!(result.pixels.holds() && result.blocks.holds() && !result.image_holds(), "{result:?}");
        assert!(!result.holds());
        assert_relative_eq!(result.image[0].difference, 0.005, max_relative = 0.5);
        assert_relative_eq!(result.image[0].std_err, 0.0008, max_relative = 0.02);
    }

    #[test]
    fn one_wrong_object_is_seen_by_its_block() {
        let inside = |at: usize| at % WIDTH / 16 == 2 && at / WIDTH / 16 == 1;
        // A block's standard error is 0.0064.
        let result = test(&rendered(4, |at| if inside(at) { 1.05 } else { 1.0 }), &exact());
        assert!(result.pixels.holds() && !result.blocks.holds(), "{result:?}");
        assert_eq!((result.blocks.failing, result.blocks.worst.x, result.blocks.worst.y), (1, 32, 16));
    }

    #[test]
    fn one_wrong_pixel_is_seen_unless_it_is_allowed() {
        let mut a = rendered(5, |_| 1.0);
        a.0[1000] = [3.0, 1.0, 1.0];
        let result = test(&a, &exact());
        assert!(!result.pixels.holds());
        assert_eq!(
            (result.pixels.failing, result.pixels.worst.x, result.pixels.worst.y),
            (1, 1000 % WIDTH, 1000 / WIDTH)
        );
        let rounding = vec![[0.0; 3]; a.0.len()];
        let pair = Pair { width: WIDTH, a: &a.0, b: &exact().0, noise: [Some(&a.1), None], rounding: &rounding };
        let lenient = pair.test(0.01, 0.0025).unwrap();
        assert_eq!((lenient.pixels.allowed, lenient.pixels.holds()), (40, true));
    }

    #[test]
    fn what_has_no_variance_must_be_equal() {
        let zero = Noise { variance: vec![[0.0; 3]; 4], samples: Some(vec![9.0; 4]) };
        let run = |a: f64, rounding: f64| {
            let (a, b, rounding) = ([[a; 3]; 4], [[0.5; 3]; 4], [[rounding; 3]; 4]);
            Pair { width: 2, a: &a, b: &b, noise: [Some(&zero), None], rounding: &rounding }.test(0.01, 0.0).unwrap()
        };
        assert!(run(0.5, 0.0).holds());
        let off = run(0.5 + 1e-8, 0.0);
        assert!(!off.pixels.holds() && !off.blocks.holds() && !off.image_holds() && off.mean_z == f64::INFINITY);
        assert!(run(0.5 + 1e-8, 1e-16).holds(), "the rounding of the file is no difference");
    }

    #[test]
    fn pixels_that_cannot_be_tested_are_counted() {
        let mut noise = Noise { variance: vec![[1.0; 3]; 4], samples: None };
        noise.variance[3] = [f64::INFINITY; 3];
        let (a, b, rounding) = ([[0.5; 3], [f64::NAN; 3], [0.5; 3], [0.5; 3]], [[0.5; 3]; 4], [[0.0; 3]; 4]);
        let pair = Pair { width: 4, a: &a, b: &b, noise: [Some(&noise), None], rounding: &rounding };
        let result = pair.test(0.01, 0.0).unwrap();
        assert_eq!((result.untested, result.pixels.tested, result.expected_z2), (2, 2, Some(1.0)));
        assert!(result.z[1][0].is_nan() && result.z[3][0].is_nan());
        let all = Pair { a: &[[f64::NAN; 3]; 4], ..pair };
        assert!(all.test(0.01, 0.0).is_none());
    }

    #[test]
    fn bounds_of_the_textbook() {
        assert_relative_eq!(normal_bound(0.05), 1.959_963_985, max_relative = 1e-8);
        assert_relative_eq!(sidak(0.05, 2), 1.0 - 0.95_f64.sqrt(), max_relative = 1e-12);
        assert_relative_eq!(sidak(0.01, 3_000_000), 0.01005033585 / 3e6, max_relative = 1e-8);
        // Student's t: 2.228 leaves 5 % at 10 degrees of freedom.
        assert_relative_eq!(t_p(2.228_138_852, 10.0), 0.05, max_relative = 1e-8);
        for (p, freedom) in [(0.05, 10.0), (1e-7, 63.0), (1e-8, 3.5), (1e-6, f64::INFINITY)] {
            assert_relative_eq!(t_p(t_bound(p, freedom), freedom), p, max_relative = 1e-6);
        }
        assert_relative_eq!(t_p(1.959_963_985, f64::INFINITY), 0.05, max_relative = 1e-8);
    }
}
