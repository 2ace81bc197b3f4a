//! `finite` and `reciprocity`: what must hold pointwise.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::check::{Check, Outcome};
use crate::bsdf::{Bsdf, Density, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::{direction, direction_mu, mirror};
use crate::sampling::stream::{Stream, stream, uniform, uniforms};

/// The largest number below 1.
const ALMOST_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
/// Random pairs per unit of work.
const UNIT: usize = 512;
/// Largest asymmetry that is put down to rounding: swapping the arguments of a sound model changes only the order of
/// commutative operations, but a lobe of exponent 10⁶ turns 10⁻¹⁶ in its cosine into 10⁻¹⁰.
const ROUNDING: f64 = 1e-7;
/// A BRDF value [1/sr] too faint for its asymmetry to matter: the far tail of a lobe.
const FAINT: f64 = 1e-9;

/// A random direction above the horizon: half of them uniform in μ, half crowded towards grazing.
fn random_direction(rng: &mut Stream) -> DVec3 {
    let (pick, u, turn) = (uniform(rng), uniform(rng), uniform(rng));
    let mu = if pick < 0.5 { u } else { 10_f64.powf(-6.0 * u) };
    direction_mu(mu.max(1e-9), TAU * turn)
}

/// A random pair: independent directions, or the second one drawn by the model, or near the mirror direction.
fn random_pair(bsdf: &dyn Bsdf, rng: &mut Stream) -> (DVec3, DVec3) {
    let wo = random_direction(rng);
    let (pick, other) = (uniform(rng), random_direction(rng));
    let drawn = bsdf.sample(wo, uniforms(rng)).map(|s| s.wi).filter(|w| w.is_finite() && w.z > 0.0);
    let wi = if pick < 0.4 {
        other
    } else if pick < 0.8 {
        drawn.unwrap_or(other)
    } else {
        nudge(mirror(wo), 10_f64.powf(-5.0 * uniform(rng)), rng)
    };
    (wo, wi)
}

/// A direction about `size` radians away, above the horizon.
fn nudge(w: DVec3, size: f64, rng: &mut Stream) -> DVec3 {
    let mut step = || -> f64 { StandardNormal.sample(rng) };
    let moved = w + size * DVec3::new(step(), step(), step());
    DVec3::new(moved.x, moved.y, moved.z.abs().max(1e-12)).normalize_or(DVec3::Z)
}

/// What is wrong with a value that must be finite and not negative.
fn fault(value: Rgb) -> Option<&'static str> {
    let channels = value.to_array();
    if channels.iter().any(|x| x.is_nan()) {
        Some("NaN")
    } else if channels.iter().any(|x| x.is_infinite()) {
        Some("infinite")
    } else if channels.iter().any(|x| *x < 0.0) {
        Some("negative")
    } else {
        None
    }
}

fn fault_at(bsdf: &dyn Bsdf, wo: DVec3, wi: DVec3) -> Option<String> {
    let eval = fault(bsdf.eval(wo, wi)).map(|what| format!("eval is {what}"));
    eval.or_else(|| fault(Rgb::grey(bsdf.pdf(wo, wi))).map(|what| format!("pdf is {what}")))
}

fn fault_of_sample(bsdf: &dyn Bsdf, wo: DVec3, u: Uniforms) -> Option<(DVec3, String)> {
    let s = bsdf.sample(wo, u)?;
    let (Density::SolidAngle(density) | Density::Dirac(density)) = s.density;
    let place = format!("at u = ({}, {}, {})", u.lobe, u.dir.x, u.dir.y);
    let what = if !s.wi.is_finite() {
        Some("direction is not finite".to_owned())
    } else if let Some(what) = fault(s.weight) {
        Some(format!("weight is {what}"))
    } else {
        fault(Rgb::grey(density)).map(|what| format!("density is {what}"))
    };
    what.map(|what| (s.wi, format!("a sample's {what} {place}")))
}

/// Directions at which formulas break: the normal, the axes' neighbourhoods, grazing, the horizon, below.
fn edge_directions() -> Vec<DVec3> {
    let mut edges = vec![DVec3::Z, DVec3::X, -DVec3::Z, direction_mu(ALMOST_ONE, 0.3)];
    for mu in [1e-12, 1e-8, 1e-4, 0.02, 0.5, 0.999_999, -1e-8, -0.5] {
        for phi in [0.0, 0.25 * TAU, 0.4, 3.0] {
            edges.push(direction_mu(mu, phi));
        }
    }
    edges
}

/// `finite`: no NaN, infinity or negative value, at edges and in a random sweep.
pub(crate) fn finite(bsdf: &dyn Bsdf, seed: u64, pairs: usize) -> Check {
    let mut check = Check::new("finite");
    let edges = edge_directions();
    let corners = [0.0, 0.5, ALMOST_ONE];
    let (mut tested, mut seen_light) = (0_u64, false);
    let mut found = None;
    let mut test_pair = |wo: DVec3, wi: DVec3| {
        tested += 1;
        seen_light |= !bsdf.eval(wo, wi).is_black();
        fault_at(bsdf, wo, wi).map(|what| ((wo, wi), what))
    };
    for &wo in &edges {
        let partners = edges.iter().copied().chain([wo, mirror(wo), DVec3::new(wo.x, wo.y, -wo.z)]);
        for wi in partners {
            found = found.or_else(|| test_pair(wo, wi));
        }
        for lobe in corners {
            for (x, y) in corners.iter().flat_map(|x| corners.map(|y| (*x, y))) {
                let u = Uniforms { lobe, dir: DVec2::new(x, y) };
                found = found.or_else(|| fault_of_sample(bsdf, wo, u).map(|(wi, what)| ((wo, wi), what)));
            }
        }
    }
    let mut rng = stream(seed, 11, 0);
    for _ in 0..pairs {
        let (wo, wi) = random_pair(bsdf, &mut rng);
        let u = uniforms(&mut rng);
        found = found.or_else(|| test_pair(wo, wi));
        found = found.or_else(|| fault_of_sample(bsdf, wo, u).map(|(wi, what)| ((wo, wi), what)));
    }
    check.statistic = f64::from(u8::from(found.is_some()));
    // At 99 %, a set of pairs is hit whose probability is −ln(0.01)/n.
    check.detects.insert("share_of_pairs", 100_f64.ln() / pairs.max(1) as f64);
    match found {
        Some((worst, what)) => {
            check.outcome = Outcome::Fail;
            check.worst = Some(worst);
            check.detail = what;
        }
        None if seen_light => {
            check.outcome = Outcome::Pass;
            check.detail = format!("{tested} pairs of directions, edges included: no NaN, infinity or negative value");
        }
        None => return check.inconclusive_here("the model is black at every pair of directions tried"),
    }
    check
}

/// |f(a, b) − f(b, a)| relative to the larger of them or [`FAINT`]; NaN counts as no asymmetry here, since `finite`
/// reports it.
fn asymmetry(bsdf: &dyn Bsdf, (a, b): (DVec3, DVec3)) -> f64 {
    let (f, g) = (bsdf.eval(a, b), bsdf.eval(b, a));
    let gap = (f - g).0.abs().max_element() / f.max_channel().max(g.max_channel()).max(FAINT);
    if gap.is_finite() { gap } else { 0.0 }
}

/// `reciprocity`: the largest relative asymmetry, by random search and then local refinement.
pub(crate) fn reciprocity(bsdf: &dyn Bsdf, seed: u64, pairs: usize) -> Check {
    let mut check = Check::new("reciprocity");
    check.bound = ROUNDING;
    let units: Vec<(f64, (DVec3, DVec3), bool)> = (0..pairs.div_ceil(UNIT) as u64)
        .into_par_iter()
        .map(|unit| {
            let mut rng = stream(seed, 12, unit);
            let (mut worst, mut at, mut seen_light) = (0.0, (DVec3::Z, DVec3::Z), false);
            for _ in 0..UNIT {
                let pair = random_pair(bsdf, &mut rng);
                let gap = asymmetry(bsdf, pair);
                seen_light |= !bsdf.eval(pair.0, pair.1).is_black();
                if gap > worst {
                    (worst, at) = (gap, pair);
                }
            }
            // Climb from the best of this unit: smaller and smaller steps.
            let mut size = 0.3;
            for _ in 0..UNIT / 4 {
                size *= 0.95;
                let near = (nudge(at.0, size, &mut rng), nudge(at.1, size, &mut rng));
                let gap = asymmetry(bsdf, near);
                if gap > worst {
                    (worst, at) = (gap, near);
                }
            }
            (worst, at, seen_light)
        })
        .collect();
    if units.iter().all(|u| !u.2) {
        return check.inconclusive_here("the model is black at every pair of directions tried");
    }
    let Some(&(worst, at, _)) = units.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return check };
    check.statistic = worst;
    check.worst = Some(at);
    check.detects.insert("relative_asymmetry", ROUNDING);
    check.detects.insert("share_of_pairs", 100_f64.ln() / pairs.max(1) as f64);
    if worst <= ROUNDING {
        check.outcome = Outcome::Pass;
        check.detail =
            format!("f(wo, wi) = f(wi, wo) to {worst:.1e} relative over {pairs} pairs and a search from the worst");
    } else {
        let (f, g) = (bsdf.eval(at.0, at.1), bsdf.eval(at.1, at.0));
        check.outcome = Outcome::Fail;
        check.detail = format!(
            "f(wo, wi) = {:.6e} but f(wi, wo) = {:.6e}: swapping eye and light changes the value",
            f.max_channel(),
            g.max_channel()
        );
    }
    check
}

/// Polar angles, with random offsets, at which to look: even in θ, then geometric towards grazing.
pub(crate) fn polar_angles(even: usize, grazing: usize, seed: u64) -> Vec<f64> {
    let mut rng = stream(seed, 13, 0);
    let quarter = 0.25 * TAU;
    let mut angles: Vec<f64> = (0..even).map(|i| quarter * (i as f64 + uniform(&mut rng)) / even as f64).collect();
    // From 6 degrees above the horizon down to 10⁻⁵ radians.
    angles.extend(
        (0..grazing).map(|i| quarter - 0.1 * 10_f64.powf(-4.0 * (i as f64 + uniform(&mut rng)) / grazing as f64)),
    );
    angles.push(0.0);
    angles.sort_by(f64::total_cmp);
    angles
}

/// The direction at polar angle `theta`, and its neighbour below the horizon pulled back above it.
pub(crate) fn above(theta: f64, phi: f64) -> DVec3 {
    let w = direction(theta, phi);
    DVec3::new(w.x, w.y, w.z.max(1e-9))
}
