//! Means over the unit square as targets: the integrands on which the laws of noise are shown.

use std::f64::consts::E;

use super::{Estimator, Target};

/// The names of the targets, with what they are.
pub const NAMES: &[(&str, &str)] = &[
    ("smooth", "e^(x + y): smooth, and not periodic"),
    ("edge", "1 below an oblique line that leaves the square on its sides, 0 above"),
    ("sum", "x² + y²: smooth, and a sum of functions of one coordinate each"),
];

/// The target of this name, with its one estimator.
pub fn square(name: &str) -> Option<Target<'static>> {
    let (exact, sigma, draw): (f64, f64, super::Draw<'static>) = match name {
        "smooth" => {
            // ∫ eˣ = e − 1 and ∫ e²ˣ = (e² − 1)/2, once for each coordinate.
            let (first, second) = ((E - 1.0).powi(2), (0.5 * (E * E - 1.0)).powi(2));
            (
                first,
                (second - first * first).sqrt(),
                Box::new(|sampler| {
                    let p = sampler.next_2d();
                    (p.x + p.y).exp()
                }),
            )
        }
        "sum" => {
            // ∫ x² = 1/3 and a variance of 1/5 − 1/9, for each coordinate.
            let variance: f64 = 2.0 * (1.0 / 5.0 - 1.0 / 9.0);
            (2.0 / 3.0, variance.sqrt(), Box::new(|sampler| sampler.next_2d().length_squared()))
        }
        "edge" => {
            // .3 + .6 / 2 of the square.
            let share: f64 = 0.6;
            (
                share,
                (share * (1.0 - share)).sqrt(),
                Box::new(|sampler| {
                    let p = sampler.next_2d();
                    f64::from(u8::from(p.y < 0.3 + 0.6 * p.x))
                }),
            )
        }
        _ => return None,
    };
    let estimators = vec![Estimator { name: "points", draw, sigma: Some(sigma) }];
    // A few roundings.
    Some(Target { name: format!("square:{name}"), exact, error: 1e-15, estimators })
}
