//! No surface at all: light passes straight through. What an opacity mask mixes with.
//!
//! f(wo, wi) |wi.z| = δ(wi + wo),  albedo 1

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::{Bsdf, BsdfSample, Density, Lobes, Uniforms};
use crate::math::color::Rgb;

/// A surface that is not there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Null;

impl Bsdf for Null {
    fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, _: Uniforms) -> Option<BsdfSample> {
        (wo.z.abs() > 0.0).then_some(BsdfSample { wi: -wo, weight: Rgb::WHITE, density: Density::Dirac(1.0) })
    }

    fn lobes(&self) -> Lobes {
        Lobes::TRANSMIT.union(Lobes::DIRAC)
    }

    fn albedo(&self, _: DVec3) -> Option<Rgb> {
        Some(Rgb::WHITE)
    }

    fn claims_lossless(&self) -> bool {
        true
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "null",
    summary: "no surface: light passes straight through",
    params: &[],
    examples: &[Example::lawful("null"), Example::lawful("mix:a=(null),b=(ggx:alpha=0.3),t=0.4")],
    build: |_| Ok(Box::new(Null)),
};

#[cfg(test)]
mod tests {
    use super::super::contract::assert_total;
    use super::super::{Lambert, Mix};
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn everything_passes_from_both_sides() {
        assert_total(&Null);
        for wo in [direction(0.4, 1.0), direction(2.4, 1.0)] {
            let draw = Null.sample(wo, Uniforms::new(0.1, 0.2, 0.3)).unwrap();
            assert_eq!((draw.wi, draw.weight, draw.density), (-wo, Rgb::WHITE, Density::Dirac(1.0)));
        }
    }

    #[test]
    fn an_opacity_mask_is_a_mixture_with_nothing() {
        let lambert: Box<dyn Bsdf> = Box::new(Lambert::new(0.5).unwrap());
        let mask = Mix::new([(0.75, lambert), (0.25, Box::new(Null) as Box<dyn Bsdf>)]).unwrap();
        let wo = direction(0.4, 1.0);
        let passed = mask.sample(wo, Uniforms::new(0.8, 0.2, 0.3)).unwrap();
        assert_eq!((passed.wi, passed.weight, passed.density), (-wo, Rgb::WHITE, Density::Dirac(0.25)));
        // 0.75 · 0.5 + 0.25, all of them powers of 2.
        assert_eq!(mask.albedo(wo), Some(Rgb::grey(0.625)));
    }
}
