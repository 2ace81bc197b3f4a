//! Stochastic progressive photon mapping: one small map for each sample of the image, with radii that shrink.
//!
//! Pass i has its own photons, and its own radius: r²_{i+1} / r²_i = (i + α) / (i + 1), i from 1. The variance of a pass
//! grows like 1 / r², its bias like r²; of the mean of n passes the variance falls like n^−α and the bias like n^(α−1). The
//! default α = 2/3 lets variance and squared bias fall alike: the mean square error goes with n^(−2/3), its root with n^(−1/3). No
//! other exponent does better. One map is held at a time, however many passes there are, and passes are independent, so that
//! the variance of a pixel is that of its samples.
//!
//! Direct light is connected to; photons count from their first reflection on.
//! # References
//! - Hachisuka & Jensen 2009, Stochastic progressive photon mapping, ACM TOG 28(5)
//! - Knaus & Zwicker 2011, Progressive photon mapping: a probabilistic approach, ACM TOG 30(3) (the radii, eq. 15)
//! - Kaplanyan & Dachsbacher 2013, Adaptive progressive photon mapping, ACM TOG 32(2) (the exponent)

use std::f64::consts::PI;

use super::gather::connected;
use super::kernel::Estimator;
use super::map::{Around, Gather, PhotonMap};
use super::shoot::Shooting;
use super::view::through_mirrors;
use super::{Kept, PhotonError};
use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::sampling::sampler::Sampler;
use crate::scene::{Ray, Scene};

/// The exponent that lets variance and squared bias fall alike.
pub const ALPHA: f64 = 2.0 / 3.0;

/// The plan of all passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sppm {
    shooting: Shooting,
    estimator: Estimator,
    alpha: f64,
    radius: f64,
    /// The largest number of reflections; None for no limit.
    bounces: Option<u32>,
}

impl Sppm {
    /// `photons` in each pass from `seed`; the first radius, or that of a disk which holds `k` photons of the first pass on the
    /// average over all surfaces; `alpha` in (0, 1).
    ///
    /// # Errors
    /// Without light or photons, where none of the first pass is stored, for k = 0, a radius that is not > 0, an alpha
    /// outside (0, 1).
    pub fn new(
        scene: &Scene,
        shooting: Shooting,
        (first, estimator): (First, Estimator),
        alpha: f64,
        bounces: Option<u32>,
    ) -> Result<Self, PhotonError> {
        let inside = alpha > 0.0 && alpha < 1.0;
        if !inside {
            return Err(PhotonError::Exponent(alpha));
        }
        let shooting = Shooting { kept: Kept::Scattered, bounces: bounces.map(|r| r.saturating_sub(1)), ..shooting };
        let radius = match first {
            First::Radius(radius) => radius,
            First::Holds(k) => {
                let stored = shooting.shoot(scene)?.photons.len();
                if stored == 0 {
                    return Err(PhotonError::NothingReached { emitted: shooting.photons, map: shooting.kept.name() });
                }
                (k as f64 * scene.area() / (PI * stored as f64)).sqrt()
            }
        };
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(PhotonError::Radius(radius));
        }
        Ok(Self { shooting, estimator, alpha, radius, bounces })
    }

    /// The radius of a pass, from 0.
    pub fn radius(&self, pass: u64) -> f64 {
        // Π (i + α) / (i + 1) over i = 1 … pass, by logarithms: Γ(pass + 1 + α) / Γ(1 + α) / Γ(pass + 2) Γ(2).
        let n = pass as f64;
        let log = libm::lgamma(n + 1.0 + self.alpha) - libm::lgamma(1.0 + self.alpha) - libm::lgamma(n + 2.0);
        self.radius * (0.5 * log).exp()
    }

    /// The light of a pass, from 0.
    ///
    /// # Errors
    /// Where more would be stored than may be.
    pub fn pass(&self, scene: &Scene, pass: u64) -> Result<Pass, PhotonError> {
        let shot = Shooting { pass, ..self.shooting }.shoot(scene)?;
        let around = Around::Radius(self.radius(pass));
        let gather = Gather { around, estimator: self.estimator, ..Gather::default() };
        Ok(Pass { map: PhotonMap::new(scene, &shot.photons, gather)?, bounces: self.bounces })
    }
}

/// How large the first radius is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum First {
    /// This.
    Radius(f64),
    /// That of a disk which holds so many photons on average.
    Holds(usize),
}

/// The light of one pass.
#[derive(Debug)]
pub struct Pass {
    map: PhotonMap,
    bounces: Option<u32>,
}

impl Pass {
    /// The map.
    pub fn map(&self) -> &PhotonMap {
        &self.map
    }
}

impl Radiance for Pass {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        let limit = self.bounces.unwrap_or(u32::MAX);
        let seen = through_mirrors(scene, ray, limit, sampler, |vertex, depth, sampler| {
            let left = limit - depth - 1;
            (connected(scene, vertex, None, left, sampler) + self.map.reflected(scene, vertex, left).value).into()
        });
        seen.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::power_law;
    use crate::math::sum::Moments;
    use crate::sampling::sampler::Independent;
    use crate::sampling::warp::uniform_sphere;
    use crate::scene::builtin::builtin;
    use glam::DVec2;
    use rayon::prelude::*;

    fn furnace() -> Scene {
        Scene::new(builtin("furnace-sphere", &[]).unwrap().unwrap()).unwrap()
    }

    fn plan(scene: &Scene, alpha: f64) -> Result<Sppm, PhotonError> {
        let shooting = Shooting { photons: 2000, ..Shooting::default() };
        Sppm::new(scene, shooting, (First::Holds(30), Estimator::KMinusOne), alpha, None)
    }

    #[test]
    fn radii_are_those_of_the_product() {
        let sppm = plan(&furnace(), ALPHA).unwrap();
        let (mut square, first) = (1.0, sppm.radius(0));
        for pass in 0..200_u32 {
            // A few roundings for each factor, and those of a logarithm of Γ near 800.
            assert!((sppm.radius(pass.into()) / first / f64::sqrt(square) - 1.0).abs() < 1e-12, "{pass}");
            let i = f64::from(pass) + 1.0;
            square *= (i + ALPHA) / (i + 1.0);
        }
        // r² falls like i^(α − 1) in the end.
        let ratio = sppm.radius(1 << 20) / sppm.radius(1 << 23);
        assert!((ratio - 8.0_f64.powf(0.5 * (1.0 - ALPHA))).abs() < 1e-5, "{ratio}");
        for alpha in [0.0, 1.0, -1.0, f64::NAN] {
            assert!(matches!(plan(&furnace(), alpha), Err(PhotonError::Exponent(_))), "{alpha}");
        }
    }

    #[test]
    fn passes_in_a_furnace_have_its_radiance() {
        let scene = furnace();
        let sppm = plan(&scene, ALPHA).unwrap();
        let (mut means, mut sampler) = (Moments::default(), Independent::new(4));
        for pass in 0..60 {
            let light = sppm.pass(&scene, pass).unwrap();
            let mut of_pass = Moments::default();
            for sample in 0..40 {
                sampler.begin(pass, sample);
                let ray = scene.camera_ray(512.0 * sampler.next_2d(), DVec2::ZERO);
                of_pass.add(light.radiance(&scene, ray, &mut sampler).mean());
            }
            means.add(of_pass.mean());
        }
        // e / (1 − ρ) = 1 within 4 sigma; no field, so no bias by the radius.
        assert!((means.mean() - 1.0).abs() <= 4.0 * means.std_err(), "{means:?}");
        assert!(means.std_err() < 0.01);
    }

    /// The exponent of the root mean square error of the mean of n passes, at points of a furnace.
    fn slope(scene: &Scene, alpha: f64) -> f64 {
        // π ρ e / (1 − ρ), both a half: what arrives after a reflection.
        let exact = 0.5 * PI;
        let places: Vec<_> = (0..16)
            .map(|i| {
                let u = DVec2::new((f64::from(i) * 0.618_033_988_749_895).fract(), (f64::from(i) + 0.5) / 16.0);
                scene.intersect(&Ray::new(glam::DVec3::ZERO, uniform_sphere(u))).unwrap()
            })
            .collect();
        let counts = [4_u64, 16, 64, 256];
        let squares: Vec<[f64; 4]> = (0..32_u64)
            .into_par_iter()
            .map(|seed| {
                let shooting = Shooting { photons: 300, seed, ..Shooting::default() };
                let sppm = Sppm::new(scene, shooting, (First::Radius(0.4), Estimator::KMinusOne), alpha, None).unwrap();
                let (mut sums, mut squares) = (vec![0.0; places.len()], [0.0; 4]);
                for pass in 0..counts[3] {
                    let light = sppm.pass(scene, pass).unwrap();
                    for (sum, place) in sums.iter_mut().zip(&places) {
                        *sum += light.map.irradiance(scene, place, -place.p).value.mean();
                    }
                    if let Some(at) = counts.iter().position(|&n| n == pass + 1) {
                        let error = |sum: &f64| (sum / (pass + 1) as f64 - exact).powi(2);
                        squares[at] = sums.iter().map(error).sum();
                    }
                }
                squares
            })
            .collect();
        let error = |at: usize| squares.iter().map(|each| each[at]).sum::<f64>().sqrt();
        let points: Vec<_> = counts.iter().enumerate().map(|(at, &n)| (n as f64, error(at))).collect();
        let [slope, _] = power_law::exponent(&points).expect("errors");
        slope
    }

    #[test]
    fn the_error_of_passes_falls_with_half_of_alpha() {
        // Light that is the same everywhere has no bias by the radius, and the variance of the mean falls like n^(−α).
        let scene = furnace();
        // 512 squares, of which those of one seed go together in part: 6 % each, .02 of the slope, 2.5 times that.
        for (alpha, exponent) in [(ALPHA, -1.0 / 3.0), (0.999, -0.5)] {
            let found = slope(&scene, alpha);
            assert!((found - exponent).abs() <= 0.05, "alpha {alpha}: {found} against {exponent}");
        }
    }
}
