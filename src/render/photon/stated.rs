//! What a map is wrong by, pixel by pixel: an error that all samples of an image have in common, and so do not tell.

use std::ops::{AddAssign, Mul};

use glam::DVec2;
use rayon::prelude::*;

use super::map::Reading;
use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{Ray, Scene};

/// Radiance \[W/(sr m²)\], and the error that the map brings into it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stated {
    /// The radiance.
    pub value: Rgb,
    /// The standard deviation of its mean channel over maps, rather too large: the parts of a value go together or cancel, and
    /// their deviations are added as if they went together. See [`Reading::variance`].
    pub std_err: f64,
    /// By how much it is too large. See [`Reading::bias`].
    pub bias: Rgb,
}

impl From<Rgb> for Stated {
    /// Light that no map is part of.
    fn from(value: Rgb) -> Self {
        Self { value, ..Self::default() }
    }
}

impl From<Reading> for Stated {
    fn from(reading: Reading) -> Self {
        Self { value: reading.value, std_err: reading.variance.sqrt(), bias: reading.bias }
    }
}

impl AddAssign for Stated {
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        self.std_err += other.std_err;
        self.bias += other.bias;
    }
}

impl Mul<Rgb> for Stated {
    type Output = Self;

    /// By a reflectance. All light may be in the channel that it reflects most of.
    fn mul(self, weight: Rgb) -> Self {
        Self { value: self.value * weight, std_err: self.std_err * weight.max_channel(), bias: self.bias * weight }
    }
}

/// Light that a photon map is part of.
pub trait OfMap: Radiance {
    /// One sample of the radiance that arrives at the ray's origin against its direction, with the error of the map.
    fn stated(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Stated;
}

/// The error of the map in every pixel of the image, row by row: standard deviation and bias of its mean channel, by so many
/// samples, one at least, spread evenly over the pixel, whatever the film's filter.
pub fn map_errors(scene: &Scene, light: &dyn OfMap, samples: u32, seed: u64) -> [Vec<f32>; 2] {
    let (width, height) = (scene.film().width, scene.film().height);
    let pixel = |at: usize| {
        let (mut sampler, mut sum) = (Independent::new(seed), Stated::default());
        for sample in 0..samples.max(1) {
            sampler.begin(at as u64, sample.into());
            let (film, lens) = (sampler.next_2d(), sampler.next_2d());
            let corner = DVec2::new((at % width) as f64, (at / width) as f64);
            sum += light.stated(scene, scene.camera_ray(corner + film, lens), &mut sampler);
        }
        let count = f64::from(samples.max(1));
        ((sum.std_err / count) as f32, (sum.bias.mean() / count) as f32)
    };
    let (std_errs, biases) = (0..width * height).into_par_iter().map(pixel).unzip();
    [std_errs, biases]
}
