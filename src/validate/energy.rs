//! `energy_eye`, `energy_light` and `white_furnace`: where the light goes.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use super::check::{Check, Outcome};
use super::laws::{above, polar_angles};
use crate::bsdf::{Bsdf, Lobes};
use crate::integrate::{Hemisphere, Integral, Side, is_isotropic, is_two_faced};
use crate::math::color::Rgb;
use crate::math::sphere::flip;
use crate::sampling::stream::{stream, uniform};

/// Gain that is put down to the quadrature and to tabulated compensation: a tenth of what must be caught.
const ROUNDING: f64 = 1e-5;
/// Tolerance of the quadrature behind each albedo.
const TOL: f64 = 3.2e-5;
/// Error up to which an albedo that is only reported, or compared loosely, counts as known.
const COARSE: f64 = 1e-3;
/// An albedo that is known to lie below this is not near a gain.
const FAR: f64 = 0.97;
/// Steps of the golden-section search from each of the highest directions.
const REFINEMENTS: usize = 14;

/// How many directions are looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub(crate) even: usize,
    pub(crate) grazing: usize,
    pub(crate) azimuths: usize,
}

/// The largest channel of an albedo found at a direction, less the error bound: what is certainly there.
#[derive(Clone, Copy, Debug)]
struct Found {
    place: Place,
    albedo: Integral,
}

/// A direction by its angle from the normal on its own side, azimuth, and whether it lies below the surface.
#[derive(Clone, Copy, Debug)]
struct Place {
    theta: f64,
    phi: f64,
    below: bool,
}

impl Place {
    fn direction(self) -> DVec3 {
        let w = above(self.theta, self.phi);
        if self.below { flip(w) } else { w }
    }
}

/// "40.0000 degrees", or that from below.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let precision = f.precision().unwrap_or(4);
        write!(f, "{:.precision$} degrees{}", self.theta.to_degrees(), if self.below { " from below" } else { "" })
    }
}

/// These polar angles with an azimuth each, on every side from which `bsdf` is lit.
fn places(bsdf: &dyn Bsdf, angles: impl IntoIterator<Item = (f64, f64)>) -> Vec<Place> {
    let above = angles.into_iter().map(|(theta, phi)| Place { theta, phi, below: false });
    let mut places: Vec<Place> = above.collect();
    if is_two_faced(bsdf) {
        let below: Vec<Place> = places.iter().map(|place| Place { below: true, ..*place }).collect();
        places.extend(below);
    }
    places
}

impl Found {
    fn at(bsdf: &dyn Bsdf, side: Side, place: Place) -> Self {
        // Bounded work in one direction: what cannot be resolved says so, and the error bound keeps it honest.
        let quadrature = Hemisphere { tol: TOL, max_evals: 400_000 };
        Self { place, albedo: quadrature.albedo(bsdf, side, place.direction()) }
    }

    /// The same, but for a model that transmits only as well as it takes to see that it is far from a gain: total internal
    /// reflection leaves a crease that no chart follows.
    fn survey(bsdf: &dyn Bsdf, side: Side, place: Place) -> Self {
        if bsdf.lobes().contains(Lobes::TRANSMIT) {
            let quadrature = Hemisphere { tol: COARSE, max_evals: 100_000 };
            let albedo = quadrature.albedo(bsdf, side, place.direction());
            if albedo.resolved && albedo.value.max_channel() + albedo.error < FAR {
                return Self { place, albedo };
            }
        }
        Self::at(bsdf, side, place)
    }

    fn certain(&self) -> f64 {
        let certain = self.albedo.value.max_channel() - self.albedo.error;
        if certain.is_nan() { f64::NEG_INFINITY } else { certain }
    }

    /// Whether the error bound leaves room for a gain that the value itself does not show.
    fn could_gain(&self) -> bool {
        let possible = self.albedo.value.max_channel() + self.albedo.error;
        possible.is_nan() || (!self.albedo.resolved && possible > 1.0 + ROUNDING)
    }

    /// Whether so little is known that nothing can be said.
    fn is_unknown(&self) -> bool {
        let scale = self.albedo.value.max_channel().max(1.0);
        self.albedo.error.is_nan() || (!self.albedo.resolved && self.albedo.error > COARSE * scale)
    }

    fn direction(&self) -> DVec3 {
        self.place.direction()
    }
}

/// The supremum over direction of the albedo with one side fixed: search, then refine, down to 10⁻⁵ radians.
pub(crate) fn energy(bsdf: &dyn Bsdf, side: Side, seed: u64, grid: Grid) -> Check {
    let (name, fixed) = match side {
        Side::Eye => ("energy_eye", "eye"),
        Side::Light => ("energy_light", "light"),
    };
    let mut check = Check::new(name);
    check.bound = 1.0 + ROUNDING;
    let mut rng = stream(seed, 14, 0);
    let azimuths = if is_isotropic(bsdf) { 1 } else { grid.azimuths };
    let angles = polar_angles(grid.even, grid.grazing, seed)
        .into_iter()
        .flat_map(|theta| (0..azimuths).map(move |i| (theta, i)))
        .map(|(theta, i)| (theta, TAU * (i as f64 + uniform(&mut rng)) / azimuths as f64));
    let places = places(bsdf, angles);
    let mut found: Vec<Found> = places.par_iter().map(|&place| Found::survey(bsdf, side, place)).collect();
    let undecided = found.iter().find(|f| f.could_gain()).copied();
    if undecided.is_none() && found.iter().all(|f| f.albedo.value.is_black()) {
        return check.inconclusive_here("the model is black: it reflects nothing from any direction tried");
    }
    found.sort_by(|a, b| b.certain().total_cmp(&a.certain()));
    let spacing = FRAC_PI_2 / grid.even as f64;
    let refined: Vec<Found> = found[..found.len().min(4)].par_iter().map(|f| climb(bsdf, side, *f, spacing)).collect();
    let Some(top) = refined.into_iter().max_by(|a, b| a.certain().total_cmp(&b.certain())) else { return check };

    check.statistic = top.albedo.value.max_channel();
    check.worst = Some((top.direction(), top.direction()));
    check.detects.insert("gain", ROUNDING + TOL);
    check.detects.insert("width_deg", spacing.to_degrees());
    let (place, albedo) = (top.place, top.albedo.value);
    if top.certain() > 1.0 + ROUNDING {
        check.outcome = Outcome::Fail;
        check.detail = format!(
            "with the {fixed} fixed at {place:.4} the surface scatters {:.6} times the light it receives ({albedo})",
            check.statistic
        );
    } else if let Some(bad) = undecided {
        return check.inconclusive(
            bad.direction(),
            &format!(
                "the albedo with the {fixed} at {:.4} could not be resolved: {} ± {:.1e}",
                bad.place, bad.albedo.value, bad.albedo.error
            ),
        );
    } else {
        check.outcome = Outcome::Pass;
        check.detail = format!(
            "with the {fixed} fixed the albedo is {:.6} at the most, at {place:.3} ({} directions)",
            check.statistic,
            found.len()
        );
    }
    check
}

/// Golden-section search in θ about a direction of the grid, towards grazing in the logarithm of the height.
fn climb(bsdf: &dyn Bsdf, side: Side, start: Found, spacing: f64) -> Found {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let theta = start.place.theta;
    let height = FRAC_PI_2 - theta;
    let (mut lo, mut hi) = if height < spacing {
        (FRAC_PI_2 - 4.0 * height, FRAC_PI_2 - 0.25 * height)
    } else {
        ((theta - spacing).max(0.0), (theta + spacing).min(FRAC_PI_2 - 1e-6))
    };
    let at = |theta: f64| Found::at(bsdf, side, Place { theta, ..start.place });
    let mut best = start;
    let (mut a, mut b) = (at(hi - GOLDEN * (hi - lo)), at(lo + GOLDEN * (hi - lo)));
    for _ in 0..REFINEMENTS {
        for candidate in [a, b] {
            if candidate.certain() > best.certain() {
                best = candidate;
            }
        }
        if a.certain() > b.certain() {
            (hi, b) = (b.place.theta, a);
            a = at(hi - GOLDEN * (hi - lo));
        } else {
            (lo, a) = (a.place.theta, b);
            b = at(lo + GOLDEN * (hi - lo));
        }
    }
    best
}

/// `white_furnace`: the albedo by quadrature against the model's closed form, and against 1 where it claims to lose
/// nothing.
pub(crate) fn white_furnace(bsdf: &dyn Bsdf, seed: u64, grid: Grid) -> Check {
    let mut check = Check::new("white_furnace");
    check.bound = ROUNDING;
    let phi = TAU * uniform(&mut stream(seed, 15, 0));
    let angles = polar_angles(grid.even.div_ceil(4), grid.grazing.div_ceil(4), seed).into_iter();
    let places = places(bsdf, angles.map(|theta| (theta, phi)));
    let compares = bsdf.claims_lossless() || bsdf.albedo(DVec3::Z).is_some();
    let look = if compares { Found::at } else { Found::survey };
    let found: Vec<Found> = places.par_iter().map(|&place| look(bsdf, Side::Eye, place)).collect();
    let expected = |f: &Found| if bsdf.claims_lossless() { Some(Rgb::WHITE) } else { bsdf.albedo(f.direction()) };
    let matters = |f: &&Found| f.is_unknown() && (f.albedo.error.is_nan() || expected(f).is_some());
    if let Some(bad) = found.iter().find(matters) {
        return check.inconclusive(
            bad.direction(),
            &format!(
                "the albedo at {:.4} could not be resolved: {} ± {:.1e}",
                bad.place, bad.albedo.value, bad.albedo.error
            ),
        );
    }
    if found.iter().all(|f| f.albedo.value.is_black()) {
        return check.inconclusive_here("the model is black: a furnace shows nothing");
    }
    let gap = |f: &Found| expected(f).map(|e| ((f.albedo.value - e).0.abs().max_element() - f.albedo.error).max(0.0));
    let compared = found.iter().filter_map(|f| gap(f).map(|g| (f, if g.is_nan() { f64::INFINITY } else { g })));
    let grazing = found.iter().rev().find(|f| !f.is_unknown()).unwrap_or(&found[0]);
    let normal = &found[0];
    let range = format!("{} at {:.1}, {} at {:.3}", brief(normal), normal.place, brief(grazing), grazing.place);
    check.detects.insert("albedo", ROUNDING + TOL);
    let Some((worst, gap)) = compared.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        check.outcome = Outcome::Pass;
        check.statistic = normal.albedo.value.max_channel();
        check.detects.clear();
        check.detail = format!("albedo {range}; the model states no closed form and no claim to compare with");
        return check;
    };
    check.statistic = gap;
    check.worst = Some((worst.direction(), worst.direction()));
    check.outcome = if gap <= ROUNDING { Outcome::Pass } else { Outcome::Fail };
    let claim = if bsdf.claims_lossless() { "1, as the model claims" } else { "the model's closed form" };
    check.detail = if check.outcome == Outcome::Pass {
        format!("albedo {range}; it equals {claim} to {gap:.1e}")
    } else {
        format!("the albedo at {:.3} is {} and differs from {claim} by {gap:.2e}", worst.place, worst.albedo.value)
    };
    check
}

fn brief(f: &Found) -> String {
    let a = f.albedo.value.map(|x| (x * 1e6).round() / 1e6);
    a.to_string()
}
