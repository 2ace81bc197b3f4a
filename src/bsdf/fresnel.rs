//! Fresnel reflection at the boundary of air and a dielectric or a conductor, and Schlick's approximation.
//!
//! With c the cosine of the angle to the (microfacet) normal, for unpolarised light:
//! - Schlick: F = f0 + (1 − f0) (1 − c)⁵
//! - dielectric of relative index η: g = √(η² − 1 + c²), F = (rs² + rp²) / 2, rs = (c − g)/(c + g),
//!   rp = (η² c − g)/(η² c + g); 1 beyond the critical angle (only for η < 1: seen from inside)
//! - conductor of index η + i k per channel: with t = η² − k² − s², s² = 1 − c², A = √(t² + 4 η² k²) = a² + b²,
//!   a² = (A + t)/2, Rs = ((a − c)² + b²)/((a + c)² + b²), Rp = Rs ((a c − s²)² + b² c²)/((a c + s²)² + b² c²),
//!   F = (Rs + Rp)/2
//!
//! F(c = 0) is 1. The hemispherical average is F_avg = 2 ∫ F(c) c dc over [0, 1].
//! # References
//! - Schlick 1994, Computer Graphics Forum 13(3)
//! - Born & Wolf, Principles of Optics, 1.5 (dielectrics) and 14.2 (metals)
//! - Kulla & Conty 2017, SIGGRAPH course (the role of F_avg); its rational fit is not used

use super::{Domain, ParamError};
use crate::math::color::Rgb;
use crate::math::quadrature::adaptive;

/// The domain of `f0`.
pub(super) const F0: Domain = Domain::Colour(0.0, 1.0);
/// The domain of `eta`. No known material is outside; at 0 and infinity the formulae have no value.
pub(super) const ETA: Domain = Domain::Colour(1e-3, 1e3);
/// The domain of `k`.
pub(super) const K: Domain = Domain::Colour(0.0, 1e3);

/// How much light a smooth boundary reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fresnel {
    /// Schlick's approximation. `f0` = 1 is the perfect mirror.
    Schlick {
        /// Reflectance at normal incidence, in [0, 1] per channel.
        f0: Rgb,
    },
    /// The exact reflectance of a dielectric.
    Dielectric {
        /// Index of refraction of the far side over the near side, in [1e-3, 1e3].
        eta: f64,
    },
    /// The exact reflectance of an absorbing material.
    Conductor {
        /// Real part of the index of refraction, in [1e-3, 1e3] per channel.
        eta: Rgb,
        /// Extinction coefficient, its imaginary part, in [0, 1e3] per channel.
        k: Rgb,
    },
}

impl Fresnel {
    /// The perfect mirror, F = 1.
    pub const MIRROR: Self = Self::Schlick { f0: Rgb::WHITE };

    /// The same if its parameters are in their domains, else the error on behalf of `model`.
    pub(super) fn validated(self, model: &'static str) -> Result<Self, ParamError> {
        match self {
            Self::Schlick { f0 } => F0.check_colour(model, "f0", f0).map(|_| self),
            Self::Dielectric { eta } => ETA.check(model, "eta", eta).map(|_| self),
            Self::Conductor { eta, k } => {
                ETA.check_colour(model, "eta", eta)?;
                K.check_colour(model, "k", k).map(|_| self)
            }
        }
    }

    /// Whether F = 1 at every angle.
    pub fn is_mirror(&self) -> bool {
        *self == Self::MIRROR
    }

    /// F at the cosine `c`, clamped to [0, 1]; in [0, 1] per channel.
    #[inline]
    pub fn eval(&self, c: f64) -> Rgb {
        let c = c.clamp(0.0, 1.0);
        match *self {
            Self::Schlick { f0 } => {
                let m = 1.0 - c;
                let m2 = m * m;
                f0 + (Rgb::WHITE - f0) * (m2 * m2 * m)
            }
            Self::Dielectric { eta } => Rgb::grey(dielectric(eta, c)),
            Self::Conductor { eta, k } => {
                Rgb::new(conductor(eta.0.x, k.0.x, c), conductor(eta.0.y, k.0.y, c), conductor(eta.0.z, k.0.z, c))
            }
        }
    }

    /// The hemispherical average 2 ∫ F(c) c dc.
    pub fn average(&self) -> Rgb {
        match *self {
            Self::Schlick { f0 } => f0 + (Rgb::WHITE - f0) * (1.0 / 21.0),
            Self::Dielectric { eta } => Rgb::grey(dielectric_average(eta)),
            Self::Conductor { eta, k } => Rgb::new(
                average_by_quadrature(eta.0.x, |c| conductor(eta.0.x, k.0.x, c)),
                average_by_quadrature(eta.0.y, |c| conductor(eta.0.y, k.0.y, c)),
                average_by_quadrature(eta.0.z, |c| conductor(eta.0.z, k.0.z, c)),
            ),
        }
    }
}

/// F of a dielectric of index `eta` (far side over near side) at the cosine `c` in [0, 1].
#[inline]
pub(super) fn dielectric(eta: f64, c: f64) -> f64 {
    let excess = (eta - 1.0) * (eta + 1.0);
    let g2 = excess + c * c;
    if g2 <= 0.0 {
        // Total internal reflection; for η = 1 there is no boundary.
        return if excess < 0.0 { 1.0 } else { 0.0 };
    }
    let g = g2.sqrt();
    // c − g and η² c − g as differences of squares over sums: exact also where they are small.
    let rs = excess / ((c + g) * (c + g));
    let p = eta * eta * c + g;
    let rp = excess * ((eta * eta + 1.0) * c * c - 1.0) / (p * p);
    (0.5 * (rs * rs + rp * rp)).min(1.0)
}

/// 1 − F of a dielectric from both cosines, that of the far side `c_t` and that of the near side `c`: with all its digits
/// also where one of them is small, and the same from either side.
///
/// Ts = 4 η c c_t / (c + η c_t)², Tp = 4 η c c_t / (η c + c_t)².
#[inline]
pub(super) fn transmitted(eta: f64, c: f64, c_t: f64) -> f64 {
    let (s, p) = (c + eta * c_t, eta * c + c_t);
    (2.0 * eta * c * c_t * (1.0 / (s * s) + 1.0 / (p * p))).min(1.0)
}

fn conductor(eta: f64, k: f64, c: f64) -> f64 {
    if eta == 1.0 && k == 0.0 {
        return 0.0; // No boundary; at c = 0 the formulae would be 0/0.
    }
    let s2 = (1.0 - c) * (1.0 + c);
    let t = (eta - k) * (eta + k) - s2;
    let cross = 2.0 * eta * k;
    let whole = t.hypot(cross);
    // a² b² = (η k)²: the smaller of the two from the larger, so that nothing cancels.
    let larger = 0.5 * (whole + t.abs());
    let smaller = if larger > 0.0 { 0.25 * cross * cross / larger } else { 0.0 };
    let (a2, b2) = if t > 0.0 { (larger, smaller) } else { (smaller, larger) };
    let a = a2.sqrt();
    let (minus, plus) = (a - c, a + c);
    let rs = (minus * minus + b2) / (plus * plus + b2);
    let (minus, plus) = (a * c - s2, a * c + s2);
    let b2c2 = b2 * c * c;
    let rp = rs * (minus * minus + b2c2) / (plus * plus + b2c2);
    (0.5 * (rs + rp)).min(1.0)
}

/// F_avg of a dielectric in closed form, derived by integrating the exact formula; by quadrature next to η = 1, where
/// its terms cancel. Inside, F_avg(1/n) = 1 − (1 − F_avg(n)) / n²: what gets out is what gets in.
fn dielectric_average(eta: f64) -> f64 {
    if eta < 1.0 {
        return 1.0 - (1.0 - dielectric_average(1.0 / eta)) * eta * eta;
    }
    if eta < 1.05 {
        return average_by_quadrature(eta, |c| dielectric(eta, c));
    }
    let n = eta;
    let n2 = n * n;
    let n4 = n2 * n2;
    let (down, up) = (n2 - 1.0, n2 + 1.0);
    let log_ratio = ((n - 1.0) / (n + 1.0)).ln();
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0)) + n2 * down * down / (up * up * up) * log_ratio
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / (up * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / (up * (n4 - 1.0) * (n4 - 1.0)) * n.ln()
}

/// 2 ∫ F(c) c dc with c = x²: the structure of F next to grazing, of size √|η − 1|, is widened. For η < 1 the range is
/// cut at the critical angle, where F has a kink without absorption and nearly one with little.
fn average_by_quadrature(eta: f64, f: impl Fn(f64) -> f64) -> f64 {
    /// Far below what any integral over directions resolves.
    const TOL: f64 = 1e-13;
    let kink = if eta < 1.0 { ((1.0 - eta) * (1.0 + eta)).sqrt().sqrt() } else { 0.5 };
    adaptive(|x| [4.0 * f(x * x) * x * x * x], &[0.0, 0.5 * kink, kink, 1.0], TOL, 400).value[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    #[test]
    fn published_points() {
        let glass = Fresnel::Dielectric { eta: 1.5 };
        assert_abs_diff_eq!(glass.eval(1.0), Rgb::grey(0.04), epsilon = 1e-16);
        // cos 80° to the last digit; 15 digits are given.
        assert_abs_diff_eq!(glass.eval(80_f64.to_radians().cos()).0.x, 0.387704354691473, epsilon = 1e-14);
        // At Brewster's angle, tan θ = η, only rs is left: ((η² − 1)/(η² + 1))² / 2.
        let brewster = (1.25_f64 / 3.25).powi(2) / 2.0;
        assert_abs_diff_eq!(glass.eval(1.5_f64.atan().cos()).0.x, brewster, epsilon = 1e-15);
        assert_abs_diff_eq!(1.5_f64.atan().to_degrees(), 56.309932, epsilon = 5e-7);
    }

    #[test]
    fn averages_of_dielectrics_from_both_sides() {
        // Nine digits are given.
        for (n, outside, inside) in [
            (1.1, 0.025157357, 0.194344923),
            (1.33, 0.065930849, 0.471949149),
            (1.5, 0.091777959, 0.596345760),
            (2.0, 0.160596637, 0.790149159),
            (2.5, 0.221866574, 0.875498652),
        ] {
            assert_abs_diff_eq!(Fresnel::Dielectric { eta: n }.average().0.x, outside, epsilon = 6e-10);
            assert_abs_diff_eq!(Fresnel::Dielectric { eta: 1.0 / n }.average().0.x, inside, epsilon = 6e-10);
            // The two are independent: closed form and quadrature of the exact formula.
            let by_quadrature = average_by_quadrature(n, |c| dielectric(n, c));
            assert_abs_diff_eq!(by_quadrature, dielectric_average(n), epsilon = 1e-12);
            let by_quadrature = average_by_quadrature(1.0 / n, |c| dielectric(1.0 / n, c));
            assert_abs_diff_eq!(by_quadrature, dielectric_average(1.0 / n), epsilon = 1e-12);
        }
    }

    #[test]
    fn conductors_at_normal_incidence_and_on_average() {
        // Nine digits are given.
        for (eta, k, f0, average) in [
            (0.1431, 3.1247, 0.948294681, 0.947331150),
            (0.9582, 6.6902, 0.921124967, 0.911007451),
            (1.1797, 2.4, 0.551064727, 0.567355917),
        ] {
            let metal = Fresnel::Conductor { eta: eta.into(), k: k.into() };
            assert_abs_diff_eq!(metal.eval(1.0), Rgb::grey(f0), epsilon = 6e-10);
            assert_abs_diff_eq!(metal.average(), Rgb::grey(average), epsilon = 6e-10);
        }
    }

    #[test]
    fn schlick_averages_to_its_closed_form() {
        let schlick = Fresnel::Schlick { f0: Rgb::new(0.04, 0.5, 1.0) };
        let by_quadrature = average_by_quadrature(1.0, |c| schlick.eval(c).0.x);
        assert_abs_diff_eq!(schlick.average().0.x, by_quadrature, epsilon = 1e-13);
        assert!(Fresnel::MIRROR.average() == Rgb::WHITE && Fresnel::MIRROR.is_mirror());
    }

    #[test]
    fn grazing_reflection_is_total_and_its_slope_exact() {
        // Next to grazing F = 1 − 2 c (1 + η²)/√(η² − 1) + O(c²) for unpolarised light.
        for eta in [1.01, 1.5, 3.0] {
            let f = Fresnel::Dielectric { eta };
            // Two roundings, of g² and of its root, to the fourth power.
            assert_abs_diff_eq!(f.eval(0.0), Rgb::WHITE, epsilon = 2e-15);
            let slope = (1.0 - f.eval(1e-8).0.x) / 1e-8;
            let exact = 2.0 * (1.0 + eta * eta) / (eta * eta - 1.0).sqrt();
            assert!((slope / exact - 1.0).abs() < 1e-5, "{eta}: {slope} {exact}");
        }
        assert_eq!(Fresnel::Conductor { eta: 0.2.into(), k: 3.0.into() }.eval(0.0), Rgb::WHITE);
        assert_eq!(Fresnel::Dielectric { eta: 1.0 }.eval(0.0), Rgb::BLACK);
    }

    proptest! {
        #[test]
        fn a_conductor_that_absorbs_nothing_is_a_dielectric(eta in 0.3..4.0_f64, c in 0.0..=1.0_f64) {
            prop_assert!((conductor(eta, 0.0, c) - dielectric(eta, c)).abs() < 1e-7, "{eta} {c}");
        }

        #[test]
        fn what_is_not_reflected_is_transmitted(eta in 0.3..4.0_f64, c in 1e-3..=1.0_f64) {
            let root2 = (eta - 1.0) * (eta + 1.0) + c * c;
            prop_assume!(root2 > 1e-6);
            let t = transmitted(eta, c, root2.sqrt() / eta);
            // The root loses digits next to the critical angle, at most 1e-16 / 1e-6.
            prop_assert!((t - (1.0 - dielectric(eta, c))).abs() < 1e-9, "{eta} {c}: {t}");
        }

        #[test]
        fn reflectance_is_a_share(log_eta in -3.0..3.0_f64, log_k in -6.0..3.0_f64, c in -1.0..2.0_f64) {
            let (eta, k) = (10_f64.powf(log_eta), 10_f64.powf(log_k));
            for f in [Fresnel::Dielectric { eta }, Fresnel::Conductor { eta: eta.into(), k: k.into() }] {
                let value = f.eval(c);
                prop_assert!(value.min_channel() >= 0.0 && value.max_channel() <= 1.0 && value.is_finite(), "{f:?} {value}");
            }
        }
    }
}
