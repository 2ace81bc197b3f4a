//! What a plate reflects of a distant round light: the highlight of Veach's picture as a target.
//!
//! The light is a cone of directions about the mirror direction of the eye, of radiance 1. The wider it is and the smoother
//! the plate, the better are draws from the plate's lobe; the smaller it is and the rougher the plate, the better are draws
//! from the light. Both weighted together are never far from the better one.
//! # References
//! - Veach & Guibas 1995, Optimally combining sampling techniques for Monte Carlo rendering, SIGGRAPH

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::spread::{one_way, sigma, two_ways};
use super::{Draw, Estimator, Target};
use crate::bsdf::{Bsdf, Density};
use crate::math::frame::Frame;
use crate::math::quadrature::adaptive;
use crate::math::sphere::mirror;
use crate::render::path::Heuristic;
use crate::sampling::warp::uniform_cone;

/// The tolerance of the integrals, relative to that of the mean and of its second moments.
const TOL: f64 = 1e-9;
/// Panels of either coordinate at most.
const PANELS: usize = 60;

/// The radiance that `bsdf` reflects towards `wo` of a light that fills the cone of `half_angle` about the mirror direction.
///
/// `wo` above the horizon, the whole cone as well: `half_angle`, in radians, is less than the angle of `wo` from the horizon.
/// `bsdf` is opaque and has no Dirac lobes.
pub fn highlight<'a>(name: &str, bsdf: &'a dyn Bsdf, wo: DVec3, half_angle: f64) -> Target<'a> {
    let seen = Seen { bsdf, wo, frame: Frame::about(mirror(wo)), half_angle };
    let (integrals, error) = seen.integrals();
    let [light, bsdf, balance, power] = std::array::from_fn(|i| {
        let terms = &integrals[4 * i..4 * i + 4];
        Some(sigma([terms[0], terms[1], terms[2], terms[3]], error))
    });
    let estimators = vec![
        Estimator { name: "light", draw: seen.by_light(), sigma: light },
        Estimator { name: "bsdf", draw: seen.by_bsdf(), sigma: bsdf },
        Estimator { name: "balance", draw: seen.by_both(Heuristic::Balance), sigma: balance },
        Estimator { name: "power", draw: seen.by_both(Heuristic::Power), sigma: power },
    ];
    Target { name: name.into(), exact: integrals[0], error, estimators }
}

/// A plate and its light.
#[derive(Clone, Copy, Debug)]
struct Seen<'a> {
    bsdf: &'a dyn Bsdf,
    wo: DVec3,
    /// About the centre of the light.
    frame: Frame,
    half_angle: f64,
}

impl<'a> Seen<'a> {
    /// f cosθ: the light's radiance is 1.
    fn reflected(&self, wi: DVec3) -> f64 {
        self.bsdf.eval(self.wo, wi).mean() * wi.z.max(0.0)
    }

    /// 2π (1 − cos g) without its cancellation.
    fn solid_angle(&self) -> f64 {
        2.0 * TAU * (0.5 * self.half_angle).sin().powi(2)
    }

    fn is_lit_along(&self, wi: DVec3) -> bool {
        let local = self.frame.to_local(wi);
        // The angle from the axis by its tangent: a cosine has lost the digits of a small one.
        local.z > 0.0 && local.truncate().length().atan2(local.z) <= self.half_angle
    }

    /// The terms of the four estimators, integrated over the light, and a bound on their error.
    fn integrals(&self) -> ([f64; 16], f64) {
        let p = 1.0 / self.solid_angle();
        let terms = |theta: f64, phi: f64| -> [f64; 16] {
            let (sin, cos) = theta.sin_cos();
            let wi = self.frame.to_world(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
            let (g, q) = (self.reflected(wi), self.bsdf.pdf(self.wo, wi));
            let four = [
                one_way(g, p),
                one_way(g, q),
                two_ways(Heuristic::Balance, g, p, q),
                two_ways(Heuristic::Power, g, p, q),
            ];
            std::array::from_fn(|i| four[i / 4][i % 4])
        };
        let ring =
            |theta: f64, tol: f64| adaptive(|phi| terms(theta, phi), &[0.0, 0.5 * PI, PI, 1.5 * PI, TAU], tol, PANELS);
        // The sharpest lobes here are a hundredth wide: the first panels must not step over them.
        let breaks: Vec<f64> =
            [0.0, 0.003, 0.03, 0.1, 0.3, 1.0].into_iter().map(|share| share * self.half_angle).collect();
        let total = |tol: f64| {
            let mut inner = 0.0_f64;
            let outer = adaptive(
                |theta| {
                    // What weighs little may be known less well.
                    let ring = ring(theta, tol / (self.half_angle * theta.sin()));
                    inner = inner.max(ring.error * theta.sin());
                    ring.value.map(|value| value * theta.sin())
                },
                &breaks,
                tol,
                PANELS,
            );
            (outer.value, outer.error + inner * self.half_angle)
        };
        // A first look says how large the second moments are.
        let scale = total(f64::INFINITY).0.into_iter().fold(0.0, f64::max);
        total(TOL * scale)
    }

    /// One draw from the light and its direction.
    fn light(&self, u: glam::DVec2) -> DVec3 {
        self.frame.to_world(uniform_cone(u, self.half_angle))
    }

    fn by_light(self) -> Draw<'a> {
        let solid_angle = self.solid_angle();
        Box::new(move |sampler| self.reflected(self.light(sampler.next_2d())) * solid_angle)
    }

    fn by_bsdf(self) -> Draw<'a> {
        Box::new(move |sampler| {
            let drawn = self.bsdf.sample(self.wo, sampler.next_uniforms());
            drawn.filter(|drawn| self.is_lit_along(drawn.wi)).map_or(0.0, |drawn| drawn.weight.mean())
        })
    }

    fn by_both(self, by: Heuristic) -> Draw<'a> {
        let p = 1.0 / self.solid_angle();
        Box::new(move |sampler| {
            let wi = self.light(sampler.next_2d());
            let by_light = self.reflected(wi) / p * by.weight(p, self.bsdf.pdf(self.wo, wi));
            let drawn = self.bsdf.sample(self.wo, sampler.next_uniforms());
            let by_bsdf = drawn.filter(|drawn| self.is_lit_along(drawn.wi)).map_or(0.0, |drawn| match drawn.density {
                Density::SolidAngle(q) => drawn.weight.mean() * by.weight(q, p),
                Density::Dirac(_) => 0.0,
            });
            by_light + by_bsdf
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Study;
    use super::*;
    use crate::bsdf::{Ggx, Lambert};
    use crate::math::sphere::direction;
    use crate::sampling::sampler::SamplerKind;

    #[test]
    fn a_diffuse_plate_has_its_closed_form() {
        // E = π sin²g cosθ for a cone above the horizon, and the radiance is ρ/π of it.
        let plate = Lambert::new(0.5).unwrap();
        for half_angle in [1e-3_f64, 0.2, 0.6] {
            let target = highlight("", &plate, direction(0.8, 0.3), half_angle);
            let exact = 0.5 * half_angle.sin().powi(2) * 0.8_f64.cos();
            // The tolerance, relative to second moments of the same size.
            assert!((target.exact / exact - 1.0).abs() < 1e-8, "{half_angle}: {} against {exact}", target.exact);
        }
    }

    #[test]
    fn estimators_have_the_mean_and_the_spread_of_the_integrals() {
        for (i, (alpha, half_angle)) in [(0.1, 0.02), (0.1, 0.2), (0.3, 0.4)].into_iter().enumerate() {
            let plate = Ggx::new(alpha).unwrap();
            let target = highlight("", &plate, direction(0.7, 0.0), half_angle);
            for (k, estimator) in target.estimators.iter().enumerate() {
                let number = (4 * i + k) as u64;
                let study =
                    Study { counts: vec![1024], replicates: 64, seed: 1, number, sampler: SamplerKind::Independent };
                let found = study.run(estimator, target.exact, target.error).samples;
                let (sigma, name) = (estimator.sigma.unwrap(), estimator.name);
                // 12 means and 12 variances: one of them in 6000 seeds is farther out than 4.5 standard errors.
                let z = (found.mean() - target.exact) / (sigma / (found.count() as f64).sqrt());
                assert!(z.abs() < 4.5, "{alpha} {half_angle} {name}: mean {z}");
                let error = ((found.excess_kurtosis() + 2.0) / found.count() as f64).sqrt();
                let z = (found.variance() / sigma.powi(2) - 1.0) / error;
                assert!(z.abs() < 4.5, "{alpha} {half_angle} {name}: variance {z}");
                // A spread that is wrong by a tenth would be seen.
                assert!(4.5 * error < 0.2, "{alpha} {half_angle} {name}: {error}");
            }
        }
    }
}
