//! Mistakes at interfaces: with transmission, with Dirac lobes, and below the surface.

use glam::DVec3;

use super::flaw::flaws;
use crate::bsdf::{BsdfSample, Density, Fresnel, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::{flip, refract};
use crate::sampling::warp::cosine_hemisphere_pdf;

/// Whether light goes from one side to the other.
fn crosses(wo: DVec3, wi: DVec3) -> bool {
    wo.z * wi.z < 0.0
}

/// The index on the side of `w`, over that of the exterior, for an interior of index `eta`.
fn index(eta: f64, w: DVec3) -> f64 {
    if w.z < 0.0 { eta } else { 1.0 }
}

flaws! {
    /// Carries L where the renderer carries L / η²: f η_o² / η_i², of all lobes.
    CarriesRadiance() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * (index(self.0.eta(), wo) / index(self.0.eta(), wi)).powi(2)
        }
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            let factor = (index(self.0.eta(), wo) / index(self.0.eta(), s.wi)).powi(2);
            Some(BsdfSample { weight: s.weight * factor, ..s })
        }
    }

    /// Takes η for 1/η from inside: the interior is another exterior.
    SameIndexInside() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            if wo.z < 0.0 { self.0.eval(flip(wo), flip(wi)) } else { self.0.eval(wo, wi) }
        }
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            if wo.z < 0.0 { self.0.pdf(flip(wo), flip(wi)) } else { self.0.pdf(wo, wi) }
        }
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            if wo.z < 0.0 {
                self.0.sample(flip(wo), u).map(|s| BsdfSample { wi: flip(s.wi), ..s })
            } else {
                self.0.sample(wo, u)
            }
        }
    }

    /// Has the 1 / (4 wo·m) of reflection in the density of what is refracted.
    ReflectionJacobian() {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            let pdf = self.0.pdf(wo, wi);
            if !crosses(wo, wi) {
                return pdf;
            }
            let eta = index(self.0.eta(), wi) / index(self.0.eta(), wo);
            let h = wo + eta * wi;
            let m = h.normalize_or(DVec3::Z);
            pdf * h.length_squared() / (4.0 * (wo.dot(m) * wi.dot(m)).abs() * eta * eta)
        }
    }

    /// Forgets that |cosθ| is meant: below the surface the weight is negative.
    SignedCosine() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            self.0.sample(wo, u).map(|s| BsdfSample { weight: s.weight * s.wi.z.signum(), ..s })
        }
    }

    /// Claims the probability of its Dirac lobes times a constant.
    DiracProbabilityOff(f64) {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            Some(match s.density {
                Density::Dirac(p) => BsdfSample { density: Density::Dirac(p * self.1), weight: s.weight / self.1, ..s },
                Density::SolidAngle(_) => s,
            })
        }
    }

    /// Refracts with the inverse index: away from the normal where it should be towards it.
    InverseSnell() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            if !crosses(wo, s.wi) {
                return Some(s);
            }
            let wrong = index(self.0.eta(), wo) / index(self.0.eta(), s.wi);
            let (upright, below) = if wo.z < 0.0 { (flip(wo), true) } else { (wo, false) };
            let wi = refract(upright, DVec3::Z, wrong)?;
            Some(BsdfSample { wi: if below { flip(wi) } else { wi }, ..s })
        }
    }

    /// Multiplies the tangential part of what passes downwards by a number, and divides it on the way up: the shares
    /// agree, the étendue is another.
    SqueezedBeam(f64) {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            if !crosses(wo, s.wi) {
                return Some(s);
            }
            let factor = if wo.z > 0.0 { self.1 } else { 1.0 / self.1 };
            let (x, y) = (s.wi.x * factor, s.wi.y * factor);
            let z2 = 1.0 - x * x - y * y;
            (z2 > 0.0).then(|| BsdfSample { wi: DVec3::new(x, y, z2.sqrt().copysign(s.wi.z)), ..s })
        }
    }

    /// Lets nothing through from below.
    OneWay() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            self.0.sample(wo, u).filter(|s| wo.z > 0.0 || !crosses(wo, s.wi))
        }
    }

    /// Forgets the Fresnel transmittance of the way out, of a coat of this index.
    FreeExit(f64) {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            let through = 1.0 - Fresnel::Dielectric { eta: self.1 }.eval(wi.z).0.x;
            if through > 0.0 { self.0.eval(wo, wi) / through } else { Rgb::BLACK }
        }
    }

    /// Claims the whole cosine density for the diffuse lobe, as if no other were ever drawn.
    UnsharedPdf() {
        fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
            if wo.z > 0.0 { cosine_hemisphere_pdf(wi) } else { 0.0 }
        }
    }

    /// f times a constant where it is seen from below.
    GainFromBelow(f64) {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * if wo.z < 0.0 { self.1 } else { 1.0 }
        }
    }
}
