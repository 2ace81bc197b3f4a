//! `finite` and `reciprocity`: what must hold pointwise.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::check::{Check, Outcome};
use crate::bsdf::{Bsdf, Density, Lobes, Uniforms};
use crate::integrate::{DiracLobe, Half, dirac_lobes, is_two_faced, way_back};
use crate::math::color::Rgb;
use crate::math::sphere::{direction, direction_mu, flip, mirror};
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

/// Height above the horizon below which the way back through a Dirac lobe is not tried: a cosine of this size comes back
/// from its square beside 1, with a relative error of 10⁻¹⁶ / LOWEST².
const LOWEST: f64 = 1e-3;

/// Where a model is looked at from, and where it can be lit.
#[derive(Clone, Copy, Debug)]
struct Sides {
    two_faced: bool,
    transmits: bool,
    has_dirac: bool,
}

impl Sides {
    fn of(bsdf: &dyn Bsdf) -> Self {
        let has = |lobes| bsdf.lobes().contains(lobes);
        Self { two_faced: is_two_faced(bsdf), transmits: has(Lobes::TRANSMIT), has_dirac: has(Lobes::DIRAC) }
    }

    /// `w`, mirrored in the tangent plane half of the times, where there is light below.
    fn either(self, w: DVec3, rng: &mut Stream) -> DVec3 {
        if self.two_faced && uniform(rng) < 0.5 { flip(w) } else { w }
    }

    /// Whether `wi` is a direction in which `wo` can see light.
    fn connects(self, wo: DVec3, wi: DVec3) -> bool {
        wi.is_finite() && if wo.z * wi.z > 0.0 { self.two_faced || wo.z > 0.0 } else { self.transmits && wi.z != 0.0 }
    }
}

/// A random direction above the horizon: half of them uniform in μ, half crowded towards grazing.
fn random_direction(rng: &mut Stream) -> DVec3 {
    let (pick, u, turn) = (uniform(rng), uniform(rng), uniform(rng));
    let mu = if pick < 0.5 { u } else { 10_f64.powf(-6.0 * u) };
    direction_mu(mu.max(1e-9), TAU * turn)
}

/// A random pair: independent directions, or the second one drawn by the model, or near the mirror direction, or near the
/// refracted one.
fn random_pair(bsdf: &dyn Bsdf, sides: Sides, rng: &mut Stream) -> (DVec3, DVec3) {
    let upright = random_direction(rng);
    let wo = sides.either(upright, rng);
    let (pick, other) = (uniform(rng), random_direction(rng));
    let other = if sides.transmits {
        sides.either(other, rng)
    } else if wo.z < 0.0 {
        flip(other)
    } else {
        other
    };
    let drawn = bsdf.sample(wo, uniforms(rng)).map(|s| s.wi).filter(|wi| sides.connects(wo, *wi));
    let wi = if pick < 0.4 {
        other
    } else if pick < 0.8 {
        drawn.unwrap_or(other)
    } else {
        let refracted = sides.transmits && uniform(rng) < 0.5;
        let centre = if refracted { Half::transmitted(wo, bsdf.eta()) } else { Half::reflected(wo) };
        nudge(centre.free(centre.centre()), 10_f64.powf(-5.0 * uniform(rng)), rng)
    };
    (wo, wi)
}

/// A direction about `size` radians away, on the same side of the horizon.
fn nudge(w: DVec3, size: f64, rng: &mut Stream) -> DVec3 {
    let mut step = || -> f64 { StandardNormal.sample(rng) };
    let moved = w + size * DVec3::new(step(), step(), step());
    let height = moved.z.abs().max(1e-12);
    DVec3::new(moved.x, moved.y, height.copysign(w.z)).normalize_or(DVec3::Z)
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
    let (mut rng, sides) = (stream(seed, 11, 0), Sides::of(bsdf));
    for _ in 0..pairs {
        let (wo, wi) = random_pair(bsdf, sides, &mut rng);
        let u = uniforms(&mut rng);
        found = found.or_else(|| test_pair(wo, wi));
        found = found.or_else(|| fault_of_sample(bsdf, wo, u).map(|(wi, what)| ((wo, wi), what)));
    }
    // What eval does not show: Dirac lobes.
    let shines = |wo: &DVec3| dirac_lobes(bsdf, *wo).iter().any(|lobe| !lobe.albedo().is_black());
    seen_light |= edges.iter().any(shines);
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

/// f(a, b) / η_b² and f(b, a) / η_a², which must be equal.
fn both_ways(bsdf: &dyn Bsdf, (a, b): (DVec3, DVec3)) -> (Rgb, Rgb) {
    let inv_eta2 = |w: DVec3| if w.z < 0.0 { bsdf.eta().powi(-2) } else { 1.0 };
    (bsdf.eval(a, b) * inv_eta2(b), bsdf.eval(b, a) * inv_eta2(a))
}

/// The gap between the two ways relative to the larger of them or [`FAINT`]; NaN counts as no asymmetry here, since
/// `finite` reports it.
fn asymmetry(bsdf: &dyn Bsdf, pair: (DVec3, DVec3)) -> f64 {
    let (f, g) = both_ways(bsdf, pair);
    let gap = (f - g).0.abs().max_element() / f.max_channel().max(g.max_channel()).max(FAINT);
    if gap.is_finite() { gap } else { 0.0 }
}

/// The largest asymmetry that a search has met, and between which directions.
#[derive(Clone, Copy, Debug)]
struct Asymmetry {
    size: f64,
    at: (DVec3, DVec3),
    seen_light: bool,
}

/// The largest asymmetry of eval: a random search, and a climb from the worst pair in smaller and smaller steps.
fn search(bsdf: &dyn Bsdf, sides: Sides, rng: &mut Stream) -> Asymmetry {
    let mut worst = Asymmetry { size: 0.0, at: (DVec3::Z, DVec3::Z), seen_light: false };
    let mut meet = |pair: (DVec3, DVec3)| {
        let size = asymmetry(bsdf, pair);
        if size > worst.size {
            (worst.size, worst.at) = (size, pair);
        }
        worst.seen_light |= !bsdf.eval(pair.0, pair.1).is_black();
        worst.at
    };
    let mut at = (DVec3::Z, DVec3::Z);
    for _ in 0..UNIT {
        at = meet(random_pair(bsdf, sides, rng));
    }
    let mut size = 0.3;
    for _ in 0..UNIT / 4 {
        size *= 0.95;
        at = meet((nudge(at.0, size, rng), nudge(at.1, size, rng)));
    }
    worst
}

/// The largest asymmetry of the Dirac lobes at random directions: the way back has the same share, and étendue is kept.
fn search_dirac(bsdf: &dyn Bsdf, sides: Sides, rng: &mut Stream) -> Asymmetry {
    let mut worst = Asymmetry { size: 0.0, at: (DVec3::Z, DVec3::Z), seen_light: false };
    for _ in 0..UNIT / 32 {
        let upright = random_direction(rng);
        let wo = sides.either(upright, rng);
        for lobe in dirac_lobes(bsdf, wo).into_iter().filter(|lobe| wo.z.abs().min(lobe.wi.z.abs()) > LOWEST) {
            let there = lobe.albedo();
            let back = way_back(bsdf, wo, &lobe).map_or(Rgb::BLACK, |back| back.albedo());
            let larger = there.max_channel().max(back.max_channel());
            worst.seen_light |= larger > 0.0;
            let share = if larger > FAINT { (there - back).0.abs().max_element() / larger } else { 0.0 };
            let size = share.max(etendue_gap(bsdf, wo, &lobe));
            if size > worst.size {
                (worst.size, worst.at) = (size, (wo, lobe.wi));
            }
        }
    }
    worst
}

/// |η_b² cosθ_b dω_b / (η_a² cosθ_a dω_a) − 1| of the beam about `wo` = a that a Dirac lobe turns into one about b.
///
/// In the tangential components p of the directions, cosθ dω = dp: the ratio is the determinant of ∂p_b/∂p_a, by
/// differences that are exact where the map is linear, as it is for all reflection and refraction.
fn etendue_gap(bsdf: &dyn Bsdf, wo: DVec3, lobe: &DiracLobe) -> f64 {
    const STEP: f64 = 1e-4;
    let index = |w: DVec3| if w.z < 0.0 { bsdf.eta() } else { 1.0 };
    // Away from grazing, where a step would leave the hemisphere.
    if wo.z.abs() < 0.05 || lobe.wi.z.abs() < 0.05 {
        return 0.0;
    }
    let shifted = |dx: f64, dy: f64| -> Option<DVec3> {
        let (x, y) = (wo.x + dx, wo.y + dy);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt().copysign(wo.z);
        let near = dirac_lobes(bsdf, DVec3::new(x, y, z)).into_iter().map(|near| near.wi);
        near.min_by(|a, b| (*a - lobe.wi).length().total_cmp(&(*b - lobe.wi).length()))
    };
    let along = |dx: f64, dy: f64| -> Option<DVec3> { Some((shifted(dx, dy)? - shifted(-dx, -dy)?) / (2.0 * STEP)) };
    let (Some(x), Some(y)) = (along(STEP, 0.0), along(0.0, STEP)) else { return 0.0 };
    let ratio = (x.x * y.y - x.y * y.x).abs() * (index(lobe.wi) / index(wo)).powi(2);
    (ratio - 1.0).abs()
}

/// `reciprocity`: the largest relative asymmetry, by random search and then local refinement.
pub(crate) fn reciprocity(bsdf: &dyn Bsdf, seed: u64, pairs: usize) -> Check {
    let mut check = Check::new("reciprocity");
    check.bound = ROUNDING;
    let sides = Sides::of(bsdf);
    let units: Vec<(Asymmetry, bool)> = (0..pairs.div_ceil(UNIT) as u64)
        .into_par_iter()
        .map(|unit| {
            let mut rng = stream(seed, 12, unit);
            let smooth = search(bsdf, sides, &mut rng);
            if !sides.has_dirac {
                return (smooth, false);
            }
            let dirac = search_dirac(bsdf, sides, &mut rng);
            let seen_light = smooth.seen_light || dirac.seen_light;
            let is_dirac = dirac.size > smooth.size;
            (Asymmetry { seen_light, ..if is_dirac { dirac } else { smooth } }, is_dirac)
        })
        .collect();
    if units.iter().all(|(found, _)| !found.seen_light) {
        return check.inconclusive_here("the model is black at every pair of directions tried");
    }
    let Some(&(Asymmetry { size: worst, at, .. }, is_dirac)) =
        units.iter().max_by(|a, b| a.0.size.total_cmp(&b.0.size))
    else {
        return check;
    };
    check.statistic = worst;
    check.worst = Some(at);
    check.detects.insert("relative_asymmetry", ROUNDING);
    check.detects.insert("share_of_pairs", 100_f64.ln() / pairs.max(1) as f64);
    let law = if bsdf.eta() == 1.0 { "f(wo, wi) = f(wi, wo)" } else { "f(wo, wi) / η_i² = f(wi, wo) / η_o²" };
    if worst <= ROUNDING {
        check.outcome = Outcome::Pass;
        let dirac = if sides.has_dirac { ", and Dirac lobes lead back with the same share" } else { "" };
        check.detail = format!("{law} to {worst:.1e} relative over {pairs} pairs and a search from the worst{dirac}");
        return check;
    }
    check.outcome = Outcome::Fail;
    check.detail = if is_dirac {
        format!("a Dirac lobe and its way back differ by {worst:.3e} relative, in share or in étendue")
    } else {
        let (f, g) = both_ways(bsdf, at);
        let (there, back) = law.split_once(" = ").unwrap_or((law, law));
        format!(
            "{there} = {:.6e} but {back} = {:.6e}: swapping eye and light changes the value",
            f.max_channel(),
            g.max_channel()
        )
    };
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
