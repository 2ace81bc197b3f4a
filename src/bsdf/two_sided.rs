//! Gives a one-sided model a back that looks like its front.

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::microfacet::Normals;
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Domain, Lobes, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::flip;

/// A model seen from both sides: below the horizon, both directions are mirrored in the tangent plane.
///
/// Mirrored, not rotated: the tangent keeps its direction, as it does on a thin sheet. `wo` in the tangent plane sees
/// nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSided<B> {
    front: B,
}

impl<B: Bsdf> TwoSided<B> {
    /// Both sides like `front`, a model of reflection.
    pub fn new(front: B) -> Self {
        Self { front }
    }
}

/// `w` as seen from the side of `wo`.
fn seen_from(wo: DVec3, w: DVec3) -> DVec3 {
    if wo.z < 0.0 { flip(w) } else { w }
}

impl<B: Bsdf> Bsdf for TwoSided<B> {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.front.eval(seen_from(wo, wo), seen_from(wo, wi))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.front.pdf(seen_from(wo, wo), seen_from(wo, wi))
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let draw = self.front.sample(seen_from(wo, wo), u)?;
        Some(BsdfSample { wi: seen_from(wo, draw.wi), ..draw })
    }

    fn lobes(&self) -> Lobes {
        self.front.lobes()
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        self.front.albedo(seen_from(wo, wo))
    }

    fn claims_lossless(&self) -> bool {
        self.front.claims_lossless()
    }

    fn normals(&self) -> Option<&dyn Normals> {
        self.front.normals()
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "two-sided",
    summary: "a model of reflection on both sides of the surface",
    params: &[ParamSpec::new("front", Domain::Subject, "what both sides look like")],
    examples: &[
        Example::lawful("two-sided:front=(ggx:alpha_x=0.1,alpha_y=0.4)"),
        Example::lawful("two-sided:front=(plastic:rho=0.8)"),
    ],
    build: |args| {
        let front = args.subject("front")?;
        if front.lobes().contains(Lobes::TRANSMIT) {
            let given = args.text("front")?.to_owned();
            return Err(ParamError::new("two-sided", "front", given, "a model that does not transmit").into());
        }
        Ok(Box::new(TwoSided::new(front)))
    },
};

#[cfg(test)]
mod tests {
    use super::super::{Density, Phong, PhongNorm};
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn glass_has_two_sides_of_its_own() {
        let error = super::super::subject::parse("two-sided:front=(null)").unwrap_err().to_string();
        assert_eq!(error, "two-sided: front = null is not allowed; allowed is a model that does not transmit");
    }

    #[test]
    fn the_back_is_the_mirror_image_of_the_front() {
        let phong = Phong::new(20.0, 0.1, 0.5, PhongNorm::AlbedoNPlus2).unwrap();
        let sheet = TwoSided::new(phong);
        let below = |w: DVec3| DVec3::new(w.x, w.y, -w.z);
        let (wo, wi) = (direction(0.6, 0.2), direction(0.5, 3.0));
        assert_eq!(sheet.eval(wo, wi), phong.eval(wo, wi));
        assert_eq!(sheet.eval(below(wo), below(wi)), phong.eval(wo, wi));
        assert_eq!(sheet.pdf(below(wo), below(wi)), phong.pdf(wo, wi));
        assert_eq!(sheet.albedo(below(wo)), phong.albedo(wo));
        assert!(sheet.eval(below(wo), wi).is_black() && sheet.eval(wo, below(wi)).is_black());
        let draw = sheet.sample(below(wo), Uniforms::new(0.9, 0.1, 0.2)).unwrap();
        assert!(draw.wi.z < 0.0);
        assert_eq!(draw.density, Density::SolidAngle(sheet.pdf(below(wo), draw.wi)));
        assert!(sheet.sample(DVec3::X, Uniforms::new(0.9, 0.1, 0.2)).is_none());
    }
}
