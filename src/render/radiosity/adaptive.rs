//! Finer patches where the light changes: at the borders of shadows, and along edges where surfaces meet.

use glam::{DVec2, DVec3};

use super::RadiosityError;
use super::patch::{Curved, Form, Patch};
use super::patches::{Materials, Patches};
use super::polygon::Polygon;
use super::reflectance::Reflectance;
use crate::math::color::Rgb;
use crate::scene::Scene;

/// The share of the patches that a round of refinement halves.
const SHARE: f64 = 0.4;
/// How far beyond an edge its neighbour is looked for, in radii of the patch.
const BEYOND: f64 = 0.05;

impl Patches {
    /// The same with those patches halved across their length at which `irradiance` changes most: as many as it takes to come
    /// nearer to `wanted`, at most [`SHARE`] of all. None if there are as many already.
    ///
    /// What a patch is halved for is its area times the largest difference from a neighbour on its face: the error of taking
    /// what varies for constant.
    pub(super) fn refined(
        &self,
        scene: &Scene,
        materials: Materials,
        irradiance: &[Rgb],
        wanted: usize,
    ) -> Result<Option<Self>, RadiosityError> {
        let all = self.all();
        let more = wanted.saturating_sub(all.len()).min((SHARE * all.len() as f64) as usize);
        if more == 0 {
            return Ok(None);
        }
        let reflectances = Reflectance::of_all(scene, materials)?;
        let mut worth: Vec<(f64, usize)> = (0..all.len()).map(|i| (self.change(i, irradiance), i)).collect();
        worth.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut halved = vec![false; all.len()];
        for (_, i) in worth.iter().take(more) {
            halved[*i] = true;
        }
        let mut patches = Vec::with_capacity(all.len() + more);
        for (patch, halved) in all.iter().zip(halved) {
            if !halved {
                patches.push(patch.clone());
                continue;
            }
            for (form, area) in halves(patch) {
                let face = &self.faces()[patch.face];
                let reflectance = reflectances[scene.shapes()[face.shape].material].over(scene, face, &form);
                patches.push(Patch { form, area, reflectance, ..*patch });
            }
        }
        Self::of(scene, self.faces().to_vec(), patches).map(Some)
    }

    /// The area of a patch times the largest difference of its irradiance from that of a neighbour.
    fn change(&self, i: usize, irradiance: &[Rgb]) -> f64 {
        let patch = &self.all()[i];
        let largest = around(&patch.form)
            .filter_map(|p| self.on_face(patch.face, p))
            .map(|j| (irradiance[j] - irradiance[i]).0.abs().max_element());
        patch.area * largest.fold(0.0, f64::max)
    }
}

/// Points a little beyond each edge of a patch.
fn around(form: &Form) -> impl Iterator<Item = DVec3> + '_ {
    let (flat, curved) = match form {
        Form::Flat(polygon) => (Some(polygon), None),
        Form::Curved(Curved { surface, from, size }) => {
            let middles = [(0.5, -BEYOND), (0.5, 1.0 + BEYOND), (-BEYOND, 0.5), (1.0 + BEYOND, 0.5)];
            let beyond = middles.map(|(x, y)| *from + *size * DVec2::new(x, y));
            let within = beyond.into_iter().filter(|u| u.min_element() >= 0.0 && u.max_element() < 1.0);
            (None, Some(within.map(|u| surface.at(u).0)))
        }
    };
    let edges = flat.into_iter().flat_map(|polygon| {
        polygon.edges().map(|(a, b)| {
            let outwards = (b - a).cross(polygon.normal()).normalize_or_zero();
            0.5 * (a + b) + outwards * (BEYOND * polygon.radius())
        })
    });
    edges.chain(curved.into_iter().flatten())
}

/// The two halves of a patch across its length, with their areas.
fn halves(patch: &Patch) -> Vec<(Form, f64)> {
    match &patch.form {
        Form::Flat(polygon) => {
            let along = longest(polygon);
            let parts = [along, -along].map(|side| polygon.above(polygon.centroid(), side));
            let halves = parts.into_iter().flatten();
            halves
                .map(|half| {
                    let area = half.area();
                    (Form::Flat(half), area)
                })
                .collect()
        }
        Form::Curved(curved) => {
            let centre = curved.surface.at(curved.from + 0.5 * curved.size).0;
            let ends = [DVec2::new(1.0, 0.5), DVec2::new(0.5, 1.0)];
            let [x, y] = ends.map(|end| curved.surface.at(curved.from + end * curved.size).0.distance(centre));
            let (size, step) = if x >= y {
                (curved.size * DVec2::new(0.5, 1.0), DVec2::new(0.5 * curved.size.x, 0.0))
            } else {
                (curved.size * DVec2::new(1.0, 0.5), DVec2::new(0.0, 0.5 * curved.size.y))
            };
            let half = |from| (Form::Curved(Curved { from, size, ..*curved }), 0.5 * patch.area);
            vec![half(curved.from), half(curved.from + step)]
        }
    }
}

/// The direction of the edge along which the polygon is longest.
fn longest(polygon: &Polygon) -> DVec3 {
    let span = |axis: DVec3| {
        let along = polygon.corners().iter().map(|corner| corner.dot(axis));
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let axes = polygon.edges().map(|(a, b)| (b - a).normalize_or_zero());
    axes.max_by(|a, b| span(*a).total_cmp(&span(*b))).unwrap_or(DVec3::X)
}

#[cfg(test)]
mod tests {
    use super::super::patches::Fineness;
    use super::*;
    use crate::scene::builtin::builtin;

    #[test]
    fn halves_make_up_the_whole_and_lie_where_light_changes() {
        for name in ["cornell-original", "furnace-sphere"] {
            let scene = Scene::new(builtin(name, &[]).unwrap().unwrap()).unwrap();
            let patches = Patches::new(&scene, Fineness::Count(100), Materials::Diffuse).unwrap();
            let area: f64 = patches.all().iter().map(|patch| patch.area).sum();
            // A step across the middle of the scene's x.
            let step = |patch: &Patch| Rgb::grey(f64::from(patch.form.centre().x > 0.4 * scene.extent()));
            let light: Vec<Rgb> = patches.all().iter().map(step).collect();
            let wanted = patches.all().len() + 10;
            let finer = patches.refined(&scene, Materials::Diffuse, &light, wanted).unwrap().unwrap();
            assert_eq!(finer.all().len(), wanted);
            let after: f64 = finer.all().iter().map(|patch| patch.area).sum();
            assert!((after - area).abs() < 1e-9 * area, "{name}: {after} against {area}");
            let numbers: Vec<usize> = finer.all().iter().map(|patch| patch.face).collect();
            assert!(numbers.is_sorted(), "patches of a face follow each other");
            let enough = patches.refined(&scene, Materials::Diffuse, &light, patches.all().len()).unwrap();
            assert!(enough.is_none());
        }
    }
}
