//! The directional albedo of a model as a target, with the standard deviations of its estimators where all light is reflected.

use std::f64::consts::PI;

use glam::DVec3;

use super::spread::{Terms, one_way, sigma, two_ways};
use super::{Draw, Estimator, Target};
use crate::bsdf::{Bsdf, Density, Lobes};
use crate::integrate::{Hemisphere, Side, hints};
use crate::render::path::Heuristic;
use crate::sampling::sampler::Sampler;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf, uniform_hemisphere, uniform_hemisphere_pdf};

/// The tolerance of a variance: the smallest that matters, of a sharp lobe drawn by itself, is near 1e-6.
const VARIANCE_TOL: f64 = 1e-10;

/// The albedo of `bsdf` for light towards `wo`, all channels' mean, from the certified integrator. Models with Dirac lobes
/// have the estimator `bsdf` alone: no other finds such a lobe.
pub fn albedo<'a>(name: &str, bsdf: &'a dyn Bsdf, wo: DVec3) -> Target<'a> {
    let exact = Hemisphere::default().albedo(bsdf, Side::Eye, wo);
    let mut estimators = vec![Estimator { name: "bsdf", draw: own(bsdf, wo), sigma: None }];
    if !bsdf.lobes().contains(Lobes::DIRAC) {
        estimators.extend([
            Estimator { name: "cosine", draw: cosine(bsdf, wo), sigma: None },
            Estimator { name: "uniform", draw: uniform(bsdf, wo), sigma: None },
            Estimator { name: "balance", draw: both(bsdf, wo, Heuristic::Balance), sigma: None },
            Estimator { name: "power", draw: both(bsdf, wo, Heuristic::Power), sigma: None },
        ]);
        for estimator in &mut estimators {
            estimator.sigma = spread(estimator.name, bsdf, wo);
        }
    }
    Target { name: name.into(), exact: exact.value.mean(), error: exact.error, estimators }
}

/// The standard deviation of one sample by quadrature; None where light is transmitted, or the integrals are not resolved.
fn spread(estimator: &str, bsdf: &dyn Bsdf, wo: DVec3) -> Option<f64> {
    if sides(bsdf) > 1.0 || wo.z <= 0.0 {
        return None;
    }
    let terms = |wi: DVec3| -> Terms {
        let g = f_cos(bsdf, wo, wi);
        match estimator {
            "uniform" => one_way(g, uniform_hemisphere_pdf(wi)),
            "cosine" => one_way(g, cosine_hemisphere_pdf(wi)),
            "bsdf" => one_way(g, bsdf.pdf(wo, wi)),
            "balance" => two_ways(Heuristic::Balance, g, cosine_hemisphere_pdf(wi), bsdf.pdf(wo, wi)),
            _ => two_ways(Heuristic::Power, g, cosine_hemisphere_pdf(wi), bsdf.pdf(wo, wi)),
        }
    };
    let integral = Hemisphere { tol: VARIANCE_TOL, ..Hemisphere::default() }.integrate(wo, &hints(bsdf, wo), &terms);
    integral.resolved.then(|| sigma(integral.value, integral.error))
}

/// f |cos|, all channels' mean.
fn f_cos(bsdf: &dyn Bsdf, wo: DVec3, wi: DVec3) -> f64 {
    bsdf.eval(wo, wi).mean() * wi.z.abs()
}

/// On how many sides of the surface there is light.
fn sides(bsdf: &dyn Bsdf) -> f64 {
    if bsdf.lobes().contains(Lobes::TRANSMIT) { 2.0 } else { 1.0 }
}

/// A direction of the upper half to the side that `u` picks, for `sides` of 2; to that of `wo` for 1.
fn to_side(w: DVec3, wo: DVec3, sides: f64, u: f64) -> DVec3 {
    let up = if sides > 1.0 { u < 0.5 } else { wo.z > 0.0 };
    if up { w } else { DVec3::new(w.x, w.y, -w.z) }
}

fn own(bsdf: &dyn Bsdf, wo: DVec3) -> Draw<'_> {
    Box::new(move |sampler| bsdf.sample(wo, sampler.next_uniforms()).map_or(0.0, |drawn| drawn.weight.mean()))
}

fn uniform(bsdf: &dyn Bsdf, wo: DVec3) -> Draw<'_> {
    let sides = sides(bsdf);
    Box::new(move |sampler| {
        let u = sampler.next_uniforms();
        let wi = to_side(uniform_hemisphere(u.dir), wo, sides, u.lobe);
        f_cos(bsdf, wo, wi) * 2.0 * PI * sides
    })
}

/// A cosine-weighted direction and its density [1/sr].
fn cosine_sample(wo: DVec3, sides: f64, sampler: &mut dyn Sampler) -> (DVec3, f64) {
    let u = sampler.next_uniforms();
    let wi = to_side(cosine_hemisphere(u.dir), wo, sides, u.lobe);
    (wi, wi.z.abs() / (PI * sides))
}

fn cosine(bsdf: &dyn Bsdf, wo: DVec3) -> Draw<'_> {
    let sides = sides(bsdf);
    Box::new(move |sampler| {
        let (wi, _) = cosine_sample(wo, sides, sampler);
        // The cosine of f cos / pdf cancels.
        bsdf.eval(wo, wi).mean() * PI * sides
    })
}

/// One cosine-weighted and one sample of the model's own.
fn both(bsdf: &dyn Bsdf, wo: DVec3, by: Heuristic) -> Draw<'_> {
    let sides = sides(bsdf);
    Box::new(move |sampler| {
        let (wi, p) = cosine_sample(wo, sides, sampler);
        let by_cosine = bsdf.eval(wo, wi).mean() * PI * sides * by.weight(p, bsdf.pdf(wo, wi));
        let by_model = bsdf.sample(wo, sampler.next_uniforms()).map_or(0.0, |drawn| match drawn.density {
            Density::SolidAngle(q) => drawn.weight.mean() * by.weight(q, drawn.wi.z.abs() / (PI * sides)),
            Density::Dirac(_) => drawn.weight.mean(),
        });
        by_cosine + by_model
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Ggx, Lambert, Phong, PhongNorm};

    #[test]
    fn spreads_are_the_closed_ones() {
        let n = 20.0;
        let phong = Phong::new(n, 0.0, 1.0, PhongNorm::AlbedoNPlus2).unwrap();
        let target = albedo("", &phong, DVec3::Z);
        let lobe = 1.0 / ((n + 1.0) * (n + 3.0));
        for (name, exact) in
            [("uniform", (n + 1.0).powi(2) / (2.0 * n + 3.0)), ("cosine", n * n / (4.0 * (n + 1.0))), ("bsdf", lobe)]
        {
            let sigma = target.estimators.iter().find(|e| e.name == name).and_then(|e| e.sigma).unwrap();
            // The tolerance against the smallest of the three.
            assert!((sigma * sigma / exact - 1.0).abs() < 1e-6, "{name}: {} against {exact}", sigma * sigma);
        }
        let lambert = Lambert::new(0.6).unwrap();
        let spreads: Vec<_> = albedo("", &lambert, DVec3::Z).estimators.iter().map(|e| e.sigma).collect();
        // Uniform directions: ρ²/3; all others draw what the cosine asks for.
        assert!(spreads[2].is_some_and(|sigma| (sigma * sigma - 0.12).abs() < 1e-9));
        assert!([0, 1, 3, 4].iter().all(|&i| spreads[i] == Some(0.0)), "{spreads:?}");
    }

    #[test]
    fn a_pair_is_bounded_as_veach_proved() {
        // V_balance ≤ V_any + (1/min nᵢ − 1/Σ nᵢ) μ², with one draw each.
        for alpha in [0.1, 0.4, 1.0] {
            let ggx = Ggx::new(alpha).unwrap();
            let target = albedo("", &ggx, crate::math::sphere::direction_mu(0.4, 0.0));
            let variance: Vec<f64> = target.estimators.iter().map(|e| e.sigma.unwrap().powi(2)).collect();
            let [bsdf, cosine, _, balance, power] = variance[..] else { panic!("five estimators") };
            let most = 0.5 * target.exact * target.exact;
            assert!(balance <= bsdf.min(cosine).min(power) + most, "{alpha}: {variance:?}");
        }
    }

    #[test]
    fn where_light_goes_through_no_spread_is_stated() {
        let glass = crate::bsdf::subject::parse("rough-dielectric:alpha=0.4,eta=1.5").unwrap();
        assert!(albedo("", &glass, DVec3::Z).estimators.iter().all(|e| e.sigma.is_none()));
    }
}
