//! All surfaces of a scene in the form in which rays meet them: one list of triangles, one of quadrics.

use glam::{DAffine3, DVec2, DVec3};

use super::bvh::{Aabb, BoxBvh, TriangleBvh, TriangleHit, Work, prefetch};
use super::mesh::Mesh;
use super::quadric::Quadric;
use super::shape::{Geometry, Shape};
use super::{BuildError, Ray};
use crate::math::color::Rgb;
use crate::math::frame::Frame;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The distance along the ray.
    pub t: f64,
    /// The number of the primitive: triangles first, then quadrics.
    primitive: u32,
    /// Barycentric coordinates of the second and third corner of a triangle.
    b1: f64,
    b2: f64,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point.
    pub p: DVec3,
    /// Unit normal of the geometry, outwards.
    pub ng: DVec3,
    /// The frame in which the material is evaluated; its n is the shading normal, on the side of `ng`.
    pub frame: Frame,
    /// Texture coordinates.
    pub uv: DVec2,
    /// Interpolated colour of the vertices; white where there is none.
    pub color: Rgb,
    /// Number of the shape.
    pub shape: usize,
    /// Number of the primitive.
    pub primitive: usize,
}

#[derive(Clone, Copy, Debug)]
struct TriangleRecord {
    /// Unit normal, outwards.
    ng: DVec3,
    shape: u32,
}

/// What the triangles of a shape have beside their corners.
#[derive(Clone, Debug, Default)]
struct Attributes {
    /// The mesh, if it has anything of its own at its vertices.
    interpolated: Option<std::sync::Arc<Mesh>>,
    first_triangle: u32,
    /// 1, or −1 where the shape is turned inside out.
    sign: f64,
}

/// The surfaces of a scene.
#[derive(Debug)]
pub(super) struct Surfaces {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    records: Vec<TriangleRecord>,
    attributes: Vec<Attributes>,
    quadrics: Vec<(Quadric, u32)>,
    triangle_bvh: TriangleBvh,
    quadric_bvh: BoxBvh,
}

impl Surfaces {
    pub(super) fn new(shapes: &[Shape]) -> Result<Self, BuildError> {
        let mut positions = Vec::new();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        let mut records = Vec::new();
        let mut attributes = Vec::new();
        let mut quadrics = Vec::new();
        for (number, shape) in shapes.iter().enumerate() {
            let refuse = |reason: &str| BuildError::Shape { shape: shape.name.clone(), reason: reason.into() };
            let sign = if shape.flip_normals { -1.0 } else { 1.0 };
            let mut mesh = None;
            let mut quadric = None;
            match &shape.geometry {
                Geometry::Sphere { centre, radius } => {
                    if !(*radius > 0.0 && radius.is_finite() && centre.is_finite()) {
                        return Err(refuse("a sphere's radius must be > 0 and finite"));
                    }
                    quadric = Some(Quadric::Sphere { centre: *centre, radius: *radius });
                }
                Geometry::Disk { to_world } => {
                    let disk = Quadric::disk(to_world).ok_or_else(|| refuse("a disk must stay round and not flat"))?;
                    quadric = Some(disk);
                }
                Geometry::Cylinder { from, to, radius } => {
                    let tube = Quadric::cylinder(*from, *to, *radius);
                    quadric = Some(tube.ok_or_else(|| refuse("a cylinder needs two ends and a radius > 0"))?);
                }
                Geometry::Rectangle { to_world } => mesh = Some(std::sync::Arc::new(rectangle(*to_world)?)),
                Geometry::Cube { to_world } => mesh = Some(std::sync::Arc::new(cube(*to_world)?)),
                Geometry::Mesh(of_file) => mesh = Some(of_file.clone()),
            }
            let first_triangle = triangles.len();
            if let Some(mesh) = &mesh {
                let first_vertex = positions.len();
                if (first_vertex + mesh.positions().len()).max(first_triangle + mesh.triangles().len()) > MOST {
                    return Err(BuildError::TooManyPrimitives { allowed: MOST });
                }
                positions.extend_from_slice(mesh.positions());
                for corners in mesh.triangles() {
                    let [a, b, c] = corners.map(|i| mesh.positions()[i as usize]);
                    let ng = (b - a).cross(c - a).normalize_or_zero() * sign;
                    records.push(TriangleRecord { ng, shape: number as u32 });
                    triangles.push(corners.map(|i| i + first_vertex as u32));
                }
            }
            quadrics.extend(quadric.map(|quadric| (quadric, number as u32)));
            let interpolated =
                mesh.filter(|mesh| !(mesh.normals().is_empty() && mesh.uvs().is_empty() && mesh.colors().is_empty()));
            attributes.push(Attributes { interpolated, first_triangle: first_triangle as u32, sign });
        }
        let boxes: Vec<_> = quadrics.iter().map(|(quadric, _)| quadric.bounds()).collect();
        let triangle_bvh = TriangleBvh::build(&positions, &triangles);
        let quadric_bvh = BoxBvh::build(&boxes);
        Ok(Self { positions, triangles, records, attributes, quadrics, triangle_bvh, quadric_bvh })
    }

    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub(super) fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.nearest_with_quadrics(ray, self.triangle_bvh.closest(ray))
    }

    /// [`Self::closest`] of each ray: faster for those that go nearly the same way.
    pub(super) fn closest_of_each(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        let mut of_triangles = vec![None; rays.len()];
        self.triangle_bvh.closest_of_each(rays, &mut of_triangles);
        hits.extend(rays.iter().zip(of_triangles).map(|(ray, hit)| self.nearest_with_quadrics(ray, hit)));
    }

    #[inline]
    fn nearest_with_quadrics(&self, ray: &Ray, hit: Option<TriangleHit>) -> Option<Hit> {
        let hit = hit.map(|hit| Hit { t: hit.t, primitive: hit.triangle, b1: hit.b1, b2: hit.b2 });
        if let Some(record) = hit.and_then(|hit| self.records.get(hit.primitive as usize)) {
            prefetch(record);
        }
        if self.quadrics.is_empty() { hit } else { self.closest_quadric(ray, hit) }
    }

    fn closest_quadric(&self, ray: &Ray, before: Option<Hit>) -> Option<Hit> {
        let ray = Ray::up_to(ray.origin, ray.dir, before.map_or(ray.t_max, |hit| hit.t));
        let found = self.quadric_bvh.closest(&ray, |i, t_max| self.quadrics[i as usize].0.hit(&ray, t_max));
        let first = self.triangles.len() as u32;
        found.map(|(i, t)| Hit { t, primitive: first + i, b1: 0.0, b2: 0.0 }).or(before)
    }

    #[inline]
    pub(super) fn occluded(&self, ray: &Ray) -> bool {
        let meets = |i: u32, t_max: f64| self.quadrics[i as usize].0.hit(ray, t_max).is_some();
        self.triangle_bvh.occluded(ray) || (!self.quadrics.is_empty() && self.quadric_bvh.occluded(ray, meets))
    }

    /// The point of the surface where `ray` has met it. `tangent` asks for a frame along ∂p/∂u.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub(super) fn surface(&self, ray: &Ray, hit: &Hit, tangent: impl Fn(usize) -> bool) -> Surface {
        let at = hit.primitive as usize;
        let p = ray.at(hit.t);
        let Some(record) = self.records.get(at) else {
            return self.quadric_surface(p, at);
        };
        let shape = record.shape as usize;
        let attributes = &self.attributes[shape];
        let mut surface = Surface {
            p,
            ng: record.ng,
            frame: Frame::about(record.ng),
            uv: DVec2::new(hit.b1, hit.b2),
            color: Rgb::WHITE,
            shape,
            primitive: at,
        };
        if let Some(mesh) = &attributes.interpolated {
            Self::dress(&mut surface, mesh, attributes, hit, tangent(shape));
        }
        surface
    }

    /// Adds what is interpolated between the corners.
    fn dress(s: &mut Surface, mesh: &Mesh, attributes: &Attributes, hit: &Hit, tangent: bool) {
        let [i, j, k] = mesh.triangles()[s.primitive - attributes.first_triangle as usize].map(|i| i as usize);
        let (b0, b1, b2) = (1.0 - hit.b1 - hit.b2, hit.b1, hit.b2);
        let mut n = s.ng;
        if let normals @ [_, ..] = mesh.normals() {
            let smooth = (normals[i] * b0 + normals[j] * b1 + normals[k] * b2) * attributes.sign;
            // A normal on the other side than the triangle's own is a mistake of the file, not a surface.
            if smooth.dot(s.ng) > 0.0 {
                n = smooth.normalize();
                s.frame = Frame::about(n);
            }
        }
        if let uvs @ [_, ..] = mesh.uvs() {
            s.uv = uvs[i] * b0 + uvs[j] * b1 + uvs[k] * b2;
            if tangent {
                let p = mesh.positions();
                let (e1, e2, d1, d2) = (p[j] - p[i], p[k] - p[i], uvs[j] - uvs[i], uvs[k] - uvs[i]);
                // Solves ∂p/∂u du + ∂p/∂v dv = dp for both edges; the length does not count, its sign does.
                let along_u = (e1 * d2.y - e2 * d1.y) * d1.perp_dot(d2).signum();
                s.frame = Frame::with_tangent(n, along_u);
            }
        }
        if let colors @ [_, ..] = mesh.colors() {
            s.color = colors[i] * b0 + colors[j] * b1 + colors[k] * b2;
        }
    }

    fn quadric_surface(&self, p: DVec3, primitive: usize) -> Surface {
        let (quadric, shape) = self.quadrics[primitive - self.triangles.len()];
        let at = quadric.at(p);
        let ng = at.normal * self.attributes[shape as usize].sign;
        let frame = Frame::with_tangent(ng, at.tangent);
        Surface { p, ng, frame, uv: at.uv, color: Rgb::WHITE, shape: shape as usize, primitive }
    }

    /// Does `work` with the best instructions of the machine.
    #[inline]
    pub(super) fn accelerate<W: Work>(&self, work: W) -> W::Output {
        self.triangle_bvh.accelerate(work)
    }

    /// The surface at a point of one of two primitives: of the first if it is a quadric or the point lies within it.
    pub(super) fn surface_at(&self, [first, second]: [usize; 2], p: DVec3) -> Surface {
        if first >= self.triangles.len() {
            return self.quadric_surface(p, first);
        }
        let at = |primitive: usize| {
            let [a, b, c] = self.triangles[primitive].map(|i| self.positions[i as usize]);
            let (e1, e2, n) = (b - a, c - a, (b - a).cross(c - a));
            let [b1, b2] = [(p - a).cross(e2), e1.cross(p - a)].map(|part| part.dot(n) / n.length_squared());
            Hit { t: 0.0, primitive: primitive as u32, b1, b2 }
        };
        let hit = at(first);
        let inside = hit.b1 >= 0.0 && hit.b2 >= 0.0 && hit.b1 + hit.b2 <= 1.0;
        self.surface(&Ray::new(p, DVec3::Z), &if inside { hit } else { at(second) }, |_| true)
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    pub(super) fn primitive_count(&self) -> usize {
        self.triangles.len() + self.quadrics.len()
    }

    /// The corners of a triangle, turned so that its outside is that of the shape.
    pub(super) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[triangle].map(|i| self.positions[i as usize]);
        if self.attributes[self.records[triangle].shape as usize].sign < 0.0 { [a, c, b] } else { [a, b, c] }
    }

    pub(super) fn triangle_shape(&self, triangle: usize) -> usize {
        self.records[triangle].shape as usize
    }

    /// The quadrics with the numbers of their shapes, in the order of their primitives.
    pub(super) fn quadrics(&self) -> &[(Quadric, u32)] {
        &self.quadrics
    }

    pub(super) fn is_inside_out(&self, shape: usize) -> bool {
        self.attributes[shape].sign < 0.0
    }

    /// The largest coordinate of any surface.
    pub(super) fn extent(&self) -> f64 {
        let of = |b: Aabb| b.min.abs().max(b.max.abs()).max_element();
        let quadrics = self.quadrics.iter().map(|(quadric, _)| of(quadric.bounds()));
        quadrics.fold(self.triangle_bvh.extent(), f64::max)
    }

    /// Centre and radius of a sphere around everything; None for an empty scene.
    pub(super) fn bounding_sphere(&self) -> Option<(DVec3, f64)> {
        let all = self.quadrics.iter().map(|(quadric, _)| quadric.bounds());
        let all = all.chain((!self.triangles.is_empty()).then(|| self.triangle_bvh.bounds()));
        let (min, max) = all.map(|b| (b.min, b.max)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        Some((0.5 * (min + max), 0.5 * (max - min).length()))
    }
}

/// Primitives are numbered by 32 bits, and a few values have a meaning of their own.
const MOST: usize = u32::MAX as usize - 16;

/// \[−1, 1\]² as two triangles.
fn rectangle(to_world: DAffine3) -> Result<Mesh, BuildError> {
    let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let positions = uvs.map(|uv| (2.0 * uv - 1.0).extend(0.0));
    let mesh = Mesh::new(positions.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
    Ok(mesh.with_uvs(uvs.to_vec())?.transformed(to_world)?)
}

/// \[−1, 1\]³ as twelve triangles, each face with the unit square of texture coordinates.
fn cube(to_world: DAffine3) -> Result<Mesh, BuildError> {
    let (mut positions, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let first = positions.len() as u32;
            for uv in [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y] {
                let (a, b) = (2.0 * uv.x - 1.0, (2.0 * uv.y - 1.0) * sign);
                let mut p = [0.0; 3];
                p[axis] = sign;
                p[(axis + 1) % 3] = a;
                p[(axis + 2) % 3] = b;
                positions.push(DVec3::from_array(p));
                uvs.push(uv);
            }
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    Ok(Mesh::new(positions, triangles)?.with_uvs(uvs)?.transformed(to_world)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_faces_outwards() {
        for scale in [DVec3::ONE, DVec3::new(-2.0, 1.0, 0.5)] {
            let mesh = cube(DAffine3::from_scale(scale)).unwrap();
            for corners in mesh.triangles() {
                let [a, b, c] = corners.map(|i| mesh.positions()[i as usize]);
                assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
            }
        }
    }
}
