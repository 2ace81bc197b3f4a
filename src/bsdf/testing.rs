//! Oracles for the unit tests of models: quadrature on the hemisphere, and the laws of a sampler.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::{Bsdf, Density, Uniforms};
use crate::math::chart::Chart;
use crate::math::cubature::Mesh;
use crate::math::sphere::direction_mu;

/// ∫ f(w) dw over the hemisphere to `tol`, in half-vector coordinates about `wo`; panics where `tol` is not reached.
pub(super) fn hemisphere(wo: DVec3, tol: f64, f: impl Fn(DVec3) -> f64) -> f64 {
    let integrand = |w| [f(w)];
    let mut mesh = Mesh::new(Chart::half(wo), &integrand);
    mesh.refine(tol, 4_000_000);
    assert!(mesh.error() <= tol, "unresolved at {wo}: {} ± {}", mesh.value()[0], mesh.error());
    mesh.value()[0]
}

/// The directional albedo of the first channel to `tol`.
pub(super) fn albedo(model: &dyn Bsdf, wo: DVec3, tol: f64) -> f64 {
    hemisphere(wo, tol, |wi| model.eval(wo, wi).0.x * wi.z)
}

/// Asserts that the sampler draws from `pdf`: for several g, ∫ g(wi) pdf dwi equals the mean of g over well-spread uniforms.
///
/// `tol` covers the discrepancy of 2¹⁹ points; the horizon is a jagged edge to them.
pub(super) fn sampler_matches_pdf(model: &dyn Bsdf, wo: DVec3, tol: f64) {
    const POINTS: usize = 1 << 19;
    // The Kronecker sequence of the root of g⁴ = g + 1, which is badly approximable in three dimensions.
    const G: f64 = 1.220_744_084_605_759_5;
    let tests: [fn(DVec3) -> f64; 4] = [|_| 1.0, |w| w.z, |w| w.x, |w| w.y * w.y + 0.3 * w.x * w.y];
    let mut means = [0.0; 4];
    for i in 0..POINTS {
        let at = |step: f64| (0.5 + i as f64 * step).fract();
        let u = Uniforms::new(at(1.0 / G), at(1.0 / (G * G)), at(1.0 / (G * G * G)));
        if let Some(s) = model.sample(wo, u) {
            for (mean, g) in means.iter_mut().zip(tests) {
                *mean += g(s.wi) / POINTS as f64;
            }
        }
    }
    for (k, (mean, g)) in means.iter().zip(tests).enumerate() {
        let exact = hemisphere(wo, 0.1 * tol, |wi| g(wi) * model.pdf(wo, wi));
        assert!((mean - exact).abs() <= tol, "{model:?}, wo {wo}: moment {k} is {mean} sampled, {exact} claimed");
    }
}

/// Asserts on edge directions and edge uniforms that nothing is NaN, infinite or negative, and that every draw has
/// weight = f cos / density and density = pdf to 1e-12.
pub(super) fn total_and_consistent(model: &dyn Bsdf) {
    let top = 1.0 - f64::EPSILON / 2.0;
    let mut directions = vec![DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(1.0, 0.0, 5e-324)];
    for mu in [1e-300, 1e-12, 1e-8, 1e-4, 0.1, 0.5, 0.9999999, -0.3] {
        for phi in [0.0, 0.3, FRAC_PI_2, PI, 4.0] {
            directions.push(direction_mu(mu, phi));
        }
    }
    for &wo in &directions {
        for &wi in &directions {
            let (f, pdf) = (model.eval(wo, wi), model.pdf(wo, wi));
            assert!(f.is_finite() && f.min_channel() >= 0.0, "{model:?}: f = {f} at {wo} {wi}");
            assert!(pdf.is_finite() && pdf >= 0.0, "{model:?}: pdf = {pdf} at {wo} {wi}");
            assert!((wo.z > 0.0 && wi.z > 0.0) || (f.is_black() && pdf == 0.0), "{model:?}: not one-sided");
        }
        for lobe in [0.0, 0.2, 0.4, 0.6, 0.8, 0.99, top] {
            for x in [0.0, 1e-300, 0.3, 0.7, top] {
                for y in [0.0, 1e-300, 0.25, 0.9, top] {
                    let Some(s) = model.sample(wo, Uniforms::new(lobe, x, y)) else { continue };
                    let Density::SolidAngle(density) = s.density else { panic!("no Dirac lobes here") };
                    assert!(s.wi.is_finite() && s.wi.z > 0.0 && wo.z > 0.0 && density > 0.0, "{model:?}: {s:?}");
                    assert!((s.wi.length() - 1.0).abs() < 1e-12);
                    let (f, pdf) = (model.eval(wo, s.wi), model.pdf(wo, s.wi));
                    assert!((density - pdf).abs() <= 1e-12 * pdf, "{model:?}: {density} {pdf}");
                    let error = s.weight - f * (s.wi.z / pdf);
                    assert!(error.map(f64::abs).max_channel() <= 1e-12 * s.weight.max_channel(), "{model:?}: {s:?}");
                    assert!(s.weight.is_finite() && s.weight.min_channel() >= 0.0, "{model:?}: {s:?}");
                }
            }
        }
    }
}
