//! Microfacet normals: by the distribution D itself, and by how much of it a direction sees.
//!
//! Given the slope widths α = (αx, αy) of a distribution D of normals m, `wo` sees normals with the density
//!
//! p(m) = max(wo·m, 0) D(m) / σ(wo)      [1/sr],  σ(w) = ∫ D(m) max(w·m, 0) dm = w.z / G1(w)
//!
//! with σ the projected area of the microsurface and G1 Smith's masking function. Both distributions here are of the
//! form D(m) = P(tanθ stretched by 1/α) / (αx αy cos⁴θ): stretching space by (αx, αy, 1) makes every α into 1. None of
//! the maps is defined for `wo.z` ≤ 0; there they return some unit vector.
//! # References
//! - Heitz 2014, JCGT 3(2): understanding the masking-shadowing function (projected area, visible normals, stretching)

pub(crate) mod beckmann;
pub(crate) mod ggx;

pub use beckmann::{
    beckmann_normal, beckmann_normal_inv, beckmann_normal_pdf, beckmann_visible, beckmann_visible_inv,
    beckmann_visible_pdf,
};
pub use ggx::{
    ggx_caps, ggx_caps_inv, ggx_caps_pdf, ggx_normal, ggx_normal_inv, ggx_normal_pdf, ggx_visible, ggx_visible_inv,
    ggx_visible_pdf,
};

use glam::{DVec2, DVec3};

/// A direction in the space in which α is 1.
#[derive(Clone, Copy, Debug)]
struct Stretched {
    /// Unit length.
    v: DVec3,
    /// Sine of its polar angle.
    rise: f64,
    /// Its azimuth as (cosine, sine); +x at the pole.
    azimuth: DVec2,
}

impl Stretched {
    #[inline]
    fn new(w: DVec3, alpha: DVec2) -> Self {
        let (x, y) = (alpha.x * w.x, alpha.y * w.y);
        let r2 = x * x + y * y;
        let (r, length) = (r2.sqrt(), (r2 + w.z * w.z).sqrt());
        if r2 < f64::MIN_POSITIVE {
            return Self { v: DVec3::new(0.0, 0.0, w.z / length), rise: 0.0, azimuth: DVec2::X };
        }
        let (per_r, per_length) = (1.0 / r, 1.0 / length);
        Self { v: DVec3::new(x, y, w.z) * per_length, rise: r * per_length, azimuth: DVec2::new(x, y) * per_r }
    }
}

/// Stretched back: a normal, of any length, that corresponds to `n` of the space in which α is 1.
#[inline]
fn unstretch(n: DVec3, alpha: DVec2) -> DVec3 {
    DVec3::new(alpha.x * n.x, alpha.y * n.y, n.z)
}

/// A unit vector along `m`; the surface's normal where there is none.
fn unit(m: DVec3) -> DVec3 {
    m.normalize_or(DVec3::Z)
}

/// An azimuth as a fraction of a full turn, in [0, 1).
fn turn(y: f64, x: f64) -> f64 {
    let t = y.atan2(x) / std::f64::consts::TAU;
    if t < 0.0 { (t + 1.0).min(1.0 - f64::EPSILON / 2.0) } else { t }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::chart::Chart;
    use crate::math::cubature::Mesh;
    use crate::math::sphere::direction;
    use crate::sampling::stream::{stream, uniform};

    type Sample = fn(DVec3, DVec2, DVec2) -> DVec3;
    type Pdf = fn(DVec3, DVec2, DVec3) -> f64;
    type Inverse = fn(DVec3, DVec2, DVec3) -> DVec2;

    /// Every map as a triple; those by D alone ignore `wo`.
    const MAPS: [(&str, Sample, Pdf, Inverse); 5] = [
        ("ggx by D", |_, a, u| ggx_normal(a, u), |_, a, m| ggx_normal_pdf(a, m), |_, a, m| ggx_normal_inv(a, m)),
        ("ggx visible", ggx_visible, ggx_visible_pdf, ggx_visible_inv),
        ("ggx caps", ggx_caps, ggx_caps_pdf, ggx_caps_inv),
        (
            "beckmann by D",
            |_, a, u| beckmann_normal(a, u),
            |_, a, m| beckmann_normal_pdf(a, m),
            |_, a, m| beckmann_normal_inv(a, m),
        ),
        ("beckmann visible", beckmann_visible, beckmann_visible_pdf, beckmann_visible_inv),
    ];

    const ALPHAS: [DVec2; 5] =
        [DVec2::splat(1e-4), DVec2::splat(0.1), DVec2::ONE, DVec2::new(0.01, 0.9), DVec2::new(0.7, 0.2)];

    fn views() -> impl Iterator<Item = DVec3> {
        [0.0, 1e-9, 0.4, 1.2, 1.57, std::f64::consts::FRAC_PI_2 - 1e-8].into_iter().map(|theta| direction(theta, 0.7))
    }

    #[test]
    fn inverses_invert() {
        let mut rng = stream(11, 0, 0);
        for (name, sample, pdf, inverse) in MAPS {
            for alpha in ALPHAS {
                for wo in views() {
                    for _ in 0..200 {
                        let u = DVec2::new(uniform(&mut rng), uniform(&mut rng));
                        let m = sample(wo, alpha, u);
                        assert!((m.length() - 1.0).abs() < 4e-16 && m.z >= 0.0, "{name} {alpha} {wo}: {m}");
                        assert!(pdf(wo, alpha, m) > 0.0, "{name} {alpha} {wo} {u}: never sampled where the pdf is 0");
                        let back = inverse(wo, alpha, m);
                        let error = (back - u).abs();
                        // Azimuths are periodic, and an azimuth 1e-16 off at a radius √u of the disk moves by 1e-16/√u.
                        let error = error.min(DVec2::ONE - error);
                        // A grazing view stretched by α sees slopes of size 1/α·z: digits of u.z remain, 16 less 8.
                        assert!(error.max_element() < 2e-8, "{name} α {alpha} wo {wo}: {u} came back as {back}");
                    }
                }
            }
        }
    }

    #[test]
    fn visible_densities_integrate_to_one() {
        for (name, _, pdf, _) in MAPS {
            for alpha in ALPHAS {
                for wo in views() {
                    let f = |m| [pdf(wo, alpha, m)];
                    let by_d = name.contains("by D");
                    let chart = if by_d { Chart::about(DVec3::Z, wo) } else { Chart::visible_normals(wo) };
                    let mut mesh = Mesh::new(chart, &f);
                    mesh.refine(1e-9, 1 << 21);
                    let mass = mesh.value()[0];
                    assert!((mass - 1.0).abs() < 1e-8, "{name} {alpha} {wo}: {mass} ± {}", mesh.error());
                }
            }
        }
    }

    #[test]
    fn densities_are_the_jacobians_of_the_maps() {
        let mut rng = stream(12, 0, 0);
        for (name, sample, pdf, _) in MAPS {
            for alpha in &ALPHAS[1..] {
                for wo in views() {
                    for _ in 0..50 {
                        let mut inner = || 0.05 + 0.9 * uniform(&mut rng);
                        let u = DVec2::new(inner(), inner());
                        let h = 1e-5;
                        let along = |d: DVec2| (sample(wo, *alpha, u + d) - sample(wo, *alpha, u - d)) / (2.0 * h);
                        let area = along(DVec2::new(h, 0.0)).cross(along(DVec2::new(0.0, h))).length();
                        let product = area * pdf(wo, *alpha, sample(wo, *alpha, u));
                        // Central differences: h² times third derivatives, which grow as 0.05⁻² at the edges.
                        assert!((product - 1.0).abs() < 1e-5, "{name} {alpha} {wo} {u}: {product}");
                    }
                }
            }
        }
    }

    #[test]
    fn extreme_uniforms_give_unit_normals() {
        let edges = [0.0, 0.5, 1.0 - f64::EPSILON / 2.0];
        for (name, sample, ..) in MAPS {
            for alpha in ALPHAS {
                for wo in views().chain([DVec3::X, DVec3::NEG_Z, direction(2.0, 1.0), DVec3::new(1.0, 0.0, 1e-300)]) {
                    for (x, y) in edges.into_iter().flat_map(|x| edges.map(|y| (x, y))) {
                        let m = sample(wo, alpha, DVec2::new(x, y));
                        assert!((m.length() - 1.0).abs() < 1e-15, "{name} {alpha} {wo} u = ({x}, {y}): {m}");
                    }
                }
            }
        }
    }

    #[test]
    fn beckmann_slopes_are_inverted_to_the_last_digits_of_u() {
        // The inverse, not the tolerance of an iteration, is what decides: u comes back within some roundings.
        let mut worst: f64 = 0.0;
        for wo in views() {
            for i in 0..2000 {
                let u = DVec2::new((f64::from(i) + 0.5) / 2000.0, 0.3);
                let m = beckmann_visible(wo, DVec2::splat(0.5), u);
                worst = worst.max((beckmann_visible_inv(wo, DVec2::splat(0.5), m) - u).abs().max_element());
            }
        }
        assert!(worst < 4e-15, "{worst:e}");
    }
}
