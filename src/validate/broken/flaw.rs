//! What all wrappers with one mistake share.

use std::fmt;

use glam::DVec3;

use crate::bsdf::{Bsdf, BsdfSample, Density, Lobes, Uniforms};
use crate::math::color::Rgb;

/// A model that is another one but for what is overridden here.
pub(super) trait Flaw: fmt::Debug + Send + Sync {
    fn original(&self) -> &dyn Bsdf;

    fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.original().eval(wo, wi)
    }

    fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.original().pdf(wo, wi)
    }

    /// The direction that is drawn.
    fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
        self.original().sample(wo, u).map(|s| s.wi)
    }

    /// The draw, consistent with `f` and `density` unless overridden. Draws of Dirac lobes are left as they are.
    fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if self.original().lobes().contains(Lobes::DIRAC) {
            let sample = self.original().sample(wo, u)?;
            if matches!(sample.density, Density::Dirac(_)) {
                return Some(sample);
            }
        }
        let wi = self.direction(wo, u)?;
        BsdfSample::new(wi, self.f(wo, wi), self.density(wo, wi))
    }

    fn closed_albedo(&self, wo: DVec3) -> Option<Rgb> {
        self.original().albedo(wo)
    }

    fn claim(&self) -> bool {
        self.original().claims_lossless()
    }
}

/// Defines wrappers `Name(pub original, pub numbers…)` from what they override of [`Flaw`].
macro_rules! flaws {
    ($($(#[$doc:meta])* $name:ident($($number:ty),*) { $($item:item)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name<B>(pub B $(, pub $number)*);

        impl<B: $crate::bsdf::Bsdf> $crate::validate::broken::flaw::Flaw for $name<B> {
            fn original(&self) -> &dyn $crate::bsdf::Bsdf {
                &self.0
            }
            $($item)*
        }

        impl<B: $crate::bsdf::Bsdf> $crate::bsdf::Bsdf for $name<B> {
            fn eval(&self, wo: glam::DVec3, wi: glam::DVec3) -> $crate::math::color::Rgb {
                $crate::validate::broken::flaw::Flaw::f(self, wo, wi)
            }
            fn pdf(&self, wo: glam::DVec3, wi: glam::DVec3) -> f64 {
                $crate::validate::broken::flaw::Flaw::density(self, wo, wi)
            }
            fn sample(&self, wo: glam::DVec3, u: $crate::bsdf::Uniforms) -> Option<$crate::bsdf::BsdfSample> {
                $crate::validate::broken::flaw::Flaw::draw(self, wo, u)
            }
            fn lobes(&self) -> $crate::bsdf::Lobes {
                self.0.lobes()
            }
            fn eta(&self) -> f64 {
                self.0.eta()
            }
            fn albedo(&self, wo: glam::DVec3) -> Option<$crate::math::color::Rgb> {
                $crate::validate::broken::flaw::Flaw::closed_albedo(self, wo)
            }
            fn claims_lossless(&self) -> bool {
                $crate::validate::broken::flaw::Flaw::claim(self)
            }
            fn normals(&self) -> Option<&dyn $crate::bsdf::microfacet::Normals> {
                self.0.normals()
            }
        }
    )*};
}
pub(super) use flaws;
