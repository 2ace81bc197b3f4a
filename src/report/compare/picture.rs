//! Pictures of z and of the error: raw numbers for EXR and PFM, false colours with a legend for PNG.

use super::Comparison;
use crate::image::{Format, Image, ImageError};
use crate::report::table::short;

/// |z| at which the colours of the z-image end.
const Z_END: f64 = 4.0;
/// Share of the pixels that the colours of the error image span; brighter ones are drawn at its end.
const ERROR_SPAN: f64 = 0.999;
/// Rows below the picture for the legend.
const LEGEND: usize = 24;
/// What is not finite, or has no test.
pub(in crate::report) const NO_NUMBER: [f64; 3] = [1.0, 0.0, 1.0];

/// Colours from test below to test above: blue, white, red.
const DIVERGING: [[f64; 3]; 5] =
    [[0.02, 0.19, 0.46], [0.42, 0.66, 0.87], [0.97, 0.97, 0.97], [0.95, 0.59, 0.42], [0.50, 0.02, 0.09]];
/// Colours from no error to the largest: black over purple and orange to pale yellow, of rising lightness.
pub(in crate::report) const RISING: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.02],
    [0.24, 0.06, 0.44],
    [0.56, 0.16, 0.50],
    [0.87, 0.29, 0.39],
    [0.99, 0.60, 0.33],
    [0.99, 0.97, 0.75],
];

/// z of every pixel: planes R, G and B of raw z for EXR and PFM; for PNG the z of largest size among the channels, blue
/// where the test is below the reference, red where it is above, magenta where there is none.
///
/// None where there are no z.
pub fn z_image(comparison: &Comparison, format: Format) -> Option<Result<Image, ImageError>> {
    let z = &comparison.noise.as_ref()?.z;
    if format != Format::Png {
        return Some(raw(comparison, z));
    }
    let largest = |z: &[f64; 3]| z.iter().fold(0.0, |most: f64, &v| if v.abs() <= most.abs() { most } else { v });
    let colours = z.iter().map(|z| {
        let largest = largest(z);
        if largest.is_nan() { NO_NUMBER } else { ramp(&DIVERGING, 0.5 + 0.5 * largest / Z_END) }
    });
    let ticks = [format!("{}", -Z_END), "0".into(), format!("+{Z_END}")];
    Some(with_legend(comparison, colours.collect(), &DIVERGING, &ticks))
}

/// The error of every pixel: planes R, G and B of test less reference for EXR and PFM; for PNG the mean of |test −
/// reference| over the channels, bright where it is large, magenta where it is not finite.
pub fn error_image(comparison: &Comparison, format: Format) -> Result<Image, ImageError> {
    let difference = &comparison.difference;
    if format != Format::Png {
        return raw(comparison, difference);
    }
    let errors: Vec<f64> = difference.iter().map(|d| (d[0].abs() + d[1].abs() + d[2].abs()) / 3.0).collect();
    let mut sorted: Vec<f64> = errors.iter().copied().filter(|e| e.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let end = sorted.get((ERROR_SPAN * sorted.len() as f64) as usize).or(sorted.last()).copied().unwrap_or(0.0);
    let share = |error: f64| if end > 0.0 { error / end } else { 0.0 };
    let colours = errors.iter().map(|&e| if e.is_finite() { ramp(&RISING, share(e)) } else { NO_NUMBER });
    with_legend(comparison, colours.collect(), &RISING, &["0".into(), short(end / 2.0), short(end)])
}

fn raw(comparison: &Comparison, values: &[[f64; 3]]) -> Result<Image, ImageError> {
    let values: Vec<[f32; 3]> = values.iter().map(|v| v.map(|v| v as f32)).collect();
    Image::from_rgb(comparison.width, comparison.height, &values)
}

/// The colour at `share` of the way through `stops`, clamped to its ends.
pub(in crate::report) fn ramp(stops: &[[f64; 3]], share: f64) -> [f64; 3] {
    let at = share.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let low = (at as usize).min(stops.len() - 2);
    let t = at - low as f64;
    [0, 1, 2].map(|c| stops[low][c] * (1.0 - t) + stops[low + 1][c] * t)
}

/// The picture over a bar of its colours with three numbers: at its ends and in its middle.
fn with_legend(
    comparison: &Comparison,
    mut colours: Vec<[f64; 3]>,
    stops: &[[f64; 3]],
    ticks: &[String; 3],
) -> Result<Image, ImageError> {
    const BAR: std::ops::Range<usize> = 3..10;
    const TEXT_TOP: usize = 12;
    let width = comparison.width;
    let mut legend = vec![[0.08; 3]; width * LEGEND];
    for x in 0..width {
        let colour = ramp(stops, (x as f64 + 0.5) / width as f64);
        for y in BAR {
            legend[y * width + x] = colour;
        }
    }
    for (i, text) in ticks.iter().enumerate() {
        let length = text.len() * GLYPH_STEP;
        let left = [1, (width / 2).saturating_sub(length / 2), width.saturating_sub(length)][i];
        // Narrow pictures have room for the ends alone, or for none.
        if length * (if i == 1 { 4 } else { 2 }) > width {
            continue;
        }
        for (at, character) in text.chars().enumerate() {
            for (x, y) in glyph(character) {
                let (x, y) = (left + at * GLYPH_STEP + x, TEXT_TOP + y);
                if x < width {
                    legend[y * width + x] = [0.95; 3];
                }
            }
        }
    }
    colours.extend(legend);
    let bytes: Vec<[u8; 3]> = colours.iter().map(|rgb| rgb.map(|v| (v * 255.0).round() as u8)).collect();
    Image::from_srgb8(width, comparison.height + LEGEND, &bytes)
}

/// From one character to the next, in pixels: glyphs are 3 x 5 dots of 2 x 2 pixels.
const GLYPH_STEP: usize = 8;

/// The pixels of a character, from its upper left corner.
fn glyph(character: char) -> impl Iterator<Item = (usize, usize)> {
    // Five rows of three dots each, the left one the highest bit.
    let rows: [u8; 5] = match character {
        '0' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '2' => [7, 1, 7, 4, 7],
        '3' => [7, 1, 7, 1, 7],
        '4' => [5, 5, 7, 1, 1],
        '5' => [7, 4, 7, 1, 7],
        '6' => [7, 4, 7, 5, 7],
        '7' => [7, 1, 2, 2, 2],
        '8' => [7, 5, 7, 5, 7],
        '9' => [7, 5, 7, 1, 7],
        'e' => [0, 7, 7, 4, 7],
        '-' => [0, 0, 7, 0, 0],
        '+' => [0, 2, 7, 2, 0],
        '.' => [0, 0, 0, 0, 2],
        _ => [0; 5],
    };
    (0..60).filter_map(move |at| {
        let (x, y) = (at % 6, at / 6);
        (rows[y / 2] >> (2 - x / 2) & 1 == 1).then_some((x, y))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::compare::{Settings, Side, compare, stated_noise};

    fn comparison(difference: f32) -> Comparison {
        let side = |value: f32| {
            let pixels: Vec<[f32; 3]> = (0..80 * 4).map(|at| [1.0, 1.0, if at == 5 { value } else { 1.0 }]).collect();
            let mut image = Image::from_rgb(80, 4, &pixels).unwrap();
            for name in ["Variance.R", "Variance.G", "Variance.B"] {
                image.push(name, vec![0.5; 320]).unwrap();
            }
            Side { name: String::new(), noise: stated_noise(&image), image, noise_source: String::new() }
        };
        compare(&side(1.0 + difference), &side(1.0), Settings::default()).unwrap()
    }

    #[test]
    fn raw_pictures_hold_the_numbers() {
        let c = comparison(-2.5);
        let z = z_image(&c, Format::Exr).unwrap().unwrap();
        // Variances of 1/2 each: z is the difference, but for the rounding of the files.
        assert!((z.rgb(5, 0)[2] + 2.5).abs() <= 1e-6 && z.rgb(6, 0) == [0.0; 3], "{:?}", z.rgb(5, 0));
        assert_eq!(error_image(&c, Format::Pfm).unwrap().rgb(5, 0), [0.0, 0.0, -2.5]);
    }

    #[test]
    fn false_colours_tell_below_from_above() {
        let pixel = |difference: f32| z_image(&comparison(difference), Format::Png).unwrap().unwrap().rgb(5, 0);
        let ([r, _, b], [r2, _, b2]) = (pixel(-3.0), pixel(3.0));
        assert!(b > r && r2 > b2, "blue below, red above");
        assert_eq!(pixel(4.0), pixel(400.0));
        assert_eq!(pixel(f32::NAN), [1.0, 0.0, 1.0]);
        let image = error_image(&comparison(1.0), Format::Png).unwrap();
        assert_eq!((image.width(), image.height()), (80, 4 + LEGEND));
        assert!(image.rgb(5, 0)[0] > 0.9 && image.rgb(6, 0)[0] < 0.1);
    }
}
