//! The number of links of hierarchical radiosity against the number of elements.

use plotters::prelude::*;

use super::Figure;
use super::frame::{Axis, Frame};
use super::marks::{EndLabel, Sign, dashes, mark, role};
use super::style::{Area, BARS, Drawn, Role, SIZE, line, px};
use crate::render::radiosity::hierarchical::Growth;
use crate::report::table::short;

/// One line for each error held fixed, with the exponent fitted to it, and the n² of a matrix dashed.
pub fn links<'a>(scene: &'a str, growths: &'a [Growth]) -> Figure<'a> {
    Figure::new("Links against elements", move |area| draw(scene, growths, area))
}

fn draw(scene: &str, growths: &[Growth], area: &Area<'_>) -> Drawn {
    let shown = |growth: &Growth| -> Vec<(f64, f64)> {
        growth.points.iter().map(|size| (size.finest as f64, size.links as f64)).filter(|p| p.1 > 0.0).collect()
    };
    let all = || growths.iter().flat_map(shown);
    let (least_n, most_n) = all().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let (least, most) = all().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.1), b.max(p.1)));
    if !(least_n < most_n && least <= most) {
        return Err("nothing to draw".into());
    }
    let mut labels: Vec<EndLabel> = growths
        .iter()
        .enumerate()
        .map(|(series, growth)| {
            let mut rows = vec![(Sign::Series(series), format!("error {} %", short(100.0 * growth.error)))];
            rows.extend(growth.exponent().map(|[p, error]| (Sign::Space, format!("n^({p:.2} ± {:.2})", BARS * error))));
            EndLabel { end: (0, 0), role: role(series), rows }
        })
        .collect();
    labels.push(EndLabel {
        end: (0, 0),
        role: Role::Ink,
        rows: vec![
            (Sign::Dashes(Role::Ink), "all pairs, n²".into()),
            (Sign::Space, format!("held fixed: {scene},")),
            (Sign::Space, "the error".into()),
        ],
    });
    let (x, y) = (Axis::log(least_n / 1.25, most_n * 1.15), Axis::log(least / 1.5, 1.5 * most_n * most_n));
    let frame = Frame::new(x, y, EndLabel::column(&labels).clamp(60, SIZE.0 / 2));
    frame.draw(area, "elements n, if all are as fine as allowed", "links")?;
    let [from, to] = [least_n, most_n].map(|n| frame.at(n, (n * n).max(frame.y.from)));
    dashes(area, from, to, Role::Ink)?;
    for (series, growth) in growths.iter().enumerate() {
        let path = frame.path(shown(growth));
        area.draw(&PathElement::new(path.clone(), line(role(series), 2)))?;
        for &at in &path {
            mark(area, series, at)?;
        }
        if let Some(&end) = path.last() {
            labels[series].end = end;
        }
    }
    if let Some(all_pairs) = labels.last_mut() {
        all_pairs.end = to;
    }
    EndLabel::draw(&labels, area, frame.right, (px(4), px(SIZE.1 - 4)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::radiosity::hierarchical::Size;

    #[test]
    fn what_is_held_fixed_and_the_exponents_are_said() {
        let size = |n: usize| Size { finest: n, leaves: n, links: 10 * n };
        let growths = [Growth { error: 0.03, points: [100, 1000, 10_000].map(size).to_vec() }];
        let svg = links("a box", &growths).inline();
        for text in ["error 3 %", "n^(1.00 ± 0.00)", "held fixed: a box,", "all pairs, n²"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(links("a box", &[]).svg().is_err());
    }
}
