//! When Phong's model conserves energy: its albedo from both sides, in every form in which it is taught.

use rayon::prelude::*;

use super::{File, KNOWN, Set, csv, literal, rounded};
use crate::bsdf::{Bsdf, Phong, PhongNorm};
use crate::integrate::{Hemisphere, Side};
use crate::math::color::Rgb;
use crate::math::sphere::direction;
use crate::report::plot;
use crate::report::probe::albedo_curve;

/// `phong_albedo.csv`, `phong_onset.csv` and `two_sides_of_phong.svg`.
pub const SET: Set = Set {
    name: "when Phong conserves energy",
    files: &[
        File {
            name: "phong_albedo.csv",
            about: "Directional albedo of Phong's lobe (ks = 1, kd = 0) against angle, with the eye and with the light fixed",
            columns: COLUMNS,
        },
        File {
            name: "phong_onset.csv",
            about: "The angle of the light beyond which Phong's lobe divided by n.l sends out more than it receives",
            columns: ONSET_COLUMNS,
        },
        File {
            name: "two_sides_of_phong.svg",
            about: "Albedo of Phong's lobe divided by n.l (n = 100, C = (n+1)/2pi) from both sides: the README's figure",
            columns: &[],
        },
    ],
    make: || {
        let albedos = albedos(&EXPONENTS);
        vec![csv(COLUMNS, albedos.iter().map(Albedo::row)), csv(ONSET_COLUMNS, onsets()), drawing()]
    },
};

const COLUMNS: &[(&str, &str)] = &[
    ("n", "exponent"),
    ("norm", "factor in front of the power: none is 1, n+1 is (n+1)/2pi, n+2 is (n+2)/2pi"),
    ("divide", "whether the lobe is divided by n.l"),
    ("side", "which direction is held fixed"),
    ("theta_deg", "its angle from the normal"),
    ("closed_form", "the albedo, from Arvo's moments"),
    ("quadrature", "the albedo, integrated"),
    ("error", "bound on the error of quadrature as it stands here"),
];

const ONSET_COLUMNS: &[(&str, &str)] = &[
    ("n", "exponent"),
    ("norm", "factor in front of the power, as in phong_albedo.csv"),
    ("theta_deg", "angle from which on the albedo with the light fixed is above 1"),
];

const EXPONENTS: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];
const NORMS: [(&str, PhongNorm); 3] =
    [("none", PhongNorm::None), ("n+1", PhongNorm::DensityNPlus1), ("n+2", PhongNorm::AlbedoNPlus2)];
const THETAS_DEG: [f64; 17] =
    [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 82.5, 85.0, 86.0, 87.0, 88.0, 89.0, 89.5];
/// The tolerance of the quadrature.
const TOL: f64 = 1e-6;
/// Evaluations for one of its values: next to grazing, what is left of a lobe is a sliver, and its last digits are not worth
/// the minutes.
const MOST_EVALS: u64 = 50_000;

/// One value of a directional albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// The exponent.
    pub n: f64,
    /// The factor in front of the power.
    pub norm: PhongNorm,
    /// Whether the lobe is divided by n·l.
    pub divide: bool,
    /// Which direction is held fixed.
    pub side: Side,
    /// Its angle from the normal in degrees.
    pub theta_deg: f64,
    /// The albedo in closed form.
    pub closed_form: f64,
    /// The albedo by quadrature.
    pub quadrature: f64,
    /// A bound on the error of `quadrature`.
    pub error: f64,
}

/// The albedos of all forms of the lobe with these exponents.
pub fn albedos(exponents: &[f64]) -> Vec<Albedo> {
    let sides = [Side::Eye, Side::Light];
    let forms = exponents.iter().flat_map(|&n| NORMS.map(|(_, norm)| (n, norm)));
    let forms = forms.flat_map(|(n, norm)| [false, true].map(|divide| (n, norm, divide)));
    let all: Vec<_> =
        forms.flat_map(|form| sides.into_iter().flat_map(move |side| THETAS_DEG.map(|t| (form, side, t)))).collect();
    all.into_par_iter().map(|((n, norm, divide), side, theta_deg)| albedo(n, norm, divide, side, theta_deg)).collect()
}

fn albedo(n: f64, norm: PhongNorm, divide: bool, side: Side, theta_deg: f64) -> Albedo {
    let phong = lobe(n, norm, divide);
    let w = direction(theta_deg.to_radians(), 0.0);
    let closed_form = match side {
        Side::Eye => phong.albedo(w).map_or(f64::NAN, Rgb::max_channel),
        Side::Light => seen_from_the_light(n, norm, divide, w),
    };
    let integral = Hemisphere { tol: TOL, max_evals: MOST_EVALS }.albedo(&phong, side, w);
    Albedo {
        n,
        norm,
        divide,
        side,
        theta_deg,
        closed_form,
        quadrature: integral.value.max_channel(),
        error: integral.error,
    }
}

/// The lobe alone.
fn lobe(n: f64, norm: PhongNorm, divide: bool) -> Phong {
    literal(Phong::new(n, 0.0, 1.0, norm)).with_division(divide)
}

/// The albedo of the undivided lobe, over cosθ with the division: its cosine is then that of the fixed direction.
fn seen_from_the_light(n: f64, norm: PhongNorm, divide: bool, w: glam::DVec3) -> f64 {
    lobe(n, norm, false).albedo(w).map_or(f64::NAN, Rgb::max_channel) / if divide { w.z } else { 1.0 }
}

/// One significant digit of a positive number, never less than it.
fn rounded_up(x: f64) -> String {
    let unit = 10.0_f64.powf(x.log10().floor());
    format!("{:.0e}", (x / unit).ceil() * unit)
}

impl Albedo {
    fn row(&self) -> Vec<String> {
        let norm = NORMS.iter().find(|(_, norm)| *norm == self.norm).map_or("", |(name, _)| *name);
        let side = match self.side {
            Side::Eye => "eye",
            Side::Light => "light",
        };
        // One digit more than the tolerance allows; half a unit of it is in the error stated.
        let decimals = |x: f64| format!("{x:.7}");
        vec![
            self.n.to_string(),
            norm.into(),
            self.divide.to_string(),
            side.into(),
            self.theta_deg.to_string(),
            rounded(self.closed_form, KNOWN),
            decimals(self.quadrature),
            rounded_up(self.error + 0.5e-7),
        ]
    }
}

/// The angle in degrees beyond which the divided lobe gains energy with the light fixed; 0 where it always does.
///
/// It says nothing for C = (n+2)/2π: the albedo is then 1 at the normal, and leaves it by less than a rounding at first.
pub fn onset_deg(n: f64, norm: PhongNorm) -> f64 {
    let gains = |theta_deg: f64| seen_from_the_light(n, norm, true, direction(theta_deg.to_radians(), 0.0)) > 1.0;
    if gains(0.0) {
        return 0.0;
    }
    // A / cos grows with the angle, without bound.
    let (mut below, mut above) = (0.0, 90.0 - 1e-9);
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        if gains(middle) { above = middle } else { below = middle }
    }
    above
}

fn onsets() -> Vec<Vec<String>> {
    // Four to a decade, from 1 to 10 000.
    let exponents = (0..=16).map(|k| (10.0_f64.powf(0.25 * f64::from(k)) * 100.0).round() / 100.0);
    let norms = NORMS.iter().filter(|(_, norm)| *norm != PhongNorm::AlbedoNPlus2);
    let pairs = exponents.flat_map(|n| norms.clone().map(move |&(name, norm)| (n, name, norm)));
    pairs.map(|(n, name, norm)| vec![n.to_string(), name.into(), rounded(onset_deg(n, norm), 8)]).collect()
}

fn drawing() -> String {
    let phong = lobe(100.0, PhongNorm::DensityNPlus1, true);
    let (eye, light) = (albedo_curve(&phong, Side::Eye), albedo_curve(&phong, Side::Light));
    literal(plot::albedo(&eye, &light).svg())
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn onsets_are_the_known_roots() {
        // Roots found with another program's incomplete beta function, to seven digits.
        for (n, expected) in [(1.0, 70.33571), (100.0, 80.15219)] {
            assert!((onset_deg(n, PhongNorm::DensityNPlus1) - expected).abs() < 1e-5, "{n}");
        }
    }

    #[test]
    fn closed_forms_and_quadrature_agree() {
        for a in albedos(&[10.0]) {
            // 1e-13: some roundings of either.
            assert!((a.closed_form - a.quadrature).abs() <= a.error + 1e-13, "{a:?}");
        }
    }

    #[test]
    fn bounds_are_rounded_up() {
        assert_eq!([5.4e-8, 5e-7, 9.1e-8, 1.0001e-3].map(rounded_up), ["6e-8", "5e-7", "1e-7", "2e-3"]);
    }
}
