//! Where the pictures of a sheet stand, and what is written below them.

use glam::DVec2;

use super::{BOUNCES, FEW_AND_MANY, SAMPLES, Settings, Shot, Shots};
use crate::image::{ImageError, preview};
use crate::math::color::Rgb;
use crate::render::film::Film;
use crate::report::plot::{Raster, text_width};

const PAPER: [u8; 3] = [0xff, 0xff, 0xff];
const INK: [u8; 3] = [0x1b, 0x1f, 0x24];
const FAINT: [u8; 3] = [0x5c, 0x64, 0x6e];
/// Small pictures side by side.
const COLUMNS: usize = 6;
/// Pixels between pictures.
const GAP: usize = 8;
/// Pixels around all.
const MARGIN: usize = 16;
/// The largest letters of a caption: pixels of an em.
const LARGEST_EM: f64 = 14.0;
/// Share of a difference's pixels that its scale keeps below white.
const UNCLIPPED: f64 = 0.995;

/// The size of a large picture: three of them are as wide as six small ones.
pub(super) fn large((width, height): (usize, usize)) -> (usize, usize) {
    let wide = 2 * width + GAP;
    (wide, (height * wide).div_ceil(width))
}

/// The sheet as the bytes of a PNG.
pub fn draw(name: &str, shots: &Shots, settings: &Settings) -> Result<Vec<u8>, ImageError> {
    let (width, height) = settings.size;
    let (large_width, large_height) = large(settings.size);
    let longest = caption(80, 3);
    // As large as the widest caption allows.
    let em = LARGEST_EM.min(width as f64 / text_width(&longest, 1.0));
    let line = (1.7 * em).ceil() as usize;
    let inner = COLUMNS * width + (COLUMNS - 1) * GAP;
    let head = 3 * line;
    let total = 2 * MARGIN + head + 2 * (height + line + line / 2) + large_height + line;
    let mut sheet = Sheet { raster: Raster::new(inner + 2 * MARGIN, total, PAPER), em, gain: settings.exposure.exp2() };

    sheet.write(name, MARGIN, MARGIN, 1.5 * em, INK, inner);
    let how = format!(
        "Light is connected to at every surface, then one random ray is followed: b bounces are b + 1 reflections. Seed {}.",
        settings.seed
    );
    sheet.write(&how, MARGIN, MARGIN + line + line / 2, em, FAINT, inner);

    let mut top = MARGIN + head;
    let rows: [Vec<(u64, u32)>; 2] = [
        SAMPLES.iter().map(|&samples| (samples, BOUNCES[0])).collect(),
        FEW_AND_MANY.iter().flat_map(|&samples| BOUNCES.map(|bounces| (samples, bounces))).collect(),
    ];
    for row in rows {
        for (column, (samples, bounces)) in row.into_iter().enumerate() {
            if let Some(shot) = shots.small(samples, bounces) {
                sheet.picture(&shot.film, MARGIN + column * (width + GAP), top);
                sheet.write(&caption(samples, bounces), MARGIN + column * (width + GAP), top + height, em, INK, width);
            }
        }
        top += height + line + line / 2;
    }
    let [fewer, more] = &shots.large;
    let (difference, scale) = difference(fewer, more, sheet.gain);
    let left = |column: usize| MARGIN + column * (large_width + GAP);
    for (column, shot) in shots.large.iter().enumerate() {
        sheet.picture(&shot.film, left(column), top);
        sheet.write(&caption(shot.samples, shot.bounces), left(column), top + large_height, em, INK, large_width);
    }
    sheet.pixels(&difference, large_width, left(2), top);
    let text = format!("{} minus {}, {}", bounces(more.bounces), bounces(fewer.bounces), scaled(scale));
    sheet.write(&text, left(2), top + large_height, em, INK, large_width);
    sheet.raster.png()
}

/// A sheet that is being filled.
struct Sheet {
    raster: Raster,
    em: f64,
    /// What all radiances are multiplied by.
    gain: f64,
}

impl Sheet {
    /// Writes a line below the height `top`, with letters of `em` or as small as it must be for `room` pixels.
    fn write(&mut self, text: &str, left: usize, top: usize, em: f64, colour: [u8; 3], room: usize) {
        let em = em.min(room as f64 / text_width(text, 1.0));
        // The baseline: an ascender's height and some air below the picture.
        let baseline = top as f64 + 1.15 * em.max(self.em);
        self.raster.text(text, DVec2::new(left as f64, baseline), em, colour);
    }

    fn picture(&mut self, film: &Film, left: usize, top: usize) {
        let pixels: Vec<Rgb> = film.pixels().iter().map(|pixel| pixel.mean() * self.gain).collect();
        self.pixels(&pixels, film.width(), left, top);
    }

    fn pixels(&mut self, pixels: &[Rgb], width: usize, left: usize, top: usize) {
        let shown: Vec<[u8; 3]> = pixels.iter().map(|rgb| preview(rgb.to_array())).collect();
        self.raster.paste(left, top, width, &shown);
    }
}

/// What the later bounces add, times the power of two that shows it best, and that power's exponent.
fn difference(fewer: &Shot, more: &Shot, gain: f64) -> (Vec<Rgb>, i32) {
    let pairs = fewer.film.pixels().iter().zip(more.film.pixels());
    let added: Vec<Rgb> = pairs.map(|(fewer, more)| Rgb((more.mean().0 - fewer.mean().0) * gain)).collect();
    let mut brightest: Vec<f64> = added.iter().map(|rgb| rgb.max_channel()).filter(|x| x.is_finite()).collect();
    brightest.sort_by(f64::total_cmp);
    let bright = brightest.get((UNCLIPPED * brightest.len() as f64) as usize).copied().unwrap_or(0.0);
    let scale = if bright > 0.0 { (-bright.log2()).floor().clamp(-30.0, 30.0) as i32 } else { 0 };
    (added.into_iter().map(|rgb| rgb * f64::from(scale).exp2()).collect(), scale)
}

fn bounces(count: u32) -> String {
    format!("{count} bounce{}", if count == 1 { "" } else { "s" })
}

fn caption(samples: u64, count: u32) -> String {
    format!("{samples} sample{}, {}", if samples == 1 { "" } else { "s" }, bounces(count))
}

/// How a power of two is spelled in a caption.
fn scaled(exponent: i32) -> String {
    match exponent {
        0 => "not scaled".into(),
        1.. => format!("{} times brighter", f64::from(exponent).exp2()),
        _ => format!("{} times darker", f64::from(-exponent).exp2()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_large_pictures_are_as_wide_as_six_small_ones() {
        for size in [(64, 64), (97, 33), (64, 200)] {
            let (wide, high) = large(size);
            assert_eq!(3 * wide + 2 * GAP, COLUMNS * size.0 + (COLUMNS - 1) * GAP);
            // The same shape, to a pixel.
            assert!((high as f64 / wide as f64 - size.1 as f64 / size.0 as f64).abs() <= 1.0 / wide as f64);
        }
    }

    #[test]
    fn a_difference_is_scaled_by_the_power_of_two_that_keeps_it_below_white() {
        let shot = |value: f64| {
            let mut film = Film::new(2, 2);
            (0..4).for_each(|at| film.add(at % 2, at / 2, Rgb::grey(value)));
            Shot { samples: 1, bounces: 1, film, seconds: 0.0 }
        };
        for (gap, exponent, text) in [(0.2, 2, "4 times brighter"), (3.0, -2, "4 times darker"), (0.0, 0, "not scaled")]
        {
            let (pixels, scale) = difference(&shot(0.1), &shot(0.1 + gap), 1.0);
            assert_eq!((scale, scaled(scale)), (exponent, text.to_string()));
            assert!(pixels.iter().all(|rgb| rgb.0.x <= 1.0));
        }
    }
}
