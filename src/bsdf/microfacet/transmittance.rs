//! How much of the light a rough interface reflects and lets through, R(μ) and T(μ), from outside and from inside.
//!
//! R(μ) = ∫ F w D(m) (wo·m) dm,  T(μ) = ∫ (1 − F) w D(m) (wo·m) dm,  w = G2 |wi.z| / |wo.z wi.z|
//!
//! over the normals that `wo` sees, by adaptive cubature. R + T is below 1 by what facets lose to each other. T is kept
//! as a Chebyshev interpolant in √μ, which crowds its nodes where T turns, at grazing.
//! # References
//! - Walter et al. 2007, EGSR (the interface); Trefethen 2013, Approximation Theory and Practice, ch. 2 (interpolants)

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::{Normals, RoughDielectric};
use crate::math::chart::Chart;
use crate::math::cubature::Mesh;
use crate::math::quadrature::adaptive;

/// Nodes of the interpolant: errors are below 1e-4 for every slope width, and below 1e-6 for those of 0.1 and more.
const NODES: usize = 32;
/// Tolerance of each node.
const TOL: f64 = 1e-6;
/// Evaluations allowed for each node.
const MAX_EVALS: u64 = 60_000;

/// T(μ) of one interface from outside.
#[derive(Clone, Debug)]
pub(super) struct Transmittance {
    /// Chebyshev coefficients in x = 2√μ − 1.
    coefficients: [f64; NODES],
}

impl Transmittance {
    /// Tabulates an interface that is the same in all azimuths.
    pub(super) fn new<N: Normals>(interface: &RoughDielectric<N>) -> Self {
        let angle = |i: usize| PI * (i as f64 + 0.5) / NODES as f64;
        let at = |i: usize| {
            let root = 0.5 * (1.0 + angle(i).cos());
            let [_, transmitted] = shares(interface, interface.index(), root * root);
            transmitted
        };
        let values: Vec<f64> = (0..NODES).into_par_iter().map(at).collect();
        let coefficient = |k: usize| {
            let sum: f64 = values.iter().enumerate().map(|(i, v)| v * (k as f64 * angle(i)).cos()).sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / NODES as f64
        };
        Self { coefficients: std::array::from_fn(coefficient) }
    }

    /// T(μ) in [0, 1], μ in [0, 1].
    pub(super) fn at(&self, mu: f64) -> f64 {
        let x = 2.0 * mu.sqrt() - 1.0;
        // Clenshaw's recurrence.
        let (mut b1, mut b2) = (0.0, 0.0);
        for &c in self.coefficients[1..].iter().rev() {
            (b1, b2) = (2.0 * x * b1 - b2 + c, b1);
        }
        (self.coefficients[0] + x * b1 - b2).clamp(0.0, 1.0)
    }
}

/// Ri = 2 ∫ R(μ; 1/η) μ dμ: the average of what the interface reflects from inside, to about 1e-5.
pub(super) fn internal_reflectance<N: Normals>(interface: &RoughDielectric<N>) -> f64 {
    let eta = 1.0 / interface.index();
    let integrand = |root: f64| {
        let mu = root * root;
        let [reflected, _] = shares(interface, eta, mu);
        [4.0 * root * mu * reflected]
    };
    // The critical angle, where a smooth interface has a kink.
    let critical = if eta < 1.0 { ((1.0 - eta) * (1.0 + eta)).sqrt().sqrt() } else { 0.5 };
    adaptive(integrand, &[0.0, critical, 1.0], 1e-5, 8).value[0]
}

/// The same as Mitsuba 3 computes it: 2 Σ R(μ) μ / 64 over 64 cosines evenly spaced from 0 to 1, both included, which is
/// about 1/64 too small.
pub(super) fn internal_reflectance_by_sum<N: Normals>(interface: &RoughDielectric<N>) -> f64 {
    const COUNT: u32 = 64;
    let term = |i: u32| {
        let mu = f64::from(i) / f64::from(COUNT - 1);
        let [reflected, _] = shares(interface, 1.0 / interface.index(), mu);
        2.0 * reflected * mu / f64::from(COUNT)
    };
    let terms: Vec<f64> = (0..COUNT).into_par_iter().map(term).collect();
    terms.iter().sum()
}

/// \[R(μ), T(μ)\] for the index `eta` of the far side over the near one.
fn shares<N: Normals>(interface: &RoughDielectric<N>, eta: f64, mu: f64) -> [f64; 2] {
    let mu = mu.max(1e-12);
    let wo = DVec3::new(((1.0 - mu) * (1.0 + mu)).sqrt(), 0.0, mu);
    let f = |m: DVec3| interface.shares_of(wo, m, eta);
    let mut mesh = Mesh::new(Chart::visible_normals(wo), &f);
    mesh.refine(TOL, MAX_EVALS);
    mesh.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Fresnel, GgxNormals, Masking};

    fn ggx(alpha: f64, eta: f64) -> RoughDielectric<GgxNormals> {
        let interface = RoughDielectric::from_normals(GgxNormals::new(alpha, alpha).unwrap(), eta).unwrap();
        interface.with_masking(Masking::Separable)
    }

    #[test]
    fn the_interpolant_holds_between_its_nodes() {
        // At α = 1 directions refracted to the horizon cut cubature's cells aslant.
        for (alpha, tol) in [(1e-4, 1e-4), (0.01, 1e-4), (0.1, 1e-5), (0.3, 2e-6), (1.0, 2e-5)] {
            let interface = ggx(alpha, 1.5);
            let table = Transmittance::new(&interface);
            for i in 0..30 {
                let root = (f64::from(i) + 0.37) / 30.0;
                let [_, exact] = shares(&interface, 1.5, root * root);
                let gap = (table.at(root * root) - exact).abs();
                assert!(gap <= tol, "α {alpha} μ {}: {exact}, off by {gap:e}", root * root);
            }
        }
    }

    #[test]
    fn the_average_from_inside_tends_to_fresnels_and_is_a_published_one() {
        for eta in [1.5, 0.8] {
            let exact = Fresnel::Dielectric { eta: 1.0 / eta }.average().0.x;
            let gap = internal_reflectance(&ggx(1e-4, eta)) - exact;
            // Slopes of 1e-4 lose that much.
            assert!(gap.abs() < 3e-4, "{eta}: {gap}");
        }
        // Mitsuba 3.9.1, recovered from f of its linear and nonlinear `roughplastic`, in single precision.
        for (alpha, published) in [(0.1, 0.551_89), (0.3, 0.414_86), (0.6, 0.240_84)] {
            let (ours, sum) = (internal_reflectance(&ggx(alpha, 1.5)), internal_reflectance_by_sum(&ggx(alpha, 1.5)));
            assert!((sum - published).abs() < 3e-4, "{alpha}: {sum} against {published}");
            assert!((sum / ours - 63.0 / 64.0).abs() < 3e-3, "{alpha}: {sum} against {ours}");
        }
    }
}
