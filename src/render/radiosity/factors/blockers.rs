//! What can lie between patches at all, and pairs between which none of it does.
//!
//! A plane face with nothing behind it is a wall: no way between two patches crosses it. The other faces, shape by shape, are
//! blockers. A pair is free of a blocker if some axis separates the hull of its two forms from the hull of the blocker.

use glam::DVec3;

use crate::render::radiosity::face::{Face, Outline};
use crate::render::radiosity::patch::Form;

/// Axes that are tried for all pairs; the first three are the world's.
const MOST_AXES: usize = 16;
/// With more blockers than this it is faster to cast the rays.
const MOST_BLOCKERS: usize = 16;

/// A range along each axis.
type Slabs = Vec<[f64; 2]>;

/// Everything that is not a wall.
#[derive(Debug)]
pub(in crate::render::radiosity) struct Blockers {
    axes: Vec<DVec3>,
    /// Of each blocker its corners, and their range.
    all: Vec<(Vec<DVec3>, Slabs)>,
    /// Of each form the same.
    forms: Vec<(Vec<DVec3>, Slabs)>,
    /// Too many to be looked at one by one.
    many: bool,
    near: f64,
}

impl Blockers {
    /// Between `forms`, which lie on these faces of a scene of this extent.
    pub(in crate::render::radiosity) fn new<'a>(
        faces: &[Face],
        forms: impl Iterator<Item = &'a Form>,
        extent: f64,
    ) -> Self {
        let near = 1e-9 * extent;
        let shapes = faces.iter().map(|face| face.shape + 1).max().unwrap_or(0);
        let mut of_shape: Vec<Vec<DVec3>> = vec![Vec::new(); shapes];
        let mut axes = vec![DVec3::X, DVec3::Y, DVec3::Z];
        let corners: Vec<Vec<DVec3>> = faces.iter().map(|face| corners(&face.outline)).collect();
        for (face, own) in faces.iter().zip(&corners) {
            if let Outline::Flat(wall) = &face.outline {
                if corners.iter().flatten().all(|&corner| wall.distance_above(corner) >= -near) {
                    continue;
                }
                let axis = wall.normal();
                if axes.len() < MOST_AXES && axes.iter().all(|known| known.dot(axis).abs() < 1.0 - 1e-9) {
                    axes.push(axis);
                }
            }
            of_shape[face.shape].extend(own);
        }
        let with_slabs = |corners: Vec<DVec3>| {
            let slabs = slabs(&axes, &corners);
            (corners, slabs)
        };
        let blockers: Vec<_> = of_shape.into_iter().filter(|all| !all.is_empty()).map(with_slabs).collect();
        let of_form = |form: &Form| match form {
            Form::Flat(polygon) => polygon.corners().to_vec(),
            Form::Curved(curved) => box_corners(curved.surface.quadric.bounds()),
        };
        let many = blockers.len() > MOST_BLOCKERS;
        let of_forms = if many { Vec::new() } else { forms.map(|form| with_slabs(of_form(form))).collect() };
        Self { all: blockers, forms: of_forms, many, near, axes }
    }

    /// Whether there are none.
    pub(in crate::render::radiosity) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Whether certainly nothing lies between two of the forms.
    pub(in crate::render::radiosity) fn leave_free(&self, i: usize, j: usize) -> bool {
        if self.many {
            return false;
        }
        let (a, b) = (&self.forms[i], &self.forms[j]);
        self.all.iter().all(|blocker| self.along_axes(&a.1, &b.1, &blocker.1) || self.along_the_way(a, b, blocker))
    }

    fn along_axes(&self, a: &Slabs, b: &Slabs, blocker: &Slabs) -> bool {
        (0..self.axes.len()).any(|k| {
            let (low, high) = (a[k][0].min(b[k][0]), a[k][1].max(b[k][1]));
            low >= blocker[k][1] - self.near || high <= blocker[k][0] + self.near
        })
    }

    /// Axes perpendicular to the way from one form to the other.
    fn along_the_way(&self, a: &(Vec<DVec3>, Slabs), b: &(Vec<DVec3>, Slabs), blocker: &(Vec<DVec3>, Slabs)) -> bool {
        let way = b.0[0] - a.0[0];
        [DVec3::Y, DVec3::X, DVec3::Z].iter().any(|across| {
            // Along the way itself there is no axis across it.
            let Some(axis) = way.cross(*across).try_normalize() else { return false };
            let near = self.near;
            let range = |corners: &[DVec3]| {
                corners
                    .iter()
                    .map(|corner| corner.dot(axis))
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
            };
            let ([a_low, a_high], [b_low, b_high], [low, high]) = (range(&a.0), range(&b.0), range(&blocker.0));
            a_low.min(b_low) >= high - near || a_high.max(b_high) <= low + near
        })
    }
}

fn slabs(axes: &[DVec3], corners: &[DVec3]) -> Slabs {
    let range = |axis: &DVec3| {
        corners
            .iter()
            .map(|corner| corner.dot(*axis))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    axes.iter().map(range).collect()
}

fn corners(outline: &Outline) -> Vec<DVec3> {
    match outline {
        Outline::Flat(polygon) => polygon.corners().to_vec(),
        Outline::Curved(surface) => box_corners(surface.quadric.bounds()),
    }
}

fn box_corners(bounds: crate::scene::bvh::Aabb) -> Vec<DVec3> {
    let pick = |bit: u32| if bit & 1 == 0 { bounds.min } else { bounds.max };
    (0..8_u32).map(|k| DVec3::new(pick(k).x, pick(k >> 1).y, pick(k >> 2).z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::radiosity::patches::{Fineness, Materials, Patches};
    use crate::sampling::stream::{stream, uniform};
    use crate::scene::Scene;
    use crate::scene::builtin::builtin;
    use glam::DVec2;

    fn between(patches: &Patches) -> Blockers {
        Blockers::new(patches.faces(), patches.all().iter().map(|patch| &patch.form), patches.extent())
    }

    #[test]
    fn a_room_without_furniture_has_no_blockers() {
        for (name, empty) in [("cube-one-emitter", true), ("cornell-original", false), ("furnace-sphere", false)] {
            let scene = Scene::new(builtin(name, &[]).unwrap().unwrap()).unwrap();
            let patches = Patches::new(&scene, Fineness::Count(30), Materials::Diffuse).unwrap();
            assert_eq!(between(&patches).is_empty(), empty, "{name}");
        }
    }

    #[test]
    fn what_is_said_to_be_free_is_seen_by_every_ray() {
        // The share of pairs that must be found free, for it to be worth its while; of the second scene's patches a third are inside
        // blocks or behind walls.
        for (name, share) in [("cornell-original", 0.33), ("cornell-bitterli", 0.15)] {
            let scene = Scene::new(builtin(name, &[]).unwrap().unwrap()).unwrap();
            let patches = Patches::new(&scene, Fineness::Count(150), Materials::Diffuse).unwrap();
            let blockers = between(&patches);
            let n = patches.all().len();
            let (mut free, mut facing) = (0, 0);
            for i in 0..n {
                for j in 0..i {
                    let ends = |k: u64| {
                        let mut rng = stream(k, i as u64, j as u64);
                        let mut u = || DVec2::new(uniform(&mut rng), uniform(&mut rng));
                        (patches.all()[i].form.at(u()), patches.all()[j].form.at(u()))
                    };
                    let ((p, normal), (q, other)) = ends(0);
                    // Two sides of one face look past each other but for rounding, and exchange nothing.
                    if (q - p).dot(normal) <= 1e-9 || (p - q).dot(other) <= 1e-9 {
                        continue;
                    }
                    facing += 1;
                    if !blockers.leave_free(i, j) {
                        continue;
                    }
                    free += 1;
                    for k in 0..4 {
                        let (from, to) = ends(k);
                        let faces = (to.0 - from.0).dot(from.1) > 0.0 && (from.0 - to.0).dot(to.1) > 0.0;
                        assert!(!faces || scene.sees(from, to), "{name}: {i} and {j}");
                    }
                }
            }
            assert!(f64::from(free) > share * f64::from(facing), "{name}: {free} of {facing}");
        }
    }
}
