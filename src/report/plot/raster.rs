//! A picture of pixels that can be written on.

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
pub(super) enum Turn {
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

    /// Copies a picture into the upper left corner, each of its pixels as a square of `zoom` x `zoom`.
    pub(super) fn paste_zoomed(&mut self, picture: &Self, zoom: usize) {
        for y in 0..picture.height {
            for x in 0..picture.width {
                let colour = picture.pixels[y * picture.width + x];
                self.fill(x * zoom..(x + 1) * zoom, y * zoom..(y + 1) * zoom, colour);
            }
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
    pub(super) fn bounds(&self, points: &[DVec2], reach: f64) -> Option<(Range<i32>, Range<i32>)> {
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

/// How much of a white picture is black, in pixels.
#[cfg(test)]
pub(super) fn ink(raster: &Raster) -> f64 {
    raster.pixels.iter().map(|p| 1.0 - f64::from(p[0]) / 255.0).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [u8; 3] = [255; 3];
    const BLACK: [u8; 3] = [0; 3];

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
