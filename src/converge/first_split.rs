//! The law of the first split: continuing a path M times from its first surface leaves Var = V₀ + V₁/M.
//!
//! A sample has a first event, such as the point of the pixel that is seen, and M continuations of it, independent of
//! each other. Given the first event their mean has 1/M of the variance of one: V₀ = Var[E[X | first]] stays, and
//! V₁ = E[Var[X | first]] is divided by M.
//! # References
//! - Arvo & Kirk 1990, Particle transport and image synthesis, SIGGRAPH (splitting)

use glam::DVec2;
use rayon::prelude::*;

use super::irradiance::irradiance;
use super::variance::{moments, variance_std_err};
use crate::math::sum::Moments;
use crate::render::path::PathTracer;
use crate::render::probe::{BLOCK, Probe};
use crate::sampling::sampler::Sampler;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::Scene;
use crate::validate::power::chi_square_p;

/// A variance at a number of continuations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Continuations of each first event.
    pub m: u32,
    /// The mean of all samples.
    pub mean: f64,
    /// Its standard error.
    pub mean_std_err: f64,
    /// The variance of one sample.
    pub variance: f64,
    /// Its standard error.
    pub std_err: f64,
}

impl Point {
    fn of(m: u32, moments: &Moments) -> Self {
        Self {
            m,
            mean: moments.mean(),
            mean_std_err: moments.std_err(),
            variance: moments.variance(),
            std_err: variance_std_err(moments),
        }
    }
}

/// Var = v0 + v1 / M.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// What splitting leaves.
    pub v0: f64,
    /// What it divides.
    pub v1: f64,
}

impl Law {
    /// The variance with `m` continuations.
    pub fn at(&self, m: f64) -> f64 {
        self.v0 + self.v1 / m
    }
}

/// The law that fits measured variances best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The law.
    pub law: Law,
    /// Standard errors of `v0` and `v1`.
    pub std_err: Law,
    /// The covariance of the two.
    pub covariance: f64,
    /// Σ ((variance − law) / standard error)².
    pub chi2: f64,
    /// Points less two.
    pub dof: usize,
}

impl Fit {
    /// Weighted least squares with weights 1 / (standard error)². None for fewer than three points, or points without
    /// spread or error.
    pub fn of(points: &[Point]) -> Option<Self> {
        if points.len() < 3 || !points.iter().all(|p| p.std_err > 0.0 && p.std_err.is_finite()) {
            return None;
        }
        let sum = |term: &dyn Fn(&Point, f64) -> f64| -> f64 {
            points.iter().map(|p| term(p, 1.0 / f64::from(p.m)) / (p.std_err * p.std_err)).sum()
        };
        let (s, sx, sxx) = (sum(&|_, _| 1.0), sum(&|_, x| x), sum(&|_, x| x * x));
        let (sy, sxy) = (sum(&|p, _| p.variance), sum(&|p, x| x * p.variance));
        let determinant = s * sxx - sx * sx;
        // Relative to its terms: below this, all M are the same but for rounding.
        let differ = determinant > 1e-12 * s * sxx;
        if !differ {
            return None;
        }
        let law = Law { v0: (sxx * sy - sx * sxy) / determinant, v1: (s * sxy - sx * sy) / determinant };
        Some(Self {
            law,
            std_err: Law { v0: (sxx / determinant).sqrt(), v1: (s / determinant).sqrt() },
            covariance: -sx / determinant,
            chi2: points.iter().map(|p| ((p.variance - law.at(p.m.into())) / p.std_err).powi(2)).sum(),
            dof: points.len() - 2,
        })
    }

    /// The probability of a misfit as large as this, if Var = V₀ + V₁/M.
    pub fn p_value(&self) -> f64 {
        chi_square_p(self.chi2, self.dof)
    }

    /// The probability of a fit as far as this from `exact`, if that is the law.
    pub fn p_value_of(&self, exact: &Law) -> f64 {
        let (d0, d1) = (self.law.v0 - exact.v0, self.law.v1 - exact.v1);
        let (c00, c11, c01) = (self.std_err.v0.powi(2), self.std_err.v1.powi(2), self.covariance);
        let distance = (d0 * d0 * c11 - 2.0 * d0 * d1 * c01 + d1 * d1 * c00) / (c00 * c11 - c01 * c01);
        chi_square_p(distance, 2)
    }
}

/// A pixel that sees a floor whose albedo grows from 0 to 1 across it, one below the centre of a unit square of radiance 1.
///
/// The first event is the albedo ρ, uniform in [0, 1); a continuation is a cosine-weighted direction, which hits the square
/// with probability F = E/π. All floors are taken to be at the same place, so that E is that of
/// [`irradiance`]'s `unit-square`. One continuation brings ρ if it hits, so that
///
/// mean = F/2,   V₀ = F² / 12,   V₁ = F (1 − F) / 3
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    f: f64,
}

impl Floor {
    /// None never happens: the square is one of the library's own.
    pub fn new() -> Option<Self> {
        irradiance("unit-square").map(|square| Self { f: square.exact / std::f64::consts::PI })
    }

    /// F/2.
    pub fn mean(&self) -> f64 {
        0.5 * self.f
    }

    /// The law in closed form.
    pub fn law(&self) -> Law {
        Law { v0: self.f * self.f / 12.0, v1: self.f * (1.0 - self.f) / 3.0 }
    }

    /// The mean of `m` continuations of one first event.
    pub fn draw(&self, m: u32, sampler: &mut dyn Sampler) -> f64 {
        let albedo = sampler.next_1d();
        let hits: u32 = (0..m).map(|_| u32::from(Self::is_lit(sampler))).sum();
        albedo * f64::from(hits) / f64::from(m)
    }

    /// Whether a cosine-weighted direction hits the square.
    fn is_lit(sampler: &mut dyn Sampler) -> bool {
        let w = cosine_hemisphere(sampler.next_2d());
        let on_plane: DVec2 = w.truncate() / w.z;
        on_plane.abs().max_element() < 0.5
    }

    /// The variance of `n` samples for each M.
    pub fn measure(&self, splits: &[u32], n: u64, seed: u64) -> Vec<Point> {
        measure(splits, n, seed, &|m, sampler| self.draw(m, sampler))
    }
}

/// The variance of `n` values of `draw` for each M; no two share a random number.
fn measure(splits: &[u32], n: u64, seed: u64, draw: &(dyn Fn(u32, &mut dyn Sampler) -> f64 + Sync)) -> Vec<Point> {
    let point =
        |(number, &m): (usize, &u32)| Point::of(m, &moments(n, seed, number as u64, &|sampler| draw(m, sampler)));
    splits.iter().enumerate().map(point).collect()
}

/// A pixel of a scene whose paths the path tracer splits.
#[derive(Debug)]
pub struct Pixel<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Column and row of the pixel in the scene's image.
    pub at: [usize; 2],
    /// How it is rendered, but for the split.
    pub tracer: PathTracer,
}

impl Pixel<'_> {
    /// The variance of the mean of all channels over some `n` samples (whole blocks of 1024) for each M.
    pub fn measure(&self, splits: &[u32], n: u64, seed: u64) -> Vec<Point> {
        let corner = DVec2::new(self.at[0] as f64, self.at[1] as f64);
        let ray = |sampler: &mut dyn Sampler| {
            let film = corner + sampler.next_2d();
            let lens = if self.scene.camera().has_lens() { sampler.next_2d() } else { DVec2::ZERO };
            self.scene.camera_ray(film, lens)
        };
        let point = |(number, &m): (usize, &u32)| {
            let tracer = PathTracer { first_split: m, ..self.tracer };
            let probe = Probe { seed, number: number as u64, samples: n };
            let block = |block: u64| {
                let mut moments = Moments::default();
                let samples = probe.values(&tracer, self.scene, &ray, block * BLOCK..(block + 1) * BLOCK);
                samples.for_each(|radiance| moments.add(radiance.mean()));
                moments
            };
            let blocks: Vec<Moments> = (0..n.div_ceil(BLOCK)).into_par_iter().map(block).collect();
            Point::of(m, &blocks.iter().fold(Moments::default(), |all, one| all.merge(one)))
        };
        splits.iter().enumerate().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPLITS: [u32; 6] = [1, 2, 4, 8, 16, 32];
    /// The seeds are fixed; one in 1000 would fail.
    const LEVEL: f64 = 1e-3;

    #[test]
    fn the_law_is_recovered_and_its_twins_are_not() {
        let floor = Floor::new().unwrap();
        let law = floor.law();
        let n = 40_000;
        let points = floor.measure(&SPLITS, n, 1);
        let fit = Fit::of(&points).unwrap();
        assert!(fit.p_value() > LEVEL, "{fit:?}");
        assert!(fit.p_value_of(&law) > LEVEL, "{fit:?} against {law:?}");
        // What is asked for is told to some per cent, or agreement means little.
        assert!(fit.std_err.v0 < 0.05 * law.v0 && fit.std_err.v1 < 0.02 * law.v1, "{fit:?}");
        for p in &points {
            assert!((p.mean - floor.mean()).abs() < 4.0 * p.mean_std_err, "M = {}", p.m);
        }

        // A sum that is not divided by M: no such law at all.
        let undivided = Fit::of(&measure(&SPLITS, n, 1, &|m, s| floor.draw(m, s) * f64::from(m))).unwrap();
        assert!(undivided.p_value() < LEVEL, "{undivided:?}");
        // One continuation used M times: splitting does nothing, V₁ is all in V₀.
        let reused = Fit::of(&measure(&SPLITS, n, 1, &|_, s| floor.draw(1, s))).unwrap();
        assert!(reused.p_value_of(&law) < LEVEL && reused.law.v1.abs() < 4.0 * reused.std_err.v1, "{reused:?}");
    }

    #[test]
    fn the_path_tracer_obeys_the_law() {
        let scene = Scene::new(crate::scene::builtin::builtin("cornell-original", &[]).unwrap().unwrap()).unwrap();
        let tracer = PathTracer { bounces: Some(2), ..PathTracer::default() };
        // A large pixel, so that its points differ and V₀ is seen.
        let scene = scene.with_size(4, 4);
        let points = Pixel { scene: &scene, at: [1, 2], tracer }.measure(&[1, 2, 4, 8], 4096, 1);
        let fit = Fit::of(&points).unwrap();
        assert!(fit.p_value() > LEVEL, "{fit:?}");
        assert!(fit.law.v0 > 4.0 * fit.std_err.v0 && fit.law.v1 > 4.0 * fit.std_err.v1, "both are there: {fit:?}");
    }

    #[test]
    fn a_law_is_fitted_exactly() {
        let law = Law { v0: 0.25, v1: 3.0 };
        let point =
            |m: u32| Point { m, mean: 0.0, mean_std_err: 1.0, variance: law.at(m.into()), std_err: 0.1 / f64::from(m) };
        let points = [1, 3, 7, 50].map(point);
        let fit = Fit::of(&points).unwrap();
        // Sums of four terms.
        assert!((fit.law.v0 - law.v0).abs() < 1e-12 && (fit.law.v1 - law.v1).abs() < 1e-12 && fit.chi2 < 1e-20);
        assert!(fit.p_value_of(&law) > 0.999 && fit.p_value_of(&Law { v0: 0.3, v1: 3.0 }) < 1e-6);
        assert!(Fit::of(&points[..2]).is_none() && Fit::of(&[points[0]; 4]).is_none());
    }
}
