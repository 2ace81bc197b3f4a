//! The k nearest of what is found, kept without an allocation per query, and a scan of all points as an oracle.

use glam::DVec3;

/// A point that was found: the square of its distance, and its number, in one word that has the order of the distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Found(u64);

impl Found {
    /// Point `number`; the square of its distance is >= 0.
    #[inline]
    pub fn new(distance2: f32, number: u32) -> Self {
        // The bits of numbers that are not negative have their order.
        Self(u64::from(distance2.to_bits()) << 32 | u64::from(number))
    }

    /// The square of its distance.
    #[inline]
    pub fn distance2(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    /// Its number.
    #[inline]
    pub fn number(self) -> u32 {
        self.0 as u32
    }
}

/// Collects the k nearest points within a limit.
///
/// What is found goes into a buffer of some more than k; when it is full, the k nearest are selected and the limit falls to the
/// k-th. That takes a constant time per point, where a heap takes log k.
#[derive(Clone, Debug, Default)]
pub struct Nearest {
    found: Vec<Found>,
    k: usize,
    room: usize,
    limit: f32,
}

/// Room that is asked for at once.
const ROOM: usize = 1 << 12;

impl Nearest {
    /// Empties it for the `k` nearest whose squared distance is below `limit`; its memory is kept.
    pub fn begin(&mut self, k: usize, limit: f32) {
        self.found.clear();
        self.k = k;
        // A half more costs a selection of 3/2 k for every k/2 points.
        self.room = k.saturating_add((k / 2).max(8));
        self.limit = limit;
        self.found.reserve(self.room.min(ROOM));
    }

    /// The squared distance from which on a point is of no interest.
    #[inline]
    pub fn limit(&self) -> f32 {
        self.limit
    }

    /// Takes a point whose squared distance is below the limit.
    #[inline]
    pub fn push(&mut self, found: Found) {
        self.found.push(found);
        if self.found.len() >= self.room {
            self.select();
        }
    }

    fn select(&mut self) {
        if self.k == 0 {
            self.found.clear();
        } else if self.found.len() > self.k {
            let (_, kth, _) = self.found.select_nth_unstable(self.k - 1);
            self.limit = kth.distance2();
            self.found.truncate(self.k);
        }
    }

    /// The k nearest, the last of them the farthest; fewer where there are fewer.
    pub fn finish(&mut self) -> &[Found] {
        self.select();
        // A selection leaves the k-th at the end; where none was made, any may be there.
        if let Some(last) = (0..self.found.len()).max_by_key(|&i| self.found[i]) {
            let end = self.found.len() - 1;
            self.found.swap(last, end);
        }
        &self.found
    }
}

/// The nearest points by looking at all of them: slow, and an oracle.
pub fn scan(points: &[DVec3], q: DVec3, nearest: &mut Nearest, keep: impl Fn(u32) -> bool) {
    for (i, p) in points.iter().enumerate() {
        let distance2 = p.distance_squared(q) as f32;
        if distance2 < nearest.limit() && keep(i as u32) {
            nearest.push(Found::new(distance2, i as u32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_many_are_those_of_a_sort() {
        let distances: Vec<f32> = (0..500_u16).map(|i| f32::from(i * 19 % 500)).collect();
        let mut nearest = Nearest::default();
        for k in [0, 1, 2, 50, 499, 500, 600] {
            nearest.begin(k, f32::INFINITY);
            for (i, &d) in distances.iter().enumerate() {
                if d < nearest.limit() {
                    nearest.push(Found::new(d, i as u32));
                }
            }
            let mut found: Vec<f32> = nearest.finish().iter().map(|found| found.distance2()).collect();
            let last = found.last().copied();
            found.sort_by(f32::total_cmp);
            assert_eq!(found, (0..k.min(500)).map(|i| i as f32).collect::<Vec<_>>());
            assert_eq!(last, found.last().copied(), "the last is the farthest");
        }
    }

    #[test]
    fn nothing_beyond_the_limit_and_the_memory_is_kept() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let mut nearest = Nearest::default();
        nearest.begin(8, 1.5);
        scan(&points, DVec3::ZERO, &mut nearest, |i| i != 0);
        assert_eq!(nearest.finish(), &[Found::new(1.0, 1)]);
        assert_eq!((nearest.finish()[0].distance2(), nearest.finish()[0].number()), (1.0, 1));
        let room = nearest.found.capacity();
        nearest.begin(8, 1.5);
        assert_eq!(nearest.found.capacity(), room);
    }
}
