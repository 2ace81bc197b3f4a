//! Lines, circles and polygons on a [`Raster`], with smooth edges: each pixel gets the share that is covered.

use glam::DVec2;

use super::raster::Raster;

impl Raster {
    /// A line through `points`, `width` pixels wide, with blunt ends and round corners.
    pub(super) fn stroke(&mut self, points: &[DVec2], width: f64, colour: [u8; 3], opacity: f64) {
        let half = 0.5 * width;
        let segments: Vec<(DVec2, DVec2)> = match *points {
            // A level or upright line fills whole pixels.
            [a, b] if a.x == b.x || a.y == b.y => vec![snapped(a, b, half)],
            _ => points.windows(2).map(|ends| (ends[0], ends[1])).collect(),
        };
        let Some((x_range, y_range)) = self.bounds(points, half + 1.0) else { return };
        let columns = (x_range.end - x_range.start) as usize;
        // The largest coverage of all parts: where they overlap, the line is not darker.
        let mut mask = vec![0.0_f64; columns * (y_range.end - y_range.start) as usize];
        let mut part = |ends: [DVec2; 2], covered: &dyn Fn(DVec2) -> f64| {
            let Some((xs, ys)) = self.bounds(&ends, half + 1.0) else { return };
            for y in ys {
                for x in xs.clone() {
                    let at = (y - y_range.start) as usize * columns + (x - x_range.start) as usize;
                    mask[at] = mask[at].max(covered(centre(x, y)));
                }
            }
        };
        for &(a, b) in &segments {
            let length = a.distance(b);
            if length > 0.0 {
                let along = (b - a) / length;
                part([a, b], &|p| {
                    let t = (p - a).dot(along);
                    let beside = (p - a).perp_dot(along).abs();
                    let ends = (t + 0.5).min(length - t + 0.5).clamp(0.0, 1.0);
                    // A hair of less than a pixel is pale rather than broken.
                    ends * (half + 0.5 - beside).clamp(0.0, width.min(1.0))
                });
            }
        }
        for &corner in points.iter().take(points.len().saturating_sub(1)).skip(1) {
            part([corner; 2], &|p| (half + 0.5 - p.distance(corner)).clamp(0.0, width.min(1.0)));
        }
        for y in y_range.clone() {
            for x in x_range.clone() {
                let covered = mask[(y - y_range.start) as usize * columns + (x - x_range.start) as usize];
                self.blend(x, y, colour, covered * opacity);
            }
        }
    }

    /// A filled circle.
    pub(super) fn disc(&mut self, at: DVec2, radius: f64, colour: [u8; 3], opacity: f64) {
        let Some((xs, ys)) = self.bounds(&[at], radius + 1.0) else { return };
        for y in ys {
            for x in xs.clone() {
                let covered = (radius + 0.5 - centre(x, y).distance(at)).clamp(0.0, 1.0);
                self.blend(x, y, colour, covered * opacity);
            }
        }
    }

    /// A filled polygon; what it surrounds twice is outside.
    pub(super) fn polygon(&mut self, corners: &[DVec2], colour: [u8; 3], opacity: f64) {
        // Rows are sampled this often; along a row, the coverage is exact.
        const LINES: i32 = 8;
        let Some((xs, ys)) = self.bounds(corners, 1.0) else { return };
        for y in ys {
            let mut covered = vec![0.0; (xs.end - xs.start) as usize];
            for line in 0..LINES {
                let height = f64::from(y) + (f64::from(line) + 0.5) / f64::from(LINES);
                let mut crossings: Vec<f64> = (0..corners.len())
                    .map(|i| (corners[i], corners[(i + 1) % corners.len()]))
                    .filter(|(a, b)| (a.y <= height) != (b.y <= height))
                    .map(|(a, b)| a.x + (height - a.y) / (b.y - a.y) * (b.x - a.x))
                    .collect();
                crossings.sort_by(f64::total_cmp);
                for pair in crossings.chunks_exact(2) {
                    for (x, covered) in xs.clone().zip(&mut covered) {
                        let x = f64::from(x);
                        *covered += ((x + 1.0).min(pair[1]) - x.max(pair[0])).max(0.0) / f64::from(LINES);
                    }
                }
            }
            for (x, covered) in xs.clone().zip(covered) {
                self.blend(x, y, colour, covered * opacity);
            }
        }
    }
}

fn centre(x: i32, y: i32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// The level or upright line from `a` to `b` moved by less than a pixel, so that its sides lie between pixels.
fn snapped(mut a: DVec2, mut b: DVec2, half: f64) -> (DVec2, DVec2) {
    if a.x == b.x {
        a.x = (a.x - half).round() + half;
        b.x = a.x;
    } else {
        a.y = (a.y - half).round() + half;
        b.y = a.y;
    }
    (a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::raster::ink;

    const WHITE: [u8; 3] = [255; 3];
    const BLACK: [u8; 3] = [0; 3];

    #[test]
    fn shapes_cover_their_areas() {
        let drawn = |draw: &dyn Fn(&mut Raster)| {
            let mut raster = Raster::new(60, 60, WHITE);
            draw(&mut raster);
            ink(&raster)
        };
        let at = DVec2::new;
        // The edge of a disc is taken as straight within a pixel, and 8 bits round by 1/510 in each of 200 pixels.
        assert!((drawn(&|r| r.disc(at(30.2, 29.6), 10.0, BLACK, 1.0)) - 314.2).abs() < 1.0);
        let corners = [at(5.3, 5.0), at(45.3, 5.0), at(5.3, 35.0)];
        assert!((drawn(&|r| r.polygon(&corners, BLACK, 1.0)) - 600.0).abs() < 1.0, "half of 40 x 30");
        assert!((drawn(&|r| r.stroke(&[at(10.0, 10.0), at(40.0, 50.0)], 3.0, BLACK, 1.0)) - 150.0).abs() < 2.0);
        assert!((drawn(&|r| r.stroke(&[at(10.0, 10.3), at(40.0, 10.3)], 2.0, BLACK, 0.5)) - 30.0).abs() < 1.0);
        // A line back over itself is not darker.
        let once = drawn(&|r| r.stroke(&[at(9.0, 9.0), at(40.0, 30.0)], 2.0, BLACK, 0.5));
        let twice = drawn(&|r| r.stroke(&[at(9.0, 9.0), at(40.0, 30.0), at(9.0, 9.0)], 2.0, BLACK, 0.5));
        assert!(twice - once < 1.0, "{once} {twice}");
    }
}
