//! How the number of links grows with the number of elements, which is what hierarchical radiosity is for.
//!
//! A matrix has n² view factors. Links have O(n) where the accuracy of each one is held fixed (Hanrahan 1991), and O(n log n) with
//! one level of them to every doubling, as the lecture says. Here the scene and the error of the whole solution are held
//! fixed, and the elements become smaller: the links that a finer division adds are those that its error needs.

use super::model::Hierarchical;
use crate::math::power_law;
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::patches::Fineness;
use crate::scene::Scene;

/// The numbers of links of one scene, the error held fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Growth {
    /// The error.
    pub error: f64,
    /// One for each size.
    pub points: Vec<Size>,
}

/// A solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// What would be the number of elements if all were as fine as allowed: n.
    pub finest: usize,
    /// Elements that there are.
    pub leaves: usize,
    /// Links.
    pub links: usize,
}

impl Growth {
    /// Solves the scene with about so many of the finest elements each time, all else as in `model`.
    pub fn measure(model: &Hierarchical, scene: &Scene, sizes: &[usize]) -> Result<Self, RadiosityError> {
        let solve = |&size: &usize| {
            let found = Hierarchical { fineness: Fineness::Count(size), ..*model }.solve(scene)?.statistics;
            Ok(Size { finest: found.finest, leaves: found.leaves, links: found.links })
        };
        Ok(Self { error: model.error, points: sizes.iter().map(solve).collect::<Result<_, RadiosityError>>()? })
    }

    /// p of links ∝ nᵖ, and its standard error. None for fewer than three sizes.
    pub fn exponent(&self) -> Option<[f64; 2]> {
        let points: Vec<_> = self.points.iter().map(|size| (size.finest as f64, size.links as f64)).collect();
        power_law::exponent(&points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    #[test]
    fn links_grow_less_than_their_number_and_without_an_error_allowed_with_its_square() {
        let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap();
        let grown = |error: f64, sizes: &[usize]| {
            let model = Hierarchical { error, ..Hierarchical::default() };
            Growth::measure(&model, &scene, sizes).unwrap().exponent().unwrap()[0]
        };
        let fixed = grown(0.03, &[500, 2000, 8000]);
        // n log n would have 1.13 here, a link of its own for every element 1.
        assert!(fixed < 1.0, "{fixed}");
        // All pairs that see each other, if nothing is good enough: n², but for what whole numbers of cells make of the sizes.
        let exact = grown(1e-9, &[60, 120, 240]);
        assert!((1.8..2.2).contains(&exact), "{exact}");
    }
}
