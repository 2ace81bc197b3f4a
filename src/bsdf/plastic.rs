//! A diffuse base under a smooth dielectric coat.
//!
//! Dirac lobe ρs F(wo.z) in the mirror direction, and f = ρd (1 − F(wo.z)) (1 − F(wi.z)) / (π η² (1 − x Fi))      [1/sr].
//! Light enters through the coat, is scattered, and leaves; of what meets the coat from below Fi is reflected back to the
//! base, any number of times. Fi = F_avg(1/η) is the average reflectance from inside, and x = ρd (`nonlinear`, where each
//! return is coloured once more) or 1. Albedo: ρs F + ρd (1 − F)(1 − F_avg(η)) / (η² (1 − x Fi)), which is 1 for
//! ρs = ρd = 1, since (1 − F_avg(η)) / η² = 1 − Fi.
//!
//! `eta` is the index of the coat over the exterior, `rho` = ρd, `reflect` = ρs. With `internal=mitsuba` Fi is the
//! fit 0.0636 η − 1.4399/η² + 0.7099/η + 0.6681 that this renderer uses; at η = 1.5 it is 5e-4 too large, and white
//! plastic gains energy.
//! The Dirac lobe is picked with probability in proportion to F, weighted by the mean colours.
//! # References
//! - Saunderson 1942, JOSA 32 (internal reflection); Jensen et al. 2001, SIGGRAPH (F_avg at the boundary)
//! - Egan & Hilgeman 1979, Optical Properties of Inhomogeneous Materials (the fit, of 1973)

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::dielectric::REFLECT;
use super::refraction::ETA;
use super::subject::{Args, ParamSpec, SubjectError};
use super::{Bsdf, BsdfSample, Density, Domain, Fresnel, Lobes, ParamError, Uniforms, fresnel};
use crate::math::color::Rgb;
use crate::math::sphere::mirror;
use crate::sampling::discrete::pick;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

const RHO: Domain = Domain::Colour(0.0, 1.0);

/// The parameter `eta` of both plastics.
pub(super) const COAT: ParamSpec = ParamSpec::new("eta", ETA, "index of refraction of the coat").or("1.5");
/// The parameter `rho` of both plastics.
pub(super) const BASE: ParamSpec = ParamSpec::new("rho", RHO, "reflectance of the diffuse base").or("0.5");
/// The parameter `nonlinear` of both plastics.
pub(super) const NONLINEAR: ParamSpec =
    ParamSpec::new("nonlinear", Domain::Word(&["false", "true"]), "whether each internal return is coloured anew")
        .or("false");

/// The parameter `internal` of both plastics.
pub(super) const INTERNAL: ParamSpec =
    ParamSpec::new("internal", Domain::Word(&["exact", "mitsuba"]), "average reflectance from inside").or("exact");

/// Where the average reflectance of the coat from inside comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InternalReflectance {
    /// From Fresnel's formulae.
    #[default]
    Exact,
    /// As Mitsuba 3 has it, to reproduce its images: a fit for smooth plastic, a coarse sum for rough.
    Mitsuba,
}

impl InternalReflectance {
    /// That of `internal`.
    pub(super) fn of(args: &Args) -> Result<Self, SubjectError> {
        Ok(if args.word("internal")? == "mitsuba" { Self::Mitsuba } else { Self::Exact })
    }
}

/// What lies below the coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Base {
    pub(super) rho: Rgb,
    pub(super) nonlinear: bool,
    /// Share of the light from below that the coat reflects back, Fi.
    pub(super) internal: f64,
    /// 1 / η²: from outside only this share of directions below leads out.
    pub(super) inv_eta2: f64,
}

impl Base {
    /// ρd / (η² (1 − x Fi)): the base with all returns, per transmittances.
    pub(super) fn reflectance(&self) -> Rgb {
        let factor = |rho: f64| {
            let returned = if self.nonlinear { rho * self.internal } else { self.internal };
            rho * self.inv_eta2 / (1.0 - returned)
        };
        self.rho.map(factor)
    }
}

/// Probabilities of the specular and the diffuse lobe where the coat reflects `share`.
pub(super) fn probabilities(share: f64, reflect: Rgb, rho: Rgb) -> [f64; 2] {
    let (specular, diffuse) = (share * reflect.mean(), (1.0 - share) * rho.mean());
    let total = specular + diffuse;
    if total > 0.0 { [specular / total, diffuse / total] } else { [0.0, 0.0] }
}

/// A diffuse base under a smooth dielectric coat. See the module for the formulae.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    eta: f64,
    reflect: Rgb,
    base: Base,
}

impl Plastic {
    /// A coat of index `eta` in [1e-3, 1e3] on a base of reflectance `rho` in [0, 1] per channel, linear.
    pub fn new(eta: f64, rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        let eta = ETA.check("plastic", "eta", eta)?;
        let rho = RHO.check_colour("plastic", "rho", rho.into())?;
        let base = Base { rho, nonlinear: false, internal: 0.0, inv_eta2: 1.0 / (eta * eta) };
        Self { eta, reflect: Rgb::WHITE, base }.with_internal_reflectance(InternalReflectance::Exact)
    }

    /// The same with a factor on the specular reflection, in [0, 1] per channel.
    pub fn with_tint(self, reflect: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { reflect: RHO.check_colour("plastic", "reflect", reflect.into())?, ..self })
    }

    /// The same on another base, of reflectance `rho` in [0, 1] per channel.
    pub fn with_rho(self, rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        let rho = RHO.check_colour("plastic", "rho", rho.into())?;
        Ok(Self { base: Base { rho, ..self.base }, ..self })
    }

    /// The same where each internal return is coloured anew by the base.
    pub fn with_nonlinear(self, nonlinear: bool) -> Self {
        Self { base: Base { nonlinear, ..self.base }, ..self }
    }

    /// The same with this internal reflectance. Mitsuba's fit is for `eta` in [1, 3]; an error outside.
    pub fn with_internal_reflectance(self, source: InternalReflectance) -> Result<Self, ParamError> {
        let eta = self.eta;
        let internal = match source {
            InternalReflectance::Exact => Fresnel::Dielectric { eta: 1.0 / eta }.average().0.x,
            InternalReflectance::Mitsuba => {
                Domain::Closed(1.0, 3.0).check("plastic", "eta", eta)?;
                0.0636 * eta - 1.4399 / (eta * eta) + 0.7099 / eta + 0.6681
            }
        };
        Ok(Self { base: Base { internal, ..self.base }, ..self })
    }

    fn share(&self, w: DVec3) -> f64 {
        fresnel::dielectric(self.eta, w.z)
    }
}

impl Bsdf for Plastic {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if wo.z > 0.0 && wi.z > 0.0 {
            self.base.reflectance() * ((1.0 - self.share(wo)) * (1.0 - self.share(wi)) * FRAC_1_PI)
        } else {
            Rgb::BLACK
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 {
            let [_, diffuse] = probabilities(self.share(wo), self.reflect, self.base.rho);
            diffuse * cosine_hemisphere_pdf(wi)
        } else {
            0.0
        }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let above = Some(wo).filter(|wo| wo.z > 0.0)?;
        let share = self.share(above);
        let (lobe, probability, _) = pick(&probabilities(share, self.reflect, self.base.rho), u.lobe)?;
        if lobe == 0 {
            let weight = self.reflect * (share / probability);
            return Some(BsdfSample { wi: mirror(wo), weight, density: Density::Dirac(probability) });
        }
        let wi = cosine_hemisphere(u.dir);
        BsdfSample::new(wi, self.eval(wo, wi), probability * cosine_hemisphere_pdf(wi))
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT.union(Lobes::DIRAC)
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        if wo.z <= 0.0 {
            return Some(Rgb::BLACK);
        }
        let entering = 1.0 - Fresnel::Dielectric { eta: self.eta }.average().0.x;
        let share = self.share(wo);
        Some(self.reflect * share + self.base.reflectance() * ((1.0 - share) * entering))
    }

    fn claims_lossless(&self) -> bool {
        self.reflect == Rgb::WHITE && self.base.rho == Rgb::WHITE
    }
}

/// Whether `nonlinear` was asked for.
pub(super) fn nonlinear(args: &Args) -> Result<bool, SubjectError> {
    Ok(args.word("nonlinear")? == "true")
}

pub(super) const ENTRY: Entry = Entry {
    name: "plastic",
    summary: "diffuse base under a smooth coat: Dirac reflection and what the coat lets through",
    params: &[BASE, COAT, REFLECT, NONLINEAR, INTERNAL],
    examples: &[
        Example::lawful("plastic:rho=0.5/0.3/0.1"),
        Example::lawful("plastic:rho=1"),
        Example::lawful("plastic:rho=1/0.8/0.5,eta=1.9,nonlinear=true,reflect=0.8"),
        // The fit reflects 5e-4 too much from inside, of which 1 − Fi = 0.4 is what a return is divided by.
        Example::breaking("plastic:rho=1,internal=mitsuba", &["energy_eye", "energy_light", "white_furnace"]),
    ],
    build: |args| {
        let plastic = Plastic::new(args.number("eta")?, args.colour("rho")?)?.with_nonlinear(nonlinear(args)?);
        let plastic = plastic.with_tint(args.colour("reflect")?)?;
        Ok(Box::new(plastic.with_internal_reflectance(InternalReflectance::of(args)?)?))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::*;
    use crate::math::sphere::direction;

    const RHO: [f64; 3] = [0.5, 0.2, 0.8];

    fn plastic() -> Plastic {
        Plastic::new(1.5, Rgb::from(RHO)).unwrap()
    }

    #[test]
    fn total_at_the_edges() {
        for eta in [1.0, 1.5, 0.5, 1e3] {
            assert_total(&Plastic::new(eta, 0.9).unwrap());
        }
        assert_total(&Plastic::new(1.5, 0.0).unwrap().with_tint(0.0).unwrap());
        assert_sampled_exactly(&plastic(), &[1.0, 0.2]);
        assert_albedo(&plastic(), &[1.0, 0.2, 0.01], 1e-7);
    }

    #[test]
    fn white_plastic_loses_nothing() {
        for eta in [1.0, 1.3, 1.5, 2.5] {
            for nonlinear in [false, true] {
                let white = Plastic::new(eta, 1.0).unwrap().with_nonlinear(nonlinear);
                for theta in [0.0, 0.7, 1.5] {
                    // Two averages, from closed form and quadrature, each to 1e-12.
                    let albedo = white.albedo(direction(theta, 0.0)).unwrap();
                    assert!((albedo - Rgb::WHITE).0.abs().max_element() < 1e-11, "{eta} {theta}: {albedo}");
                }
            }
        }
    }

    /// `plastic` (int_ior 1.5, ext_ior 1, diffuse_reflectance .5 .2 .8) in Mitsuba 3.9.1, scalar_rgb: (θo, φo, θi, φi) in
    /// degrees, f linear, f nonlinear (first channel), pdf.
    const MITSUBA: [([f64; 4], [f64; 3], f64, f64); 3] = [
        ([30.0, 10.0, 40.0, 200.0], [0.16046505, 0.064186024, 0.256744096], 0.0922152913, 0.224397078),
        ([60.0, 0.0, 50.0, 170.0], [0.150579084, 0.0602316324, 0.24092653], 0.0865340614, 0.17109789),
        ([10.0, 0.0, 85.0, 90.0], [0.0652122194, 0.0260848878, 0.104339551], 0.0374758444, 0.0256076995),
    ];

    #[test]
    fn f_and_pdf_are_those_of_another_renderer() {
        let fitted = plastic().with_internal_reflectance(InternalReflectance::Mitsuba).unwrap();
        for ([theta_o, phi_o, theta_i, phi_i], linear, nonlinear, pdf) in MITSUBA {
            let at = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
            let (wo, wi) = (at(theta_o, phi_o), at(theta_i, phi_i));
            // Single precision.
            let gap = (fitted.eval(wo, wi) - Rgb::from(linear)).0.abs().max_element();
            assert!(gap < 1e-6 && (fitted.pdf(wo, wi) - pdf).abs() < 1e-6, "{theta_o} {theta_i}: {gap}");
            let gap = fitted.with_nonlinear(true).eval(wo, wi).0.x - nonlinear;
            assert!(gap.abs() < 1e-6, "{theta_o} {theta_i}: {gap}");
            // The fit is 5e-4 off, of 1 − Fi = 0.4.
            let gap = (plastic().eval(wo, wi) - Rgb::from(linear)).0.abs().max_element();
            assert!(gap < 2e-3 * linear[2], "{theta_o} {theta_i}: {gap}");
        }
    }

    #[test]
    fn both_lobes_share_the_draws_and_the_mean_weight_is_the_albedo() {
        let (wo, n) = (direction(1.2, 0.3), 100_000);
        let mut rng = crate::sampling::stream::stream(4, 0, 0);
        let mut sum = Rgb::BLACK;
        for _ in 0..n {
            let s = plastic().sample(wo, crate::sampling::stream::uniforms(&mut rng)).unwrap();
            sum += s.weight;
            if let Density::SolidAngle(p) = s.density {
                assert!((p / plastic().pdf(wo, s.wi) - 1.0).abs() < 1e-14);
            }
        }
        let gap = sum / f64::from(n) - plastic().albedo(wo).unwrap();
        // Weights spread by less than 1: five standard errors.
        assert!(gap.0.abs().max_element() < 5.0 / f64::from(n).sqrt(), "{gap}");
    }
}
