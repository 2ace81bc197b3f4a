//! The faces of a scene as trees of ever smaller elements, below clusters where there are many.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::cluster::{Parts, group};
use super::cut::Cut;
use crate::math::color::Rgb;
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::contact::{covered, without};
use crate::render::radiosity::face::{Face, Outline, faces};
use crate::render::radiosity::factors::End;
use crate::render::radiosity::patch::{Curved, Form, Patch};
use crate::render::radiosity::patches::{Fineness, MOST_PATCHES, Materials, Patches};
use crate::render::radiosity::reflectance::Reflectance;
use crate::scene::Scene;

/// No element.
pub(super) const NONE: u32 = u32::MAX;

/// What an element is.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A part of a face.
    Surface(Form),
    /// Several faces or clusters.
    Cluster,
}

/// An element.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) shape: Shape,
    /// The face, or [`NONE`].
    pub(super) face: u32,
    /// \[m²\]
    pub(super) area: f64,
    /// Mean over the element, as that below.
    pub(super) reflectance: Rgb,
    /// Radiosity [W/m²].
    pub(super) emission: Rgb,
    pub(super) parent: u32,
    /// The first of its parts, which follow each other.
    first: u32,
    parts: u8,
    /// How many times the face was cut.
    pub(super) level: u8,
    /// The points of [`PROBES`] and the normals there. A cluster has none.
    pub(super) points: [End; PROBES.len()],
    pub(super) centre: DVec3,
    /// Radius of a sphere about the centre that holds the element, for a curved one roughly \[m\].
    pub(super) radius: f64,
}

impl Node {
    /// A cluster of nothing.
    const CLUSTER: Self = Self {
        shape: Shape::Cluster,
        face: NONE,
        area: 0.0,
        reflectance: Rgb::BLACK,
        emission: Rgb::BLACK,
        parent: NONE,
        first: NONE,
        parts: 0,
        level: 0,
        points: [(DVec3::ZERO, DVec3::ZERO); PROBES.len()],
        centre: DVec3::ZERO,
        radius: 0.0,
    };

    /// Its parts, by number.
    pub(super) fn parts(&self) -> std::ops::Range<usize> {
        let first = self.first as usize;
        first..first + usize::from(self.parts)
    }

    /// Whether it can be cut.
    pub(super) fn divisible(&self) -> bool {
        self.parts > 0
    }

    /// Whether it is several faces.
    pub(super) fn is_cluster(&self) -> bool {
        matches!(self.shape, Shape::Cluster)
    }
}

/// A point of each quarter of the unit square and its centre, with weights: exact for the mean of a cubic, and for the mean
/// square of a linear function.
///
/// The four of Gauss' rule would not do: a function with the symmetry of a square has one value at all of them, and seems to be
/// constant. These are a lattice that is its own mirror image in no axis.
pub(super) const PROBES: [([f64; 2], f64); 5] = [
    ([0.3, 0.1], 5.0 / 24.0),
    ([0.9, 0.3], 5.0 / 24.0),
    ([0.1, 0.7], 5.0 / 24.0),
    ([0.7, 0.9], 5.0 / 24.0),
    ([0.5, 0.5], 1.0 / 6.0),
];

/// The quarter of the unit square in which a point lies.
pub(super) fn quarter(u: DVec2) -> usize {
    usize::from(u.x >= 0.5) + 2 * usize::from(u.y >= 0.5)
}

/// All elements of a scene, parts after what they are parts of.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) faces: Vec<Face>,
    pub(super) nodes: Vec<Node>,
    /// The elements that are part of no other come first: so many.
    pub(super) roots: usize,
    /// Which elements are whole faces, or what is left of them where they are covered. Before them come the clusters.
    pub(super) whole: Range<usize>,
    /// Faces whose reflectance varies.
    pub(super) varying: Vec<bool>,
}

impl Tree {
    /// Cuts the faces of the scene down to the cells of `fineness`. What is covered has no elements. More than `most_roots` faces
    /// are put into clusters.
    pub(super) fn new(
        scene: &Scene,
        fineness: Fineness,
        materials: Materials,
        most_roots: usize,
    ) -> Result<Self, RadiosityError> {
        let faces = faces(scene)?;
        let reflectances = Reflectance::of_all(scene, materials)?;
        let holes = covered(scene, &faces)?;
        let side = fineness.side(&faces)?;
        let mut forms = Vec::new();
        for (number, (face, holes)) in faces.iter().zip(&holes).enumerate() {
            match &face.outline {
                Outline::Flat(polygon) => {
                    let pieces = holes.iter().fold(vec![polygon.clone()], |pieces, hole| {
                        pieces.iter().flat_map(|piece| without(piece, hole)).collect()
                    });
                    forms.extend(pieces.into_iter().map(|piece| {
                        let cut = Cut::of(&Outline::Flat(piece.clone()), side);
                        (number, Form::Flat(piece), cut)
                    }));
                }
                Outline::Curved(surface) => {
                    let whole = Curved { surface: *surface, from: DVec2::ZERO, size: DVec2::ONE };
                    forms.push((number, Form::Curved(whole), Cut::of(&face.outline, side)));
                }
            }
        }
        let count = forms.iter().map(|(.., cut)| cut.count()).fold(0, usize::saturating_add);
        if count > MOST_PATCHES {
            return Err(RadiosityError::TooMany { patches: count, allowed: MOST_PATCHES });
        }
        if forms.is_empty() {
            return Err(RadiosityError::NoSurface);
        }
        let reflectance = |face: &Face| reflectances[scene.shapes()[face.shape].material];
        let varying = faces.iter().map(|face| matches!(reflectance(face), Reflectance::Varying)).collect();
        let (clusters, order) = if forms.len() > most_roots {
            group(&forms.iter().map(|(_, form, _)| form.at(DVec2::splat(0.5))).collect::<Vec<_>>())
        } else {
            (Vec::new(), (0..forms.len()).collect())
        };
        let whole = clusters.len()..clusters.len() + forms.len();
        let roots = if clusters.is_empty() { forms.len() } else { 1 };
        let mut tree = Self { roots, whole, faces, nodes: vec![Node::CLUSTER; clusters.len()], varying };
        // One for each element that is no cluster.
        let mut cuts = Vec::with_capacity(2 * count);
        for at in order {
            let (face, form, cut) = forms[at].clone();
            let rho = reflectance(&tree.faces[face]).over(scene, &tree.faces[face], &form);
            tree.add(form, face, rho, NONE, 0);
            cuts.push(cut);
        }
        tree.hold(&clusters);
        let mut at = tree.whole.start;
        while at < tree.nodes.len() {
            let Node { face, level, .. } = tree.nodes[at];
            let Shape::Surface(form) = &tree.nodes[at].shape else { unreachable!("clusters come first") };
            let parts = cuts[at - tree.whole.start].parts(form);
            tree.nodes[at].first = tree.nodes.len() as u32;
            tree.nodes[at].parts = parts.len() as u8;
            for (form, cut) in parts {
                let of = &tree.faces[face as usize];
                let rho = reflectance(of).over(scene, of, &form);
                tree.add(form, face as usize, rho, at as u32, level + 1);
                cuts.push(cut);
            }
            at += 1;
        }
        tree.average();
        Ok(tree)
    }

    fn add(&mut self, form: Form, face: usize, reflectance: Rgb, parent: u32, level: u8) {
        let points = PROBES.map(|(at, _)| form.at(DVec2::from_array(at)));
        let centre = form.centre();
        let (area, radius) = match &form {
            Form::Flat(polygon) => (polygon.area(), polygon.radius()),
            Form::Curved(Curved { surface, size, .. }) => {
                let across = |k: u32| 0.25 * f64::from(k);
                let grid = (0..25).map(|k| form.at(DVec2::new(across(k % 5), across(k / 5))).0.distance(centre));
                (surface.quadric.area() * size.x * size.y, grid.fold(0.0, f64::max))
            }
        };
        let emission = self.faces[face].emission;
        self.nodes.push(Node {
            shape: Shape::Surface(form),
            face: face as u32,
            area,
            reflectance,
            emission,
            parent,
            first: 0,
            parts: 0,
            level,
            points,
            centre,
            radius,
        });
    }

    /// Makes the clusters of the faces, or clusters, that they hold.
    fn hold(&mut self, clusters: &[Parts]) {
        for (at, parts) in clusters.iter().enumerate().rev() {
            let parts = match parts {
                Parts::Clusters(parts) => parts.clone(),
                Parts::Faces(parts) => parts.start + self.whole.start..parts.end + self.whole.start,
            };
            for part in &mut self.nodes[parts.clone()] {
                part.parent = at as u32;
            }
            let held = &self.nodes[parts.clone()];
            let area: f64 = held.iter().map(|part| part.area).sum();
            let centre = held.iter().map(|part| part.centre * part.area).sum::<DVec3>() / area;
            let reach = held.iter().map(|part| part.centre.distance(centre) + part.radius);
            let cluster = Node {
                first: parts.start as u32,
                parts: parts.len() as u8,
                area,
                centre,
                radius: reach.fold(0.0, f64::max),
                emission: held.iter().map(|part| part.emission * part.area).sum::<Rgb>() / area,
                parent: self.nodes[at].parent,
                ..Node::CLUSTER
            };
            self.nodes[at] = cluster;
        }
    }

    /// Reflectances of elements from those of their parts.
    fn average(&mut self) {
        for at in (0..self.nodes.len()).rev() {
            let node = &self.nodes[at];
            if node.is_cluster() || node.divisible() && self.varying[node.face as usize] {
                let parts = &self.nodes[node.parts()];
                let sum: Rgb = parts.iter().map(|part| part.reflectance * part.area).sum();
                let area: f64 = parts.iter().map(|part| part.area).sum();
                self.nodes[at].reflectance = sum / area;
            }
        }
    }

    /// How many elements are clusters.
    pub(super) fn clusters(&self) -> usize {
        self.whole.start
    }

    /// The forms of all elements but the clusters.
    pub(super) fn forms(&self) -> impl Iterator<Item = &Form> {
        self.nodes.iter().filter_map(|node| match &node.shape {
            Shape::Surface(form) => Some(form),
            Shape::Cluster => None,
        })
    }

    /// The point of an element at `u` in [0, 1)², uniformly in area, and the normal there.
    pub(super) fn at(&self, element: usize, mut u: DVec2) -> End {
        let mut node = &self.nodes[element];
        loop {
            match &node.shape {
                Shape::Surface(form) => return form.at(u),
                Shape::Cluster => {
                    // Of the area up to u.x the part that it ends in, and how far.
                    let mut left = u.x * node.area;
                    let parts = &self.nodes[node.parts()];
                    let ends_in = parts[..parts.len() - 1].iter().find(|part| {
                        let within = left < part.area;
                        if !within {
                            left -= part.area;
                        }
                        within
                    });
                    node = ends_in.unwrap_or(&parts[parts.len() - 1]);
                    // Roundings may leave a little more than there is.
                    u.x = (left / node.area).min(1.0 - f64::EPSILON);
                }
            }
        }
    }

    /// The elements at which `open` ends, in the order of the faces and those of a face one after the other.
    pub(super) fn ends(&self, open: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut ends = Vec::new();
        let mut stack: Vec<usize> = (0..self.roots).rev().collect();
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if node.is_cluster() || node.divisible() && open(at) {
                stack.extend(node.parts().rev());
            } else {
                ends.push(at);
            }
        }
        // Of the clusters' faces, which lie in another order.
        ends.sort_by_key(|&at| self.nodes[at].face);
        ends
    }

    /// Elements as patches, but for clusters. They must be in the order of [`Self::ends`].
    pub(super) fn patches(&self, scene: &Scene, elements: &[usize]) -> Result<Patches, RadiosityError> {
        let patch = |&at: &usize| {
            let Node { shape: Shape::Surface(form), face, area, reflectance, emission, .. } = self.nodes[at].clone()
            else {
                return None;
            };
            let face = face as usize;
            Some(Patch { shape: self.faces[face].shape, face, form, area, reflectance, emission })
        };
        Patches::of(scene, self.faces.clone(), elements.iter().filter_map(patch).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    fn emitted(patches: &Patches) -> Rgb {
        patches.all().iter().map(|patch| patch.emission * patch.area).sum()
    }

    #[test]
    fn the_trees_have_the_areas_of_what_is_not_covered() {
        for (name, most_roots) in [
            ("cornell-original", 100),
            ("cornell-original", 5),
            ("cornell-bitterli", 5),
            ("furnace-sphere", 100),
            ("cube-one-emitter", 1),
        ] {
            let scene = Scene::new(builtin(name, &[]).unwrap().unwrap()).unwrap();
            let fineness = Fineness::Count(1500);
            let tree = Tree::new(&scene, fineness, Materials::Diffuse, most_roots).unwrap();
            let flat = Patches::new(&scene, fineness, Materials::Diffuse).unwrap();
            let area: f64 = flat.all().iter().map(|patch| patch.area).sum();
            for whole in [false, true] {
                let ends = tree.ends(|_| whole);
                let sum: f64 = ends.iter().map(|&at| tree.nodes[at].area).sum();
                assert!((sum - area).abs() < 1e-9 * area, "{name}: {sum} of {area}");
                let patches = tree.patches(&scene, &ends).unwrap();
                let [found, known] = [&patches, &flat].map(emitted);
                assert!((found - known).0.abs().max_element() <= 1e-9 * known.max_channel(), "{name}");
            }
            let finest = tree.ends(|_| true).len() as f64;
            assert!((finest / flat.all().len() as f64 - 1.0).abs() < 0.2, "{name}: {finest} of {}", flat.all().len());
        }
    }
}
