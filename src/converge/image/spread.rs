//! What replicates of one image say: how far they spread, and how far their common mean is from a reference.
//!
//! With images A₁ … A_R of one expectation, a reference B, and ⟨·⟩ the mean over pixels and channels:
//!
//! ```text
//! V = Σᵢ ⟨(Aᵢ − Ā)²⟩ / (R − 1)                       the variance of an image; no reference is in it
//! F = Σ_{i≠j} ⟨(Aᵢ − B)(Aⱼ − B)⟩ / (R (R − 1))       the floor
//! ```
//! E V = Var A and E F = bias² + (the error of B)², both without bias, and V + F is the mean of ⟨(Aᵢ − B)²⟩ to the last
//! digit. So V is the mean square error with its floor taken off, whatever the reference. F may come out below 0.
//!
//! How far V and F themselves are off is seen from the replicates alone: pixels need be neither independent nor Gaussian.
//! # References
//! - Hoeffding 1948, A class of statistics with asymptotically normal distribution, Ann. Math. Stat. 19(3) (the variance of F)
//! - Efron & Stein 1981, The jackknife estimate of variance, Ann. Stat. 9(3)
//! - Box 1954, Ann. Math. Stat. 25(2) (sums of squares of unequal variance as one of fewer degrees of freedom)
//! - Paulson 1942, Ann. Math. Stat. 13(2) (the F distribution as a normal one)

use glam::DVec3;

use super::reference::Reference;
use crate::math::color::Rgb;
use crate::math::sum::{Moments, Neumaier};

/// What the replicates of one image say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// V, an unbiased estimate of the variance of one image, mean over pixels and channels.
    pub variance: f64,
    /// The variance of ln V, by the jackknife over the replicates; NaN for fewer than three, or where V is 0.
    pub log_variance: f64,
    /// The largest share of one pixel of one replicate, both in V and in the variance relative to the pixels' brightness, where
    /// it is far from the same pixel of all other replicates; 0 where none is.
    pub largest_share: f64,
    /// The mean over all pixels, channels and replicates.
    pub mean: f64,
    /// Its standard error.
    pub std_err: f64,
    /// How far the common mean is from the reference, if there is one.
    pub floor: Option<Floor>,
}

/// What does not go away with more samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// F, an unbiased estimate of bias² + (the reference's own error)², mean over pixels and channels.
    pub value: f64,
    /// Its standard error; NaN for fewer than four replicates.
    pub std_err: f64,
    /// How many standard deviations the relative square of Ā − B, ⟨(Ā − B)² / (B² + (⟨B⟩/10)²)⟩, is above what the spread and
    /// the reference's own error let one expect without a bias; None where the reference's error is not known.
    pub z: Option<f64>,
}

/// An image of doubles rounds each value to no worse than this share of it, after thousands of samples.
const ROUNDING: f64 = 1e-12;

/// What these images, of one size, have in common and do not. The reference is of the same size.
pub fn spread(images: &[Vec<Rgb>], reference: Option<&Reference>) -> Spread {
    let r = images.len() as f64;
    let pixels = images.first().map_or(0, Vec::len);
    let values = 3.0 * pixels as f64;
    let mean: Vec<DVec3> = (0..pixels).map(|at| images.iter().map(|image| image[at].0).sum::<DVec3>() / r).collect();
    let mut means = Moments::default();
    let mut deviations = Vec::with_capacity(images.len());
    for image in images {
        means.add(image.iter().map(|c| c.0.element_sum()).collect::<Neumaier>().value() / values);
        let squares = image.iter().zip(&mean).map(|(colour, mean)| (colour.0 - mean).length_squared());
        deviations.push(squares.collect::<Neumaier>().value() / values);
    }
    let sum = deviations.iter().copied().collect::<Neumaier>().value();
    let variance = sum / (r - 1.0);
    Spread {
        variance,
        log_variance: jackknifed_log(&deviations, sum),
        largest_share: largest_outlier(images, &mean),
        mean: means.mean(),
        std_err: means.std_err(),
        floor: reference.map(|reference| floor(images, &mean, variance, reference)),
    }
}

/// What the square of an error counts in a pixel of this brightness: 1 / (brightness² + (mean/10)²). Squares themselves are
/// those of the edges of lamps, and say nothing of all other pixels.
fn weights(colours: &[DVec3]) -> Vec<f64> {
    let brightness = || colours.iter().map(|c| c.element_sum() / 3.0);
    let mean = brightness().collect::<Neumaier>().value() / colours.len() as f64;
    let least = (0.1 * mean).powi(2).max(f64::MIN_POSITIVE);
    brightness().map(|x| 1.0 / (x * x + least)).collect()
}

/// The largest share of a replicate's pixel in the sum of all squared deviations, if it is an outlier among its replicates as no
/// normal number is. The lesser of the shares in the sum as it is, by which a rate is fitted, and in the weighted one: an edge of
/// a lamp has much of the former, and structured points of it few values, of which a rare one is no firefly.
fn largest_outlier(images: &[Vec<Rgb>], mean: &[DVec3]) -> f64 {
    let r = images.len() as f64;
    // Squared, in variances of the others: one of about 10⁵ normal numbers is as large. Few others know their variance badly.
    let bound = 20.0 * (1.0 + 20.0 / (r - 2.0));
    let (mut outliers, mut all, mut weighted) = (Vec::new(), Neumaier::default(), Neumaier::default());
    for (at, (mean, weight)) in mean.iter().zip(weights(mean)).enumerate() {
        let square = |image: &Vec<Rgb>| (image[at].0 - mean).length_squared();
        let sum = images.iter().map(square).sum::<f64>();
        let most = images.iter().map(square).fold(0.0, f64::max);
        all.add(sum);
        weighted.add(weight * sum);
        // Without it the mean moves, too.
        let apart = most * r / (r - 1.0);
        if apart * (r - 2.0) > bound * (sum - apart) {
            outliers.push((most, weight * most));
        }
    }
    let share = |(plain, relative): &(f64, f64)| (plain / all.value()).min(relative / weighted.value());
    outliers.iter().map(share).fold(0.0, f64::max)
}

/// The variance of ln Σ dᵢ, where leaving out replicate i takes r dᵢ / (r − 1) away: the mean moves as well.
fn jackknifed_log(deviations: &[f64], sum: f64) -> f64 {
    let r = deviations.len() as f64;
    if deviations.len() < 3 {
        return f64::NAN;
    }
    let mut logs = Moments::default();
    for d in deviations {
        logs.add((sum - d * r / (r - 1.0)).ln());
    }
    // Moments divide by r − 1, the jackknife multiplies by (r − 1)/r.
    logs.variance() * (r - 1.0) * (r - 1.0) / r
}

fn floor(images: &[Vec<Rgb>], mean: &[DVec3], variance: f64, reference: &Reference) -> Floor {
    let r = images.len() as f64;
    let values = 3.0 * mean.len() as f64;
    let gap = mean.iter().zip(&reference.colours).map(|(a, b)| (*a - b.0).length_squared());
    let square = gap.collect::<Neumaier>().value() / values;
    Floor {
        value: square - variance / r,
        std_err: products(images, reference).variance().sqrt(),
        z: reference.variance.as_ref().map(|variance| excess(images, mean, &reference.colours, variance)),
    }
}

/// Sums over the products hᵢⱼ = ⟨(Aᵢ − B)(Aⱼ − B)⟩ with i ≠ j.
struct Products {
    r: f64,
    /// Σ hᵢⱼ.
    sum: f64,
    /// Σᵢ (Σⱼ hᵢⱼ)².
    rows: f64,
    /// Σ hᵢⱼ².
    squares: f64,
}

fn products(images: &[Vec<Rgb>], reference: &Reference) -> Products {
    let (mut sum, mut rows, mut squares) = (0.0, 0.0, 0.0);
    for (i, a) in images.iter().enumerate() {
        let mut row = 0.0;
        for (_, b) in images.iter().enumerate().filter(|(j, _)| *j != i) {
            let terms = a.iter().zip(b).zip(&reference.colours).map(|((a, b), c)| (a.0 - c.0).dot(b.0 - c.0));
            let product = terms.sum::<f64>() / (3 * a.len()) as f64;
            row += product;
            squares += product * product;
        }
        sum += row;
        rows += row * row;
    }
    Products { r: images.len() as f64, sum, rows, squares }
}

impl Products {
    /// The variance of the mean of all hᵢⱼ: 4 (R − 2) ζ₁ / (R (R − 1)) + 2 ζ₂ / (R (R − 1)) with ζ₁ = Cov(h₁₂, h₁₃) and
    /// ζ₂ = Var h₁₂, each with the square of the mean estimated from products of disjoint pairs. ζ₁, which is 0 where A and B
    /// have one expectation, is not let below that: the result then errs to the safe side.
    fn variance(&self) -> f64 {
        let Self { r, sum, rows, squares } = *self;
        if r < 4.0 {
            return f64::NAN;
        }
        let pairs = r * (r - 1.0);
        let disjoint = (sum * sum - 4.0 * rows + 2.0 * squares) / (pairs * (r - 2.0) * (r - 3.0));
        let zeta1 = (rows - squares) / (pairs * (r - 2.0)) - disjoint;
        let zeta2 = squares / pairs - disjoint;
        (4.0 * (r - 2.0) * zeta1.max(0.0) + 2.0 * zeta2.max(0.0)) / pairs
    }
}

/// The z of the relative square of Ā − B under the hypothesis that A and B have one expectation.
///
/// The sum of the squares of all pixels, of variance vₚ each, is taken as one of ν = (Σ vₚ)² / Σ vₚ² degrees of freedom; the
/// channels of a pixel as one, which errs to the safe side. The vₚ are estimated with R − 1 degrees of freedom each.
fn excess(images: &[Vec<Rgb>], mean: &[DVec3], reference: &[Rgb], variance: &[Rgb]) -> f64 {
    let r = images.len() as f64;
    let brightness: Vec<DVec3> = reference.iter().map(|c| c.0).collect();
    let [mut square, mut sum, mut sum_of_squares] = [Neumaier::default(); 3];
    for (at, weight) in weights(&brightness).into_iter().enumerate() {
        let (mean, known) = (mean[at], brightness[at]);
        let own = images.iter().map(|image| (image[at].0 - mean).length_squared()).sum::<f64>() / (r * (r - 1.0));
        let v = weight * (own + variance[at].0.element_sum() + (ROUNDING * known).length_squared());
        square.add(weight * (mean - known).length_squared());
        sum.add(v);
        sum_of_squares.add(v * v);
    }
    let (square, sum, sum_of_squares) = (square.value(), sum.value(), sum_of_squares.value());
    if sum == 0.0 {
        // Black on black agrees.
        return if square == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let nu = sum * sum / sum_of_squares;
    normal_of_f(square / sum, nu, nu * (r - 1.0))
}

/// The normal deviate of as small an upper tail as the ratio `f` of two χ²/ν has, with `upper` and `lower` degrees of freedom.
///
/// Cube roots of χ²/ν are nearly normal, for ν = 1 within .03 of z up to 4.
fn normal_of_f(f: f64, upper: f64, lower: f64) -> f64 {
    let (a, b) = (2.0 / (9.0 * upper), 2.0 / (9.0 * lower));
    let root = f.cbrt();
    ((1.0 - b) * root - (1.0 - a)) / (b * root * root + a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use approx::assert_relative_eq;
    use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal};

    /// `replicates` images of 30 pixels about 1 + `bias`, with noise that grows from pixel to pixel.
    fn images(seed: u64, replicates: u64, bias: f64) -> Vec<Vec<Rgb>> {
        let image = |r| {
            let mut rng = stream(seed, r, 0);
            let mut noise = || (0..12).map(|_| uniform(&mut rng)).sum::<f64>() - 6.0;
            let pixel = |at: u32| 1.0 + bias + 0.01 * f64::from(at) * DVec3::new(noise(), noise(), noise());
            (0..30).map(pixel).map(Rgb).collect()
        };
        (0..replicates).map(image).collect()
    }

    fn truth(variance: f64) -> Reference {
        Reference { colours: vec![Rgb::WHITE; 30], variance: Some(vec![Rgb::grey(variance); 30]) }
    }

    #[test]
    fn variance_and_floor_add_up_to_the_mean_square_error() {
        let images = images(1, 8, 0.2);
        let reference = truth(0.0);
        let found = spread(&images, Some(&reference));
        let errors = images.iter().flatten().map(|c| (c.0 - 1.0).length_squared());
        let floor = found.floor.unwrap();
        assert_relative_eq!(found.variance + floor.value, errors.sum::<f64>() / (90.0 * 8.0), max_relative = 1e-13);
        let products = products(&images, &reference);
        assert_relative_eq!(products.sum / 56.0, floor.value, max_relative = 1e-12);
    }

    #[test]
    fn estimates_are_right_on_average_and_so_are_their_errors() {
        for bias in [0.0, 0.05] {
            let [mut variance, mut floor, mut stated, mut logs, mut stated_log] = [Moments::default(); 5];
            for seed in 0..2000 {
                let found = spread(&images(100 + seed, 16, bias), Some(&truth(0.0)));
                let f = found.floor.unwrap();
                variance.add(found.variance);
                logs.add(found.variance.ln());
                stated_log.add(found.log_variance);
                floor.add(f.value);
                stated.add(f.std_err * f.std_err);
            }
            // Σ at² / 30 = 285.1…, at variance 1e-4 at².
            let exact = 1e-4 * (0..30).map(|at| f64::from(at * at)).sum::<f64>() / 30.0;
            assert!((variance.mean() - exact).abs() < 4.0 * variance.std_err(), "{variance:?}");
            assert!((floor.mean() - bias * bias).abs() < 4.0 * floor.std_err(), "{floor:?}");
            // A variance of 2000 values is known to 3 %, more for skewed ones. Without a bias ζ₁ is 0, and half of its
            // estimates would be negative; with one, ζ₁ is most of it.
            let (floor, log) = (stated.mean() / floor.variance(), stated_log.mean() / logs.variance());
            assert!((0.9..if bias == 0.0 { 2.0 } else { 1.35 }).contains(&floor), "{bias}: {floor}");
            // The jackknife errs to the safe side.
            assert!((0.9..1.4).contains(&log), "{log}");
        }
    }

    #[test]
    fn a_bias_stands_out_and_the_references_own_error_does_not() {
        let z = |seed, bias, error: f64| {
            // The reference is off by its error in every value, with either sign.
            let mut reference = truth(error * error);
            let mut rng = stream(seed, 0, 1);
            reference.colours.iter_mut().for_each(|c| {
                *c = Rgb(c.0.map(|x| x + error * (12.0 * (uniform(&mut rng) - 0.5) * 0.288_675)));
            });
            spread(&images(seed, 16, bias), Some(&reference)).floor.unwrap().z.unwrap()
        };
        let beyond = |bias, error, bound: f64| (0..500).filter(|seed| z(*seed, bias, error) > bound).count();
        // At 2.33 one in a hundred: 5 ± 2.2 of 500. Channels are independent here, which makes it fewer.
        assert!(beyond(0.0, 0.0, 2.33) <= 12 && beyond(0.0, 0.1, 2.33) <= 12);
        assert!(beyond(0.08, 0.0, 2.33) > 450, "the test has lost its power");
    }

    #[test]
    fn a_firefly_is_an_outlier_and_the_noisiest_pixel_is_none() {
        let mut images = images(1, 16, 0.0);
        // The last pixel has a tenth of all variance, evenly.
        assert_eq!(spread(&images, None).largest_share, 0.0);
        images[3][2].0.y += 3.0;
        let share = spread(&images, None).largest_share;
        assert!(share > 0.1 && share < 1.0, "{share}");
        // One pixel of 64 normal replicates, and with a value that is a hundred times the others.
        let mut alone: Vec<Vec<Rgb>> = (0..64).map(|r| vec![self::images(2, 64, 0.0)[r][29]]).collect();
        assert_eq!(spread(&alone, None).largest_share, 0.0);
        alone[5][0] = Rgb::grey(100.0);
        assert!(spread(&alone, None).largest_share > 0.9);
    }

    #[test]
    fn the_normal_deviate_is_that_of_the_tail() {
        for (f, upper, lower) in [(4.0, 1.0, 15.0), (1.3, 300.0, 4500.0), (0.8, 20.0, 300.0), (9.0, 1.0, 63.0)] {
            let tail = FisherSnedecor::new(upper, lower).unwrap().sf(f);
            let exact = -Normal::standard().inverse_cdf(tail);
            assert!((normal_of_f(f, upper, lower) - exact).abs() < 0.05, "{f} {upper} {lower}: {exact}");
        }
    }
}
