//! A picture of pixels that can be written and drawn on, with smooth edges.

use std::ops::Range;

use glam::DVec2;

use super::font;
use crate::image::{Format, Image, ImageError};

/// 8-bit sRGB pixels. Coordinates grow to the right and downwards; the pixel (x, y) is the square from there to
/// (x + 1, y + 1). What lies outside is cut off.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// The way in which a line of text runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// To the right.
    Right,
    /// Upwards.
    Up,
    /// Downwards.
    Down,
}

impl Raster {
    /// All of one colour.
    pub fn new(width: usize, height: usize, paper: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![paper; width * height] }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour of a pixel; None outside.
    pub fn pixel(&self, x: usize, y: usize) -> Option<[u8; 3]> {
        (x < self.width).then(|| self.pixels.get(y * self.width + x).copied()).flatten()
    }

    /// Fills whole pixels.
    pub fn fill(&mut self, x: Range<usize>, y: Range<usize>, colour: [u8; 3]) {
        for row in y.start..y.end.min(self.height) {
            let (from, to) = (x.start.min(self.width), x.end.min(self.width));
            self.pixels[row * self.width..][from..to.max(from)].fill(colour);
        }
    }

    /// Copies a picture, row by row from its top, `width` pixels wide, with its upper left corner at (x, y).
    pub fn paste(&mut self, x: usize, y: usize, width: usize, pixels: &[[u8; 3]]) {
        let Some(room) = self.width.checked_sub(x).filter(|_| width > 0) else { return };
        for (row, line) in (y..self.height).zip(pixels.chunks(width)) {
            let line = &line[..line.len().min(room)];
            self.pixels[row * self.width + x..][..line.len()].copy_from_slice(line);
        }
    }

    /// Writes a line of text: its baseline starts at `at`, an em has `em` pixels. Its width is
    /// [`text_width`](super::text_width).
    pub fn text(&mut self, text: &str, at: DVec2, em: f64, colour: [u8; 3]) {
        self.text_turned(text, at, em, colour, 1.0, Turn::Right);
    }

    /// The same with an opacity in [0, 1], along `turn`.
    pub(super) fn text_turned(&mut self, text: &str, at: DVec2, em: f64, colour: [u8; 3], opacity: f64, turn: Turn) {
        // Baselines lie between pixels, so that feet are sharp; along the line, the fraction of a pixel counts.
        let snapped = match turn {
            Turn::Right => DVec2::new(at.x.floor(), at.y.round()),
            _ => at.round(),
        };
        let shift = if turn == Turn::Right { at.x - snapped.x } else { 0.0 };
        let (x0, y0) = (snapped.x as i32, snapped.y as i32);
        font::rasterize(text, em, shift, |x, y, covered| {
            let (x, y) = match turn {
                Turn::Right => (x, y),
                Turn::Up => (y, -x - 1),
                Turn::Down => (-y - 1, x),
            };
            self.blend(x0 + x, y0 + y, colour, covered * opacity);
        });
    }

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

    /// Mixes `share` of a colour into a pixel.
    pub(super) fn blend(&mut self, x: i32, y: i32, colour: [u8; 3], share: f64) {
        let inside = |at: i32, size: usize| usize::try_from(at).ok().filter(|&at| at < size);
        if let (Some(x), Some(y), true) = (inside(x, self.width), inside(y, self.height), share > 0.0) {
            let pixel = &mut self.pixels[y * self.width + x];
            for (old, new) in pixel.iter_mut().zip(colour) {
                *old = (f64::from(*old) + (f64::from(new) - f64::from(*old)) * share.min(1.0)).round() as u8;
            }
        }
    }

    /// The pixels within `reach` of the box around `points`, cut to the picture; None where there are none.
    fn bounds(&self, points: &[DVec2], reach: f64) -> Option<(Range<i32>, Range<i32>)> {
        let low = points.iter().copied().reduce(DVec2::min)? - reach;
        let high = points.iter().copied().reduce(DVec2::max)? + reach;
        let range = |low: f64, high: f64, size: usize| {
            let size = size as f64;
            (low.floor().clamp(0.0, size) as i32)..(high.ceil().clamp(0.0, size) as i32)
        };
        let (xs, ys) = (range(low.x, high.x, self.width), range(low.y, high.y, self.height));
        (!xs.is_empty() && !ys.is_empty()).then_some((xs, ys))
    }

    /// The picture as an image.
    pub fn image(&self) -> Result<Image, ImageError> {
        Image::from_srgb8(self.width, self.height, &self.pixels)
    }

    /// The content of a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        self.image()?.encode(Format::Png, 0.0)
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

    const WHITE: [u8; 3] = [255; 3];
    const BLACK: [u8; 3] = [0; 3];

    fn ink(raster: &Raster) -> f64 {
        raster.pixels.iter().map(|p| 1.0 - f64::from(p[0]) / 255.0).sum()
    }

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

    #[test]
    fn a_turned_text_has_the_same_ink_and_what_is_outside_is_cut_off() {
        let written = |at, turn| {
            let mut raster = Raster::new(80, 80, WHITE);
            raster.text_turned("Rσ²", at, 20.0, BLACK, 1.0, turn);
            raster
        };
        let right = ink(&written(DVec2::new(10.0, 40.0), Turn::Right));
        assert!(right > 50.0);
        assert!((ink(&written(DVec2::new(40.0, 70.0), Turn::Up)) - right).abs() < 1e-9);
        assert!((ink(&written(DVec2::new(40.0, 10.0), Turn::Down)) - right).abs() < 1e-9);
        assert!(ink(&written(DVec2::new(70.0, 40.0), Turn::Right)) < right);
        assert_eq!(ink(&written(DVec2::new(-900.0, 40.0), Turn::Right)), 0.0);
    }

    #[test]
    fn a_png_holds_the_pixels() {
        let mut raster = Raster::new(16, 17, WHITE);
        let all: Vec<[u8; 3]> = (0..=255).map(|v| [v, 255 - v, v / 2]).collect();
        raster.paste(0, 0, 16, &all);
        raster.fill(14..99, 16..99, [1, 2, 3]);
        raster.paste(15, 16, 3, &[[9; 3]; 9]);
        let back = Image::decode(&raster.png().unwrap(), std::path::Path::new("a.png")).unwrap();
        for y in 0..17 {
            for x in 0..16 {
                let found = back.rgb(x, y).map(|v| (v * 255.0).round() as u8);
                assert_eq!(Some(found), raster.pixel(x, y), "{x} {y}");
            }
        }
        assert_eq!(
            (raster.pixel(14, 16), raster.pixel(15, 16), raster.pixel(16, 16)),
            (Some([1, 2, 3]), Some([9; 3]), None)
        );
    }
}
