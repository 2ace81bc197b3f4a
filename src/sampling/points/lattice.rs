//! Rank-1 lattices with a random shift.

use glam::DVec2;

use super::hash::{below_one, mix, permuted};
use crate::sampling::sampler::Sampler;
use crate::sampling::stream::unit;

/// Of N samples, the pairs are the points (i/N, g i/N) modulo 1 of a lattice that is moved as a whole by a random shift,
/// in random order; single dimensions are an even grid, moved likewise. The generator g is near N over the golden ratio,
/// and such that the lattice's closest points are as far from each other as any of its neighbours' are. Samples beyond N
/// begin another lattice.
///
/// # References
/// - Sloan & Joe 1994, Lattice methods for multiple integration
/// - Cranley & Patterson 1976, Randomization of number theoretic methods, SIAM J. Numer. Anal. 13(6)
#[derive(Clone, Debug)]
pub struct Lattice {
    seed: u64,
    samples: u32,
    generator: u32,
    pixel: u64,
    index: u32,
    dimension: u64,
}

/// How far from N over the golden ratio a generator is looked for.
const REACH: u32 = 64;

impl Lattice {
    /// The sampler of this seed for so many samples of a pixel, at sample 0 of pixel 0.
    pub fn new(seed: u64, samples: u64) -> Self {
        let samples = samples.clamp(1, 1 << 30) as u32;
        let mut sampler = Self { seed, samples, generator: generator(samples), pixel: 0, index: 0, dimension: 0 };
        sampler.begin(0, 0);
        sampler
    }

    /// The hash of the next dimension, and the place of this sample in the order of that.
    #[inline]
    fn next(&mut self) -> (u64, u32) {
        self.dimension += 1;
        let hash = mix(self.pixel, self.dimension);
        (hash, permuted(self.index, self.samples, hash))
    }
}

/// The generator of N points that are farthest apart, coprime to N, so that no two points share a coordinate.
fn generator(n: u32) -> u32 {
    let golden = (f64::from(n) * 0.618_033_988_749_895).round() as u32;
    let near = golden.saturating_sub(REACH).max(1)..=golden.saturating_add(REACH).min(n.max(2) - 1);
    // The one nearest to the golden ratio comes first among equals.
    near.filter(|&g| gcd(g, n) == 1).max_by_key(|&g| (shortest(g, n), u32::MAX - g.abs_diff(golden))).unwrap_or(1)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The square of the shortest distance of two points of the lattice (i, g i) modulo `n`, by Gauss's reduction of its basis
/// (1, g), (0, n).
fn shortest(g: u32, n: u32) -> i64 {
    let dot = |a: [i64; 2], b: [i64; 2]| a[0] * b[0] + a[1] * b[1];
    let (mut long, mut short) = ([0, i64::from(n)], [1, i64::from(g)]);
    loop {
        if dot(long, long) < dot(short, short) {
            std::mem::swap(&mut long, &mut short);
        }
        let length = dot(short, short);
        // Nearest whole number of times that the short one fits into the long one.
        let times = (2 * dot(long, short) + length).div_euclid(2 * length);
        if times == 0 {
            return length;
        }
        long = [long[0] - times * short[0], long[1] - times * short[1]];
        if dot(long, long) == length {
            return length;
        }
    }
}

/// (i + shift) / n modulo 1, for i < n and a shift in [0, n).
#[inline]
fn shifted(i: u32, shift: f64, n: u32) -> f64 {
    let (x, n) = (f64::from(i) + shift, f64::from(n));
    below_one(if x >= n { x - n } else { x } / n)
}

impl Sampler for Lattice {
    #[inline]
    fn begin(&mut self, pixel: u64, sample: u64) {
        let samples = u64::from(self.samples);
        self.pixel = mix(mix(self.seed, pixel), sample / samples);
        self.index = (sample % samples) as u32;
        self.dimension = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let (hash, i) = self.next();
        // A shift by a whole number of points would change the order alone.
        shifted(i, unit(mix(hash, 1)), self.samples)
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let (hash, i) = self.next();
        let n = self.samples;
        let j = (u64::from(i) * u64::from(self.generator) % u64::from(n)) as u32;
        let shifts = [1, 2].map(|axis| f64::from(n) * unit(mix(hash, axis)));
        DVec2::new(shifted(i, shifts[0], n), shifted(j, shifts[1], n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generators_are_as_good_as_any_and_reach_every_point() {
        for n in 2..128 {
            let best = (1..n).filter(|&g| gcd(g, n) == 1).map(|g| shortest(g, n)).max();
            assert_eq!(Some(shortest(generator(n), n)), best, "{n}");
        }
        // Fibonacci's lattices are near the best: F(k−1) generates F(k) points.
        for (g, n) in [(89, 144), (610, 987), (10_946, 17_711)] {
            assert!(shortest(generator(n), n) >= shortest(g, n), "{n}");
        }
        for n in 1..300 {
            let g = generator(n);
            let mut seen = vec![false; n as usize];
            (0..n).for_each(|i| seen[(i * g % n) as usize] = true);
            assert!(seen.iter().all(|seen| *seen), "{n} points, generator {g}");
        }
    }

    #[test]
    fn the_shortest_distance_is_that_of_the_closest_pair() {
        for (g, n) in [(5, 13), (7, 32), (1, 10), (27, 64), (13, 34)] {
            let around = |x: i64| x.min(n - x);
            let squares = (1..n).map(|i| around(i).pow(2) + around(i * g % n).pow(2));
            assert_eq!(i64::from(shortest(g as u32, n as u32) as i32), squares.min().unwrap(), "{g}, {n}");
        }
    }
}
