//! A scene cut into patches, and which of them a ray has met.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::RadiosityError;
use super::contact::{covered, without};
use super::face::{Face, Outline, faces};
use super::locator::Locator;
use super::patch::{Curved, Form, Patch};
use super::polygon::Polygon;
use super::reflectance::Reflectance;
use crate::math::color::Rgb;
use crate::scene::{self, Quadric, Scene};

/// How a scene is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fineness {
    /// Into about this many patches, as square and as large as each other as the faces allow.
    Count(usize),
    /// Into patches of about this area, in the scene's unit squared.
    Area(f64),
}

impl Fineness {
    /// The side of the squares into which the faces are to be cut.
    pub(super) fn side(self, faces: &[Face]) -> Result<f64, RadiosityError> {
        match self {
            Self::Count(wanted) => side_for(faces, wanted),
            Self::Area(area) if area > 0.0 && area.is_finite() => Ok(area.sqrt()),
            Self::Area(area) => Err(RadiosityError::Area(area)),
        }
    }
}

/// What is taken for diffuse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Materials {
    /// Only what is: anything else is refused.
    #[default]
    Diffuse,
    /// Everything, by its albedo under even light.
    Approximated,
}

/// Most patches that a scene is cut into.
pub const MOST_PATCHES: usize = 1 << 22;

/// A scene cut into patches.
#[derive(Debug)]
pub struct Patches {
    faces: Vec<Face>,
    all: Vec<Patch>,
    /// Of each face, what finds its patches.
    locators: Vec<Locator>,
    /// The faces of each primitive: its outside, and its inside if that is not black.
    of_primitive: Vec<[u32; 2]>,
    shapes: Vec<String>,
    extent: f64,
}

const NONE: u32 = u32::MAX;

impl Patches {
    /// Cuts the scene. Where surfaces stand on each other, what is covered has no patches.
    pub fn new(scene: &Scene, fineness: Fineness, materials: Materials) -> Result<Self, RadiosityError> {
        let faces = faces(scene)?;
        let reflectances = Reflectance::of_all(scene, materials)?;
        let holes = covered(scene, &faces)?;
        let side = fineness.side(&faces)?;
        let count: usize = faces.iter().map(|face| cells(&face.outline, side).count()).sum();
        if count > MOST_PATCHES {
            return Err(RadiosityError::TooMany { patches: count, allowed: MOST_PATCHES });
        }
        let mut patches = Vec::new();
        for (number, (face, holes)) in faces.iter().zip(&holes).enumerate() {
            let mut add = |form: Form, area: f64| {
                let reflectance = reflectances[scene.shapes()[face.shape].material].over(scene, face, &form);
                let emission = face.emission;
                patches.push(Patch { shape: face.shape, face: number, form, area, reflectance, emission });
            };
            let cells = cells(&face.outline, side);
            match &face.outline {
                Outline::Flat(polygon) => {
                    for cell in cells.of(polygon) {
                        let pieces = holes.iter().fold(vec![cell], |pieces, hole| {
                            pieces.iter().flat_map(|piece| without(piece, hole)).collect()
                        });
                        for piece in pieces {
                            let area = piece.area();
                            add(Form::Flat(piece), area);
                        }
                    }
                }
                Outline::Curved(surface) => {
                    let Cells { columns, rows } = cells;
                    let size = 1.0 / DVec2::new(columns as f64, rows as f64);
                    let area = surface.quadric.area() / (columns * rows) as f64;
                    for i in 0..columns * rows {
                        let from = size * DVec2::new((i % columns) as f64, (i / columns) as f64);
                        add(Form::Curved(Curved { surface: *surface, from, size }), area);
                    }
                }
            }
        }
        Self::of(scene, faces, patches)
    }

    /// Patches of these faces, in the order of the faces.
    pub(super) fn of(scene: &Scene, faces: Vec<Face>, patches: Vec<Patch>) -> Result<Self, RadiosityError> {
        if patches.is_empty() {
            return Err(RadiosityError::NoSurface);
        }
        let mut of_primitive = vec![[NONE; 2]; scene.primitives()];
        for (number, face) in faces.iter().enumerate() {
            for primitive in face.primitives {
                of_primitive[primitive][usize::from(!face.outside)] = number as u32;
            }
        }
        let mut locators = Vec::with_capacity(faces.len());
        let mut first = 0;
        for (number, face) in faces.iter().enumerate() {
            let count = patches[first..].iter().take_while(|patch| patch.face == number).count();
            locators.push(Locator::new(&face.outline, &patches[first..first + count], first));
            first += count;
        }
        let shapes = scene.shapes().iter().map(|shape| shape.name.clone()).collect();
        Ok(Self { faces, all: patches, locators, of_primitive, shapes, extent: scene.extent() })
    }

    /// The patches, those of a face one after the other.
    pub fn all(&self) -> &[Patch] {
        &self.all
    }

    /// The faces that they are parts of.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Names of the shapes, by number.
    pub fn shapes(&self) -> &[String] {
        &self.shapes
    }

    /// The largest coordinate of the scene.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// The patch at a point of a surface that is seen from direction `wo`. None on a side that is black, and where something
    /// covers the surface.
    pub fn at(&self, surface: &scene::Surface, wo: DVec3) -> Option<usize> {
        let side = usize::from(surface.ng.dot(wo) <= 0.0);
        let face = self.of_primitive[surface.primitive][side];
        self.locators.get(face as usize)?.find(&self.all, surface.p)
    }

    /// The patch of a face at a point of it.
    pub(super) fn on_face(&self, face: usize, p: DVec3) -> Option<usize> {
        self.locators[face].find(&self.all, p)
    }

    /// Whether the back of a patch is a patch too.
    pub(super) fn has_other_side(&self, patch: usize) -> bool {
        self.of_primitive[self.faces[self.all[patch].face].primitives[0]].iter().all(|face| *face != NONE)
    }

    /// The reflectance at a point of a patch: that of the point where the material is diffuse, else that of the patch.
    pub(super) fn reflectance_at(&self, scene: &Scene, patch: usize, surface: &scene::Surface) -> Rgb {
        let material = scene.material_of(surface.shape);
        if !(material.is_diffuse() && material.varies()) {
            return self.all[patch].reflectance;
        }
        material.at(surface.uv, surface.color).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI
    }
}

/// The side of the squares into which the faces are to be cut, for about `wanted` of them.
fn side_for(faces: &[Face], wanted: usize) -> Result<f64, RadiosityError> {
    if !(1..=MOST_PATCHES).contains(&wanted) {
        return Err(RadiosityError::TooMany { patches: wanted, allowed: MOST_PATCHES });
    }
    let area: f64 = faces.iter().map(|face| face.outline.area()).sum();
    let count = |side: f64| faces.iter().map(|face| cells(&face.outline, side).count()).fold(0, usize::saturating_add);
    let even = (area / wanted as f64).sqrt();
    // The count falls with the side, in steps; between these bounds lies any that can be had.
    let (mut small, mut large) = (even / 64.0, even * 64.0);
    for _ in 0..60 {
        let side = (small * large).sqrt();
        if count(side) > wanted { small = side } else { large = side }
    }
    // Either of the two neighbours may be nearer to what is wanted.
    let miss = |side: f64| count(side).abs_diff(wanted);
    Ok(if miss(small) < miss(large) { small } else { large })
}

/// How many columns and rows a face is cut into; of a triangle, k² parts for k of both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    pub(super) columns: usize,
    pub(super) rows: usize,
}

/// As square as they can be, of about this side.
pub(super) fn cells(outline: &Outline, side: f64) -> Cells {
    let number = |length: f64| (length / side).round().clamp(1.0, MOST_PATCHES as f64) as usize;
    match outline {
        Outline::Flat(polygon) => match *polygon.corners() {
            [a, b, c, d] => {
                let mean = |p: f64, q: f64| number(0.5 * (p + q));
                Cells { columns: mean(a.distance(b), c.distance(d)), rows: mean(b.distance(c), d.distance(a)) }
            }
            _ => Cells { columns: number(polygon.area().sqrt()), rows: number(polygon.area().sqrt()) },
        },
        Outline::Curved(surface) => match surface.quadric {
            // Bands of the same height and sectors: a quarter of the equator has as much area as a square of the radius.
            Quadric::Sphere { radius, .. } => Cells { columns: number(2.0 * radius), rows: number(TAU * radius) },
            Quadric::Disk { .. } => {
                let across = number(surface.quadric.area().sqrt());
                Cells { columns: across, rows: across }
            }
            Quadric::Cylinder { length, radius, .. } => Cells { columns: number(TAU * radius), rows: number(length) },
        },
    }
}

impl Cells {
    pub(super) fn count(self) -> usize {
        self.columns.saturating_mul(self.rows)
    }

    /// The cells of a triangle or quadrangle.
    pub(super) fn of(self, polygon: &Polygon) -> Vec<Polygon> {
        let cell = |corners: &[DVec3]| Polygon::new(corners.to_vec()).ok();
        match *polygon.corners() {
            [a, b, c, d] => {
                let at = |i: usize, j: usize| {
                    let (u, v) = (i as f64 / self.columns as f64, j as f64 / self.rows as f64);
                    a.lerp(b, u).lerp(d.lerp(c, u), v)
                };
                let each = (0..self.rows).flat_map(|j| (0..self.columns).map(move |i| (i, j)));
                each.filter_map(|(i, j)| cell(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])).collect()
            }
            [a, b, c] => {
                let k = self.columns;
                let at = |i: usize, j: usize| a + ((b - a) * i as f64 + (c - a) * j as f64) / k as f64;
                let upright = (0..k).flat_map(|j| (0..k - j).map(move |i| [(i, j), (i + 1, j), (i, j + 1)]));
                let inverted = (1..k).flat_map(|j| (0..k - j).map(move |i| [(i, j), (i + 1, j - 1), (i + 1, j)]));
                upright.chain(inverted).filter_map(|three| cell(&three.map(|(i, j)| at(i, j)))).collect()
            }
            _ => vec![polygon.clone()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;
    use crate::scene::{Geometry, Material, SceneDescription};

    fn described(name: &str) -> SceneDescription {
        builtin(name, &[]).unwrap().unwrap()
    }

    fn cut(scene: &Scene, wanted: usize) -> Patches {
        Patches::new(scene, Fineness::Count(wanted), Materials::Diffuse).unwrap()
    }

    #[test]
    fn the_patches_make_up_the_surfaces_without_what_is_covered() {
        let scene = Scene::new(described("cornell-original")).unwrap();
        for wanted in [19, 200, 2000] {
            let patches = cut(&scene, wanted);
            let of = |name: &str| -> f64 {
                let named = patches.all().iter().filter(|patch| patches.shapes()[patch.shape] == name);
                named.map(|patch| patch.area).sum()
            };
            // The published areas; the floor without the blocks' footprints.
            let footprints = 0.5 * ((240.0 - 130.0) * (114.0 - 225.0) - (272.0 - 65.0) * (290.0 - 82.0_f64)).abs()
                + 0.5 * ((314.0 - 423.0) * (406.0 - 296.0) - (456.0 - 247.0) * (472.0 - 265.0_f64)).abs();
            for (name, area) in
                [("light", 13650.0), ("back", 303_376.64), ("red", 306_904.514), ("floor", 308_231.04 - footprints)]
            {
                assert!((of(name) - area).abs() < 1e-6 * area, "{name}, {wanted}: {} against {area}", of(name));
            }
            let count = patches.all().len();
            assert!(wanted < 100 || (count as f64 / wanted as f64 - 1.0).abs() < 0.15, "{count} for {wanted}");
        }
    }

    #[test]
    fn rays_find_the_patch_that_they_meet() {
        let mut mixed = described("cornell-bitterli");
        let sphere = Geometry::Sphere { centre: DVec3::new(0.3, 1.2, 0.2), radius: 0.3 };
        mixed.shapes.push(crate::scene::Shape { geometry: sphere, ..mixed.shapes[0].clone() });
        for description in [described("cornell-original"), mixed, described("furnace-sphere")] {
            let scene = Scene::new(description).unwrap();
            let patches = cut(&scene, 1500);
            let mut met = 0;
            for (i, patch) in patches.all().iter().enumerate() {
                for u in [DVec2::new(0.3, 0.6), DVec2::new(0.9, 0.1)] {
                    let (p, n) = patch.form.at(u);
                    let ray = crate::scene::Ray::new(p + n * 1e-6 * scene.extent(), -n);
                    // Where surfaces touch, the ray may meet the other one.
                    let own = patches.faces()[patch.face].primitives;
                    let Some(surface) = scene.intersect(&ray).filter(|surface| own.contains(&surface.primitive)) else {
                        continue;
                    };
                    assert_eq!(patches.at(&surface, n), Some(i), "patch {i} of {}", scene.name());
                    met += 1;
                }
            }
            assert!(met > patches.all().len(), "{met} of {} points were met", 2 * patches.all().len());
        }
    }

    #[test]
    fn the_back_of_a_surface_that_has_one_side_is_no_patch() {
        let scene = Scene::new(described("cube-one-emitter")).unwrap();
        let patches = cut(&scene, 6);
        let ray = crate::scene::Ray::new(DVec3::new(0.5, 0.5, -1.0), DVec3::Z);
        assert_eq!(patches.at(&scene.intersect(&ray).unwrap(), -ray.dir), None);
        assert_eq!(patches.all().len(), 6);
        let emitted: Rgb = patches.all().iter().map(|patch| patch.emission * patch.area).sum();
        assert!((emitted.0 - DVec3::ONE).length() < 1e-15);
    }

    #[test]
    fn cells_of_every_outline_have_its_area() {
        let corners = [(0.0, 0.0), (3.0, 0.0), (2.0, 1.0), (0.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
        for corners in [&corners[..], &corners[..3]] {
            let polygon = Polygon::new(corners.to_vec()).unwrap();
            let cells = cells(&Outline::Flat(polygon.clone()), 0.1);
            let all = cells.of(&polygon);
            assert_eq!(all.len(), cells.count());
            assert!((all.iter().map(Polygon::area).sum::<f64>() - polygon.area()).abs() < 1e-12);
            assert!(all.iter().all(|cell| cell.normal().dot(polygon.normal()) > 0.999));
        }
    }

    #[test]
    fn a_texture_is_averaged_over_each_patch() {
        let mut description = described("cube-one-emitter");
        let checkers = crate::scene::Texture::Checkerboard {
            first: Rgb::grey(0.2),
            second: Rgb::grey(0.6),
            to_uv: glam::DAffine2::IDENTITY,
        };
        description.materials.push(Material::diffuse("checkers", checkers));
        let plate = Geometry::Rectangle {
            to_world: glam::DAffine3::from_scale_rotation_translation(
                DVec3::splat(0.25),
                glam::DQuat::IDENTITY,
                DVec3::splat(0.5),
            ),
        };
        description.shapes[1].geometry = plate;
        description.shapes[1].material = 1;
        let scene = Scene::new(description).unwrap();
        let reflectances = |wanted: usize| -> Vec<f64> {
            let patches = cut(&scene, wanted);
            patches.all().iter().filter(|patch| patch.shape == 1).map(|patch| patch.reflectance.mean()).collect()
        };
        let whole = reflectances(6);
        assert!(whole.len() == 1 && (whole[0] - 0.4).abs() < 1e-12, "{whole:?}");
        let quarters = Patches::new(&scene, Fineness::Area(1.0 / 16.0), Materials::Diffuse).unwrap();
        let quarters: Vec<f64> =
            quarters.all().iter().filter(|patch| patch.shape == 1).map(|patch| patch.reflectance.mean()).collect();
        assert_eq!(quarters.len(), 4);
        assert!(quarters.iter().all(|rho| (rho - 0.2).abs() < 1e-12 || (rho - 0.6).abs() < 1e-12), "{quarters:?}");
    }

    #[test]
    fn what_cannot_be_cut_is_said() {
        let scene = Scene::new(described("cube-one-emitter")).unwrap();
        let cut = |fineness| Patches::new(&scene, fineness, Materials::Diffuse).unwrap_err().to_string();
        assert!(cut(Fineness::Count(0)).contains("allowed are 1 to"));
        assert!(cut(Fineness::Area(0.0)).contains("> 0") && cut(Fineness::Area(f64::NAN)).contains("> 0"));
        assert!(cut(Fineness::Area(1e-12)).contains("allowed are"));
        let empty = SceneDescription { shapes: Vec::new(), ..described("cube-one-emitter") };
        let empty = Scene::new(empty).unwrap();
        let error = Patches::new(&empty, Fineness::Count(10), Materials::Diffuse).unwrap_err();
        assert_eq!(error, RadiosityError::NoSurface);
    }
}
