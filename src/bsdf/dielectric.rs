//! A perfectly smooth interface of two transparent media: Dirac reflection and refraction.
//!
//! Lobes: ρ F in the mirror direction, τ (1 − F) in the refracted one, F = F(|wo.z|) from the side of `wo`. Light is
//! carried as L / η², so that neither has a factor η².
//!
//! `eta` is the index of the interior (z < 0) over that of the exterior; `reflect` = ρ and `transmit` = τ are colours in
//! [0, 1]. The lobe is chosen with its probability F or 1 − F: without tints the weight is 1, from either side.
//! # References
//! - Born & Wolf, Principles of Optics, 1.5

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::refraction::{ETA, relative};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Density, Domain, Lobes, ParamError, Uniforms, fresnel};
use crate::math::color::Rgb;
use crate::math::sphere::{flip, mirror, refract};

const TINT: Domain = Domain::Colour(0.0, 1.0);

/// The parameter `reflect` of all models that transmit.
pub(super) const REFLECT: ParamSpec = ParamSpec::new("reflect", TINT, "factor on what is reflected").or("1");
/// The parameter `transmit` of all models that transmit.
pub(super) const TRANSMIT: ParamSpec = ParamSpec::new("transmit", TINT, "factor on what is transmitted").or("1");

/// Factors on reflection and transmission, both in [0, 1] per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tints {
    pub(super) reflect: Rgb,
    pub(super) transmit: Rgb,
}

impl Tints {
    pub(super) const NONE: Self = Self { reflect: Rgb::WHITE, transmit: Rgb::WHITE };

    pub(super) fn new(model: &'static str, reflect: Rgb, transmit: Rgb) -> Result<Self, ParamError> {
        let reflect = TINT.check_colour(model, "reflect", reflect)?;
        Ok(Self { reflect, transmit: TINT.check_colour(model, "transmit", transmit)? })
    }
}

/// A smooth interface of two dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    eta: f64,
    tints: Tints,
}

impl Dielectric {
    /// Index of refraction `eta` in [1e-3, 1e3] of the interior over that of the exterior.
    pub fn new(eta: f64) -> Result<Self, ParamError> {
        Ok(Self { eta: ETA.check("dielectric", "eta", eta)?, tints: Tints::NONE })
    }

    /// The same with factors on what is reflected and what is transmitted, in [0, 1] per channel.
    pub fn with_tints(self, reflect: impl Into<Rgb>, transmit: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { tints: Tints::new("dielectric", reflect.into(), transmit.into())?, ..self })
    }
}

impl Bsdf for Dielectric {
    fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let eta = relative(self.eta, wo);
        // The tangent plane, and NaN, see neither side.
        Some(wo.z).filter(|z| z.abs() > 0.0)?;
        let f = fresnel::dielectric(eta, wo.z.abs());
        if u.lobe < f {
            return Some(BsdfSample { wi: mirror(wo), weight: self.tints.reflect, density: Density::Dirac(f) });
        }
        let upright = if wo.z < 0.0 { flip(wo) } else { wo };
        let wi = refract(upright, DVec3::Z, eta)?;
        let wi = if wo.z < 0.0 { flip(wi) } else { wi };
        Some(BsdfSample { wi, weight: self.tints.transmit, density: Density::Dirac(1.0 - f) })
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT.union(Lobes::TRANSMIT).union(Lobes::DIRAC)
    }

    fn eta(&self) -> f64 {
        self.eta
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        let f = fresnel::dielectric(relative(self.eta, wo), wo.z.abs());
        Some(self.tints.reflect * f + self.tints.transmit * (1.0 - f))
    }

    fn claims_lossless(&self) -> bool {
        self.tints == Tints::NONE
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "dielectric",
    summary: "smooth glass: Dirac reflection F and refraction 1 − F",
    params: &[
        ParamSpec::new("eta", ETA, "index of refraction of the interior over the exterior").or("1.5"),
        REFLECT,
        TRANSMIT,
    ],
    examples: &[
        Example::lawful("dielectric:eta=1.5"),
        Example::lawful("dielectric:eta=0.75"),
        Example::lawful("dielectric:eta=2.4,reflect=0.9,transmit=0.9/0.5/0.3"),
    ],
    build: |args| {
        let glass = Dielectric::new(args.number("eta")?)?;
        Ok(Box::new(glass.with_tints(args.colour("reflect")?, args.colour("transmit")?)?))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::assert_total;
    use super::*;
    use crate::math::sphere::direction;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn glass() -> Dielectric {
        Dielectric::new(1.5).unwrap()
    }

    #[test]
    fn lobes_have_the_probabilities_and_directions_of_the_textbook() {
        assert_total(&glass());
        let reflected = glass().sample(DVec3::Z, Uniforms::new(0.0399, 0.5, 0.5)).unwrap();
        // ((1.5 − 1)/(1.5 + 1))² = 0.04, to rounding.
        assert!(matches!(reflected.density, Density::Dirac(p) if (p - 0.04).abs() < 1e-16) && reflected.wi == DVec3::Z);
        let refracted = glass().sample(direction(0.5, 0.0), Uniforms::new(LAST, 0.5, 0.5)).unwrap();
        assert!((refracted.wi.x + 0.5_f64.sin() / 1.5).abs() < 1e-16 && refracted.wi.z < 0.0);
        assert_eq!(refracted.weight, Rgb::WHITE);
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected() {
        // sin 42° > 1/1.5 > sin 41°.
        let inside = |degrees: f64| direction(f64::to_radians(180.0 - degrees), 1.0);
        let beyond = glass().sample(inside(42.0), Uniforms::new(LAST, 0.5, 0.5)).unwrap();
        assert_eq!((beyond.wi, beyond.density), (mirror(inside(42.0)), Density::Dirac(1.0)));
        assert!(glass().sample(inside(41.0), Uniforms::new(LAST, 0.5, 0.5)).unwrap().wi.z > 0.0);
    }

    #[test]
    fn the_way_back_has_the_same_share() {
        for theta in [0.0, 0.3, 1.0, 1.5] {
            let wo = direction(theta, 0.4);
            let there = glass().sample(wo, Uniforms::new(LAST, 0.5, 0.5)).unwrap();
            let back = glass().sample(there.wi, Uniforms::new(LAST, 0.5, 0.5)).unwrap();
            let (Density::Dirac(p), Density::Dirac(q)) = (there.density, back.density) else { panic!() };
            // At 1.5 the rounding of the inner cosine is magnified by the cosines' ratio, about 10, and F by its slope.
            assert!((p - q).abs() < 1e-13 && (back.wi - wo).length() < 1e-13, "{theta}: {p} {q} {}", back.wi);
        }
    }

    #[test]
    fn equal_media_have_no_interface() {
        let draw = Dielectric::new(1.0).unwrap().sample(direction(1.2, 0.0), Uniforms::new(0.0, 0.5, 0.5)).unwrap();
        assert!((draw.wi + direction(1.2, 0.0)).length() < 1e-15 && draw.density == Density::Dirac(1.0));
    }
}
