//! The contract of eval, pdf, sample and albedo, as assertions for the unit tests of the models.

use glam::DVec3;

use super::{Bsdf, Density, Lobes, Uniforms};
use crate::integrate::{Hemisphere, Side};
use crate::math::chart::Chart;
use crate::math::cubature::Mesh;
use crate::math::sphere::{direction, direction_mu, mirror};
use crate::sampling::stream::{stream, uniforms};

/// The next number below 1.
const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

/// Directions at which models go wrong: the normal, next to it, the horizon, below.
fn edges() -> Vec<DVec3> {
    let mut edges = vec![DVec3::Z, DVec3::X, DVec3::NEG_Z, direction_mu(-1e-8, 1.0), direction(2.0, 0.3)];
    edges.extend([1e-300, 1e-8, 1e-4, 0.1, 0.5].map(|mu| direction_mu(mu, 0.7)));
    edges.extend([1e-8, 1e-3, 0.6].map(|theta| direction(theta, -2.0)));
    edges
}

/// eval, pdf and sample are finite, not negative, and, unless the model transmits, one-sided at every edge.
pub(super) fn assert_total(bsdf: &dyn Bsdf) {
    let sees = |w: DVec3| w.z > 0.0 || bsdf.lobes().contains(Lobes::TRANSMIT);
    for wo in edges() {
        for wi in edges().into_iter().chain([wo, mirror(wo)]) {
            let (f, pdf) = (bsdf.eval(wo, wi), bsdf.pdf(wo, wi));
            assert!(f.is_finite() && f.min_channel() >= 0.0, "{bsdf:?}: f({wo}, {wi}) = {f}");
            assert!(pdf.is_finite() && pdf >= 0.0, "{bsdf:?}: pdf({wo}, {wi}) = {pdf}");
            assert!(sees(wo) && sees(wi) || f.is_black() && pdf == 0.0, "{bsdf:?}: {wo} and {wi} see each other");
        }
        for lobe in [0.0, 0.3, LAST] {
            for (x, y) in [(0.0, 0.0), (LAST, 0.5), (0.5, LAST), (LAST, LAST), (1e-20, 0.2)] {
                if let Some(s) = bsdf.sample(wo, Uniforms::new(lobe, x, y)) {
                    assert!(sees(wo) && sees(s.wi) && s.weight.is_finite() && s.weight.min_channel() >= 0.0);
                    let (Density::SolidAngle(p) | Density::Dirac(p)) = s.density;
                    assert!(p > 0.0 && p.is_finite(), "{bsdf:?}: density {p} at {wo}");
                    assert!((s.wi.length() - 1.0).abs() <= 1e-15, "{bsdf:?}: length {}", s.wi.length());
                }
            }
        }
    }
}

/// The weight is f |cos| / pdf, the density is the pdf, and its mass is what is neither lost nor drawn from Dirac lobes.
///
/// `mus` are the cosines of `wo` at which it is tried; negative ones are below the surface.
pub(super) fn assert_sampled_exactly(bsdf: &dyn Bsdf, mus: &[f64]) {
    const DRAWS: u32 = 20_000;
    for (i, &mu) in mus.iter().enumerate() {
        let wo = direction_mu(mu, 0.4);
        let (mut rng, mut others) = (stream(3, i as u64, 0), 0);
        for _ in 0..DRAWS {
            let s = bsdf.sample(wo, uniforms(&mut rng));
            let Some(s) = s.filter(|s| matches!(s.density, Density::SolidAngle(_))) else {
                others += 1;
                continue;
            };
            let (pdf, f) = (bsdf.pdf(wo, s.wi), bsdf.eval(wo, s.wi));
            assert_eq!(s.density, Density::SolidAngle(pdf), "{bsdf:?}");
            let gap = (s.weight - f * (s.wi.z.abs() / pdf)).0.abs().max_element();
            // The contract's 1e-12; the weight is the same expression.
            assert!(gap <= 1e-12 * s.weight.max_channel(), "{bsdf:?}: weight {} off by {gap}", s.weight);
        }
        let mass = Hemisphere::with_tol(8e-6).pdf_mass(bsdf, wo);
        assert!(mass.resolved, "{bsdf:?} at μ = {mu}: {mass:?}");
        let kept = 1.0 - f64::from(others) / f64::from(DRAWS);
        // Five standard errors of a proportion, at most 5 √(¼ / N); exact where nothing is lost.
        let spread = 5.0 * (mass.value * (1.0 - mass.value).max(0.0) / f64::from(DRAWS)).sqrt();
        assert!((mass.value - kept).abs() <= spread + 2e-6, "{bsdf:?} at μ = {mu}: mass {} kept {kept}", mass.value);
    }
}

/// The closed-form albedo is what quadrature at `tol` finds, to twice that. An error bound that is too wide is not the
/// model's fault.
pub(super) fn assert_albedo(bsdf: &dyn Bsdf, mus: &[f64], tol: f64) {
    for &mu in mus {
        let wo = direction_mu(mu, 0.4);
        let closed = bsdf.albedo(wo).unwrap_or_else(|| panic!("{bsdf:?} has no albedo at μ = {mu}"));
        let quadrature = Hemisphere::with_tol(tol).albedo(bsdf, Side::Eye, wo);
        let tol = 2.0 * tol * closed.max_channel().max(1.0);
        let gap = (closed - quadrature.value).0.abs().max_element();
        assert!(gap <= tol, "{bsdf:?} at μ = {mu}: {closed} is off by {gap:e}");
    }
}

/// ∫ f(w) dw over the hemisphere to `tol`, in half-vector coordinates about `wo`; panics where `tol` is not reached.
pub(super) fn hemisphere(wo: DVec3, tol: f64, f: impl Fn(DVec3) -> f64) -> f64 {
    let integrand = |w| [f(w)];
    let mut mesh = Mesh::new(Chart::half(wo), &integrand);
    mesh.refine(tol, 4_000_000);
    assert!(mesh.error() <= tol, "unresolved at {wo}: {} ± {}", mesh.value()[0], mesh.error());
    mesh.value()[0]
}

/// The directional albedo of the first channel to `tol`.
pub(super) fn albedo(bsdf: &dyn Bsdf, wo: DVec3, tol: f64) -> f64 {
    hemisphere(wo, tol, |wi| bsdf.eval(wo, wi).0.x * wi.z)
}

/// Asserts that the sampler draws from `pdf`: for several g, ∫ g(wi) pdf dwi equals the mean of g over well-spread uniforms.
///
/// `tol` covers the discrepancy of 2¹⁹ points; the horizon is a jagged edge to them.
pub(super) fn assert_draws_follow_pdf(bsdf: &dyn Bsdf, wo: DVec3, tol: f64) {
    const POINTS: usize = 1 << 19;
    // The Kronecker sequence of the root of g⁴ = g + 1, which is badly approximable in three dimensions.
    const G: f64 = 1.220_744_084_605_759_5;
    let tests: [fn(DVec3) -> f64; 4] = [|_| 1.0, |w| w.z, |w| 1.0 + w.x, |w| w.y * w.y + 0.3 * (1.0 + w.x * w.y)];
    let mut means = [0.0; 4];
    for i in 0..POINTS {
        let at = |step: f64| (0.5 + i as f64 * step).fract();
        let u = Uniforms::new(at(1.0 / G), at(1.0 / (G * G)), at(1.0 / (G * G * G)));
        if let Some(s) = bsdf.sample(wo, u) {
            for (mean, g) in means.iter_mut().zip(tests) {
                *mean += g(s.wi) / POINTS as f64;
            }
        }
    }
    for (k, (mean, g)) in means.iter().zip(tests).enumerate() {
        let exact = hemisphere(wo, 0.1 * tol, |wi| g(wi) * bsdf.pdf(wo, wi));
        assert!((mean - exact).abs() <= tol, "{bsdf:?}, wo {wo}: moment {k} is {mean} sampled, {exact} claimed");
    }
}
