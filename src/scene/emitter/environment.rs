//! Light from infinitely far, sampled by its radiance.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::math::color::Rgb;
use crate::sampling::discrete::AliasTable;
use crate::sampling::warp::{uniform_sphere, uniform_sphere_pdf};
use crate::scene::light::EnvironmentMap;

/// Radiance from every direction, with a sampler whose density is nearly proportional to it.
#[derive(Clone, Debug)]
pub(super) enum EnvironmentSampler {
    Constant(Rgb),
    Map { map: EnvironmentMap, cells: Box<AliasTable>, total: f64 },
}

impl EnvironmentSampler {
    pub(super) fn constant(radiance: Rgb) -> Self {
        Self::Constant(radiance)
    }

    /// None for a map without a pixel that shines, or with one that is not finite and ≥ 0.
    pub(super) fn of_map(map: EnvironmentMap) -> Option<Self> {
        let (w, h) = (map.width, map.height);
        let sound = w > 0 && h > 0 && map.pixels.len() == w * h && map.scale >= 0.0 && map.scale.is_finite();
        if !sound || map.pixels.iter().flatten().any(|&x| !(x >= 0.0 && x.is_finite())) {
            return None;
        }
        let grey = |x: usize, y: usize| map.pixels[y * w + x].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
        let mut weights = Vec::with_capacity(w * h);
        for y in 0..h {
            // The exact solid angle of the row.
            let edge = |y: usize| (PI * y as f64 / h as f64).cos();
            let row = (edge(y) - edge(y + 1)) * TAU / w as f64;
            for x in 0..w {
                // All pixels that an interpolated value within this cell depends on, so that none is left out.
                let near = |x: usize| {
                    let (above, below) = (y.saturating_sub(1), (y + 1).min(h - 1));
                    0.25 * grey(x, above) + 0.5 * grey(x, y) + 0.25 * grey(x, below)
                };
                let value = 0.25 * near((x + w - 1) % w) + 0.5 * near(x) + 0.25 * near((x + 1) % w);
                weights.push(value * row);
            }
        }
        let total = weights.iter().sum::<f64>() * map.scale;
        let cells = Box::new(AliasTable::new(&weights)?);
        (map.scale > 0.0).then_some(Self::Map { map, cells, total })
    }

    /// ∫ L dω.
    pub(super) fn total(&self) -> f64 {
        match self {
            Self::Constant(radiance) => 2.0 * TAU * radiance.mean(),
            Self::Map { total, .. } => *total,
        }
    }

    /// Draws a direction: it, the radiance from there, and the density [1/sr].
    pub(super) fn sample(&self, u: DVec2) -> (DVec3, Rgb, f64) {
        match self {
            Self::Constant(radiance) => (uniform_sphere(u), *radiance, uniform_sphere_pdf()),
            Self::Map { map, cells, .. } => {
                let (cell, probability, fresh) = cells.pick(u.x);
                let (x, y) = (cell % map.width, cell / map.width);
                let edge = |y: usize| (PI * y as f64 / map.height as f64).cos();
                let (top, bottom) = (edge(y), edge(y + 1));
                let cos = top + (bottom - top) * fresh;
                let phi = TAU * (x as f64 + u.y) / map.width as f64;
                let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
                let local = DVec3::new(phi.sin() * sin, cos, -phi.cos() * sin);
                let pdf = probability * map.width as f64 / (TAU * (top - bottom));
                let wi = map.to_world * local;
                (wi, radiance(map, local), pdf)
            }
        }
    }

    /// The radiance from `wi` and the density [1/sr] of drawing it.
    pub(super) fn eval(&self, wi: DVec3) -> (Rgb, f64) {
        match self {
            Self::Constant(radiance) => (*radiance, uniform_sphere_pdf()),
            Self::Map { map, cells, .. } => {
                let local = map.to_world.transpose() * wi;
                let (u, v) = uv(local);
                let x = ((u * map.width as f64) as usize).min(map.width - 1);
                let y = ((v * map.height as f64) as usize).min(map.height - 1);
                let edge = |y: usize| (PI * y as f64 / map.height as f64).cos();
                let pdf = cells.probability(y * map.width + x) * map.width as f64 / (TAU * (edge(y) - edge(y + 1)));
                (radiance(map, local), pdf)
            }
        }
    }
}

/// Where a direction of the map's space lies in the picture, in [0, 1]².
fn uv(w: DVec3) -> (f64, f64) {
    let u = w.x.atan2(-w.z) / TAU;
    (if u < 0.0 { u + 1.0 } else { u }, w.x.hypot(w.z).atan2(w.y) / PI)
}

/// The interpolated radiance from a direction of the map's space; pixels count at their centres.
fn radiance(map: &EnvironmentMap, w: DVec3) -> Rgb {
    let (u, v) = uv(w);
    let (x, y) = (u * map.width as f64 - 0.5, (v * map.height as f64 - 0.5).clamp(0.0, map.height as f64 - 1.0));
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let column = |x: f64| (x.rem_euclid(map.width as f64) as usize).min(map.width - 1);
    let pixel = |x: usize, y: f64| {
        let [r, g, b] = map.pixels[(y as usize).min(map.height - 1) * map.width + x].map(f64::from);
        Rgb::new(r, g, b)
    };
    let (left, right) = (column(x0), column(x0 + 1.0));
    let row = |y: f64| pixel(left, y) * (1.0 - fx) + pixel(right, y) * fx;
    (row(y0) * (1.0 - fy) + row(y0 + 1.0) * fy) * map.scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sum::Moments;
    use crate::sampling::stream::{stream, uniform};
    use glam::DMat3;
    use std::sync::Arc;

    fn sun() -> EnvironmentSampler {
        let mut pixels = vec![[0.1; 3]; 16 * 8];
        pixels[3 * 16 + 5] = [50.0, 20.0, 10.0];
        pixels[0] = [0.0; 3];
        let to_world = DMat3::from_rotation_x(0.6) * DMat3::from_rotation_y(1.0);
        let map = EnvironmentMap { pixels: Arc::new(pixels), width: 16, height: 8, to_world, scale: 2.0 };
        EnvironmentSampler::of_map(map).unwrap()
    }

    #[test]
    fn draws_agree_with_the_density_and_estimate_the_total() {
        let (sun, mut rng) = (sun(), stream(6, 0, 0));
        let (mut by_map, mut uniformly) = (Moments::default(), Moments::default());
        for _ in 0..200_000 {
            let u = DVec2::new(uniform(&mut rng), uniform(&mut rng));
            let (wi, l, pdf) = sun.sample(u);
            let (again, again_pdf) = sun.eval(wi);
            assert!((again - l).max_channel().abs() < 1e-9 && (again_pdf / pdf - 1.0).abs() < 1e-9);
            by_map.add(l.mean() / pdf);
            uniformly.add(sun.eval(uniform_sphere(u)).0.mean() * 2.0 * TAU);
        }
        let error = by_map.std_err().hypot(uniformly.std_err());
        assert!((by_map.mean() - uniformly.mean()).abs() < 4.0 * error, "1 in 16 000 seeds");
        // The weights are exact integrals up to the curvature of the sphere within a pixel, 1/8 of a half turn here.
        assert!((sun.total() / by_map.mean() - 1.0).abs() < 0.05, "{} {}", sun.total(), by_map.mean());
        assert!(by_map.variance() < 0.1 * uniformly.variance(), "importance sampling must pay");
    }

    #[test]
    fn bad_maps_are_none() {
        let with = |value: f32| {
            let map = EnvironmentMap {
                pixels: Arc::new(vec![[value; 3]; 2]),
                width: 2,
                height: 1,
                to_world: DMat3::IDENTITY,
                scale: 1.0,
            };
            EnvironmentSampler::of_map(map)
        };
        assert!(with(1.0).is_some() && with(0.0).is_none() && with(f32::NAN).is_none() && with(-1.0).is_none());
    }
}
