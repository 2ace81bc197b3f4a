//! The faces of a scene: plane polygons and curved surfaces that are yet to be cut into patches.
//!
//! Two triangles of a shape that follow each other and make a convex plane quadrangle are one face. A surface that is the
//! same on both sides has two faces. The back of any other is black: it takes up what it receives.

use glam::DVec3;

use super::RadiosityError;
use super::polygon::Polygon;
use crate::math::color::Rgb;
use crate::scene::{Quadric, Scene};

/// The outline of a face.
#[derive(Clone, Debug)]
pub enum Outline {
    /// A triangle or a convex quadrangle.
    Flat(Polygon),
    /// A sphere, disk or tube as a whole.
    Curved(Surface),
}

impl Outline {
    /// Its area \[m²\].
    pub fn area(&self) -> f64 {
        match self {
            Self::Flat(polygon) => polygon.area(),
            Self::Curved(surface) => surface.quadric.area(),
        }
    }
}

/// One side of a curved surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub(super) quadric: Quadric,
    /// 1 for the outside, −1 for the inside.
    pub(super) sign: f64,
}

impl Surface {
    /// The point of the unit square's `u`, which covers the surface uniformly in area, and the normal there.
    pub(super) fn at(&self, u: glam::DVec2) -> (DVec3, DVec3) {
        let p = self.quadric.sample_area(u);
        (p, self.quadric.at(p).normal * self.sign)
    }
}

/// One side of a plane or curved part of a shape.
#[derive(Clone, Debug)]
pub struct Face {
    /// Number of the shape.
    pub shape: usize,
    /// The primitives that it consists of: one twice, or two triangles.
    pub primitives: [usize; 2],
    /// Its outline, seen from this side.
    pub outline: Outline,
    /// Whether it is the side that emits.
    pub outside: bool,
    /// Radiosity emitted [W/m²].
    pub emission: Rgb,
}

/// All faces of the scene, those of triangles first.
pub(super) fn faces(scene: &Scene) -> Result<Vec<Face>, RadiosityError> {
    let mut faces = Vec::new();
    let mut triangle = 0;
    while triangle < scene.triangles() {
        let (first, shape) = scene.triangle(triangle);
        let mut primitives = [triangle; 2];
        let partner = (triangle + 1 < scene.triangles()).then(|| scene.triangle(triangle + 1));
        let joined = partner.filter(|(_, other)| *other == shape).and_then(|(second, _)| joined(first, second));
        let outline = match joined {
            Some(quadrangle) => {
                primitives[1] = triangle + 1;
                Some(quadrangle)
            }
            // A triangle without area has no share in anything.
            None => Polygon::new(first.to_vec()).ok(),
        };
        triangle = primitives[1] + 1;
        if let Some(polygon) = outline {
            add(scene, &mut faces, shape, primitives, Outline::Flat(polygon));
        }
    }
    for (i, (quadric, shape, sign)) in scene.quadrics().enumerate() {
        add(scene, &mut faces, shape, [scene.triangles() + i; 2], Outline::Curved(Surface { quadric, sign }));
    }
    if faces.is_empty() { Err(RadiosityError::NoSurface) } else { Ok(faces) }
}

fn add(scene: &Scene, faces: &mut Vec<Face>, shape: usize, primitives: [usize; 2], outline: Outline) {
    let emission = scene.shapes()[shape].emission.unwrap_or(Rgb::BLACK) * std::f64::consts::PI;
    if scene.material_of(shape).is_two_sided() {
        let back = match &outline {
            Outline::Flat(polygon) => Outline::Flat(polygon.flipped()),
            Outline::Curved(surface) => Outline::Curved(Surface { sign: -surface.sign, ..*surface }),
        };
        faces.push(Face { shape, primitives, outline: back, outside: false, emission: Rgb::BLACK });
    }
    faces.push(Face { shape, primitives, outline, outside: true, emission });
}

/// The convex quadrangle that two triangles with a common edge make, if they do.
fn joined(first: [DVec3; 3], second: [DVec3; 3]) -> Option<Polygon> {
    (0..3).find_map(|turn| {
        // The corner of the first that is not shared comes first.
        let [a, b, c] = [0, 1, 2].map(|i| first[(i + turn) % 3]);
        let opposite = (0..3).find_map(|i| {
            let [d, from, to] = [0, 1, 2].map(|k| second[(i + k) % 3]);
            // The shared edge runs the other way there.
            (from == c && to == b).then_some(d)
        })?;
        let quadrangle = Polygon::new(vec![a, b, opposite, c]).ok()?;
        // A corner that does not turn would make it a triangle with a corner too many: it could not be cut evenly.
        let corners = quadrangle.corners();
        let turns = (0..4).all(|i| {
            let (before, here, after) = (corners[(i + 3) % 4], corners[i], corners[(i + 1) % 4]);
            let (x, y) = (here - before, after - here);
            x.cross(y).dot(quadrangle.normal()) > 1e-3 * x.length() * y.length()
        });
        (corners.len() == 4 && turns).then_some(quadrangle)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    fn faces_of(name: &str) -> Vec<Face> {
        faces(&Scene::new(builtin(name, &[]).unwrap().unwrap()).unwrap()).unwrap()
    }

    fn flat(face: &Face) -> &Polygon {
        match &face.outline {
            Outline::Flat(polygon) => polygon,
            Outline::Curved(_) => panic!("a curved face"),
        }
    }

    #[test]
    fn the_faces_of_the_cornell_box_have_its_areas() {
        let all = faces_of("cornell-original");
        // Floor, four parts of the ceiling, light, back, green, two triangles of the red wall, five of each block.
        assert_eq!(all.len(), 1 + 4 + 1 + 1 + 1 + 2 + 5 + 5);
        let triangles = all.iter().filter(|face| flat(face).corners().len() == 3).count();
        assert_eq!(triangles, 2, "the red wall alone is not plane");
        assert!((flat(&all[0]).area() - 308_231.04).abs() < 1e-8);
        assert!(all.iter().all(|face| face.outside));
    }

    #[test]
    fn a_surface_that_is_the_same_on_both_sides_has_two_faces() {
        let all = faces_of("cornell-bitterli");
        let sums = all.iter().fold(DVec3::ZERO, |sum, face| sum + flat(face).normal() * flat(face).area());
        assert_eq!(all.len(), 2 * (6 + 2 * 6));
        assert!(sums.length() < 1e-12, "every face has its opposite: {sums}");
        assert_eq!(all.iter().filter(|face| !face.emission.is_black()).count(), 1, "the back of a light is dark");
    }

    #[test]
    fn two_triangles_join_only_into_a_convex_plane_quadrangle() {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        assert_eq!(joined([a, b, c], [a, c, d]).unwrap().area(), 1.0);
        assert_eq!(joined([b, c, a], [d, a, c]).unwrap().area(), 1.0);
        assert!(joined([a, b, c], [a, c, d + DVec3::Z]).is_none(), "not plane");
        assert!(joined([a, b, c], [a, c, DVec3::new(-1.0, -0.5, 0.0)]).is_none(), "not convex");
        assert!(joined([a, b, c], [a, d, c]).is_none(), "facing the other way");
        assert!(joined([a, b, DVec3::new(2.0, 0.0, 0.0) + d], [a, DVec3::new(2.0, 0.0, 0.0) + d, d]).is_some());
    }
}
