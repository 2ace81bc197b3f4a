//! A convex combination of models.
//!
//! f = Σ tₖ fₖ      [1/sr],  Σ tₖ = 1
//!
//! Reciprocity and energy conservation pass from the parts to the mixture. Sampled by choosing part k with probability
//! tₖ and then its own sampler; the density is the full mixture Σ tₖ pₖ, whichever part was chosen.

use glam::DVec3;

use super::catalog::{Entry, Example};
use super::subject::ParamSpec;
use super::{Bsdf, BsdfSample, Density, Domain, Lobes, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::discrete::pick;

const WEIGHT: Domain = Domain::AtLeast(0.0);
const T: Domain = Domain::Closed(0.0, 1.0);

/// A convex combination of any number of models.
#[derive(Debug)]
pub struct Mix {
    parts: Vec<Box<dyn Bsdf>>,
    /// tₖ, of sum 1.
    weights: Vec<f64>,
}

impl Mix {
    /// Parts with weights ≥ 0, which are divided by their sum. At least one must be positive; parts of weight 0 are
    /// dropped.
    pub fn new(parts: impl IntoIterator<Item = (f64, Box<dyn Bsdf>)>) -> Result<Self, ParamError> {
        let (mut weights, mut kept) = (Vec::new(), Vec::new());
        for (weight, part) in parts {
            if WEIGHT.check("mix", "weight", weight)? > 0.0 {
                weights.push(weight);
                kept.push(part);
            }
        }
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(ParamError::new("mix", "sum of weights", total, Domain::Positive));
        }
        for weight in &mut weights {
            *weight /= total;
        }
        Ok(Self { parts: kept, weights })
    }

    fn weighted(&self) -> impl Iterator<Item = (f64, &dyn Bsdf)> {
        self.weights.iter().copied().zip(self.parts.iter().map(AsRef::as_ref))
    }
}

impl Bsdf for Mix {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.weighted().map(|(t, part)| part.eval(wo, wi) * t).sum()
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.weighted().map(|(t, part)| t * part.pdf(wo, wi)).sum()
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let (k, t, fresh) = pick(&self.weights, u.lobe)?;
        let draw = self.parts[k].sample(wo, Uniforms { lobe: fresh, ..u })?;
        match draw.density {
            // The other parts have no share in a delta: t in f and t in the probability cancel.
            Density::Dirac(p) => Some(BsdfSample { density: Density::Dirac(t * p), ..draw }),
            Density::SolidAngle(_) => BsdfSample::new(draw.wi, self.eval(wo, draw.wi), self.pdf(wo, draw.wi)),
        }
    }

    fn lobes(&self) -> Lobes {
        let lobes = self.parts.iter().map(Bsdf::lobes);
        lobes.reduce(Lobes::union).unwrap_or(Lobes::REFLECT)
    }

    /// That of the first part whose sides differ. Where others differ otherwise, no index makes the mixture reciprocal.
    fn eta(&self) -> f64 {
        self.parts.iter().map(Bsdf::eta).find(|&eta| eta != 1.0).unwrap_or(1.0)
    }

    fn albedo(&self, wo: DVec3) -> Option<Rgb> {
        self.weighted().map(|(t, part)| part.albedo(wo).map(|albedo| albedo * t)).sum()
    }

    fn claims_lossless(&self) -> bool {
        self.parts.iter().all(Bsdf::claims_lossless)
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "mix",
    summary: "(1 − t) a + t b of two subjects",
    params: &[
        ParamSpec::new("a", Domain::Subject, "first subject"),
        ParamSpec::new("b", Domain::Subject, "second subject"),
        ParamSpec::new("t", T, "share of b").or("0.5"),
    ],
    examples: &[
        Example::lawful("mix:a=(lambert:rho=0.5),b=(phong:n=50,kd=0,ks=1,norm=n+2),t=0.3"),
        Example::lawful("mix:a=(lambert:rho=1),b=(eon:rho=1,r=0.7),t=0.5"),
        Example::lawful("mix:a=(fon:rho=0.8,r=1),b=(mix:a=(lommel-seeliger),b=(minnaert:rho=0.9,k=3),t=0.2),t=0.6"),
        // At the normal 0.5 · 0.8 + 0.5 · 1.500671491 > 1.
        Example::breaking(
            "mix:a=(lambert:rho=0.8),b=(blinn-phong:n=10,kd=0,ks=1,norm=none),t=0.5",
            &["energy_eye", "energy_light"],
        ),
    ],
    build: |args| {
        let t = args.number("t")?;
        Ok(Box::new(Mix::new([(1.0 - t, args.subject("a")?), (t, args.subject("b")?)])?))
    },
};

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_albedo, assert_sampled_exactly, assert_total};
    use super::super::{Lambert, Phong, PhongNorm};
    use super::*;
    use crate::math::sphere::direction;
    use approx::assert_abs_diff_eq;

    fn lambert(rho: f64) -> Box<dyn Bsdf> {
        Box::new(Lambert::new(rho).unwrap())
    }

    fn phong(n: f64) -> Box<dyn Bsdf> {
        Box::new(Phong::new(n, 0.0, 1.0, PhongNorm::AlbedoNPlus2).unwrap())
    }

    #[test]
    fn three_parts_obey_the_contract() {
        let mix = Mix::new([(2.0, lambert(0.5)), (1.0, phong(10.0)), (1.0, phong(300.0)), (0.0, phong(1.0))]).unwrap();
        assert_total(&mix);
        assert_sampled_exactly(&mix, &[1.0, 0.5, 0.05]);
        assert_albedo(&mix, &[1.0, 0.5, 0.05], 1e-7);
        let at_normal = mix.albedo(DVec3::Z).unwrap();
        assert_abs_diff_eq!(at_normal.0.x, 0.5 * 0.5 + 0.25 + 0.25, epsilon = 1e-15);
    }

    #[test]
    fn lossless_if_and_only_if_all_parts_are() {
        assert!(Mix::new([(0.3, lambert(1.0)), (0.7, lambert(1.0))]).unwrap().claims_lossless());
        assert!(!Mix::new([(0.3, lambert(1.0)), (0.7, lambert(0.9))]).unwrap().claims_lossless());
        // A part of weight 0 has no say.
        assert!(Mix::new([(1.0, lambert(1.0)), (0.0, lambert(0.9))]).unwrap().claims_lossless());
    }

    #[test]
    fn an_unknown_albedo_of_a_part_is_an_unknown_albedo() {
        let unknown = super::super::FnBsdf::new("unknown", |_, _| Rgb::BLACK);
        let mix = Mix::new([(0.5, lambert(1.0)), (0.5, Box::new(unknown) as Box<dyn Bsdf>)]).unwrap();
        assert!(mix.albedo(DVec3::Z).is_none());
    }

    #[test]
    fn a_delta_keeps_its_weight_and_shares_its_probability() {
        #[derive(Debug)]
        struct Mirror;
        impl Bsdf for Mirror {
            fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
                Rgb::BLACK
            }
            fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
                0.0
            }
            fn sample(&self, wo: DVec3, _: Uniforms) -> Option<BsdfSample> {
                let wi = crate::math::sphere::mirror(wo);
                Some(BsdfSample { wi, weight: Rgb::WHITE, density: Density::Dirac(1.0) })
            }
            fn lobes(&self) -> Lobes {
                Lobes::REFLECT.union(Lobes::DIRAC)
            }
        }
        let mix = Mix::new([(0.75, lambert(0.5)), (0.25, Box::new(Mirror) as Box<dyn Bsdf>)]).unwrap();
        assert!(mix.lobes().contains(Lobes::DIRAC));
        let wo = direction(0.5, 0.0);
        let delta = mix.sample(wo, Uniforms::new(0.9, 0.5, 0.5)).unwrap();
        assert_eq!((delta.weight, delta.density), (Rgb::WHITE, Density::Dirac(0.25)));
        let diffuse = mix.sample(wo, Uniforms::new(0.1, 0.5, 0.5)).unwrap();
        assert_abs_diff_eq!(diffuse.weight.0.x, 0.5, epsilon = 1e-15);
    }

    #[test]
    fn invalid_weights_are_refused() {
        assert!(Mix::new([]).is_err());
        assert!(Mix::new([(0.0, lambert(0.5))]).is_err() && Mix::new([(-1.0, lambert(0.5))]).is_err());
        assert!(Mix::new([(f64::NAN, lambert(0.5))]).is_err());
        assert!(Mix::new([(f64::MAX, lambert(0.5)), (f64::MAX, lambert(0.5))]).is_err());
    }
}
