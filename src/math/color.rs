//! Linear Rec.709 colour triples.

use std::fmt;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Sub};

use glam::DVec3;

/// A linear Rec.709 triple: a reflectance, a BRDF value [1/sr] or a radiance, as the context says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb(pub DVec3);

impl Rgb {
    /// (0, 0, 0).
    pub const BLACK: Self = Self(DVec3::ZERO);
    /// (1, 1, 1).
    pub const WHITE: Self = Self(DVec3::ONE);

    /// A triple of its three channels.
    pub const fn new(r: f64, g: f64, b: f64) -> Self {
        Self(DVec3::new(r, g, b))
    }

    /// The same value in all three channels.
    pub const fn grey(value: f64) -> Self {
        Self(DVec3::splat(value))
    }

    /// The largest channel. NaN channels are ignored, as in [`f64::max`]: test [`Rgb::is_finite`] first.
    pub fn max_channel(self) -> f64 {
        self.0.x.max(self.0.y).max(self.0.z)
    }

    /// The smallest channel. NaN channels are ignored, as in [`f64::min`].
    pub fn min_channel(self) -> f64 {
        self.0.x.min(self.0.y).min(self.0.z)
    }

    /// The mean of the three channels.
    pub fn mean(self) -> f64 {
        (self.0.x + self.0.y + self.0.z) / 3.0
    }

    /// Rec.709 luminance, 0.2126 R + 0.7152 G + 0.0722 B.
    pub fn luminance(self) -> f64 {
        self.0.dot(DVec3::new(0.2126, 0.7152, 0.0722))
    }

    /// Whether no channel is NaN or infinite.
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// Whether every channel is exactly 0.
    pub fn is_black(self) -> bool {
        self.0 == DVec3::ZERO
    }

    /// Applies `f` to every channel.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::new(f(self.0.x), f(self.0.y), f(self.0.z))
    }

    /// The channels as an array, red first.
    pub fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }
}

impl From<f64> for Rgb {
    fn from(value: f64) -> Self {
        Self::grey(value)
    }
}

impl From<[f64; 3]> for Rgb {
    fn from(channels: [f64; 3]) -> Self {
        Self(DVec3::from_array(channels))
    }
}

/// `0.5` for a grey, `0.5/0.4/0.3` otherwise: the spelling of a SUBJECT.
impl fmt::Display for Rgb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.0;
        if x == y && y == z { write!(f, "{x}") } else { write!(f, "{x}/{y}/{z}") }
    }
}

impl Add for Rgb {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for Rgb {
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl Sub for Rgb {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Rgb {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

impl Mul<Rgb> for f64 {
    type Output = Rgb;
    fn mul(self, colour: Rgb) -> Rgb {
        colour * self
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        Self(self.0 / divisor)
    }
}

impl Div for Rgb {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl Sum for Rgb {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::BLACK, Add::add)
    }
}

impl approx::AbsDiffEq for Rgb {
    type Epsilon = f64;

    fn default_epsilon() -> f64 {
        f64::EPSILON
    }

    fn abs_diff_eq(&self, other: &Self, epsilon: f64) -> bool {
        self.0.abs_diff_eq(other.0, epsilon)
    }
}

impl approx::RelativeEq for Rgb {
    fn default_max_relative() -> f64 {
        f64::EPSILON
    }

    fn relative_eq(&self, other: &Self, epsilon: f64, max_relative: f64) -> bool {
        approx::RelativeEq::relative_eq(&self.0, &other.0, epsilon, max_relative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_of_white_is_one() {
        approx::assert_relative_eq!(Rgb::WHITE.luminance(), 1.0, epsilon = 1e-15);
    }

    #[test]
    fn display_is_the_spelling_of_a_subject() {
        assert_eq!(Rgb::grey(0.5).to_string(), "0.5");
        assert_eq!(Rgb::new(0.5, 0.4, 0.25).to_string(), "0.5/0.4/0.25");
    }

    #[test]
    fn nan_is_not_finite_and_never_equal() {
        let bad = Rgb::new(f64::NAN, 1.0, 1.0);
        assert!(!bad.is_finite());
        assert!(!approx::abs_diff_eq!(bad, bad));
    }
}
