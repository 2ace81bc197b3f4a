//! The variance of a sample against the number of continuations of its first event.

use plotters::prelude::*;

use super::Figure;
use super::frame::{Axis, Frame};
use super::marks::{EndLabel, Sign, dashes, mark, role};
use super::style::{Area, BARS, Drawn, SIZE, line, px};
use crate::converge::first_split::{Fit, Law, Point};
use crate::report::table::short;

/// Measured variances with 95 % bars, the law V₀ + V₁/M through them with its two parts, and the exact law if it is known.
pub fn first_split<'a>(points: &'a [Point], fit: &'a Fit, exact: Option<Law>) -> Figure<'a> {
    Figure::new("Variance against the first split", move |area| draw(points, fit, exact, area))
}

fn draw(points: &[Point], fit: &Fit, exact: Option<Law>, area: &Area<'_>) -> Drawn {
    let (least_m, most_m) = points.iter().fold((u32::MAX, 0), |(a, b), p| (a.min(p.m), b.max(p.m)));
    let ms = [f64::from(least_m), f64::from(most_m)];
    let law = fit.law;
    let low_bar = |p: &Point| Some(p.variance - BARS * p.std_err).filter(|&low| low > 0.0).unwrap_or(p.variance);
    let values = points.iter().flat_map(|p| [low_bar(p), p.variance + BARS * p.std_err]);
    // The parts are shown where they are of the size of the whole.
    let least_whole = points.iter().map(|p| p.variance).fold(f64::INFINITY, f64::min);
    let parts = [law.v0, law.v1 / ms[1]].map(|part| part.max(least_whole / 30.0));
    let (least, most) = values.chain(parts).fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    if !(ms[0] < ms[1] && least > 0.0 && least < most && most.is_finite()) {
        return Err("nothing to draw".into());
    }
    let number = |name: &str, value: f64, error: f64| format!("{name} = {}", with_error(value, BARS * error));
    let (x, y) = (Axis::log(ms[0] / 1.15, ms[1] * 1.15), Axis::log(least / 1.25, most * 1.25));
    let mut labels = vec![
        EndLabel {
            end: (0, 0),
            role: role(0),
            rows: vec![(Sign::Mark(0), "measured, 95 %".into()), (Sign::Line(line(role(0), 2)), "V₀ + V₁/M".into())],
        },
        EndLabel {
            end: (0, 0),
            role: role(1),
            rows: vec![(Sign::Dashes(role(1)), number("V₀", law.v0, fit.std_err.v0))],
        },
        EndLabel {
            end: (0, 0),
            role: role(3),
            rows: vec![(Sign::Dashes(role(3)), "V₁/M".into()), (Sign::Space, number("V₁", law.v1, fit.std_err.v1))],
        },
    ];
    if let Some(exact) = exact {
        labels[1].rows.push((Sign::Space, format!("exact: {}", short(exact.v0))));
        labels[2].rows.push((Sign::Space, format!("exact: {}", short(exact.v1))));
    }
    let frame = Frame::new(x, y, EndLabel::column(&labels).clamp(60, SIZE.0 / 2));
    frame.draw(area, "continuations M of the first event", "variance of a sample")?;

    // A part that is negative, as noise may have it, has no place on this axis.
    let parts: [(usize, &dyn Fn(f64) -> f64); 2] = [(1, &|_| law.v0), (3, &|m| law.v1 / m)];
    for (series, part) in parts {
        if ms.iter().all(|&m| part(m) > 0.0) {
            let seen = clipped(&frame, &ms, part);
            let [from, to] = seen.map(|m| frame.at(m, part(m)));
            dashes(area, from, to, role(series))?;
        }
    }
    let steps = (0..=128).map(|i| ms[0] * (ms[1] / ms[0]).powf(f64::from(i) / 128.0));
    let curve = frame.path(steps.map(|m| (m, law.at(m).max(frame.y.from))));
    area.draw(&PathElement::new(curve, line(role(0), 2)))?;
    for p in points {
        let m = f64::from(p.m);
        let bar = frame.path([(m, low_bar(p)), (m, p.variance + BARS * p.std_err)]);
        area.draw(&PathElement::new(bar, line(role(0), 1)))?;
        mark(area, 0, frame.at(m, p.variance))?;
    }
    for (label, value) in labels.iter_mut().zip([law.at(ms[1]), law.v0, law.v1 / ms[1]]) {
        label.end = frame.at(ms[1], value.max(frame.y.from));
    }
    EndLabel::draw(&labels, area, frame.right, (px(4), px(SIZE.1 - 4)))
}

/// A value with its error, both to two digits of the error where plain digits are not long.
fn with_error(value: f64, error: f64) -> String {
    let decimals = (1.0 - error.abs().log10().floor()).max(0.0);
    if decimals <= 7.0 {
        let decimals = decimals as usize;
        format!("{value:.decimals$} ± {error:.decimals$}")
    } else {
        format!("{} ± {}", short(value), short(error))
    }
}

/// The ends of the part of a power law that lies within the frame.
fn clipped(frame: &Frame, ms: &[f64; 2], part: &dyn Fn(f64) -> f64) -> [f64; 2] {
    let steps = (0..=256).map(|i| ms[0] * (ms[1] / ms[0]).powf(f64::from(i) / 256.0));
    let inside: Vec<f64> = steps.filter(|&m| (frame.y.from..=frame.y.to).contains(&part(m))).collect();
    [inside.first().copied().unwrap_or(ms[0]), inside.last().copied().unwrap_or(ms[0])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_two_digits() {
        assert_eq!(with_error(0.0047690, 4.552e-5), "0.004769 ± 0.000046");
        assert_eq!(with_error(12.3456, 1.7), "12.3 ± 1.7");
        assert_eq!(with_error(1e-12, 1e-13), "1e-12 ± 1e-13");
    }

    #[test]
    fn the_law_and_its_parts_are_named() {
        let point =
            |m: u32| Point { m, mean: 0.0, mean_std_err: 0.1, variance: 0.1 + 1.0 / f64::from(m), std_err: 0.01 };
        let points = [1, 2, 4, 8].map(point);
        let fit = Fit::of(&points).unwrap();
        let svg = first_split(&points, &fit, Some(Law { v0: 0.11, v1: 1.0 })).inline();
        for text in ["V₀ + V₁/M", "V₀ = 0.100 ±", "exact: 0.11", "continuations M"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(first_split(&[], &fit, None).svg().is_err());
    }
}
