//! A picture of variances in false colours on a logarithmic scale, beside the bar of its colours.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::frame::Axis;
use super::raster::Raster;
use super::style::{Drawn, Role, SIZE, anchored, colour, label, line, px};
use super::{Area, Figure, Picture};
use crate::report::compare::picture::{NO_NUMBER, RISING, ramp};

/// Shares of the pixels that are drawn at the ends of the scale, at most.
const CUT: [f64; 2] = [0.01, 0.001];
/// The scale spans at least this factor, at most that one.
const SPAN: [f64; 2] = [10.0, 1e8];
/// The bar in pixels: its width, and what is left for it and its numbers.
const BAR: i32 = 20;
const BESIDE: i32 = 130;

/// The variances of an image's pixels, row by row from the top, `width` in a row. Zeros have the darkest colour; what is
/// negative or not finite is magenta.
pub fn variance(width: usize, values: &[f64], what: &str) -> Figure<'static> {
    let height = values.len() / width.max(1);
    let scale = scale(values);
    let colours: Vec<[u8; 3]> = values.iter().map(|&v| shown(&scale, v)).collect();
    let mut raster = Raster::new(width, height, [0; 3]);
    raster.paste(0, 0, width, &colours);
    // As large as there is room, and in the middle of its height.
    let room = (f64::from(SIZE.0 - BESIDE - 12), f64::from(SIZE.1 - 24));
    let zoom = (room.0 / width.max(1) as f64).min(room.1 / height.max(1) as f64);
    let shown = ((width as f64 * zoom) as i32, (height as f64 * zoom) as i32);
    // A narrow picture stands beside its bar, in the middle of both.
    let left = 12 + ((room.0 as i32 - shown.0) / 2).max(0);
    let (top, right, bottom) = (px((SIZE.1 - shown.1) / 2), px(left + shown.0), px(i32::midpoint(SIZE.1, shown.1)));
    let corners = [(px(left), top), (right, bottom)];
    let what = what.to_string();
    let empty = values.is_empty();
    let draw = move |area: &Area<'_>| {
        if empty { Err("there are no pixels".into()) } else { bar(&scale, (right + px(16), px(24)), &what, area) }
    };
    Figure::new("Variance of the pixels", draw).with_picture(Picture { corners, raster })
}

/// From the smallest variances to the largest, but for a few.
fn scale(values: &[f64]) -> Axis {
    let mut positive: Vec<f64> = values.iter().copied().filter(|v| *v > 0.0 && v.is_finite()).collect();
    positive.sort_by(f64::total_cmp);
    let last = positive.len().saturating_sub(1);
    let at = |share: f64| positive.get((share * last as f64).round() as usize).copied().unwrap_or(1.0);
    let to = at(1.0 - CUT[1]);
    let from = at(CUT[0]).clamp(to / SPAN[1], to / SPAN[0]);
    Axis::log(from, to)
}

fn shown(scale: &Axis, value: f64) -> [u8; 3] {
    let colour = if value >= 0.0 && value.is_finite() { ramp(&RISING, scale.share(value)) } else { NO_NUMBER };
    colour.map(|v| (v * 255.0).round() as u8)
}

/// The bar of colours from bottom to top, with its numbers.
fn bar(scale: &Axis, (x, top): (i32, i32), what: &str, area: &Area<'_>) -> Drawn {
    const STEPS: i32 = 128;
    let bottom = px(SIZE.1 - 24);
    let height = |share: f64| bottom - (share * f64::from(bottom - top)).round() as i32;
    // Each colour from its upper end down to the bottom, over the brighter ones: neighbours show no seam.
    for step in (0..STEPS).rev() {
        let share = |step: f64| step / f64::from(STEPS);
        let [r, g, b] = ramp(&RISING, share(f64::from(step) + 0.5)).map(|v| (v * 255.0).round() as u8);
        let corners = [(x, height(share(f64::from(step) + 1.0))), (x + px(BAR), bottom)];
        area.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled()))?;
    }
    area.draw(&Rectangle::new([(x, top), (x + px(BAR), bottom)], line(Role::Ink, 1)))?;
    for tick in scale.ticks() {
        let y = height(scale.share(tick.at));
        let length = if tick.number.is_some() { 5 } else { 3 };
        let from = x + px(BAR);
        area.draw(&PathElement::new(vec![(from, y), (from + px(length), y)], line(Role::Ink, 1)))?;
        if let Some(number) = tick.number {
            area.draw(&Text::new(number, (from + px(9), y), anchored(Role::Ink, HPos::Left, VPos::Center)))?;
        }
    }
    let upwards = label(Role::Ink).transform(FontTransform::Rotate270).pos(Pos::new(HPos::Center, VPos::Center));
    let at = (x + px(BAR + 66), i32::midpoint(top, bottom));
    area.draw(&Text::new(what.to_string(), at, upwards.color(&colour(Role::Ink))))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_leaves_out_a_few_and_brighter_is_more() {
        let values: Vec<f64> = (0..1000).map(|i| 10_f64.powf(-4.0 + 4.0 * f64::from(i) / 999.0)).chain([0.0]).collect();
        let scale = scale(&values);
        assert!(scale.from > 1e-4 && scale.from < 1.2e-4 && scale.to <= 1.0 && scale.to > 0.98, "{scale:?}");
        let sum = |v: f64| shown(&scale, v).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(sum(0.0) < sum(1e-3) && sum(1e-3) < sum(1e-1) && sum(1e-1) < sum(1.0));
        assert_eq!(shown(&scale, f64::NAN), [255, 0, 255]);
        assert_eq!(shown(&scale, 0.0), shown(&scale, scale.from), "what is below the scale has its lowest colour");
    }

    #[test]
    fn the_picture_is_in_both_kinds_of_file() {
        let figure = variance(4, &[0.1, 1.0, 10.0, 100.0, 0.2, 0.3, 0.0, f64::INFINITY], "variance");
        let svg = figure.svg().unwrap();
        assert!(svg.contains("<image ") && svg.contains("data:image/png;base64,iVBORw0KGgo"), "{svg}");
        assert!(roxmltree::Document::parse(&svg).is_ok());
        let raster = figure.raster().unwrap();
        let magenta = (0..raster.height()).flat_map(|y| (0..raster.width()).map(move |x| (x, y)));
        let magenta = magenta.filter(|&(x, y)| raster.pixel(x, y) == Some([255, 0, 255])).count();
        // An eighth of a picture twice as wide as high: 2 · (640 − 142) pixels wide.
        let expected = (996.0 / 4.0_f64).powi(2);
        assert!((magenta as f64 / expected - 1.0).abs() < 0.02, "{magenta}");
        assert!(variance(0, &[], "").png().is_err());
    }
}
