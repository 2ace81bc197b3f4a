//! The convergence lab: how the error of an estimator falls with the number of samples.
//!
//! A [`Target`] is a mean that is known exactly, with the [`Estimator`]s that seek it. A [`Study`] takes means of N samples,
//! many times for each N, fits the rate at which their error falls, and compares it with what theory says of the points. Of a
//! whole [`image`](mod@image) no exact value is known; its error is seen from the spread of its replicates.

pub mod albedo;
pub mod first_split;
pub mod highlight;
pub mod image;
pub mod irradiance;
pub mod roulette;
mod spread;
pub mod square;
pub mod study;
pub mod variance;

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
