//! Per-sample variances of the usual estimators, in closed form, against ∫ (f L cos)² / p dω − (∫ f L cos dω)² by quadrature
//! with the crate's own densities, and against its samplers.

use std::f64::consts::FRAC_1_PI;

use whitefurnace::bsdf::{Bsdf, Lambert, Phong, PhongNorm};
use whitefurnace::glam::DVec3;
use whitefurnace::integrate::{Hemisphere, Side};
use whitefurnace::math::sum::Moments;
use whitefurnace::prelude::Ggx;
use whitefurnace::sampling::stream::{stream, uniform, uniforms};
use whitefurnace::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

/// Seen along the normal.
const WO: DVec3 = DVec3::Z;

/// Variance of f(WO, w) L(w) cos / p(w) for w drawn with density `p`.
fn variance(bsdf: &dyn Bsdf, light: impl Fn(DVec3) -> f64, p: impl Fn(DVec3) -> f64) -> f64 {
    let value = |w: DVec3| bsdf.eval(WO, w).0.x * light(w) * w.z;
    let moments = Hemisphere::with_tol(1e-9).integrate(WO, &[], &|w: DVec3| {
        let density = p(w);
        [value(w), if density > 0.0 { value(w).powi(2) / density } else { 0.0 }]
    });
    assert!(moments.resolved, "{moments:?}");
    let [first, second] = moments.value;
    second - first * first
}

fn close(value: f64, exact: f64) {
    assert!((value - exact).abs() <= 1e-8 * exact.max(1.0), "{value} against {exact}");
}

#[test]
fn lambert_under_constant_and_cosine_light() {
    let rho = 0.7_f64;
    let lambert = Lambert::new(rho).unwrap();
    let uniform_hemisphere = |_: DVec3| 0.5 * FRAC_1_PI;
    let uniform_sphere = |_: DVec3| 0.25 * FRAC_1_PI;
    let constant = |_: DVec3| 1.0;
    let cosine = |w: DVec3| w.z;
    close(variance(&lambert, constant, uniform_hemisphere), rho * rho / 3.0);
    close(variance(&lambert, constant, cosine_hemisphere_pdf), 0.0);
    close(variance(&lambert, constant, uniform_sphere), 5.0 * rho * rho / 3.0);
    close(variance(&lambert, cosine, uniform_hemisphere), 16.0 * rho * rho / 45.0);
    close(variance(&lambert, cosine, cosine_hemisphere_pdf), rho * rho / 18.0);
}

#[test]
fn phong_by_uniform_cosine_and_lobe_sampling() {
    for n in [1.0, 10.0, 100.0] {
        let phong = Phong::new(n, 0.0, 1.0, PhongNorm::AlbedoNPlus2).unwrap();
        let constant = |_: DVec3| 1.0;
        close(variance(&phong, constant, |_| 0.5 * FRAC_1_PI), (n + 1.0).powi(2) / (2.0 * n + 3.0));
        close(variance(&phong, constant, cosine_hemisphere_pdf), n * n / (4.0 * (n + 1.0)));
        close(variance(&phong, constant, |w| phong.pdf(WO, w)), 1.0 / ((n + 1.0) * (n + 3.0)));
    }
}

#[test]
fn the_defensive_mixture_costs_what_the_table_says() {
    for (n, exact) in [(1.0, 0.125), (10.0, 0.451_878), (100.0, 0.852_230), (1000.0, 0.975_390)] {
        let phong = Phong::new(n, 0.0, 1.0, PhongNorm::AlbedoNPlus2).unwrap();
        let mixture = |w: DVec3| 0.5 * cosine_hemisphere_pdf(w) + 0.5 * phong.pdf(WO, w);
        let value = variance(&phong, |_| 1.0, mixture);
        // Six decimals are given.
        assert!((value - exact).abs() <= 6e-7, "n = {n}: {value} against {exact}");
    }
}

#[test]
fn phong_under_a_cone_of_light() {
    // (n+2)/2π lobe along the normal, light within 10 degrees: 1 − cos^{n+2}.
    let (n, cone) = (10.0, 10_f64.to_radians());
    let phong = Phong::new(n, 0.0, 1.0, PhongNorm::AlbedoNPlus2).unwrap();
    let lit = |w: DVec3| [if w.z > cone.cos() { phong.eval(WO, w).0.x * w.z } else { 0.0 }];
    let value = Hemisphere::with_tol(1e-7).integrate(WO, &[], &lit);
    assert!(value.resolved && (value.value[0] - 0.167_819_552).abs() <= 1e-7, "{value:?}");
}

#[test]
fn weights_drawn_by_the_samplers_have_these_variances() {
    let n = 100_000;
    let mut rng = stream(5, 0, 0);
    let (mut cosine_light, mut visible) = (Moments::default(), Moments::default());
    let lambert = Lambert::new(1.0).unwrap();
    let ggx = Ggx::new(0.5).unwrap();
    for _ in 0..n {
        let u = uniforms(&mut rng);
        let w = cosine_hemisphere(u.dir);
        cosine_light.add(lambert.eval(WO, w).0.x * w.z * w.z / cosine_hemisphere_pdf(w));
        visible.add(ggx.sample(WO, u).map_or(0.0, |s| s.weight.0.x));
    }
    // The standard error of a sample variance is about sqrt((κ + 2)/n) of it; 5 of those.
    let bar = |m: &Moments| 5.0 * ((m.excess_kurtosis() + 2.0) / f64::from(n)).sqrt();
    assert!((cosine_light.variance() * 18.0 - 1.0).abs() <= bar(&cosine_light));
    let albedo = Hemisphere::default().albedo(&ggx, Side::Eye, WO).value.0.x;
    // Weights in [0, 1] with mean E vary by E (1 − E) at the most.
    assert!(visible.max() <= 1.0 + 1e-12 && visible.variance() <= albedo * (1.0 - albedo) * (1.0 + bar(&visible)));
}

/// A closed furnace: every bounce adds 1 and survives with probability q, its weight multiplied by ρ/q.
fn roulette(rho: f64, q: f64, paths: u32) -> Moments {
    let mut rng = stream(6, 0, 0);
    let mut moments = Moments::default();
    for _ in 0..paths {
        let (mut sum, mut weight) = (1.0, 1.0);
        while uniform(&mut rng) < q {
            weight *= rho / q;
            sum += weight;
        }
        moments.add(sum);
    }
    moments
}

#[test]
fn roulette_in_a_furnace_has_its_closed_form_variance() {
    // q = ρ: var ρ/(1 − ρ)², 2 at ρ = 1/2.
    let even = roulette(0.5, 0.5, 200_000);
    let bar = |m: &Moments| 5.0 * ((m.excess_kurtosis() + 2.0) / m.count() as f64).sqrt();
    assert!((even.variance() / 2.0 - 1.0).abs() <= bar(&even), "{}", even.variance());
    // General q with q > ρ²: E[X²] = 1/(1−a) + 2/(w−1) [a/(1−a) − ρ/(1−ρ)], a = ρ²/q, w = ρ/q.
    let (rho, q) = (0.5_f64, 0.4_f64);
    let (a, w) = (rho * rho / q, rho / q);
    let second = 1.0 / (1.0 - a) + 2.0 / (w - 1.0) * (a / (1.0 - a) - rho / (1.0 - rho));
    let exact = second - (1.0 / (1.0 - rho)).powi(2);
    let uneven = roulette(rho, q, 400_000);
    assert!((uneven.variance() / exact - 1.0).abs() <= bar(&uneven), "{} {exact}", uneven.variance());
    assert!((uneven.mean() - 2.0).abs() <= 5.0 * uneven.std_err());
}
