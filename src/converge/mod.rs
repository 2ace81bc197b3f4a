//! The convergence lab: how the error of an estimator falls with the number of samples.
//!
//! A [`Target`] is a mean that is known exactly, with the [`Estimator`]s that seek it. A [`Study`] takes means of N samples,
//! many times for each N, fits the rate at which their error falls, and compares it with what theory says of the points.

pub mod albedo;
pub mod irradiance;
pub mod study;

use std::fmt;

use crate::sampling::sampler::Sampler;

pub use study::{Convergence, Point, Study, Theory, Verdict};

/// One value of a random variable, from the numbers of one sample.
pub type Draw<'a> = Box<dyn Fn(&mut dyn Sampler) -> f64 + Sync + 'a>;

/// A random variable whose mean is a target's value.
pub struct Estimator<'a> {
    /// Its name on the command line.
    pub name: &'static str,
    /// Draws one value.
    pub draw: Draw<'a>,
    /// The standard deviation of one value for independent numbers, where it is known in closed form.
    pub sigma: Option<f64>,
}

impl fmt::Debug for Estimator<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Estimator {{ name: {}, sigma: {:?} }}", self.name, self.sigma)
    }
}

/// A mean that is known, and ways to estimate it.
#[derive(Debug)]
pub struct Target<'a> {
    /// As on the command line.
    pub name: String,
    /// The mean.
    pub exact: f64,
    /// A bound on the error of `exact`.
    pub error: f64,
    /// The estimators.
    pub estimators: Vec<Estimator<'a>>,
}

/// The weight of a sample from density `p` where density `q` could have drawn it too, one sample each: Veach's balance
/// heuristic for a power of 1, and his power heuristic.
///
/// # References
/// - Veach & Guibas 1995, Optimally combining sampling techniques for Monte Carlo rendering, SIGGRAPH
fn mis(power: i32, p: f64, q: f64) -> f64 {
    // By the larger of the two, so that no power overflows.
    let scale = p.max(q);
    if scale > 0.0 && scale.is_finite() {
        let (p, q) = ((p / scale).powi(power), (q / scale).powi(power));
        p / (p + q)
    } else {
        0.0
    }
}
