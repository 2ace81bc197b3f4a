//! Error against number of samples, on logarithmic axes.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::Figure;
use super::frame::{Axis, Frame};
use super::marks::{EndLabel, Sign, dashes, mark, role};
use super::style::{Area, BARS, Drawn, Role, SIZE, anchored, colour, label_width, line, px};
use crate::report::table::short;

/// A line of the plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What stands at its end.
    pub name: String,
    /// (N, RMSE, standard deviation of ln RMSE), growing in N.
    pub points: Vec<(f64, f64, f64)>,
    /// Its standard deviation for one sample, if known: σ / √N is drawn beside it.
    pub sigma: Option<f64>,
    /// The exponents that theory allows, from the steepest, which may be −∞, to the flattest.
    pub theory: [f64; 2],
}

impl Curve {
    /// What a log axis can show.
    fn shown(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        self.points.iter().copied().filter(|p| p.0 > 0.0 && p.1 > 0.0 && p.1.is_finite())
    }
}

/// The exponents that have names: independent points, stratified ones at an edge, on smooth integrands, scrambled nets on
/// smooth integrands.
const SLOPES: [(f64, &str); 4] = [(-0.5, "−1/2"), (-0.75, "−3/4"), (-1.0, "−1"), (-1.5, "−3/2")];

/// Most rows at the ends of lines: more do not fit.
const MOST_ROWS: usize = 18;

/// RMSE of every curve with 95 % bars, σ/√N dashed where σ is known, names at the ends of the lines, and the slopes that
/// theory allows any of them.
pub fn convergence(curves: &[Curve]) -> Figure<'_> {
    Figure::new("Error against number of samples", move |area| draw(curves, area))
}

fn draw(curves: &[Curve], area: &Area<'_>) -> Drawn {
    let all = || curves.iter().flat_map(Curve::shown);
    let (least_n, most_n) = all().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let bar = |p: (f64, f64, f64)| {
        let factor = (BARS * p.2).exp().min(1e3);
        (p.1 / factor, p.1 * factor)
    };
    let (least, most) = all().map(bar).fold((f64::INFINITY, 0.0_f64), |(a, b), (low, high)| (a.min(low), b.max(high)));
    if !(least_n < most_n && least <= most) {
        return Err("nothing to draw".into());
    }
    let theory_rows = curves.iter().filter(|curve| curve.sigma.is_some()).count();
    let with_theory = curves.len() + theory_rows <= MOST_ROWS;
    let rows = |series: usize, curve: &Curve| {
        let mut rows = vec![(Sign::Series(series), curve.name.clone())];
        let theory = curve.sigma.filter(|_| with_theory);
        rows.extend(theory.map(|sigma| (Sign::Dashes(role(series)), format!("{}/√N", short(sigma)))));
        rows
    };
    let unplaced = curves.iter().enumerate().filter(|(_, curve)| curve.shown().next().is_some());
    let mut labels: Vec<EndLabel> = unplaced
        .map(|(series, curve)| EndLabel { end: (0, 0), role: role(series), rows: rows(series, curve) })
        .collect();
    let column = EndLabel::column(&labels).clamp(60, SIZE.0 / 2);

    let x = Axis::log(least_n / 1.25, most_n * 1.15);
    let fan = Fan::new(curves, &x, all().map(|p| (p.0, bar(p).1)));
    let y = Axis::log(least / 1.3, (most * 1.3).max(fan.top * 1.15));
    let frame = Frame::new(x, y, column);
    frame.draw(area, "samples N", "root mean square error")?;
    fan.draw(area, &frame)?;

    for (series, curve) in curves.iter().enumerate() {
        if let Some(sigma) = curve.sigma {
            let [from, to] = [least_n, most_n].map(|n| frame.at(n, sigma / n.sqrt()));
            dashes(area, from, to, role(series))?;
        }
    }
    for (series, curve) in curves.iter().enumerate() {
        let path = frame.path(curve.shown().map(|p| (p.0, p.1)));
        area.draw(&PathElement::new(path.clone(), line(role(series), 2)))?;
        for p in curve.shown() {
            let (low, high) = bar(p);
            area.draw(&PathElement::new(frame.path([(p.0, low), (p.0, high)]), line(role(series), 1)))?;
        }
        for at in path {
            mark(area, series, at)?;
        }
    }
    let ends = curves.iter().filter_map(|curve| curve.shown().last());
    for (label, end) in labels.iter_mut().zip(ends) {
        label.end = frame.at(end.0, end.1);
    }
    EndLabel::draw(&labels, area, frame.right, (px(4), px(SIZE.1 - 4)))
}

/// The slopes of theory, as rays from one point above the curves.
#[derive(Debug)]
struct Fan {
    slopes: Vec<(f64, &'static str)>,
    /// The point's N and error, and how far the rays go.
    start: f64,
    top: f64,
    end: f64,
}

impl Fan {
    /// The lowest one whose rays stay above `points`; they fill the upper right, where errors have fallen.
    fn new(curves: &[Curve], x: &Axis, points: impl Iterator<Item = (f64, f64)>) -> Self {
        let allowed = |slope: f64| curves.iter().any(|c| c.theory[0] <= slope && slope <= c.theory[1]);
        let slopes: Vec<_> = SLOPES.into_iter().filter(|&(slope, _)| allowed(slope)).collect();
        // A share of the axis, so that the names fit to the right of the rays.
        let decades = (x.to / x.from).log10();
        let [start, end] = [0.52, 0.86].map(|share| x.from * 10_f64.powf(share * decades));
        let steepest = slopes.last().map_or(0.0, |&(slope, _)| -slope);
        let drop = (end / start).powf(steepest);
        let below = points.filter(|&(n, _)| n >= start / 2.0).map(|(_, high)| high).fold(0.0, f64::max);
        let top = if slopes.is_empty() { 0.0 } else { 1.6 * below * drop };
        Self { slopes, start, top, end }
    }

    fn draw(&self, area: &Area<'_>, frame: &Frame) -> Drawn {
        // There may be more room above than it needs.
        let top = self.top.max(frame.y.to / 1.15);
        let mut free = 0;
        for &(slope, name) in &self.slopes {
            let path = frame.path([(self.start, top), (self.end, top * (self.end / self.start).powf(slope))]);
            let (x, y) = path[1];
            area.draw(&PathElement::new(path, line(Role::Ink, 1)))?;
            let at = (x + px(5), y.max(free));
            free = at.1 + px(15);
            written(area, name, at)?;
        }
        if !self.slopes.is_empty() {
            let (x, y) = frame.at(self.start, top);
            let name = "slope";
            written(area, name, (x - px(6) - label_width(name), y))?;
        }
        Ok(())
    }
}

/// A text from `at` to the right, with paper below it: no line of the grid crosses it.
fn written(area: &Area<'_>, text: &'static str, (x, y): (i32, i32)) -> Drawn {
    let corners = [(x - px(1), y - px(7)), (x + label_width(text) + px(1), y + px(7))];
    area.draw(&Rectangle::new(corners, colour(Role::Paper).filled()))?;
    area.draw(&Text::new(text, (x, y), anchored(Role::Ink, HPos::Left, VPos::Center)))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_curve_has_its_name_and_its_theory() {
        let points = (4..10).map(|k| (f64::from(1 << k), 0.3 / f64::from(1 << k).sqrt(), 0.1)).collect();
        let curve = Curve { name: "cosine".into(), points, sigma: Some(0.3), theory: [-0.5, -0.5] };
        let svg = convergence(std::slice::from_ref(&curve)).inline();
        assert!(svg.contains("cosine") && svg.contains("0.3/√N") && svg.contains("class=\"s-first\""), "{svg}");
        assert!(svg.contains("−1/2") && !svg.contains("−3/4"), "only the slopes that theory allows");
        let bare = convergence(&[Curve { sigma: None, ..curve }]).inline();
        assert!(bare.len() < svg.len());
        assert!(convergence(&[]).inline().contains("could not be drawn") && convergence(&[]).png().is_err());
    }

    #[test]
    fn the_fan_stays_above_the_curves() {
        let points: Vec<(f64, f64, f64)> = (4..14).map(|k| (f64::from(1 << k), 0.1, 0.1)).collect();
        let curve =
            Curve { name: String::new(), points: points.clone(), sigma: None, theory: [f64::NEG_INFINITY, -0.5] };
        let x = Axis::log(10.0, 1e4);
        let fan = Fan::new(&[curve], &x, points.iter().map(|p| (p.0, p.1)));
        assert_eq!(fan.slopes.len(), 4);
        assert!(fan.top * (fan.end / fan.start).powf(-1.5) > 0.1);
    }
}
