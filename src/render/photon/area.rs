//! How much of a ball around a point of a surface is surface: at an edge half of the disk, at a corner a quarter.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::disk::{POINTS, disk, rim};
use crate::math::frame::Frame;
use crate::scene::{Quadric, Ray, Scene, Surface};

/// Cosine of the angle up to which normals count as those of one surface.
pub const SAME: f64 = 0.9;
/// Surfaces that a ray which looks for an outline goes through.
const LAYERS: u32 = 16;
/// Triangles of a shape up to which they are cut with the disk.
const MOST: usize = 64;

/// The outline of a shape.
#[derive(Clone, Debug)]
pub(super) enum Outline {
    /// Corners and unit normal of each triangle.
    Flat(Vec<([DVec3; 3], DVec3)>),
    Sphere {
        radius: f64,
    },
    Disk {
        centre: DVec3,
        radius: f64,
    },
    /// Found by rays; the area is known.
    Unknown {
        area: f64,
    },
}

/// The outline of every shape of a scene. That of more than 64 triangles, or of a cylinder, is not known.
pub(super) fn outlines(scene: &Scene) -> Vec<Outline> {
    let mut all: Vec<Outline> = scene.areas().into_iter().map(|area| Outline::Unknown { area }).collect();
    let unknown = all.clone();
    let mut counts = vec![0; all.len()];
    for primitive in 0..scene.triangles() {
        let (corners, shape) = scene.triangle(primitive);
        counts[shape] += 1;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        match &mut all[shape] {
            outline if counts[shape] > MOST => *outline = unknown[shape].clone(),
            Outline::Flat(triangles) => triangles.push((corners, normal)),
            outline => *outline = Outline::Flat(vec![(corners, normal)]),
        }
    }
    for (quadric, shape, _) in scene.quadrics() {
        all[shape] = match quadric {
            Quadric::Sphere { radius, .. } => Outline::Sphere { radius },
            Quadric::Disk { centre, x, .. } => Outline::Disk { centre, radius: x.length() },
            Quadric::Cylinder { .. } => continue,
        };
    }
    all
}

impl Outline {
    /// The area of the shape within `radius` of the point, where normals agree, over π radius².
    ///
    /// Exact on flat surfaces and spheres. Triangles that are bent against the tangent plane count by their projection over
    /// the cosine. Where the outline is not known, the part of the tangent plane that has the shape above or below it.
    pub(super) fn share(&self, scene: &Scene, surface: &Surface, radius: f64) -> f64 {
        let circle = PI * radius * radius;
        match self {
            Self::Unknown { area } => {
                let n = surface.ng;
                let has = |p| is_at(scene, surface, radius, p);
                if rim(surface.p, n, radius).all(has) {
                    return 1.0;
                }
                // The point itself is of the surface.
                let inside = disk(surface.p, n, radius).filter(|&p| has(p)).count().max(1);
                (inside as f64 / f64::from(POINTS)).min(area / circle)
            }
            // Of a cap all normals within the angle whose cosine is SAME: its height is 1 − SAME radii.
            Self::Sphere { radius: of_sphere } => (2.0 * PI * of_sphere * of_sphere * (1.0 - SAME) / circle).min(1.0),
            Self::Disk { centre, radius: of_disk } => lens(centre.distance(surface.p), radius, *of_disk) / circle,
            Self::Flat(triangles) => {
                let frame = Frame::about(surface.ng);
                let near = triangles.iter().filter(|triangle| belongs(triangle, surface, radius));
                let area: f64 = near
                    .map(|(corners, normal)| {
                        let flat = corners.map(|corner| frame.to_local(corner - surface.p).truncate());
                        cut(flat, radius).abs() / normal.dot(surface.ng).abs()
                    })
                    .sum();
                // A point of the surface has some around it; less than this is rounding.
                (area / circle).max(1e-12)
            }
        }
    }

    /// Whether the point of the tangent plane lies over the shape.
    pub(super) fn holds(&self, scene: &Scene, surface: &Surface, radius: f64, p: DVec3) -> bool {
        match self {
            Self::Unknown { .. } => is_at(scene, surface, radius, p),
            Self::Sphere { .. } => true,
            Self::Disk { centre, radius } => centre.distance(p) <= *radius,
            Self::Flat(triangles) => {
                let n = surface.ng;
                triangles.iter().filter(|triangle| belongs(triangle, surface, radius)).any(|([a, b, c], _)| {
                    let [x, y, z] = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).cross(p - from).dot(n));
                    (x >= 0.0 && y >= 0.0 && z >= 0.0) || (x <= 0.0 && y <= 0.0 && z <= 0.0)
                })
            }
        }
    }
}

/// Whether the same part of the shape lies at a point of the tangent plane, above or below it: a surface whose normals agree to
/// [`SAME`] rises by no more than .485 of the way. Other shapes do not hide it.
fn is_at(scene: &Scene, surface: &Surface, radius: f64, p: DVec3) -> bool {
    let (n, height) = (surface.ng, (1.0 - SAME * SAME).sqrt() / SAME * radius);
    let mut ray = Ray::up_to(p + n * height, -n, 2.0 * height);
    for _ in 0..LAYERS {
        let Some(met) = scene.intersect(&ray) else { return false };
        if met.shape == surface.shape && met.ng.dot(n).abs() > SAME {
            return true;
        }
        ray = scene.leave(&met, -n);
        ray.t_max = height + (met.p - p).dot(n);
    }
    false
}

/// Whether a triangle is of the same part of the surface: it faces the same way and is no farther than the radius, or it lies
/// in the same plane.
fn belongs((corners, normal): &([DVec3; 3], DVec3), surface: &Surface, radius: f64) -> bool {
    let height = (corners[0] - surface.p).dot(*normal).abs();
    // Meshes need not be wound one way: in one plane, to a thousandth of the radius, either way counts.
    normal.dot(surface.ng).abs() > SAME && height < if same_way(*normal, surface) { radius } else { 1e-3 * radius }
}

fn same_way(normal: DVec3, surface: &Surface) -> bool {
    normal.dot(surface.ng) > 0.0
}

/// Signed area of the part of a triangle within `radius` of the origin.
fn cut([a, b, c]: [DVec2; 3], radius: f64) -> f64 {
    wedge(a, b, radius) + wedge(b, c, radius) + wedge(c, a, radius)
}

/// The same of the triangle of the origin, `a` and `b`.
fn wedge(a: DVec2, b: DVec2, radius: f64) -> f64 {
    let sector = |u: DVec2, v: DVec2| 0.5 * radius * radius * u.perp_dot(v).atan2(u.dot(v));
    let way = b - a;
    let (length2, along) = (way.length_squared(), -a.dot(way));
    if length2 <= 0.0 {
        return 0.0;
    }
    // Where the line through a and b is nearest, and how far it is within the circle to both sides.
    let foot = along / length2;
    let nearest2 = (a + way * foot).length_squared();
    let half2 = (radius * radius - nearest2) / length2;
    let (from, to) = (foot - half2.max(0.0).sqrt(), foot + half2.max(0.0).sqrt());
    if half2 <= 0.0 || to <= 0.0 || from >= 1.0 {
        return sector(a, b);
    }
    let (p, q) = (a + way * from.max(0.0), a + way * to.min(1.0));
    let before = if from > 0.0 { sector(a, p) } else { 0.0 };
    let after = if to < 1.0 { sector(q, b) } else { 0.0 };
    before + 0.5 * p.perp_dot(q) + after
}

/// Area common to two disks whose centres are this far apart.
fn lens(distance: f64, r: f64, s: f64) -> f64 {
    if distance <= (r - s).abs() {
        return PI * r.min(s) * r.min(s);
    }
    if distance >= r + s {
        return 0.0;
    }
    let angle = |near: f64, far: f64| {
        ((distance * distance + near * near - far * far) / (2.0 * distance * near)).clamp(-1.0, 1.0).acos()
    };
    let (a, b) = (angle(r, s), angle(s, r));
    r * r * (a - a.sin() * a.cos()) + s * s * (b - b.sin() * b.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_halves_and_corners_are_quarters() {
        let [o, x, y, d] = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|p| 10.0 * p);
        let square = |p: DVec2, r: f64| cut([o - p, x - p, d - p], r) + cut([o - p, d - p, y - p], r);
        let disk = PI;
        // Section 2.5's factors: 1 inside, 1/2 at an edge, 1/4 at a corner; to the roundings of coordinates up to 10.
        for (p, share) in [((5.0, 5.0), 1.0), ((5.0, 0.0), 0.5), ((0.0, 0.0), 0.25), ((10.0, 10.0), 0.25)] {
            let area = square(DVec2::new(p.0, p.1), 1.0);
            assert!((area / disk - share).abs() < 1e-13, "{p:?}: {area}");
        }
        // A segment of half the radius from the centre: π/3 − √3/4 less than the disk.
        let area = square(DVec2::new(5.0, 0.5), 1.0);
        assert!((area - (PI - (PI / 3.0 - 0.75_f64.sqrt() / 2.0))).abs() < 1e-13, "{area}");
        // A disk larger than the square.
        assert!((square(DVec2::splat(5.0), 100.0) - 100.0).abs() < 1e-10);
    }

    #[test]
    fn a_lens_is_known_where_it_is_simple() {
        assert!((lens(0.5, 1.0, 3.0) - PI).abs() < 1e-15 && lens(4.0, 1.0, 3.0) == 0.0);
        // Two unit disks a radius apart: 2π/3 − √3/2.
        assert!((lens(1.0, 1.0, 1.0) - (2.0 * PI / 3.0 - 0.75_f64.sqrt())).abs() < 1e-14);
        // At the edge of a large disk half.
        assert!((lens(1e4, 1.0, 1e4) / PI - 0.5).abs() < 1e-4);
    }
}
