//! Rays.

use glam::DVec3;

/// A ray: origin, unit direction, and the distance up to which it looks. Hits have 0 < t < `t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Unit direction.
    pub dir: DVec3,
    /// The distance at which it ends, exclusive.
    pub t_max: f64,
}

impl Ray {
    /// The ray from `origin` along the unit vector `dir`, without an end.
    pub fn new(origin: DVec3, dir: DVec3) -> Self {
        Self { origin, dir, t_max: f64::INFINITY }
    }

    /// The same up to the distance `t_max`.
    pub fn up_to(origin: DVec3, dir: DVec3, t_max: f64) -> Self {
        Self { origin, dir, t_max }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.dir * t
    }
}
