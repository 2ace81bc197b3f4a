//! A model made from a closure: the first rung of bringing one's own BRDF.

use std::fmt;

use glam::DVec3;

use super::Bsdf;
use crate::math::color::Rgb;

/// A BRDF that is nothing but its formula, sampled by the cosine.
///
/// The closure takes `wo` and `wi` and returns f [1/sr] without the cosine, as [`Bsdf::eval`] does. It is called as it
/// is, also below the horizon: whether the formula is one-sided, finite and reciprocal is what the checks find out.
///
/// ```
/// use whitefurnace::bsdf::{Bsdf, FnBsdf};
/// use whitefurnace::glam::DVec3;
/// use whitefurnace::math::color::Rgb;
///
/// let mine = FnBsdf::new("mine", |wo: DVec3, wi: DVec3| {
///     Rgb::grey(if wo.z > 0.0 && wi.z > 0.0 { 0.25 } else { 0.0 })
/// });
/// assert_eq!(mine.eval(DVec3::Z, DVec3::Z), Rgb::grey(0.25));
/// ```
#[derive(Clone)]
pub struct FnBsdf<F> {
    name: String,
    f: F,
}

impl<F: Fn(DVec3, DVec3) -> Rgb + Send + Sync> FnBsdf<F> {
    /// The formula `f(wo, wi)` under a name for reports.
    pub fn new(name: impl Into<String>, f: F) -> Self {
        Self { name: name.into(), f }
    }

    /// The name it was given.
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl<F> fmt::Debug for FnBsdf<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FnBsdf").field("name", &self.name).finish_non_exhaustive()
    }
}

impl<F: Fn(DVec3, DVec3) -> Rgb + Send + Sync> Bsdf for FnBsdf<F> {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        (self.f)(wo, wi)
    }
}

#[cfg(test)]
mod tests {
    use super::super::contract::{assert_sampled_exactly, assert_total};
    use super::super::{Lambert, Uniforms};
    use super::*;
    use crate::math::sphere::direction;

    #[test]
    fn the_default_sampler_fits_any_formula() {
        let lambert = Lambert::new(0.5).unwrap();
        let mine = FnBsdf::new("mine", move |wo, wi| lambert.eval(wo, wi));
        assert_total(&mine);
        assert_sampled_exactly(&mine, &[1.0, 0.2]);
        let u = Uniforms::new(0.1, 0.2, 0.3);
        let weight = mine.sample(direction(0.4, 1.0), u).unwrap().weight;
        assert!((weight - Rgb::grey(0.5)).0.abs().max_element() <= 1e-15);
    }

    #[test]
    fn it_is_known_by_its_name() {
        let mine = FnBsdf::new("mine", |_, _| Rgb::BLACK);
        assert_eq!(mine.name(), "mine");
        assert!(format!("{mine:?}").contains("mine"));
    }
}
