//! LDR-FLIP: how different two pictures look when one flips between them.
//!
//! Both are seen as linear Rec.709 clamped to [0, 1]. The map is in [0, 1]; its mean is the number that is quoted.
//! Colour: each opponent channel (YCxCz) is blurred by the eye's contrast sensitivity, then HyAB distances in
//! Hunt-adjusted L*a*b*. Features: differences of edges and points, found by derivatives of Gaussians, which raise the
//! colour difference to a smaller power.
//! # References
//! - Andersson et al. 2020, FLIP: a difference evaluator for alternating images, HPG (table 1, sections 4.1 to 4.3)

use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Pixels per degree of visual angle on a display of 3840 pixels in 0.7 m seen from 0.7 m: 67.02, the paper's default.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Exponent of the colour distance, q_c.
const COLOUR_POWER: f64 = 0.7;
/// The share p_c of the largest distance that is mapped to the share p_t of the result.
const COLOUR_KNEE: (f64, f64) = (0.4, 0.95);
/// Width w of the edge and point detectors in degrees: the distance of the Gaussian derivative's extremes.
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent of the feature difference, q_f.
const FEATURE_POWER: f64 = 0.5;

/// From linear Rec.709 to X, Y and Z by rows, to the eight digits of the authors' program; white is (1, 1, 1).
const XYZ: [[f64; 3]; 3] = [
    [0.412_386_56, 0.357_591_49, 0.180_450_49],
    [0.212_636_82, 0.715_182_99, 0.072_180_19],
    [0.019_330_62, 0.119_197_16, 0.950_372_59],
];

/// Sums of Gaussians a √(π/b) exp(−π² r²/b) over degrees r that stand for the contrast sensitivity of achromatic,
/// red-green and blue-yellow vision: (a, b) each.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// The map of two pictures of `width` columns, row by row; the first is the reference. All samples must be finite.
pub fn map(reference: &[[f64; 3]], test: &[[f64; 3]], width: usize, pixels_per_degree: f64) -> Vec<f64> {
    let opponent = |pixels: &[[f64; 3]]| -> [Plane; 3] {
        let pixels: Vec<[f64; 3]> = pixels.iter().map(|&rgb| to_opponent(rgb.map(|v| v.clamp(0.0, 1.0)))).collect();
        [0, 1, 2].map(|c| Plane { width, samples: pixels.iter().map(|p| p[c]).collect() })
    };
    let (reference, test) = (opponent(reference), opponent(test));
    let colour = colour_difference(&reference, &test, pixels_per_degree);
    let feature = feature_difference(&reference[0], &test[0], pixels_per_degree);
    colour.iter().zip(feature).map(|(colour, feature)| colour.powf(1.0 - feature)).collect()
}

fn colour_difference(reference: &[Plane; 3], test: &[Plane; 3], ppd: f64) -> Vec<f64> {
    // The widest Gaussian decides the radius of all: three of its standard deviations √(b/2π²).
    let widest = SENSITIVITY.iter().flat_map(|sums| sums.iter()).fold(0.0, |b: f64, s| b.max(s.1));
    let radius = (3.0 * (widest / 2.0).sqrt() / std::f64::consts::PI * ppd).ceil() as usize;
    let to_rgb = DMat3::from_cols_array_2d(&XYZ).transpose().inverse();
    let seen = |planes: &[Plane; 3]| -> Vec<[f64; 3]> {
        let [y, cx, cz] = [0, 1, 2].map(|channel| blurred(&planes[channel], SENSITIVITY[channel], radius, ppd));
        let pixels = y.samples.par_iter().zip(&cx.samples).zip(&cz.samples);
        pixels.map(|((y, cx), cz)| hunt(from_opponent([*y, *cx, *cz], &to_rgb).map(|v| v.clamp(0.0, 1.0)))).collect()
    };
    let (reference, test) = (seen(reference), seen(test));
    let largest = hyab(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0])).powf(COLOUR_POWER);
    let (knee, share) = (COLOUR_KNEE.0 * largest, COLOUR_KNEE.1);
    let redistributed = |distance: f64| {
        let d = distance.powf(COLOUR_POWER);
        if d < knee { share / knee * d } else { share + (d - knee) / (largest - knee) * (1.0 - share) }
    };
    reference.iter().zip(test).map(|(&r, t)| redistributed(hyab(r, t))).collect()
}

fn feature_difference(reference: &Plane, test: &Plane, ppd: f64) -> Vec<f64> {
    let deviation = 0.5 * FEATURE_WIDTH * ppd;
    let radius = (3.0 * deviation).ceil() as usize;
    let bell = kernel(radius, |x| (-0.5 * (x / deviation).powi(2)).exp());
    let edge = balanced(kernel(radius, |x| -x * (-0.5 * (x / deviation).powi(2)).exp()));
    let squares = |x: f64| (x / deviation).powi(2);
    let point = balanced(kernel(radius, |x| (squares(x) - 1.0) * (-0.5 * squares(x)).exp()));
    let total: f64 = bell.iter().sum();
    let bell: Vec<f64> = bell.iter().map(|v| v / total).collect();
    let strength = |plane: &Plane, derivative: &[f64]| -> Vec<f64> {
        // Y runs from −16 to 100 and is to run from 0 to 1.
        let lightness = plane.map(|y| (y + 16.0) / 116.0);
        let across = lightness.convolved(derivative, &bell);
        let down = lightness.convolved(&bell, derivative);
        across.samples.iter().zip(down.samples).map(|(x, y)| x.hypot(y)).collect()
    };
    let [reference_edge, test_edge, reference_point, test_point] =
        [(reference, &edge), (test, &edge), (reference, &point), (test, &point)].map(|(p, d)| strength(p, d));
    (0..reference.samples.len())
        .map(|at| {
            let edges = (reference_edge[at] - test_edge[at]).abs();
            let points = (reference_point[at] - test_point[at]).abs();
            (edges.max(points) / std::f64::consts::SQRT_2).powf(FEATURE_POWER)
        })
        .collect()
}

/// A kernel's values from −radius to radius.
fn kernel(radius: usize, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| value(i as f64 - radius as f64)).collect()
}

/// Positive values scaled to the sum 1, negative ones to −1.
fn balanced(mut kernel: Vec<f64>) -> Vec<f64> {
    let sum = |positive: bool| kernel.iter().filter(|v| (**v > 0.0) == positive).sum::<f64>().abs();
    let (above, below) = (sum(true), sum(false));
    for v in &mut kernel {
        *v /= if *v > 0.0 { above } else { below };
    }
    kernel
}

/// The plane under a sum of Gaussians, scaled so that a constant stays.
fn blurred(plane: &Plane, sums: &[(f64, f64)], radius: usize, ppd: f64) -> Plane {
    let pi = std::f64::consts::PI;
    let mut result = plane.map(|_| 0.0);
    let mut total = 0.0;
    for &(a, b) in sums {
        let gauss = kernel(radius, |x| (-(pi * x / ppd).powi(2) / b).exp());
        let height = a * (pi / b).sqrt();
        total += height * gauss.iter().sum::<f64>().powi(2);
        let part = plane.convolved(&gauss, &gauss);
        for (sum, v) in result.samples.iter_mut().zip(part.samples) {
            *sum += height * v;
        }
    }
    result.map(|v| v / total)
}

/// One channel of a picture.
struct Plane {
    width: usize,
    samples: Vec<f64>,
}

impl Plane {
    fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self { width: self.width, samples: self.samples.iter().map(|&v| f(v)).collect() }
    }

    /// Correlated with one kernel along rows and another along columns; beyond its border the picture goes on as there.
    fn convolved(&self, along: &[f64], down: &[f64]) -> Self {
        let width = self.width;
        let height = self.samples.len() / width;
        let mut rows = vec![0.0; self.samples.len()];
        rows.par_chunks_mut(width).zip(self.samples.par_chunks(width)).for_each(|(result, row)| {
            let radius = along.len() / 2;
            let before = std::iter::repeat_n(row[0], radius);
            let after = std::iter::repeat_n(row[width - 1], radius);
            let padded: Vec<f64> = before.chain(row.iter().copied()).chain(after).collect();
            for (shift, k) in along.iter().enumerate() {
                add_scaled(result, *k, &padded[shift..shift + width]);
            }
        });
        let mut samples = vec![0.0; self.samples.len()];
        samples.par_chunks_mut(width).enumerate().for_each(|(y, result)| {
            for (shift, k) in down.iter().enumerate() {
                let from = (y + shift).saturating_sub(down.len() / 2).min(height - 1);
                add_scaled(result, *k, &rows[from * width..(from + 1) * width]);
            }
        });
        Self { width, samples }
    }
}

/// `sum` += `factor` · `terms`, element by element: the form that compilers turn into wide instructions.
fn add_scaled(sum: &mut [f64], factor: f64, terms: &[f64]) {
    for (sum, term) in sum.iter_mut().zip(terms) {
        *sum += factor * term;
    }
}

/// To Y, C_x, C_z: a linear relative of L*a*b*.
fn to_opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// X, Y and Z, each over that of white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    XYZ.map(|row| (0..3).map(|c| row[c] * rgb[c]).sum::<f64>() / row.iter().sum::<f64>())
}

/// The inverse of [`to_opponent`].
fn from_opponent([y, cx, cz]: [f64; 3], to_rgb: &DMat3) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    let xyz = [0, 1, 2].map(|c| relative[c] * XYZ[c].iter().sum::<f64>());
    (*to_rgb * DVec3::from_array(xyz)).to_array()
}

/// L*a*b* of a linear colour, a* and b* scaled by the lightness (Hunt).
fn hunt(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(rgb).map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// |ΔL| plus the Euclidean distance in the other two.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (64, 48);

    /// Smooth in red, squares in green, a ramp in blue.
    fn picture(k: f64) -> Vec<[f64; 3]> {
        let pixel = |at: usize| {
            let (x, y) = (at % SIZE.0, at / SIZE.0);
            let square = ((x / 8 + y / 8) % 2) as f64;
            let (x, y) = (x as f64, y as f64);
            [0.5 + 0.5 * (0.3 * x + 0.05 * y * k).sin(), 0.8 * square + 0.1 * k, x * y / (64.0 * 48.0)]
        };
        (0..SIZE.0 * SIZE.1).map(pixel).collect()
    }

    fn mean(map: &[f64]) -> f64 {
        map.iter().sum::<f64>() / map.len() as f64
    }

    /// The authors' own program (flip-evaluator 1.7 from PyPI, LDR, linear input) gave the numbers. It computes in
    /// f32, where a feature difference near 0 has a root of a rounding: 3e-5 of the result.
    #[test]
    fn the_authors_program_says_the_same() {
        let (a, b) = (picture(0.0), picture(1.0));
        let full = map(&a, &b, SIZE.0, PIXELS_PER_DEGREE);
        let dim: Vec<[f64; 3]> = a.iter().map(|p| p.map(|v| 0.95 * v)).collect();
        let constant = |rgb: [f64; 3]| vec![rgb; SIZE.0 * SIZE.1];
        let (black, white) = (constant([0.0; 3]), constant([1.0; 3]));
        let (green, blue) = (constant([0.0, 1.0, 0.0]), constant([0.0, 0.0, 1.0]));
        for (ours, theirs) in [
            (mean(&full), 0.616_235_67),
            (full[0], 0.479_261_88),
            (full[10 * 64 + 20], 0.462_062_1),
            (full[47 * 64 + 63], 0.609_975_76),
            (mean(&map(&b, &a, SIZE.0, PIXELS_PER_DEGREE)), 0.616_235_67),
            (mean(&map(&a, &b, SIZE.0, 30.0)), 0.615_290_34),
            (mean(&map(&a, &dim, SIZE.0, PIXELS_PER_DEGREE)), 0.144_698_22),
            (mean(&map(&black, &white, SIZE.0, PIXELS_PER_DEGREE)), 0.967_365_26),
            (mean(&map(&green, &blue, SIZE.0, PIXELS_PER_DEGREE)), 1.0),
        ] {
            assert!((ours - theirs).abs() <= 3e-5, "{ours}, the authors {theirs}");
        }
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        assert!(map(&picture(0.3), &picture(0.3), SIZE.0, PIXELS_PER_DEGREE).iter().all(|v| *v == 0.0));
    }
}
