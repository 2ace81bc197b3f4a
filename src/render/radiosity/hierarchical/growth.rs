//! How the number of links grows with the number of elements, which is what hierarchical radiosity is for.
//!
//! A matrix has n² view factors. Links have O(n) where the accuracy of each one is held fixed (Hanrahan 1991), and O(n log n) with
//! one level of them to every doubling, as the lecture says. Here the scene and the error of the whole solution are held
//! fixed, and the elements become smaller: the links that a finer division adds are those that its error needs.

use super::model::Hierarchical;
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

    /// p of links ∝ nᵖ by least squares of logarithms, and its standard error by what these leave. None for fewer than three sizes.
    pub fn exponent(&self) -> Option<[f64; 2]> {
        let logs = || self.points.iter().map(|size| ((size.finest as f64).ln(), (size.links as f64).ln()));
        let n = self.points.len() as f64;
        let (mean_x, mean_y) = (logs().map(|p| p.0).sum::<f64>() / n, logs().map(|p| p.1).sum::<f64>() / n);
        let sxx: f64 = logs().map(|p| (p.0 - mean_x).powi(2)).sum();
        let slope = logs().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum::<f64>() / sxx;
        let left: f64 = logs().map(|p| (p.1 - mean_y - slope * (p.0 - mean_x)).powi(2)).sum();
        (self.points.len() > 2 && slope.is_finite()).then(|| [slope, (left / (n - 2.0) / sxx).sqrt()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    #[test]
    fn the_exponent_of_a_power_is_found() {
        let size = |n: usize, links: usize| Size { finest: n, leaves: n, links };
        let exact = Growth { error: 0.1, points: [4, 16, 64].map(|n| size(n, n * n)).to_vec() };
        let [slope, error] = exact.exponent().unwrap();
        assert!((slope - 2.0).abs() < 1e-14 && error < 1e-14);
        // ln 1, ln 2 and ln 8 at 0, 1 and 2 times ln 2: slope 3/2, residuals 1/6, -1/3 and 1/6 of ln 2.
        let bent = Growth { error: 0.1, points: vec![size(1, 1), size(2, 2), size(4, 8)] };
        let [slope, error] = bent.exponent().unwrap();
        assert!((slope - 1.5).abs() < 1e-14 && (error - (1.0_f64 / 12.0).sqrt()).abs() < 1e-14, "{slope} {error}");
        assert_eq!(Growth { error: 0.1, points: vec![size(1, 1), size(2, 2)] }.exponent(), None);
        assert_eq!(Growth { error: 0.1, points: vec![size(2, 1); 3] }.exponent(), None);
    }

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
