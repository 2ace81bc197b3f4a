//! Error metrics over the pixels and channels of two pictures.
//!
//! "Relative MSE" is several formulas, each with its ε: they differ by factors, so each has a name of its own. Here b
//! is the reference, a channel at a time, and b̄ is the mean of its three channels.
//!
//! | name | formula | who means it |
//! |---|---|---|
//! | `relmse` | mean of (a − b)² / (b² + 0.01) | papers on adaptive sampling and denoising; the viewer tev |
//! | `relmse_grey` | mean of (a − b)² / (b̄² + 0.01) | papers that want no weight on a dark channel of a bright pixel |
//! | `mrse` | mean of (a − b)² / (b + 0.01)² | `imgtool diff --metric MRSE` of pbrt-v4 |
//! # References
//! - Rousselle, Knaus & Zwicker 2011, Adaptive sampling and reconstruction using greedy error minimization, SIGGRAPH Asia
//! - Pharr, Jakob & Humphreys 2023, Physically based rendering, 4th edition, `Image::MRSE`

use crate::math::sum::Neumaier;

/// ε of the relative metrics: that of every source named above.
pub const EPSILON: f64 = 0.01;

/// One number for the difference of two pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Its name, for programs.
    pub name: &'static str,
    /// How it is computed, for people.
    pub formula: &'static str,
    /// The ε in it.
    pub epsilon: Option<f64>,
    /// NaN where there are no pixels.
    pub value: f64,
}

/// All metrics of pairs (a, b) of pixels; b is the reference. All samples must be finite.
pub fn metrics(pairs: &[([f64; 3], [f64; 3])]) -> Vec<Metric> {
    let mean = |term: &dyn Fn(f64, f64, f64) -> f64| {
        let terms = pairs.iter().flat_map(|(a, b)| {
            let grey = (b[0] + b[1] + b[2]) / 3.0;
            (0..3).map(move |channel| term(a[channel], b[channel], grey))
        });
        terms.collect::<Neumaier>().value() / (3 * pairs.len()) as f64
    };
    let square = |a: f64, b: f64| (a - b) * (a - b);
    let mse = mean(&|a, b, _| square(a, b));
    let metric = |name, formula, value| Metric { name, formula, epsilon: None, value };
    let relative = |name, formula, value| Metric { name, formula, epsilon: Some(EPSILON), value };
    vec![
        metric("mse", "mean (a-b)²", mse),
        metric("rmse", "√ mean (a-b)²", mse.sqrt()),
        metric("mae", "mean |a-b|", mean(&|a, b, _| (a - b).abs())),
        relative("relmse", "mean (a-b)² / (b² + 0.01)", mean(&|a, b, _| square(a, b) / (b * b + EPSILON))),
        relative(
            "relmse_grey",
            "mean (a-b)² / (b̄² + 0.01), b̄ the mean of the channels",
            mean(&|a, b, grey| square(a, b) / (grey * grey + EPSILON)),
        ),
        // b = −ε would divide by 0; radiance is not negative.
        relative("mrse", "mean (a-b)² / (b + 0.01)², as pbrt", mean(&|a, b, _| square(a, b) / (b + EPSILON).powi(2))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn by_hand() {
        let pairs = [([0.5, 0.2, 0.0], [0.4, 0.2, 0.0]), ([0.0; 3], [0.0, 0.0, 0.3])];
        let value = |name: &str| metrics(&pairs).iter().find(|m| m.name == name).map(|m| m.value).unwrap();
        // Two of six differences are not 0: 0.1 against 0.4, and −0.3 against 0.3.
        for (name, expected) in [
            ("mse", (0.01 + 0.09) / 6.0),
            ("rmse", (0.1 / 6.0_f64).sqrt()),
            ("mae", 0.4 / 6.0),
            ("relmse", (0.01 / 0.17 + 0.09 / 0.10) / 6.0),
            ("relmse_grey", (0.01 / 0.05 + 0.09 / 0.02) / 6.0),
            ("mrse", (0.01 / 0.1681 + 0.09 / 0.0961) / 6.0),
        ] {
            assert_relative_eq!(value(name), expected, max_relative = 1e-14);
        }
    }

    #[test]
    fn no_pixels_have_no_error_either_way() {
        assert!(metrics(&[]).iter().all(|m| m.value.is_nan()));
    }
}
