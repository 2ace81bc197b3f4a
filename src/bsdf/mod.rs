//! The one interface that every model of reflection implements, and the models.
//!
//! Local frame: the normal is +z. `wo` and `wi` are unit vectors that both point away from the surface; `wo` is known,
//! `wi` is sampled. [`Bsdf::eval`] is f [1/sr] **without** the cosine, [`Bsdf::pdf`] is a density per steradian, and
//! [`BsdfSample::weight`] is f |cos| / density. Opaque models are one-sided: black, 0 or None unless `wo.z` > 0 and
//! `wi.z` > 0. All three functions are total: no panic, no NaN, whatever the arguments.
//!
//! A model that transmits has an exterior, z > 0, and an interior, z < 0, whose index of refraction over that of the
//! exterior is [`Bsdf::eta`]. Light is carried as *basic radiance* L / η², which refraction leaves unchanged: an
//! interface that absorbs nothing has weights of mean 1 from either side, and one `eval` serves paths from the eye and
//! from lights. With η_a the index of the side on which a lies, reciprocity is f(a, b) / η_b² = f(b, a) / η_a².

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::math::color::Rgb;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

pub mod catalog;
pub mod ior;
pub mod measured;
pub mod microfacet;
pub mod subject;

mod ashikhmin_shirley;
mod blinn_phong;
mod burley;
#[cfg(test)]
mod contract;
mod custom;
mod dielectric;
mod disney;
mod eon;
mod fon;
mod fresnel;
mod half_vector;
mod lambert;
mod lommel_seeliger;
mod minnaert;
mod mix;
mod null;
mod oren_nayar;
mod param;
mod phong;
mod plastic;
mod refraction;
mod specular;
mod thin_dielectric;
mod two_sided;
mod ward;

pub use crate::sampling::stream::Uniforms;
pub use ashikhmin_shirley::AshikhminShirley;
pub use blinn_phong::{BlinnPhong, BlinnPhongNorm};
pub use burley::Burley;
pub use custom::FnBsdf;
pub use dielectric::Dielectric;
pub use disney::{Disney, DisneyParams};
pub use eon::Eon;
pub use fon::Fon;
pub use fresnel::Fresnel;
pub use lambert::Lambert;
pub use lommel_seeliger::LommelSeeliger;
pub use microfacet::{
    Beckmann, BeckmannNormals, Blinn, BlinnNormals, Compensation, Ggx, GgxNormals, Masking, Microfacet,
    RoughDielectric, RoughPlastic, Sampling,
};
pub use minnaert::Minnaert;
pub use mix::Mix;
pub use null::Null;
pub use oren_nayar::OrenNayar;
pub use param::{Domain, ParamError};
pub use phong::{Phong, PhongNorm, phong_a, phong_t};
pub use plastic::{InternalReflectance, Plastic};
pub use specular::SpecularReflector;
pub use thin_dielectric::ThinDielectric;
pub use two_sided::TwoSided;
pub use ward::{Ward, WardVariant};

pub(crate) use refraction::relative;

use microfacet::Normals;

/// A model of reflection at one point. [`eval`](Bsdf::eval) alone suffices; the rest has defaults that fit it.
pub trait Bsdf: fmt::Debug + Send + Sync {
    /// f(wo, wi) [1/sr], without the cosine. Dirac lobes contribute 0.
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb;

    /// Density [1/sr] with which [`sample`](Bsdf::sample) returns `wi`, given `wo`. Default: |cos| / π.
    ///
    /// Its integral is 1 less the probabilities of a lost draw and of Dirac lobes.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 { cosine_hemisphere_pdf(wi) } else { 0.0 }
    }

    /// Both [`eval`](Bsdf::eval) and [`pdf`](Bsdf::pdf), for models that share work between them.
    #[inline]
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        (self.eval(wo, wi), self.pdf(wo, wi))
    }

    /// Draws `wi` from uniforms: a pure function of `wo` and `u`. Default: cosine-weighted hemisphere.
    ///
    /// None is a lost draw: it counts as 0, and every estimator divides by the number of draws, lost ones included.
    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = cosine_hemisphere(u.dir);
        BsdfSample::new(wi, self.eval(wo, wi), cosine_hemisphere_pdf(wi))
    }

    /// What kinds of lobes there are. Default: reflection without Dirac parts.
    fn lobes(&self) -> Lobes {
        Lobes::REFLECT
    }

    /// Index of refraction of the interior (z < 0) over that of the exterior. Default: 1, as on both sides of a sheet.
    fn eta(&self) -> f64 {
        1.0
    }

    /// The directional albedo ∫ f |cos| dwi in closed form, where one is known: an oracle for quadrature.
    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        let _ = wo;
        None
    }

    /// Whether the model claims an albedo of exactly 1 in every direction, so that a white furnace must not show it.
    fn claims_lossless(&self) -> bool {
        false
    }

    /// The distribution of microfacet normals behind the model, if it is a microfacet model with Smith masking.
    fn normals(&self) -> Option<&dyn Normals> {
        None
    }
}

/// One draw of a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction drawn, unit length, away from the surface.
    pub wi: DVec3,
    /// f |cos| / density.
    pub weight: Rgb,
    /// The density with which `wi` is drawn.
    pub density: Density,
}

impl BsdfSample {
    /// The draw `wi` from f(wo, wi) and the density [1/sr] at it. None in the tangent plane or where the density is not
    /// positive and finite: a lost draw.
    pub fn new(wi: DVec3, f: Rgb, pdf: f64) -> Option<Self> {
        (wi.z.abs() > 0.0 && pdf > 0.0 && pdf.is_finite()).then(|| Self {
            wi,
            weight: f * (wi.z.abs() / pdf),
            density: Density::SolidAngle(pdf),
        })
    }
}

/// The measure of a sample's density. Multiple importance sampling takes only `SolidAngle`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Per steradian.
    SolidAngle(f64),
    /// A discrete probability: the direction is one of finitely many.
    Dirac(f64),
}

/// A set of kinds of lobes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(u8);

impl Lobes {
    /// Reflection: `wi` on the side of `wo`.
    pub const REFLECT: Self = Self(1);
    /// Transmission: `wi` on the other side.
    pub const TRANSMIT: Self = Self(2);
    /// At least one lobe is a Dirac delta.
    pub const DIRAC: Self = Self(4);

    /// Both sets together.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether every kind in `other` is in this set.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

macro_rules! forward_to_pointee {
    ($($pointer:ty),*) => {$(
        impl<B: Bsdf + ?Sized> Bsdf for $pointer {
            fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
                (**self).eval(wo, wi)
            }
            fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
                (**self).pdf(wo, wi)
            }
            fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
                (**self).eval_pdf(wo, wi)
            }
            fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
                (**self).sample(wo, u)
            }
            fn lobes(&self) -> Lobes {
                (**self).lobes()
            }
            fn eta(&self) -> f64 {
                (**self).eta()
            }
            fn albedo(&self, wo: DVec3) -> Option<Rgb> {
                (**self).albedo(wo)
            }
            fn claims_lossless(&self) -> bool {
                (**self).claims_lossless()
            }
            fn normals(&self) -> Option<&dyn Normals> {
                (**self).normals()
            }
        }
    )*};
}
forward_to_pointee!(&B, Box<B>, Arc<B>);
