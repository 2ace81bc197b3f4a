//! Russian roulette: ending a path at random, and weighing up those that go on.

use crate::math::color::Rgb;

/// With which probability a path goes on after a reflection. Those that do are divided by it, so that the mean stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roulette {
    /// Always, up to the limit of bounces.
    Off,
    /// With the largest channel of the reflection's weight, or 1: the weight of a path never grows, and for a diffuse
    /// surface it is the albedo.
    Albedo,
    /// From this number of reflections on with the largest channel of the path's weight, at most .99: in a closed room of
    /// albedo ρ the variance is finite while ρ² is below that.
    From(u32),
    /// With a constant probability in (0, 1]. Where it is below the square of the albedo the variance has no bound.
    Constant(f64),
}

impl Roulette {
    /// The probability of going on after the reflection number `depth`, from 1, whose weight is `weight`; `throughput`
    /// is the product of all weights.
    #[inline]
    pub fn survival(self, depth: u32, weight: Rgb, throughput: Rgb) -> f64 {
        match self {
            Self::Off => 1.0,
            Self::Albedo => weight.max_channel().min(1.0),
            Self::From(first) if depth < first => 1.0,
            // Less than 1, so that light that is caught in glass is given up some day.
            Self::From(_) => throughput.max_channel().min(0.99),
            Self::Constant(q) => q,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survival_is_a_probability_and_starts_when_it_should() {
        let (weight, throughput) = (Rgb::new(0.2, 0.7, 0.1), Rgb::grey(3.0));
        assert_eq!(Roulette::Off.survival(9, weight, throughput), 1.0);
        assert_eq!(Roulette::Albedo.survival(1, weight, throughput), 0.7);
        assert_eq!(Roulette::Albedo.survival(1, Rgb::grey(1.4), throughput), 1.0);
        assert_eq!(Roulette::From(3).survival(2, weight, throughput), 1.0);
        assert_eq!(Roulette::From(3).survival(3, weight, throughput), 0.99);
        assert_eq!(Roulette::From(3).survival(3, weight, Rgb::BLACK), 0.0);
    }
}
