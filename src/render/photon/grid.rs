//! A sorted hash grid: points of one cell lie next to each other, and the cells within a fixed radius are few.
//!
//! Cells have a side of twice the radius, so that a ball meets at most eight. A cell goes to one of as many buckets as there are
//! points, and the points are sorted by bucket: two arrays, whatever the extent of the scene.
//! # References
//! - Teschner et al. 2003, Optimized spatial hashing for collision detection of deformable objects, VMV (the hash)

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::nearest::Found;

/// A grid of cells. Points have the numbers in which it sorts them: [`Grid::order`] tells what they were.
#[derive(Clone, Debug)]
pub struct Grid {
    points: Vec<DVec3>,
    order: Vec<u32>,
    /// Where each bucket begins, and the end.
    starts: Vec<u32>,
    cell: f64,
}

impl Grid {
    /// The grid of these points for this radius, > 0 and finite; at most 2³² − 1 points, each finite.
    pub fn new(points: &[DVec3], radius: f64) -> Self {
        let cell = 2.0 * radius;
        let buckets = points.len().next_power_of_two().max(1);
        let mut keyed: Vec<(u32, u32)> =
            points.par_iter().enumerate().map(|(i, p)| (bucket(cell_of(*p, cell), buckets), i as u32)).collect();
        keyed.par_sort_unstable();
        let mut starts = vec![0_u32; buckets + 1];
        for &(bucket, _) in &keyed {
            starts[bucket as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let order: Vec<u32> = keyed.into_iter().map(|(_, i)| i).collect();
        let points = order.iter().map(|&i| points[i as usize]).collect();
        Self { points, order, starts, cell }
    }

    /// The points as they are sorted.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Of each point its number before it was sorted.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Tells `each` of the points closer than `radius` to `q`.
    pub fn within(&self, q: DVec3, radius: f64, mut each: impl FnMut(Found)) {
        let (low, high) = (cell_of(q - radius, self.cell), cell_of(q + radius, self.cell));
        let radius2 = radius * radius;
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let cell = I64Vec3::new(x, y, z);
                    let bucket = bucket(cell, self.starts.len() - 1) as usize;
                    for i in self.starts[bucket]..self.starts[bucket + 1] {
                        let p = self.points[i as usize];
                        let distance2 = p.distance_squared(q);
                        // Another cell of the ball may have the same bucket.
                        if distance2 < radius2 && cell_of(p, self.cell) == cell {
                            each(Found::new(distance2 as f32, i));
                        }
                    }
                }
            }
        }
    }
}

fn cell_of(p: DVec3, cell: f64) -> I64Vec3 {
    (p / cell).floor().as_i64vec3()
}

fn bucket(cell: I64Vec3, buckets: usize) -> u32 {
    let mixed =
        (cell.x.wrapping_mul(73_856_093) ^ cell.y.wrapping_mul(19_349_663) ^ cell.z.wrapping_mul(83_492_791)) as u64;
    // The product's high bits depend on all of its factor's.
    let spread = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    spread as u32 & (buckets - 1) as u32
}

#[cfg(test)]
mod tests {
    use super::super::nearest::{Nearest, scan};
    use super::*;
    use crate::sampling::stream::{stream, uniform};

    #[test]
    fn what_is_near_is_what_a_scan_finds() {
        let mut rng = stream(4, 0, 0);
        let mut point =
            |flat: f64| DVec3::new(uniform(&mut rng), flat * uniform(&mut rng), uniform(&mut rng)) * 2.0 - 1.0;
        for (n, flat) in [(0, 1.0), (1, 1.0), (2000, 1.0), (20_000, 0.0)] {
            let mut points: Vec<DVec3> = (0..n).map(|_| point(flat)).collect();
            points.extend(vec![DVec3::splat(0.25); n.min(1000)]);
            let grid = Grid::new(&points, 0.1);
            assert!(grid.order.iter().zip(&grid.points).all(|(&i, &p)| points[i as usize] == p));
            for q in (0..30).map(|_| point(flat)).chain([DVec3::splat(0.25)]) {
                for radius in [0.05, 0.1, 0.25] {
                    let (mut near, mut all) = (Vec::new(), Nearest::default());
                    grid.within(q, radius, |f| near.push(Found::new(f.distance2(), grid.order[f.number() as usize])));
                    all.begin(points.len(), (radius * radius) as f32);
                    scan(&points, q, &mut all, |_| true);
                    let mut all = all.finish().to_vec();
                    near.sort_unstable();
                    all.sort_unstable();
                    assert_eq!(near, all, "{n} points, radius {radius}");
                }
            }
        }
    }
}
