//! The energy that one bounce between perfectly reflecting facets loses, L(μ) = 1 − E(μ), and its sampling.
//!
//! E(μ) = ∫ D G2 / (4 μ wi.z) wi.z dwi is the directional albedo for F = 1 of isotropic facets. With e the elevation
//! of `wi` and ψ its azimuth from the mirror plane,
//!
//! E(μ) = ∫ V(μ, sin e) sin e cos e ∫ D dψ de,  V = G2 / (4 μ sin e)
//!
//! where V has left the inner integral, and the slope of the half vector is √(Δ² + 4 sₒ sᵢ sin²(ψ/2)) / (μ + sin e) with
//! Δ = cos e − cos eₒ: each integral has one known centre and scale, and a few panels that grow geometrically from there
//! give it to about 1e-10 (tested), whatever the slope width.
//!
//! The table holds Chebyshev interpolants of L over panels of t = ln((μ + μ₀) / (1 + ν − μ)) + const., with μ₀ far below the
//! slope width: L goes like μ ln μ at grazing, and for Gaussian slopes like exp(−1/tan²) at the normal. It is *not* monotone. Its average L_avg = 2 ∫ L μ dμ is that of the interpolant, so that Kulla and
//! Conty's lobe L(μₒ) L(μᵢ) / (π L_avg) returns exactly what the table says is lost. It is sampled by its own exact
//! density L(μᵢ) μᵢ / (π L_avg): the weight is L(μₒ), without variance.
//! # References
//! - Kulla & Conty 2017, SIGGRAPH course (the lobe); Trefethen 2013, Approximation Theory and Practice, ch. 8 (rate)

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use std::fmt;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Masking, Microfacet, Normals};
use crate::math::quadrature::PAIR;
use crate::math::special::sin_cos_turns;

/// Coefficients per panel, at most `PANEL` wide in t: singularities are about π/2 away, so that the error is below 1e-8.
const DEGREE: usize = 12;
const PANEL: f64 = 0.9;
/// Cells per panel of the sampler.
const CELLS: usize = 8;
/// μ₀ over the slope width: below it L changes by less than 1e-6 in all, and smoothly but for the last 1e-8.
const GRAZING: f64 = 1e-8;
/// ν, the scale on which L is resolved at the normal.
const NORMAL: f64 = 0.1;

/// L(μ) of one distribution and masking, tabulated.
pub(super) struct LossTable {
    mu_0: f64,
    /// ln(μ₀ / (1 + ν)), where μ = 0 and t = 0.
    start: f64,
    /// Panels per unit of t.
    density: f64,
    panels: Vec<[f64; DEGREE]>,
    /// 2 ∫ L μ dμ from 0 to the end of each cell of the sampler.
    cumulative: Vec<f64>,
}

impl fmt::Debug for LossTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LossTable").field("average", &self.average()).finish_non_exhaustive()
    }
}

impl LossTable {
    /// Tabulates `normals`, which must be isotropic.
    pub(super) fn new<N: Normals>(normals: &N, masking: Masking) -> Self {
        let mu_0 = GRAZING * normals.slope_widths().x;
        let start = (mu_0 / (1.0 + NORMAL)).ln();
        let end = ((1.0 + mu_0) / NORMAL).ln() - start;
        let count = (end / PANEL).ceil();
        let mut table = Self { mu_0, start, density: count / end, panels: Vec::new(), cumulative: Vec::new() };
        let panel = |index: usize| {
            let losses: [f64; DEGREE] = std::array::from_fn(|i| {
                let x = (PI * (i as f64 + 0.5) / DEGREE as f64).cos();
                let mu = table.mu((index as f64 + 0.5 + 0.5 * x) / table.density).clamp(f64::MIN_POSITIVE, 1.0);
                1.0 - directional_albedo(normals, masking, mu)
            });
            chebyshev(&losses)
        };
        table.panels = (0..count as usize).into_par_iter().map(panel).collect();
        let mut sum = 0.0;
        for cell in 0..table.panels.len() * CELLS {
            sum += table.flux(table.cell_edge(cell), table.cell_edge(cell + 1));
            table.cumulative.push(sum);
        }
        table
    }

    fn mu(&self, t: f64) -> f64 {
        let e = (t + self.start).exp();
        ((1.0 + NORMAL) * e - self.mu_0) / (1.0 + e)
    }

    fn t(&self, mu: f64) -> f64 {
        ((mu + self.mu_0) / (1.0 + NORMAL - mu)).ln() - self.start
    }

    /// dμ / dt
    fn stretch(&self, mu: f64) -> f64 {
        (mu + self.mu_0) * (1.0 + NORMAL - mu) / (1.0 + NORMAL + self.mu_0)
    }

    fn cell_edge(&self, cell: usize) -> f64 {
        cell as f64 / (CELLS as f64 * self.density)
    }

    fn loss_at(&self, t: f64) -> f64 {
        let position = (t * self.density).max(0.0);
        let panel = (position as usize).min(self.panels.len() - 1);
        let x = 2.0 * (position - panel as f64) - 1.0;
        // Clenshaw's recurrence. Rounding leaves ±1e-16 where nothing is lost.
        let (mut b1, mut b2) = (0.0, 0.0);
        for &c in self.panels[panel][1..].iter().rev() {
            (b1, b2) = (2.0 * x * b1 - b2 + c, b1);
        }
        (self.panels[panel][0] + x * b1 - b2).clamp(0.0, 1.0)
    }

    /// L(μ) in [0, 1], for μ in (0, 1].
    pub(super) fn loss(&self, mu: f64) -> f64 {
        self.loss_at(self.t(mu.min(1.0)))
    }

    /// L_avg = 2 ∫ L(μ) μ dμ over [0, 1], exactly that of the table.
    pub(super) fn average(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// 2 ∫ L μ dμ between two values of t within one cell.
    fn flux(&self, from: f64, to: f64) -> f64 {
        let width = to - from;
        let term = |t: f64| 2.0 * self.loss_at(t) * self.mu(t) * self.stretch(self.mu(t));
        width * PAIR.iter().map(|node| node.kronrod * term(from + width * node.x)).sum::<f64>()
    }

    /// Density [1/sr] of [`sample`](Self::sample) at a direction with z = `mu`, where the loss is `loss`.
    pub(super) fn pdf(&self, mu: f64, loss: f64) -> f64 {
        let average = self.average();
        if average > 0.0 { loss * mu * FRAC_1_PI / average } else { 0.0 }
    }

    /// Draws a direction with density L(μ) μ / (π L_avg).
    pub(super) fn sample(&self, u: DVec2) -> DVec3 {
        let target = u.x * self.average();
        let cell = self.cumulative.partition_point(|&sum| sum <= target).min(self.cumulative.len() - 1);
        let before = if cell == 0 { 0.0 } else { self.cumulative[cell - 1] };
        let (from, to) = (self.cell_edge(cell), self.cell_edge(cell + 1));
        let within = self.cumulative[cell] - before;
        // L is nearly constant in a cell, so flux goes like μ²; Newton's steps then square the error of 1e-2 thrice.
        let share = if within > 0.0 { ((target - before) / within).clamp(0.0, 1.0) } else { 0.5 };
        let (mu_from, mu_to) = (self.mu(from), self.mu(to));
        let mut t = self.t((mu_from * mu_from + share * (mu_to * mu_to - mu_from * mu_from)).sqrt()).clamp(from, to);
        for _ in 0..3 {
            let slope = 2.0 * self.loss_at(t) * self.mu(t) * self.stretch(self.mu(t));
            if slope > 0.0 {
                t = (t - (self.flux(from, t) - share * within) / slope).clamp(from, to);
            }
        }
        let mu = self.mu(t).clamp(0.0, 1.0);
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        let r = ((1.0 - mu) * (1.0 + mu)).sqrt();
        DVec3::new(r * cos_phi, r * sin_phi, mu)
    }
}

/// The Chebyshev coefficients of the polynomial through `values` at cos(π (i + 1/2) / DEGREE).
fn chebyshev(values: &[f64; DEGREE]) -> [f64; DEGREE] {
    let n = DEGREE as f64;
    std::array::from_fn(|k| {
        let terms = values.iter().enumerate().map(|(i, v)| v * (PI * k as f64 * (i as f64 + 0.5) / n).cos());
        terms.sum::<f64>() * if k == 0 { 1.0 / n } else { 2.0 / n }
    })
}

/// E(μ) for F = 1 of isotropic normals, μ in (0, 1].
pub(super) fn directional_albedo<N: Normals>(normals: &N, masking: Masking, mu: f64) -> f64 {
    let alpha = normals.slope_widths().x;
    let sin_o = ((1.0 - mu) * (1.0 + mu)).sqrt();
    // Elevations, not polar angles: they have all their digits next to the horizon.
    let elevation = mu.atan2(sin_o);
    let wo = DVec3::new(sin_o, 0.0, mu);
    let area_o = normals.projected_area(wo);
    let mut breaks = vec![0.0, elevation, FRAC_PI_2];
    // The lobe is 2α wide in angle, masking changes on the scale of α above the horizon, or of μ itself.
    for width in geometric(2.0 * alpha) {
        breaks.extend([elevation - width, elevation + width]);
    }
    breaks.extend(geometric(alpha.min(mu)));
    breaks.retain(|e| (0.0..=FRAC_PI_2).contains(e));
    breaks.sort_by(f64::total_cmp);
    let outer = |e: f64| {
        let (z, sin_i) = e.sin_cos();
        let wi = DVec3::new(sin_i, 0.0, z);
        let (middle, half) = (0.5 * (e + elevation), 0.5 * (e - elevation));
        let offset = 2.0 * middle.sin() * half.sin();
        let v = Microfacet::<N>::visibility(masking, area_o, normals.projected_area(wi), wo, wi);
        v * z * sin_i * ring(normals, alpha, offset, sin_o * sin_i, mu + z)
    };
    integrate(&breaks, outer)
}

/// ∫ D(h) dψ over the full turn, with h = (√(offset² + 4 s sin²(ψ/2)), height) and s = `sines`.
fn ring<N: Normals>(normals: &N, alpha: f64, offset: f64, sines: f64, height: f64) -> f64 {
    /// D falls with ψ, and each panel holds a small share of the one before: what follows this share is not seen.
    const NEGLIGIBLE: f64 = 1e-13;
    let scale = offset.hypot(alpha * height) / sines.sqrt();
    let d = |psi: f64| {
        let s = (0.5 * psi).sin();
        normals.d(DVec3::new((offset * offset + 4.0 * sines * s * s).sqrt(), 0.0, height))
    };
    let (mut sum, mut from) = (0.0, 0.0);
    for to in geometric(scale).chain([PI]) {
        let to = to.min(PI);
        let panel = integrate(&[from, to], d);
        sum += panel;
        if panel <= NEGLIGIBLE * sum || to >= PI {
            break;
        }
        from = to;
    }
    2.0 * sum
}

/// Panel ends 1.5, 6, 24, … times `scale`, to beyond π: so far from a singularity at ±i `scale` that 15 nodes suffice.
fn geometric(scale: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(1.5 * scale), |width| Some(4.0 * width)).take_while(|&width| width < 4.0)
}

/// ∫ f by the 15-point rule on each panel.
fn integrate(breaks: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let panel = |w: &[f64]| (w[1] - w[0]) * PAIR.iter().map(|n| n.kronrod * f(w[0] + (w[1] - w[0]) * n.x)).sum::<f64>();
    breaks.windows(2).map(panel).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{BeckmannNormals, BlinnNormals, Bsdf, GgxNormals};
    use crate::math::chart::Chart;
    use crate::math::cubature::Mesh;
    use crate::math::quadrature::adaptive;
    use crate::math::sphere::direction_mu;
    use std::f64::consts::{LN_2, TAU};

    fn ggx(alpha: f64) -> GgxNormals {
        GgxNormals::new(alpha, alpha).unwrap()
    }

    fn beckmann(alpha: f64) -> BeckmannNormals {
        BeckmannNormals::new(alpha, alpha).unwrap()
    }

    /// Albedos and their averages by quadratures of others; nine digits are given.
    #[test]
    fn published_albedos() {
        use Masking::{Correlated, Separable};
        for (alpha, mu, correlated, separable, gauss, gauss_separable) in [
            (0.1, 0.1, 0.883455002, 0.872756084, 0.912911380, 0.912327536),
            (0.1, 1.0, 0.988304057, 0.988304057, 1.0, 1.0),
            (0.5, 0.1, 0.860105073, 0.772276065, 0.955027694, 0.936092195),
            (0.5, 0.5, 0.698250697, 0.686007250, 0.869360254, 0.868942654),
            (0.5, 1.0, 0.687848515, 0.687848515, 0.942998375, 0.942998375),
            (1.0, 0.1, 0.760210473, 0.557914217, 0.952795040, 0.901934304),
            (1.0, 0.5, 0.450693856, 0.409137093, 0.766567767, 0.756297963),
            (1.0, 1.0, 0.306852819, 0.306852819, 0.461588091, 0.461588091),
        ] {
            for (value, expected) in [
                (directional_albedo(&ggx(alpha), Correlated, mu), correlated),
                (directional_albedo(&ggx(alpha), Separable, mu), separable),
                (directional_albedo(&beckmann(alpha), Correlated, mu), gauss),
                (directional_albedo(&beckmann(alpha), Separable, mu), gauss_separable),
            ] {
                assert!((value - expected).abs() < 1.1e-9, "α {alpha} μ {mu}: {value} {expected}");
            }
        }
        for (alpha, mu, expected) in [
            (0.001, 0.01, 0.994182085),
            (0.001, 0.1, 0.999948733),
            (0.001, 0.5, 0.999997493),
            (0.001, 1.0, 0.999998999),
            (0.01, 0.01, 0.891987352),
            (0.01, 0.1, 0.994123953),
            (0.01, 0.5, 0.999742123),
            (0.01, 1.0, 0.999898556),
        ] {
            let value = directional_albedo(&ggx(alpha), Correlated, mu);
            assert!((value - expected).abs() < 1.1e-9, "α {alpha} μ {mu}: {value} {expected}");
        }
    }

    #[test]
    fn averages_of_the_table() {
        // Eight digits are given; at α = 1 the closed forms.
        for (alpha, correlated, separable) in [
            (0.1, 0.97204576, 0.97155948),
            (0.25, 0.88232338, 0.87945567),
            (0.5, 0.70024047, 0.68940271),
            (1.0, 4.0 / 3.0 * (1.0 - LN_2), 4.0 * (1.0 - LN_2).powi(2)),
        ] {
            for (masking, expected) in [(Masking::Correlated, correlated), (Masking::Separable, separable)] {
                let average = 1.0 - LossTable::new(&ggx(alpha), masking).average();
                assert!((average - expected).abs() < 1e-8, "α {alpha} {masking:?}: {average} {expected}");
            }
        }
    }

    #[test]
    fn alpha_one_is_elementary_down_to_the_horizon() {
        let table = LossTable::new(&ggx(1.0), Masking::Correlated);
        for i in 0..3000 {
            let mu = (-30.0 * f64::from(i) / 3000.0).exp();
            let exact = mu * (1.0 / mu).ln_1p();
            assert!((table.loss(mu) - exact).abs() < 1e-8, "μ {mu}: {} {exact}", table.loss(mu));
            let direct = 1.0 - directional_albedo(&ggx(1.0), Masking::Correlated, mu);
            assert!((direct - exact).abs() < 1e-11, "μ {mu}: {direct} {exact}");
        }
    }

    #[test]
    fn normal_incidence_is_a_one_dimensional_integral() {
        // 4α² ∫ μ dμ / [((1+α²) − (1−α²) μ)² (μ + √(α² + (1−α²) μ²))], in e = ln(1 − μ + α²) for the peak at μ = 1.
        for alpha in [1e-4, 1e-3, 0.02, 0.3, 0.9] {
            let a2: f64 = alpha * alpha;
            let (from, to) = (a2.ln(), (1.0 + a2).ln());
            let integrand = |e: f64| {
                let v = e.exp() - a2;
                let mu = 1.0 - v;
                let q = 2.0 * a2 + (1.0 - a2) * v;
                [4.0 * a2 * mu * (v + a2) / (q * q * (mu + (a2 + (1.0 - a2) * mu * mu).sqrt()))]
            };
            let breaks: Vec<f64> = (0..=40).map(|i| from + (to - from) * f64::from(i) / 40.0).collect();
            let exact = adaptive(integrand, &breaks, 1e-13, 1000).value[0];
            let value = directional_albedo(&ggx(alpha), Masking::Correlated, 1.0);
            assert!((value - exact).abs() < 1e-11, "α {alpha}: {value} {exact}");
        }
    }

    fn check_table<N: Normals + Copy>(normals: N, masking: Masking) {
        let start = std::time::Instant::now();
        let table = LossTable::new(&normals, masking);
        let seconds = start.elapsed().as_secs_f64();
        assert!(seconds < 1.0, "{normals:?} took {seconds} s");
        let bsdf = Microfacet::from_normals(normals).with_masking(masking);
        // Off-node points, from the normal to far below the slope width.
        for i in 0..60 {
            let mu = (-30.0 * (f64::from(i) + 0.37) / 60.0).exp();
            let direct = 1.0 - directional_albedo(&normals, masking, mu);
            let error = (table.loss(mu) - direct).abs();
            assert!(error < 1e-7, "{normals:?} {masking:?} μ {mu}: {} against {direct}", table.loss(mu));
        }
        // An independent route: adaptive cubature of the model itself, with its own error bound.
        for mu in [1e-5, 1e-3, 0.1, 0.6, 0.98] {
            let wo = direction_mu(mu, 0.4);
            let f = |wi: DVec3| [bsdf.eval(wo, wi).0.x * wi.z];
            let mut mesh = Mesh::new(Chart::half(wo), &f);
            mesh.refine(1e-8, 1 << 20);
            let error = (1.0 - table.loss(mu) - mesh.value()[0]).abs();
            assert!(error < 1e-6 && mesh.error() < 1e-6, "{normals:?} {masking:?} μ {mu}: {error} ± {}", mesh.error());
        }
    }

    #[test]
    fn tables_hold_for_every_alpha() {
        for alpha in [1e-4, 3e-4, 3e-3, 0.05, 0.4, 1.0] {
            check_table(ggx(alpha), Masking::Correlated);
            check_table(ggx(alpha), Masking::Separable);
            check_table(beckmann(alpha), Masking::Correlated);
        }
        for n in [1e-3, 1.0, 30.0, 1e4, 1e6] {
            check_table(BlinnNormals::new(n).unwrap(), Masking::Correlated);
        }
    }

    #[test]
    fn samples_follow_the_density() {
        for table in
            [LossTable::new(&ggx(0.5), Masking::Correlated), LossTable::new(&beckmann(1e-3), Masking::Correlated)]
        {
            for i in 0..1000 {
                let u = (f64::from(i) + 0.5) / 1000.0;
                let mu = table.sample(DVec2::new(u, 0.25)).z;
                // The share of the density below μ, by its own quadrature in ln μ.
                let breaks: Vec<f64> = (0..=60).map(|k| mu.ln() - 30.0 + 0.5 * f64::from(k)).collect();
                let below = integrate(&breaks, |x| TAU * table.pdf(x.exp(), table.loss(x.exp())) * x.exp());
                assert!((below - u).abs() < 1e-6, "{u}: {below} at μ = {mu}");
            }
            assert!(table.sample(DVec2::ZERO).is_finite() && table.sample(DVec2::splat(1.0 - 1e-16)).is_finite());
        }
    }
}
