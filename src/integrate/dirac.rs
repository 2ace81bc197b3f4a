//! The Dirac lobes of a model: found by sweeping the uniform that picks them, since `eval` does not show them.
//!
//! Lobes own intervals of that uniform. Between two neighbours of the sweep that fall into different ones the border is
//! bisected to the last digits, so that no lobe in between is missed, however improbable.

use glam::DVec3;

use crate::bsdf::{Bsdf, Density, Lobes, Uniforms};
use crate::math::color::Rgb;

/// Even steps of the sweep.
const STEPS: u32 = 32;
/// Lobes narrower than this in the uniform may be missed: their share of any estimate is below rounding.
const NARROWEST: f64 = 1e-12;
/// Directions no farther apart than this are one.
const SAME: f64 = 1e-9;

/// One Dirac lobe, given the direction fixed: f |cos| = weight · probability · δ(w − wi).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiracLobe {
    /// Where it points.
    pub wi: DVec3,
    /// The weight of its samples.
    pub weight: Rgb,
    /// The probability with which the sampler says that it draws it.
    pub probability: f64,
}

impl DiracLobe {
    /// What the lobe adds to the albedo.
    pub fn albedo(&self) -> Rgb {
        self.weight * self.probability
    }

    /// Whether it points along `w`.
    pub fn points_along(&self, w: DVec3) -> bool {
        (self.wi - w).length() <= SAME
    }
}

/// The lobe at one value of the uniform; None for a lost draw or one of a smooth lobe.
fn lobe_at(bsdf: &dyn Bsdf, wo: DVec3, u: f64) -> Option<DiracLobe> {
    let s = bsdf.sample(wo, Uniforms::new(u, 0.5, 0.5))?;
    match s.density {
        Density::Dirac(probability) => Some(DiracLobe { wi: s.wi, weight: s.weight, probability }),
        Density::SolidAngle(_) => None,
    }
}

fn same(a: Option<DiracLobe>, b: Option<DiracLobe>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.points_along(b.wi),
        (None, None) => true,
        _ => false,
    }
}

/// All Dirac lobes for the direction `wo`; none of a model that does not say it has any.
pub fn dirac_lobes(bsdf: &dyn Bsdf, wo: DVec3) -> Vec<DiracLobe> {
    let mut found: Vec<DiracLobe> = Vec::new();
    if !bsdf.lobes().contains(Lobes::DIRAC) {
        return found;
    }
    let at = |u: f64| (u, lobe_at(bsdf, wo, u));
    let last = 1.0 - f64::EPSILON / 2.0;
    let sweep: Vec<_> = (0..=STEPS).map(|i| at((f64::from(i) / f64::from(STEPS)).min(last))).collect();
    let mut borders: Vec<_> = sweep.windows(2).map(|pair| (pair[0], pair[1])).collect();
    let mut see = |lobe: Option<DiracLobe>| {
        if let Some(lobe) = lobe.filter(|lobe| !found.iter().any(|known| known.points_along(lobe.wi))) {
            found.push(lobe);
        }
    };
    for (_, lobe) in &sweep {
        see(*lobe);
    }
    while let Some(((from, low), (to, high))) = borders.pop() {
        if same(low, high) || to - from <= NARROWEST {
            continue;
        }
        let middle = at(0.5 * (from + to));
        see(middle.1);
        borders.extend([((from, low), middle), (middle, (to, high))]);
    }
    found
}

/// The Dirac lobe that leads from the end of `lobe` back to `wo`.
pub fn way_back(bsdf: &dyn Bsdf, wo: DVec3, lobe: &DiracLobe) -> Option<DiracLobe> {
    dirac_lobes(bsdf, lobe.wi).into_iter().find(|back| back.points_along(wo))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Dielectric, Lambert, Mix, Null, Plastic};
    use crate::math::sphere::direction;

    #[test]
    fn both_lobes_of_glass_even_where_one_is_all_but_nothing() {
        for eta in [1.5, 1.0001] {
            let glass = Dielectric::new(eta).unwrap();
            let lobes = dirac_lobes(&glass, direction(0.1, 0.3));
            assert_eq!(lobes.len(), 2, "{eta}");
            let total: Rgb = lobes.iter().map(DiracLobe::albedo).sum();
            assert!((total - Rgb::WHITE).0.abs().max_element() < 1e-15);
        }
    }

    #[test]
    fn a_lobe_in_the_middle_of_others_is_found() {
        let lambert = || Box::new(Lambert::new(0.5).unwrap()) as Box<dyn Bsdf>;
        let mix = Mix::new([(0.3, lambert()), (1e-6, Box::new(Null)), (0.7, lambert())]).unwrap();
        // Between two smooth parts nothing differs on either side: only a lobe next to another kind is sure to be seen.
        assert!(dirac_lobes(&mix, DVec3::Z).len() <= 1);
        let parts: [(f64, Box<dyn Bsdf>); 3] = [
            (0.3, lambert()),
            (1e-6, Box::new(Null)),
            (0.7, Box::new(crate::bsdf::SpecularReflector::mirror(1.0).unwrap())),
        ];
        assert_eq!(dirac_lobes(&Mix::new(parts).unwrap(), direction(0.4, 0.0)).len(), 2);
    }

    #[test]
    fn the_way_back_is_found_through_glass_and_not_off_lambert() {
        let glass = Dielectric::new(1.5).unwrap();
        let wo = direction(1.2, 0.3);
        for lobe in dirac_lobes(&glass, wo) {
            let back = way_back(&glass, wo, &lobe).unwrap();
            // One rounding of the cosines, magnified at grazing.
            assert!((back.albedo() - lobe.albedo()).0.abs().max_element() < 1e-13);
        }
        assert!(dirac_lobes(&Lambert::new(1.0).unwrap(), wo).is_empty());
        assert_eq!(dirac_lobes(&Plastic::new(1.5, 0.5).unwrap(), wo).len(), 1);
    }
}
