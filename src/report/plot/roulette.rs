//! The variance of Russian roulette in a furnace against the probability of going on.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Figure;
use super::frame::{Axis, Frame};
use super::marks::{Sign, dashes, hollow, legend, mark, role};
use super::style::{Area, BARS, Drawn, Role, anchored, colour, label, label_width, line, px};
use crate::converge::roulette::Furnace;
use crate::report::table::short;

/// A measured variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoulettePoint {
    /// Where.
    pub furnace: Furnace,
    /// The variance of the samples.
    pub variance: f64,
    /// Its standard error; None where the fourth moment is infinite, and the samples cannot know it.
    pub std_err: Option<f64>,
}

/// Share of the axis that the region of infinite variance takes, where ρ² allows.
const REGION: f64 = 0.24;

/// The closed form as a line, the region q ≤ ρ² in which it is infinite, and measured variances with 95 % bars, or as rings
/// where the samples cannot know their error.
pub fn roulette(rho: f64, points: &[RoulettePoint]) -> Figure<'_> {
    Figure::new("Variance of Russian roulette", move |area| draw(rho, points, area))
}

fn draw(rho: f64, points: &[RoulettePoint], area: &Area<'_>) -> Drawn {
    let pole = rho * rho;
    let from = (pole - REGION / (1.0 - REGION) * (1.0 - pole)).max(0.0);
    let variance = |q: f64| Furnace::new(rho, q).map_or(f64::NAN, |furnace| furnace.variance());
    // Towards the pole the line leaves through the top.
    let qs = |share: f64| pole + (1.0 - pole) * share;
    let (least, most) = (variance(qs(0.985)), variance(qs(0.004)));
    let finite = |p: &&RoulettePoint| p.variance > 0.0 && p.variance.is_finite();
    let values = points.iter().filter(finite).flat_map(|p| [p.variance, p.variance + BARS * p.std_err.unwrap_or(0.0)]);
    let (least, most) = values.fold((least, most), |(a, b), v| (a.min(v), b.max(v)));
    if !(least > 0.0 && least < most && most.is_finite()) {
        return Err("nothing to draw".into());
    }
    let frame = Frame::new(Axis::linear(from, 1.0), Axis::log(least / 1.3, most * 1.5), 24);

    let (left, right) = (frame.at(from, least).0, frame.at(pole, least).0);
    area.draw(&Rectangle::new([(left, frame.top), (right, frame.bottom)], colour(Role::Grid).filled()))?;
    frame.draw(area, "probability q of going on after a reflection", "variance of a path")?;
    dashes(area, (right, frame.top), (right, frame.bottom), Role::Ink)?;
    let text = [format!("q ≤ ρ² = {}:", short(pole)), "infinite variance".to_string()];
    let (middle, high) = (i32::midpoint(left, right), frame.bottom - px(70));
    if right - left > text.iter().map(|row| label_width(row)).max().unwrap_or(0) + px(8) {
        for (row, text) in (0_i32..).zip(text) {
            area.draw(&Text::new(
                text,
                (middle, high + px(18 * row)),
                anchored(Role::Ink, HPos::Center, VPos::Center),
            ))?;
        }
    } else {
        let upwards = label(Role::Ink).transform(FontTransform::Rotate270).pos(Pos::new(HPos::Left, VPos::Center));
        let x = if right - left > px(18) { middle } else { right + px(12) };
        area.draw(&Text::new(text.join(" "), (x, frame.bottom - px(10)), upwards))?;
    }

    // Denser at both ends, where the line is steep.
    let shares = (0..=240).map(|i| 0.5 - 0.5 * (std::f64::consts::PI * (f64::from(i) + 0.5) / 241.0).cos());
    let seen = shares.map(|share| (qs(share), variance(qs(share))));
    let curve = frame.path(seen.filter(|p| p.1 >= frame.y.from && p.1 <= frame.y.to));
    area.draw(&PathElement::new(curve, line(role(0), 2)))?;
    for p in points.iter().filter(finite) {
        let q = p.furnace.survival();
        let Some(std_err) = p.std_err else {
            hollow(area, role(3), frame.at(q, p.variance))?;
            continue;
        };
        let low = (p.variance - BARS * std_err).max(frame.y.from);
        area.draw(&PathElement::new(frame.path([(q, low), (q, p.variance + BARS * std_err)]), line(role(1), 1)))?;
        mark(area, 1, frame.at(q, p.variance))?;
    }
    let mut entries =
        vec![(Sign::Line(line(role(0), 2)), "ρ²(1−q) / ((1−ρ)²(q−ρ²))"), (Sign::Mark(1), "measured, 95 %")];
    if points.iter().any(|p| p.std_err.is_none()) {
        entries.push((Sign::Hollow(role(3)), "q ≤ ρ^(4/3): no known error"));
    }
    legend(area, (frame.right - px(6), frame.top + px(6)), true, &entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_region_of_infinite_variance_is_named() {
        for rho in [0.05, 0.5, 0.9, 0.99] {
            let furnace = Furnace::new(rho, 0.5 + 0.5 * rho).unwrap();
            let point =
                RoulettePoint { furnace, variance: furnace.variance(), std_err: Some(0.1 * furnace.variance()) };
            let svg = roulette(rho, &[point]).inline();
            assert!(
                svg.contains("infinite variance") && svg.contains(&format!("q ≤ ρ² = {}", short(rho * rho))),
                "{svg}"
            );
        }
        assert!(roulette(1.0, &[]).png().is_err(), "no furnace");
    }
}
