//! The k nearest of what is found, kept without an allocation per query, and a scan of all points as an oracle.

use glam::DVec3;

/// A point that was found: the square of its distance, and its number.
pub type Found = (f64, u32);

/// Collects the k nearest points within a limit.
///
/// What is found goes into a buffer of some more than k; when it is full, the k nearest are selected and the limit falls to the
/// k-th. That takes a constant time per point, where a heap takes log k.
#[derive(Clone, Debug, Default)]
pub struct Nearest {
    found: Vec<Found>,
    k: usize,
    room: usize,
    limit: f64,
}

impl Nearest {
    /// Empties it for the `k` nearest whose squared distance is below `limit`; its memory is kept.
    pub fn begin(&mut self, k: usize, limit: f64) {
        self.found.clear();
        self.k = k;
        // A quarter more costs a selection of 5/4 k for every k/4 points.
        self.room = k + (k / 2).max(8);
        self.limit = limit;
        self.found.reserve(self.room);
    }

    /// The squared distance from which on a point is of no interest.
    #[inline]
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Takes a point whose squared distance is below the limit.
    #[inline]
    pub fn push(&mut self, distance2: f64, number: u32) {
        self.found.push((distance2, number));
        if self.found.len() >= self.room {
            self.select();
        }
    }

    fn select(&mut self) {
        if self.k == 0 {
            self.found.clear();
        } else if self.found.len() > self.k {
            let (_, kth, _) = self.found.select_nth_unstable_by(self.k - 1, compare);
            self.limit = kth.0;
            self.found.truncate(self.k);
        }
    }

    /// The k nearest, the last of them the farthest; fewer where there are fewer.
    pub fn finish(&mut self) -> &[Found] {
        self.select();
        // A selection leaves the k-th at the end; where none was made, any may be there.
        if let Some(last) = (0..self.found.len()).max_by(|&a, &b| compare(&self.found[a], &self.found[b])) {
            let end = self.found.len() - 1;
            self.found.swap(last, end);
        }
        &self.found
    }
}

fn compare(a: &Found, b: &Found) -> std::cmp::Ordering {
    // Squares are not negative, and the bits of such numbers have their order.
    a.0.to_bits().cmp(&b.0.to_bits())
}

/// The nearest points by looking at all of them: slow, and an oracle.
pub fn scan(points: &[DVec3], q: DVec3, nearest: &mut Nearest, keep: impl Fn(u32) -> bool) {
    for (i, p) in points.iter().enumerate() {
        let distance2 = p.distance_squared(q);
        if distance2 < nearest.limit() && keep(i as u32) {
            nearest.push(distance2, i as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_many_are_those_of_a_sort() {
        let distances: Vec<f64> = (0..500).map(|i| f64::from(i * 7919 % 500)).collect();
        let mut nearest = Nearest::default();
        for k in [0, 1, 2, 50, 499, 500, 600] {
            nearest.begin(k, f64::INFINITY);
            for (i, &d) in distances.iter().enumerate() {
                if d < nearest.limit() {
                    nearest.push(d, i as u32);
                }
            }
            let mut found: Vec<f64> = nearest.finish().iter().map(|(d, _)| *d).collect();
            let last = found.last().copied();
            found.sort_by(f64::total_cmp);
            assert_eq!(found, (0..k.min(500)).map(|i| i as f64).collect::<Vec<_>>());
            assert_eq!(last, found.last().copied(), "the last is the farthest");
        }
    }

    #[test]
    fn nothing_beyond_the_limit_and_the_memory_is_kept() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let mut nearest = Nearest::default();
        nearest.begin(8, 1.5);
        scan(&points, DVec3::ZERO, &mut nearest, |i| i != 0);
        assert_eq!(nearest.finish(), &[(1.0, 1)]);
        let room = nearest.found.capacity();
        nearest.begin(8, 1.5);
        assert_eq!(nearest.found.capacity(), room);
    }
}
