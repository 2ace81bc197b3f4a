//! Finer patches where the light changes: at the borders of shadows, and along edges where surfaces meet.

use glam::{DVec2, DVec3};

use super::RadiosityError;
use super::patch::{Curved, Form, Patch};
use super::patches::{Materials, Patches};
use super::reflectance::Reflectance;
use crate::math::color::Rgb;
use crate::scene::Scene;

/// The share of the patches that a round of refinement halves.
const SHARE: f64 = 0.4;
/// How far beyond an edge its neighbour is looked for, in radii of the patch.
const BEYOND: f64 = 0.05;

/// What is not known of the irradiance along an axis on which a patch has no neighbour on its face, as a share of itself.
const UNKNOWN: f64 = 0.5;

/// A way to halve a patch.
#[derive(Clone, Copy, Debug)]
struct Halving {
    /// What it takes from the square of the error.
    worth: f64,
    /// The direction in which the halves lie beside each other: from the patch's centre, of a curved one in its unit square.
    axis: DVec3,
}

impl Patches {
    /// The same with those patches halved of which it takes most from the error: as many as it takes to come nearer to
    /// `wanted`, at most [`SHARE`] of all. None if there are as many already.
    ///
    /// The error of taking what varies for constant is A (ρ g L)² / 12, L the length of a patch along an axis and g the slope of
    /// the irradiance, from that of a neighbour on its face; halves leave a quarter of it.
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
        let best: Vec<Halving> = (0..all.len()).map(|i| self.best_halving(i, irradiance)).collect();
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|&a, &b| best[b].worth.total_cmp(&best[a].worth).then(a.cmp(&b)));
        let mut halved = vec![false; all.len()];
        for &i in order.iter().take(more) {
            halved[i] = true;
        }
        let mut patches = Vec::with_capacity(all.len() + more);
        for (i, patch) in all.iter().enumerate() {
            if !halved[i] {
                patches.push(patch.clone());
                continue;
            }
            for (form, area) in halves(patch, best[i].axis) {
                let face = &self.faces()[patch.face];
                let reflectance = reflectances[scene.shapes()[face.shape].material].over(scene, face, &form);
                patches.push(Patch { form, area, reflectance, ..*patch });
            }
        }
        Self::of(scene, self.faces().to_vec(), patches).map(Some)
    }

    fn best_halving(&self, i: usize, irradiance: &[Rgb]) -> Halving {
        let patch = &self.all()[i];
        let centre = patch.form.centre();
        let each = ways_out(&patch.form).map(|way| {
            let neighbour = way.beyond.and_then(|p| self.on_face(patch.face, p)).filter(|&j| j != i);
            let over_patch = match neighbour {
                Some(j) => {
                    let apart = self.all()[j].form.centre().distance(centre);
                    (irradiance[j] - irradiance[i]) * (2.0 * way.half_length / apart)
                }
                None => irradiance[i] * UNKNOWN,
            };
            let error = (patch.reflectance * over_patch).0.length_squared() / 12.0;
            // An axis with a neighbour on one side is known from that one.
            (neighbour.is_some(), Halving { worth: 0.75 * patch.area * error, axis: way.axis })
        });
        let ways: Vec<(bool, Halving)> = each.collect();
        let parallel =
            |a: DVec3, b: DVec3| a.cross(b).length_squared() < 1e-6 * a.length_squared() * b.length_squared();
        let informed = |(known, way): &(bool, Halving)| {
            *known || !ways.iter().any(|(other_known, other)| *other_known && parallel(other.axis, way.axis))
        };
        let useful = ways.iter().filter(|way| informed(way)).map(|(_, halving)| *halving);
        useful.max_by(|a, b| a.worth.total_cmp(&b.worth)).unwrap_or(Halving { worth: 0.0, axis: DVec3::X })
    }
}

/// A way across an edge of a patch.
struct WayOut {
    /// As in [`Halving`].
    axis: DVec3,
    /// From the centre to the edge \[m\].
    half_length: f64,
    /// A point a little beyond the edge; None where a curved surface ends.
    beyond: Option<DVec3>,
}

fn ways_out(form: &Form) -> Box<dyn Iterator<Item = WayOut> + '_> {
    match form {
        Form::Flat(polygon) => Box::new(polygon.edges().map(|(a, b)| {
            let outwards = (b - a).cross(polygon.normal()).normalize_or_zero();
            let middle = 0.5 * (a + b);
            WayOut {
                axis: outwards,
                half_length: (middle - polygon.centroid()).dot(outwards),
                beyond: Some(middle + outwards * (BEYOND * polygon.radius())),
            }
        })),
        Form::Curved(Curved { surface, from, size }) => {
            let centre = surface.at(*from + 0.5 * *size).0;
            Box::new([DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].into_iter().map(move |axis| {
                let at = |reach: f64| *from + *size * (DVec2::splat(0.5) + reach * axis);
                let beyond = at(0.5 + BEYOND);
                let inside = beyond.min_element() >= 0.0 && beyond.max_element() < 1.0;
                WayOut {
                    axis: axis.extend(0.0),
                    half_length: surface.at(at(0.5)).0.distance(centre),
                    beyond: inside.then(|| surface.at(beyond).0),
                }
            }))
        }
    }
}

/// The two halves of a patch beside each other along `axis`, with their areas.
fn halves(patch: &Patch, axis: DVec3) -> Vec<(Form, f64)> {
    match &patch.form {
        Form::Flat(polygon) => {
            let parts = [axis, -axis].map(|side| polygon.above(polygon.centroid(), side));
            let halves = parts.into_iter().flatten();
            halves
                .map(|half| {
                    let area = half.area();
                    (Form::Flat(half), area)
                })
                .collect()
        }
        Form::Curved(curved) => {
            let step = 0.5 * curved.size * axis.truncate().abs();
            let half = |from| (Form::Curved(Curved { from, size: curved.size - step, ..*curved }), 0.5 * patch.area);
            vec![half(curved.from), half(curved.from + step)]
        }
    }
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
