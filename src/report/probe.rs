//! What the plots show: curves, lobes, maps and histograms of one BRDF, as plain numbers.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use crate::bsdf::{Bsdf, Density};
use crate::integrate::{Hemisphere, Integral, Side, hints, is_isotropic};
use crate::math::color::Rgb;
use crate::math::quadrature::{PAIR, adaptive};
use crate::math::sphere::{basis, direction, mirror};
use crate::sampling::stream::{stream, uniforms};

/// One value of a directional albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlbedoPoint {
    /// Angle of the fixed direction from the normal in degrees.
    pub theta_deg: f64,
    /// The largest channel.
    pub albedo: f64,
    /// Whether the integral met the tolerance of a picture.
    pub resolved: bool,
}

/// The directional albedo against angle, at azimuth 0, denser towards grazing.
pub fn albedo_curve(bsdf: &dyn Bsdf, side: Side) -> Vec<AlbedoPoint> {
    // A pixel is some 1/300 of the axis; a picture needs no more, and a spiky model must not cost minutes.
    let hemisphere = Hemisphere { tol: 1e-3, max_evals: 100_000 };
    let coarse = (0..17).map(|i| 5.0 * f64::from(i));
    let angles = coarse.chain([82.0, 84.0, 85.0, 86.0, 87.0, 88.0, 88.5, 89.0, 89.4, 89.7, 89.9]);
    let mut angles: Vec<f64> = angles.collect();
    angles.sort_by(f64::total_cmp);
    let point = |theta_deg: f64| {
        let integral = hemisphere.albedo(bsdf, side, direction(theta_deg.to_radians(), 0.0));
        AlbedoPoint { theta_deg, albedo: integral.value.max_channel(), resolved: integral.resolved }
    };
    angles.into_iter().map(point).collect()
}

/// The lobe in the plane of incidence: (angle of `wi` from the normal in radians, f·cos in its largest channel).
///
/// Positive angles lie on the side of the mirror direction. The angles crowd around that direction, so that a lobe of
/// any width is drawn with its width.
pub fn lobe(bsdf: &dyn Bsdf, theta_o: f64) -> Vec<(f64, f64)> {
    let wo = direction(theta_o, 0.0);
    let even = (-180..=180).map(|i| f64::from(i) / 180.0 * FRAC_PI_2);
    let near = (0..=120).flat_map(|i| {
        let step = 10.0_f64.powf(-6.0 + 0.05 * f64::from(i)) * 0.2;
        [theta_o - step, theta_o + step]
    });
    let mut angles: Vec<f64> = even.chain(near).chain([theta_o]).filter(|a| a.abs() <= FRAC_PI_2).collect();
    angles.sort_by(f64::total_cmp);
    let value = |angle: f64| {
        let wi = DVec3::new(-angle.sin(), 0.0, angle.cos().max(0.0));
        let value = bsdf.eval(wo, wi).max_channel() * wi.z;
        if value.is_finite() { value.max(0.0) } else { 0.0 }
    };
    angles.into_iter().map(|angle| (angle, value(angle))).collect()
}

/// The largest relative asymmetry |f(a, b) − f(b, a)| / max over azimuths, on a grid of polar angles.
#[derive(Clone, Debug)]
pub struct AsymmetryMap {
    /// Cells along each axis, which runs from 0° to 90°.
    pub size: usize,
    /// Row by row: the cell of the angles `i` of a and `j` of b is at `i * size + j`. NaN where f is not finite.
    pub cells: Vec<f64>,
}

/// The reciprocity residual of `bsdf`.
pub fn asymmetry(bsdf: &dyn Bsdf) -> AsymmetryMap {
    let size = 45;
    let turns: &[f64] = if is_isotropic(bsdf) { &[0.0] } else { &[0.0, 0.7, 1.9] };
    let cell = |i: usize, j: usize| {
        let theta = |k: usize| (k as f64 + 0.5) / size as f64 * FRAC_PI_2;
        let mut worst = 0.0_f64;
        for &turn in turns {
            for step in 0..=6 {
                let a = direction(theta(i), turn);
                let b = direction(theta(j), turn + f64::from(step) / 6.0 * PI);
                let residual = relative_gap(bsdf.eval(a, b), bsdf.eval(b, a));
                worst = if residual.is_nan() { f64::NAN } else { worst.max(residual) };
                if worst.is_nan() {
                    return worst;
                }
            }
        }
        worst
    };
    AsymmetryMap { size, cells: (0..size * size).map(|at| cell(at / size, at % size)).collect() }
}

/// Values below this are next to subnormal numbers, which have lost their digits: they are compared with it instead.
const DIGITS_END: f64 = 1e-290;

/// |x − y| / max(|x|, |y|) of the worst channel; 0 for two zeros, NaN where a value is not finite.
fn relative_gap(x: Rgb, y: Rgb) -> f64 {
    if !x.is_finite() || !y.is_finite() {
        return f64::NAN;
    }
    let gap = |(a, b): (f64, f64)| (a - b).abs() / a.abs().max(b.abs()).max(DIGITS_END);
    x.to_array().into_iter().zip(y.to_array()).map(gap).fold(0.0, f64::max)
}

/// Where the sampler's draws fall, against where its pdf says they do: rings about the mirror direction.
#[derive(Clone, Debug)]
pub struct Histogram {
    /// Edges of the rings: angles from the mirror direction in radians, the first 0, ascending.
    pub edges: Vec<f64>,
    /// Shares of the draws: one for each ring, then all farther out, then the others: lost draws, those below the
    /// horizon, and those of Dirac lobes.
    pub sampled: Vec<f64>,
    /// The same according to the pdf.
    pub claimed: Vec<f64>,
    /// How many draws there were.
    pub draws: u64,
    /// Whether the rings' masses are accurate enough for a picture.
    pub resolved: bool,
}

/// Rings in a histogram, the outermost region not counted.
const RINGS: usize = 36;

/// The histogram for the eye at `theta_o`, with this many draws.
pub fn histogram(bsdf: &dyn Bsdf, theta_o: f64, draws: u64, seed: u64) -> Histogram {
    let wo = direction(theta_o, 0.0);
    let pole = mirror(wo);
    // A stream of its own: the picture must not repeat the draws that the checks have judged.
    let mut rng = stream(seed, u64::MAX, 0);
    let mut angles: Vec<f64> = (0..draws)
        .filter_map(|_| bsdf.sample(wo, uniforms(&mut rng)))
        .filter(|s| s.wi.z > 0.0 && matches!(s.density, Density::SolidAngle(_)))
        // atan2 keeps the digits of an angle far below 1e-8, which acos loses.
        .map(|s| s.wi.cross(pole).length().atan2(s.wi.dot(pole)))
        .collect();
    angles.sort_by(f64::total_cmp);
    let reach = angles.get(angles.len() * 199 / 200).copied().unwrap_or(PI).clamp(1e-9, PI);
    // Quadratic: thin rings where a lobe has its peak.
    let edges: Vec<f64> = (0..=RINGS).map(|k| reach * (k as f64 / RINGS as f64).powi(2)).collect();

    let mut sampled = vec![0.0; RINGS + 2];
    for &angle in &angles {
        let ring = edges[1..].partition_point(|&edge| edge <= angle);
        sampled[ring] += 1.0 / draws as f64;
    }
    sampled[RINGS + 1] = 1.0 - angles.len() as f64 / draws as f64;

    let quadrature = Hemisphere { tol: 1e-4, max_evals: 200_000 };
    let Integral { value: [mass], resolved, .. } = quadrature.integrate(wo, &hints(bsdf, wo), &|wi| [bsdf.pdf(wo, wi)]);
    let mut claimed: Vec<f64> = edges.windows(2).map(|e| ring_mass(bsdf, wo, pole, e[0], e[1])).collect();
    let farther = ring_mass(bsdf, wo, pole, reach, PI);
    let sum = claimed.iter().sum::<f64>() + farther;
    claimed.push(farther);
    claimed.push(1.0 - mass);
    // 1 % of the whole is some three pixels of the tallest bar.
    Histogram { edges, sampled, claimed, draws, resolved: resolved && (sum - mass).abs() <= 0.01 }
}

/// ∫ pdf over the part above the horizon of the ring between two angles from `pole`.
fn ring_mass(bsdf: &dyn Bsdf, wo: DVec3, pole: DVec3, from: f64, to: f64) -> f64 {
    let (side, up) = basis(pole);
    // In panels of growing width, since what is far out may still have its weight at the inner edge.
    let panels = if to > 4.0 * from.max(1e-3) { 12 } else { 1 };
    let edge = |k: i32| from + (to - from) * (f64::from(k) / f64::from(panels)).powi(3);
    let mut sum = 0.0;
    for k in 0..panels {
        let (a, b) = (edge(k), edge(k + 1));
        for node in PAIR {
            let t = a + (b - a) * node.x;
            let (sin_t, cos_t) = t.sin_cos();
            // w.z = cos t · pole.z + sin t · up.z · cos ψ is positive for |ψ| below the angle at the horizon.
            let ratio = -cos_t * pole.z / (sin_t * up.z);
            let horizon = if ratio <= -1.0 || ratio.is_nan() { PI } else { ratio.min(1.0).acos() };
            if horizon > 0.0 {
                let around = |psi: f64| {
                    let w = pole * cos_t + (up * psi.cos() + side * psi.sin()) * sin_t;
                    [bsdf.pdf(wo, w)]
                };
                let breaks = [-1.0, -0.9, -0.5, -0.1, 0.0, 0.1, 0.5, 0.9, 1.0].map(|x| x * horizon);
                let scale = 1e-3 / (sin_t * (b - a) * f64::from(panels) * RINGS as f64);
                sum += node.kronrod * (b - a) * sin_t * adaptive(around, &breaks, scale, 64).value[0];
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lambert;

    #[test]
    fn a_lambertian_has_flat_curves_and_a_round_lobe() {
        let lambert = Lambert::new(0.5).unwrap();
        for side in [Side::Eye, Side::Light] {
            // The tolerance of the picture.
            assert!(albedo_curve(&lambert, side).iter().all(|p| p.resolved && (p.albedo - 0.5).abs() <= 1e-3));
        }
        assert!(asymmetry(&lambert).cells.iter().all(|&r| r == 0.0));
        for (angle, value) in lobe(&lambert, 0.7) {
            assert!((value - 0.5 / PI * angle.cos()).abs() < 1e-15);
        }
    }

    #[test]
    fn claimed_and_sampled_shares_agree_and_add_up_to_one() {
        let lambert = Lambert::new(0.5).unwrap();
        let h = histogram(&lambert, 1.0, 20_000, 7);
        assert!(h.resolved && h.edges.len() == RINGS + 1);
        assert!((h.claimed.iter().sum::<f64>() - 1.0).abs() < 1e-3, "the quadrature of a picture");
        assert!((h.sampled.iter().sum::<f64>() - 1.0).abs() < 1e-9, "20 000 roundings");
        for (s, c) in h.sampled.iter().zip(&h.claimed) {
            // Five standard deviations of a binomial share, and the quadrature.
            assert!((s - c).abs() <= 5.0 * (c.max(1e-6) / 20_000.0).sqrt() + 1e-3, "{s} {c}");
        }
    }

    /// Not reciprocal, by a factor cos_i, and not finite at one place.
    #[derive(Debug)]
    struct Skew;

    impl Bsdf for Skew {
        fn eval(&self, _: DVec3, wi: DVec3) -> Rgb {
            Rgb::grey(wi.z)
        }
    }

    #[test]
    fn the_map_shows_asymmetry() {
        let map = asymmetry(&Skew);
        assert!(map.cells[map.size - 1] > 0.9, "grazing against normal");
        assert!(map.cells[0] == 0.0, "the diagonal");
        assert!(relative_gap(Rgb::grey(f64::NAN), Rgb::WHITE).is_nan());
    }
}
