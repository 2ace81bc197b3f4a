//! Surfaces that emit: triangles, rectangles, spheres, disks and cylinders.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::LightSampling;
use crate::math::frame::Frame;
use crate::sampling::solid_angle::{SphericalRectangle, SphericalTriangle, triangle_solid_angle};
use crate::scene::geometry::Surface;
use crate::scene::quadric::Quadric;

/// Beyond this many times its half diagonal a flat emitter is sampled in area: there the distance's square varies by at
/// most a quarter over it, and solid angle would take away less than a hundredth of a pixel's variance for its price.
const NEAR: f64 = 2.0;

/// The surface of an emitter.
#[derive(Clone, Debug)]
pub(super) enum AreaEmitter {
    Triangle { a: DVec3, e1: DVec3, e2: DVec3, normal: DVec3, area: f64, near: Near },
    Rectangle { corner: DVec3, x: DVec3, y: DVec3, normal: DVec3, area: f64, near: Near },
    Quadric { quadric: Quadric, sign: f64, area: f64 },
}

/// The ball around a flat emitter within which it is sampled by solid angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    centre: DVec3,
    radius2: f64,
}

impl Near {
    fn new(centre: DVec3, half_diagonal: f64) -> Self {
        Self { centre, radius2: (NEAR * half_diagonal) * (NEAR * half_diagonal) }
    }

    #[inline]
    fn holds(&self, by: LightSampling, p: DVec3) -> bool {
        by == LightSampling::SolidAngle && p.distance_squared(self.centre) < self.radius2
    }
}

/// A point drawn on an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    pub(super) wi: DVec3,
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// Per steradian.
    pub(super) pdf: f64,
}

impl AreaEmitter {
    pub(super) fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let (e1, e2) = (b - a, c - a);
        let double = e1.cross(e2);
        let longest = e1.length().max(e2.length()).max(e1.distance(e2));
        let near = Near::new(a + (e1 + e2) / 3.0, 0.5 * longest);
        Self::Triangle { a, e1, e2, normal: double.normalize_or_zero(), area: 0.5 * double.length(), near }
    }

    /// The rectangle that two triangles make, if they do.
    pub(super) fn rectangle_of(first: [DVec3; 3], second: [DVec3; 3]) -> Option<Self> {
        // Turned so that the right angle of the first triangle comes first; the corner opposite to it is then the one
        // that only the second triangle has.
        (0..3).find_map(|turn| {
            let [a, b, c] = [0, 1, 2].map(|i| first[(i + turn) % 3]);
            let (x, y) = (b - a, c - a);
            let size = x.length_squared().max(y.length_squared());
            let close = |p: DVec3, q: DVec3| p.distance_squared(q) <= 1e-24 * size;
            let far = a + x + y;
            let others = [far, c, b];
            let same = (0..3).any(|k| (0..3).all(|i| close(second[(i + k) % 3], others[i])));
            let double = x.cross(y);
            // Edges are perpendicular up to the digits that files have.
            let right = x.dot(y).abs() <= 1e-7 * double.length();
            (same && right && double != DVec3::ZERO).then(|| Self::Rectangle {
                corner: a,
                x,
                y,
                normal: double.normalize(),
                area: double.length(),
                near: Near::new(a + 0.5 * (x + y), 0.5 * (x + y).length()),
            })
        })
    }

    pub(super) fn quadric(quadric: Quadric, inside_out: bool) -> Self {
        Self::Quadric { quadric, sign: if inside_out { -1.0 } else { 1.0 }, area: quadric.area() }
    }

    pub(super) fn area(&self) -> f64 {
        match self {
            Self::Triangle { area, .. } | Self::Rectangle { area, .. } | Self::Quadric { area, .. } => *area,
        }
    }

    /// Draws a point whose outside is seen from `p`; None where there is none, or the draw is one that is not.
    #[inline]
    pub(super) fn sample(&self, by: LightSampling, p: DVec3, u: DVec2) -> Option<Drawn> {
        match *self {
            Self::Triangle { a, e1, e2, normal, area, near } => {
                if near.holds(by, p) {
                    let spherical = SphericalTriangle::new(a - p, a + e1 - p, a + e2 - p)?;
                    let wi = spherical.sample(u);
                    let facing = -wi.dot(normal);
                    let point = p + wi * ((p - a).dot(normal) / facing);
                    return seen(Drawn { wi, point, normal, pdf: 1.0 / spherical.solid_angle() }, facing);
                }
                // Folds the square onto the triangle along its diagonal, which keeps strata in one piece.
                let (b1, b2) = if u.x > u.y { (u.x - 0.5 * u.y, 0.5 * u.y) } else { (0.5 * u.x, u.y - 0.5 * u.x) };
                towards(p, a + e1 * b1 + e2 * b2, normal, area)
            }
            Self::Rectangle { corner, x, y, normal, area, near } => {
                if near.holds(by, p) {
                    let spherical = SphericalRectangle::new(p, corner, x, y)?;
                    let point = spherical.sample(u);
                    let wi = (point - p).normalize();
                    return seen(Drawn { wi, point, normal, pdf: 1.0 / spherical.solid_angle() }, -wi.dot(normal));
                }
                towards(p, corner + x * u.x + y * u.y, normal, area)
            }
            Self::Quadric { quadric, sign, area } => {
                if let Some((axis, sin2, distance, radius)) = cone_of(&quadric, sign, by, p) {
                    return Some(sample_cone(p, (axis, distance, radius), sin2, u));
                }
                let point = quadric.sample_area(u);
                towards(p, point, quadric.at(point).normal * sign, area)
            }
        }
    }

    /// The density [1/sr] of [`AreaEmitter::sample`] at the point of `surface`, seen from `p` along `wi`.
    #[inline]
    pub(super) fn pdf(&self, by: LightSampling, p: DVec3, wi: DVec3, surface: &Surface) -> f64 {
        match *self {
            Self::Triangle { a, e1, e2, near, .. } if near.holds(by, p) => {
                1.0 / triangle_solid_angle(a - p, a + e1 - p, a + e2 - p)
            }
            Self::Rectangle { corner, x, y, near, .. } if near.holds(by, p) => {
                SphericalRectangle::new(p, corner, x, y).map_or(0.0, |spherical| 1.0 / spherical.solid_angle())
            }
            Self::Quadric { quadric, sign, area } => match cone_of(&quadric, sign, by, p) {
                Some((_, sin2, ..)) => 1.0 / cone_solid_angle(sin2),
                None => area_pdf(p, wi, surface, area),
            },
            Self::Triangle { area, .. } | Self::Rectangle { area, .. } => area_pdf(p, wi, surface, area),
        }
    }
}

#[inline]
fn seen(drawn: Drawn, facing: f64) -> Option<Drawn> {
    (facing > 0.0 && drawn.pdf.is_finite()).then_some(drawn)
}

/// The draw of a point, uniform in area.
#[inline]
fn towards(p: DVec3, point: DVec3, normal: DVec3, area: f64) -> Option<Drawn> {
    let way = point - p;
    let distance2 = way.length_squared();
    let wi = way * (1.0 / distance2.sqrt());
    let facing = -wi.dot(normal);
    seen(Drawn { wi, point, normal, pdf: distance2 / (facing * area) }, facing)
}

fn area_pdf(p: DVec3, wi: DVec3, surface: &Surface, area: f64) -> f64 {
    p.distance_squared(surface.p) / (wi.dot(surface.ng).abs() * area)
}

/// Axis, squared sine of the half angle, distance and radius of the cone of a sphere whose outside emits and is seen.
fn cone_of(quadric: &Quadric, sign: f64, by: LightSampling, p: DVec3) -> Option<(DVec3, f64, f64, f64)> {
    let Quadric::Sphere { centre, radius } = *quadric else { return None };
    let way = centre - p;
    let distance = way.length();
    let outside = sign > 0.0 && distance > radius && by == LightSampling::SolidAngle;
    outside.then(|| (way / distance, (radius / distance) * (radius / distance), distance, radius))
}

/// 2π (1 − cos) from the squared sine, without the cancellation.
fn cone_solid_angle(sin2: f64) -> f64 {
    TAU * (sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt()))
}

/// A direction in the cone of a sphere, uniform, and the point of the sphere there.
fn sample_cone(p: DVec3, (axis, distance, radius): (DVec3, f64, f64), sin2: f64, u: DVec2) -> Drawn {
    let solid_angle = cone_solid_angle(sin2);
    // 1 − cos θ of the direction within the cone.
    let below = u.x * solid_angle / TAU;
    let (cos, sin_theta2) = (1.0 - below, below * (2.0 - below));
    let sin = sin_theta2.sqrt();
    let (s, c) = (TAU * u.y).sin_cos();
    let wi = Frame::about(axis).to_world(DVec3::new(sin * c, sin * s, cos));
    // The near end of the chord.
    let half_chord = (radius * radius - distance * distance * sin_theta2).max(0.0).sqrt();
    let point = p + wi * (distance * cos - half_chord);
    let centre = p + axis * distance;
    let normal = (point - centre).normalize_or(-wi);
    Drawn { wi, point: centre + normal * radius, normal, pdf: 1.0 / solid_angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sum::Moments;
    use crate::sampling::stream::{stream, uniform};

    fn square(z: f64) -> AreaEmitter {
        // The unit square at this height, facing down.
        let [a, b, c, d] = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, z));
        AreaEmitter::rectangle_of([a, b, c], [a, c, d]).expect("a rectangle")
    }

    /// Mean and standard deviation of E for L = 1 on an upright receiver.
    fn irradiance(emitter: &AreaEmitter, by: LightSampling, p: DVec3) -> Moments {
        let mut rng = stream(5, 0, 0);
        let mut moments = Moments::default();
        for _ in 0..200_000 {
            let u = DVec2::new(uniform(&mut rng), uniform(&mut rng));
            moments.add(emitter.sample(by, p, u).map_or(0.0, |drawn| drawn.wi.z.max(0.0) / drawn.pdf));
        }
        moments
    }

    #[test]
    fn the_unit_square_has_its_irradiance_and_its_sigmas() {
        let p = DVec3::new(0.5, 0.5, 0.0);
        for (by, sigma) in [(LightSampling::Area, 0.1310654085), (LightSampling::SolidAngle, 0.0325582572)] {
            let moments = irradiance(&square(1.0), by, p);
            assert!((moments.mean() - 0.752274688454).abs() < 4.0 * moments.std_err(), "1 in 16 000 seeds");
            // The standard deviation of a standard deviation is below σ/√N = .2 % here.
            assert!((moments.variance().sqrt() / sigma - 1.0).abs() < 0.01, "{by:?}: {}", moments.variance().sqrt());
        }
    }

    #[test]
    fn a_sphere_has_its_irradiance_in_the_least_variance() {
        // E = π s² for s = r/d, receiver facing it; the solid angle draws have the spread of the cosine alone.
        let sphere = Quadric::Sphere { centre: DVec3::new(0.0, 0.0, 4.0), radius: 1.0 };
        for by in [LightSampling::SolidAngle, LightSampling::Area] {
            let moments = irradiance(&AreaEmitter::quadric(sphere, false), by, DVec3::ZERO);
            assert!((moments.mean() - 0.196349540849).abs() < 4.0 * moments.std_err(), "1 in 16 000 seeds: {by:?}");
        }
    }

    #[test]
    fn pairs_of_triangles_are_rectangles_only_if_they_are() {
        let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        for (first, second) in [([a, b, c], [a, c, d]), ([b, c, a], [d, a, c]), ([d, a, b], [b, c, d])] {
            assert!(AreaEmitter::rectangle_of(first, second).is_some(), "{first:?} {second:?}");
        }
        let e = DVec3::new(1.0, 1.2, 0.0);
        assert!(AreaEmitter::rectangle_of([a, b, e], [a, e, d]).is_none());
        assert!(AreaEmitter::rectangle_of([a, b, c], [a, d, c]).is_none(), "facing the other way");
    }
}
