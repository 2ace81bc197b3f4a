//! Spheres, disks and cylinders, hit in f64.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec2, DVec3};

use super::Ray;
use super::bvh::Aabb;

/// A curved or round surface that is not made of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Quadric {
    Sphere { centre: DVec3, radius: f64 },
    Disk { centre: DVec3, x: DVec3, y: DVec3, normal: DVec3 },
    Cylinder { from: DVec3, axis: DVec3, length: f64, radius: f64, x: DVec3 },
}

/// The differential geometry at a point of a quadric.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadricPoint {
    /// Unit normal, outwards.
    pub(crate) normal: DVec3,
    /// ∂p/∂u, or 0 at a pole.
    pub(crate) tangent: DVec3,
    pub(crate) uv: DVec2,
}

impl Quadric {
    /// The image of the unit disk, if it is round and not flat.
    pub(super) fn disk(to_world: &DAffine3) -> Option<Self> {
        let (x, y) = (to_world.matrix3.x_axis, to_world.matrix3.y_axis);
        let size = x.length_squared();
        // A thousandth of the tolerance to which scene files write their matrices.
        let round = x.dot(y).abs() <= 1e-6 * size && (y.length_squared() - size).abs() <= 1e-6 * size;
        let normal = x.cross(y).normalize_or_zero() * to_world.matrix3.determinant().signum();
        (round && normal != DVec3::ZERO).then_some(Self::Disk { centre: to_world.translation, x, y, normal })
    }

    pub(super) fn cylinder(from: DVec3, to: DVec3, radius: f64) -> Option<Self> {
        let length = from.distance(to);
        let axis = (to - from) / length;
        (length > 0.0 && radius > 0.0 && axis.is_finite() && radius.is_finite()).then(|| Self::Cylinder {
            from,
            axis,
            length,
            radius,
            // For an axis along z this is x, as in Mitsuba, whose rule for other axes (Duff et al. 2017) is glam's too.
            x: axis.any_orthonormal_pair().0,
        })
    }

    pub(crate) fn bounds(&self) -> Aabb {
        match *self {
            Self::Sphere { centre, radius } => Aabb { min: centre - radius, max: centre + radius },
            Self::Disk { centre, x, y, .. } => {
                let reach = (x * x + y * y).map(f64::sqrt);
                Aabb { min: centre - reach, max: centre + reach }
            }
            Self::Cylinder { from, axis, length, radius, .. } => {
                let to = from + axis * length;
                let reach = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt) * radius;
                Aabb { min: from.min(to) - reach, max: from.max(to) + reach }
            }
        }
    }

    pub(crate) fn area(&self) -> f64 {
        match *self {
            Self::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Self::Disk { x, y, .. } => PI * x.cross(y).length(),
            Self::Cylinder { length, radius, .. } => TAU * radius * length,
        }
    }

    /// The nearest hit with 0 < t < `t_max`.
    pub(super) fn hit(&self, ray: &Ray, t_max: f64) -> Option<f64> {
        let nearest = |[near, far]: [f64; 2]| {
            if near > 0.0 { (near < t_max).then_some(near) } else { (far > 0.0 && far < t_max).then_some(far) }
        };
        match *self {
            Self::Sphere { centre, radius } => {
                let to_centre = centre - ray.origin;
                let b = to_centre.dot(ray.dir);
                // The foot of the perpendicular, not b² − c: nothing cancels for a far and small sphere.
                let off_axis = to_centre - b * ray.dir;
                let half_chord2 = (radius - off_axis.length()) * (radius + off_axis.length());
                if half_chord2 < 0.0 {
                    return None;
                }
                let far_side = b + half_chord2.sqrt().copysign(b);
                let c = (to_centre.length() - radius) * (to_centre.length() + radius);
                // On the surface c is 0 but for rounding, and the exact root is 0: the other one counts.
                let other = if far_side == 0.0 { 0.0 } else { c / far_side };
                nearest([far_side.min(other), far_side.max(other)])
            }
            Self::Disk { centre, x, y, normal } => {
                let t = (centre - ray.origin).dot(normal) / ray.dir.dot(normal);
                let p = ray.at(t) - centre;
                let (u, v) = (p.dot(x) / x.length_squared(), p.dot(y) / y.length_squared());
                (t > 0.0 && t < t_max && u * u + v * v <= 1.0).then_some(t)
            }
            Self::Cylinder { from, axis, length, radius, .. } => {
                let flat = |w: DVec3| w - axis * w.dot(axis);
                let (o, d) = (flat(ray.origin - from), flat(ray.dir));
                let (a, b) = (d.length_squared(), -o.dot(d));
                let off_axis = (o + d * (b / a)).length();
                let half_chord2 = (radius - off_axis) * (radius + off_axis) * a;
                if !(half_chord2 >= 0.0 && a > 0.0) {
                    return None;
                }
                let far_side = b + half_chord2.sqrt().copysign(b);
                let c = (o.length() - radius) * (o.length() + radius);
                let (t0, t1) = (far_side / a, if far_side == 0.0 { 0.0 } else { c / far_side });
                let inside = |t: f64| (0.0..=length).contains(&(ray.at(t) - from).dot(axis));
                let mut hits = [t0.min(t1), t0.max(t1)].into_iter();
                hits.find(|&t| t > 0.0 && t < t_max && inside(t))
            }
        }
    }

    /// The geometry at the point `p` of the surface.
    pub(crate) fn at(&self, p: DVec3) -> QuadricPoint {
        match *self {
            Self::Sphere { centre, .. } => {
                let normal = (p - centre).normalize_or(DVec3::Z);
                let tangent = DVec3::new(-normal.y, normal.x, 0.0);
                let v = normal.x.hypot(normal.y).atan2(normal.z) / PI;
                QuadricPoint { normal, tangent, uv: DVec2::new(turn(normal.y, normal.x), v) }
            }
            Self::Disk { centre, x, y, normal } => {
                let q = p - centre;
                let (a, b) = (q.dot(x) / x.length_squared(), q.dot(y) / y.length_squared());
                QuadricPoint { normal, tangent: q, uv: DVec2::new(a.hypot(b), turn(b, a)) }
            }
            Self::Cylinder { from, axis, length, x, .. } => {
                let q = p - from;
                let height = q.dot(axis);
                let normal = (q - axis * height).normalize_or(x);
                let uv = DVec2::new(turn(normal.dot(axis.cross(x)), normal.dot(x)), height / length);
                QuadricPoint { normal, tangent: axis.cross(normal), uv }
            }
        }
    }

    /// The `u` that [`Self::sample_area`] maps to the point `p` of the surface.
    pub(crate) fn sample_area_inv(&self, p: DVec3) -> DVec2 {
        match *self {
            Self::Sphere { centre, .. } => {
                crate::sampling::warp::uniform_sphere_inv((p - centre).normalize_or(DVec3::Z))
            }
            Self::Disk { centre, x, y, .. } => {
                let q = p - centre;
                let on_disk = DVec2::new(q.dot(x) / x.length_squared(), q.dot(y) / y.length_squared());
                crate::sampling::warp::concentric_disk_inv(on_disk)
            }
            Self::Cylinder { .. } => self.at(p).uv,
        }
    }

    /// Maps the unit square to the surface, uniformly in area. Inverse: [`Self::sample_area_inv`].
    pub(crate) fn sample_area(&self, u: DVec2) -> DVec3 {
        match *self {
            Self::Sphere { centre, radius } => centre + radius * crate::sampling::warp::uniform_sphere(u),
            Self::Disk { centre, x, y, .. } => {
                let on_disk = crate::sampling::warp::concentric_disk(u);
                centre + x * on_disk.x + y * on_disk.y
            }
            Self::Cylinder { from, axis, length, radius, x } => {
                let (sin, cos) = (TAU * u.x).sin_cos();
                from + axis * (length * u.y) + (x * cos + axis.cross(x) * sin) * radius
            }
        }
    }
}

/// An azimuth as a fraction of a full turn, in [0, 1).
fn turn(y: f64, x: f64) -> f64 {
    let t = y.atan2(x) / TAU;
    if t < 0.0 { (t + 1.0).min(1.0 - f64::EPSILON / 2.0) } else { t }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sphere::direction;
    use crate::sampling::stream::{stream, uniform};
    use glam::DMat3;

    fn all() -> [Quadric; 4] {
        let turned = DAffine3::from_mat3_translation(
            DMat3::from_rotation_x(0.7) * DMat3::from_diagonal(DVec3::splat(1.5)),
            DVec3::new(5.0, 2.0, -1.0),
        );
        [
            Quadric::Sphere { centre: DVec3::new(3.0, -1.0, 1e3), radius: 0.25 },
            Quadric::Sphere { centre: DVec3::ZERO, radius: 100.0 },
            Quadric::disk(&turned).unwrap(),
            Quadric::cylinder(DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 0.0, 4.0), 0.3).unwrap(),
        ]
    }

    #[test]
    fn rays_towards_points_of_the_surface_hit_it_there_or_before() {
        let mut rng = stream(3, 0, 0);
        for quadric in all() {
            let bounds = quadric.bounds();
            for _ in 0..2000 {
                let mut u = || uniform(&mut rng);
                let target = quadric.sample_area(DVec2::new(u(), u()));
                let slack = 1e-12 * target.length();
                assert!(target.cmpge(bounds.min - slack).all() && target.cmple(bounds.max + slack).all());
                let normal = quadric.at(target).normal;
                let w = direction(PI * u(), TAU * u());
                let (distance, facing) = (10.0 * u() + 0.01, w.dot(normal));
                let ray = Ray::new(target + w * distance, -w);
                let t = quadric.hit(&ray, f64::INFINITY).expect("a hit");
                // 1e-12 of the size of the scene, magnified where the ray grazes.
                let tol = 1e-11 * (1.0 + target.length() + distance) / facing.abs().max(1e-4);
                assert!(t <= distance + tol, "{quadric:?}: {t} against {distance}");
                let p = ray.at(t);
                assert!((quadric.at(p).normal.dot(normal) > 1.0 - 1e-6) || t < distance - tol);
                assert!(quadric.hit(&Ray::up_to(ray.origin, ray.dir, t), t).is_none());
            }
        }
    }

    #[test]
    fn the_inverse_of_the_uniform_map_returns() {
        let mut rng = stream(4, 0, 0);
        for quadric in all() {
            for _ in 0..500 {
                let u = DVec2::new(uniform(&mut rng), uniform(&mut rng)) * 0.98 + 0.01;
                let back = quadric.sample_area_inv(quadric.sample_area(u));
                // Coordinates of up to 1e3 for a radius of .25, in roundings; an azimuth is worse near its pole by 1 / sin θ.
                assert!((back - u).abs().max_element() <= 1e-11, "{quadric:?}: {u} became {back}");
            }
        }
    }

    #[test]
    fn a_flat_or_oval_disk_is_none() {
        let oval = DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0));
        assert!(Quadric::disk(&oval).is_none() && Quadric::disk(&DAffine3::from_scale(DVec3::ZERO)).is_none());
        assert!(Quadric::cylinder(DVec3::ONE, DVec3::ONE, 1.0).is_none());
    }
}
