//! The time of a search in photons against their number, by the store that holds them.

use plotters::prelude::*;

use super::Figure;
use super::frame::{Axis, Frame};
use super::marks::{EndLabel, Sign, dashes, mark, role};
use super::style::{Area, BARS, Drawn, SIZE, line, px};
use crate::render::photon::stores::{Cost, Store, Timing, exponents};

/// One line for each store, with the exponent fitted to it, and the slope that a scan tends to dashed; the photons are those of
/// `scene`, `k` of them are searched for.
pub fn stores<'a>(scene: &'a str, k: usize, timings: &'a [Timing]) -> Figure<'a> {
    Figure::new("Seconds to find photons against their number", move |area| draw(scene, k, timings, area))
}

fn draw(scene: &str, k: usize, timings: &[Timing], area: &Area<'_>) -> Drawn {
    let (first, last) = timings.first().zip(timings.last()).ok_or("nothing to draw")?;
    let all = || timings.iter().flat_map(|of| of.costs).map(|cost| cost.query);
    let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let mut labels: Vec<EndLabel> = (0..)
        .zip(Store::ALL.iter().zip(exponents(timings)))
        .map(|(series, (store, exponent))| {
            let mut rows = vec![(Sign::Series(series), store.name().into())];
            rows.extend(exponent.map(|[p, error]| (Sign::Space, format!("n^({p:.2} ± {:.2})", BARS * error))));
            if *store == Store::Scan {
                rows.push((Sign::Dashes(role(series)), "slope 1".into()));
            }
            EndLabel { end: (0, 0), role: role(series), rows }
        })
        .collect();
    let x = Axis::log(first.photons as f64 / 1.25, last.photons as f64 * 1.15);
    let frame = Frame::new(x, Axis::log(least / 1.5, most * 1.5), EndLabel::column(&labels).clamp(60, SIZE.0 / 2));
    let found = if k == 1 { "nearest".into() } else { format!("{k} nearest") };
    frame.draw(area, &format!("photons n ({scene})"), &format!("seconds to find the {found}"))?;
    // From where it is as low as the frame.
    let [Cost { query: scan, .. }, ..] = last.costs;
    let lowest = (last.photons as f64 * frame.y.from / scan).max(first.photons as f64);
    let share = lowest / last.photons as f64;
    dashes(area, frame.at(lowest, share * scan), frame.at(last.photons as f64, scan), role(0))?;
    for (series, label) in labels.iter_mut().enumerate() {
        let path = frame.path(timings.iter().map(|of| (of.photons as f64, of.costs[series].query)));
        area.draw(&PathElement::new(path.clone(), line(role(series), 2)))?;
        for &at in &path {
            mark(area, series, at)?;
        }
        label.end = frame.at(last.photons as f64, last.costs[series].query);
    }
    EndLabel::draw(&labels, area, frame.right, (px(4), px(SIZE.1 - 4)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stores_and_their_exponents_are_said() {
        let timing = |photons: usize| {
            let cost = |p: f64| Cost { build: 0.0, query: 1e-6 * (photons as f64).powf(p) };
            Timing { photons, costs: [1.0, 0.25, 0.0].map(cost) }
        };
        let timings = [1000, 10_000, 100_000].map(timing);
        let svg = stores("a box", 100, &timings).inline();
        for text in [
            "scan",
            "n^(1.00 ± 0.00)",
            "slope 1",
            "hash grid",
            "n^(0.25 ± 0.00)",
            "k-d tree",
            "n^(0.00",
            "a box",
            "100",
        ] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(!stores("a box", 1, &timings[..1]).svg().unwrap().contains("n^("), "one number has no exponent");
        assert!(stores("a box", 1, &[]).svg().is_err());
    }
}
