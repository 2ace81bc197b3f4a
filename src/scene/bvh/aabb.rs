//! Boxes aligned with the axes.

use glam::DVec3;

/// The points between two corners, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least coordinates.
    pub min: DVec3,
    /// The greatest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box without a point: the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around some points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |all, p| Self { min: all.min.min(p), max: all.max.max(p) })
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether there is no point in it. A box with a NaN is empty too.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The centre; NaN for an empty box.
    pub fn centre(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unions_and_emptiness() {
        let points = [DVec3::new(1.0, -2.0, 3.0), DVec3::new(0.0, 5.0, 3.0)];
        let both = Aabb::around(points);
        assert_eq!(both, Aabb { min: DVec3::new(0.0, -2.0, 3.0), max: DVec3::new(1.0, 5.0, 3.0) });
        assert_eq!(both.union(Aabb::EMPTY), both);
        assert_eq!(both.centre(), DVec3::new(0.5, 1.5, 3.0));
        assert!(Aabb::EMPTY.is_empty() && !both.is_empty() && !Aabb::around([DVec3::ZERO]).is_empty());
        assert!(Aabb { min: DVec3::NAN, max: DVec3::ONE }.is_empty());
    }
}
