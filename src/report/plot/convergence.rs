//! Error against number of samples, on logarithmic axes.

use plotters::prelude::*;

use super::Figure;
use super::style::{Drawn, SERIES, SIZE, colour, framed, label, line, px, ruled};

/// A line of the plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What stands at its end.
    pub name: String,
    /// (N, RMSE, standard deviation of ln RMSE), growing in N.
    pub points: Vec<(f64, f64, f64)>,
    /// Its standard deviation for one sample, if known: σ / √N is drawn beside it.
    pub sigma: Option<f64>,
}

/// Room for a letter of a name, in pixels.
const WIDTH_OF_LETTER: i32 = 8;

/// Error bars reach to 1.96 standard deviations: 95 %.
const BARS: f64 = 1.96;

/// 10^k as text where x is a power of ten, else nothing.
fn decade(x: f64) -> String {
    let exponent = x.log10().round();
    if (x.log10() - exponent).abs() > 1e-6 {
        return String::new();
    }
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    match exponent as i32 {
        0 => "1".into(),
        1 => "10".into(),
        k => format!("10{}", k.to_string().chars().map(raised).collect::<String>()),
    }
}

/// The labels' heights, in the order of the ends of their lines and at least `gap` apart.
fn spread(ends: &[f64], gap: f64, top: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by(|&a, &b| ends[a].total_cmp(&ends[b]));
    let mut heights = ends.to_vec();
    let mut least = f64::NEG_INFINITY;
    for &i in &order {
        heights[i] = heights[i].max(least);
        least = heights[i] + gap;
    }
    // Those pushed beyond the top come back down.
    let mut most = top;
    for &i in order.iter().rev() {
        heights[i] = heights[i].min(most);
        most = heights[i] - gap;
    }
    heights
}

/// RMSE of every curve with 95 % bars, σ/√N dashed where σ is known, and names at the ends of the lines.
pub fn convergence(curves: &[Curve]) -> Figure<'_> {
    let all = || curves.iter().flat_map(|curve| &curve.points).filter(|p| p.0 > 0.0 && p.1 > 0.0 && p.1.is_finite());
    let (least_n, most_n) = all().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let (least, most) = all().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.1), b.max(p.1)));
    let (low, high) = (10_f64.powf((least * 0.8).log10().floor()), 10_f64.powf((most * 1.2).log10().ceil()));
    Figure::new("Error against number of samples", move |area| {
        let longest = curves.iter().map(|curve| curve.name.chars().count().min(99) as u8).max().map_or(0, i32::from);
        let (plot, names) = area.split_horizontally(px(SIZE.0 - (WIDTH_OF_LETTER * longest + 20).clamp(60, 320)));
        if !(least_n < most_n && least <= most) {
            return Err("nothing to draw".into());
        }
        let mut chart = framed(&plot, 56)
            .margin_right(px(4))
            .build_cartesian_2d((least_n * 0.8..most_n * 1.1).log_scale(), (low..high).log_scale())?;
        let mut mesh = chart.configure_mesh();
        ruled(&mut mesh);
        mesh.x_labels(8)
            .y_labels(12)
            .x_label_formatter(&|x| decade(*x))
            .y_label_formatter(&|y| decade(*y))
            .x_desc("samples")
            .y_desc("root mean square error")
            .draw()?;
        for (series, curve) in curves.iter().enumerate() {
            let role = SERIES[series % SERIES.len()];
            if let Some(sigma) = curve.sigma {
                let ends = [least_n, most_n].map(|n| (n, sigma / n.sqrt()));
                let dashes = DashedLineSeries::new(ends, px(5), px(5), line(role, 1));
                chart.draw_series(dashes)?;
            }
            let points: Vec<(f64, f64)> = curve.points.iter().filter(|p| p.1 > 0.0).map(|p| (p.0, p.1)).collect();
            chart.draw_series(LineSeries::new(points.iter().copied(), line(role, 2)))?;
            for &(n, rmse, log_std_err) in curve.points.iter().filter(|p| p.1 > 0.0) {
                let factor = (BARS * log_std_err).exp();
                let bar = vec![(n, (rmse / factor).max(low)), (n, (rmse * factor).min(high))];
                chart.draw_series([PathElement::new(bar, line(role, 1))])?;
            }
            // Lines of one colour differ by their marks, which also tell neighbours apart in grey.
            let (at, fill) = (points.into_iter(), colour(role).filled());
            match (series + series / SERIES.len()) % 4 {
                0 => chart.draw_series(at.map(|p| Circle::new(p, px(4), fill)))?,
                1 => chart.draw_series(at.map(|p| TriangleMarker::new(p, px(5), fill)))?,
                2 => {
                    let corners = [(-px(4), -px(4)), (px(4), px(4))];
                    chart.draw_series(at.map(|p| EmptyElement::at(p) + Rectangle::new(corners, fill)))?
                }
                _ => chart.draw_series(at.map(|p| Cross::new(p, px(4), line(role, 2))))?,
            };
        }
        let height = |rmse: f64| f64::from(chart.backend_coord(&(most_n, rmse)).1);
        let ends: Vec<f64> =
            curves.iter().map(|curve| curve.points.last().map_or(0.0, |p| height(p.1.clamp(low, high)))).collect();
        let bottom = f64::from(px(SIZE.1 - 24));
        for ((series, curve), y) in curves.iter().enumerate().zip(spread(&ends, f64::from(px(20)), bottom)) {
            let text = Text::new(curve.name.clone(), (px(6), y as i32 - px(8)), label(SERIES[series % SERIES.len()]));
            names.draw(&text)?;
        }
        Ok(()) as Drawn
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_written_as_powers() {
        assert_eq!([1.0, 10.0, 1000.0, 1e-12, 2.0].map(decade), ["1", "10", "10³", "10⁻¹²", ""]);
    }

    #[test]
    fn labels_keep_their_distance_and_their_order() {
        let heights = spread(&[50.0, 10.0, 12.0, 99.0, 98.0], 20.0, 100.0);
        let mut sorted = heights.clone();
        sorted.sort_by(f64::total_cmp);
        assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] >= 20.0 - 1e-9), "{heights:?}");
        assert!(heights[1] < heights[2] && heights[2] < heights[0] && heights[4] < heights[3], "{heights:?}");
        assert!(sorted[4] <= 100.0);
    }

    #[test]
    fn every_curve_has_its_name_and_its_theory() {
        let points = (4..10).map(|k| (f64::from(1 << k), 0.3 / f64::from(1 << k).sqrt(), 0.1)).collect();
        let curve = Curve { name: "cosine".into(), points, sigma: Some(0.3) };
        let svg = convergence(std::slice::from_ref(&curve)).inline();
        assert!(svg.contains("cosine") && svg.contains("class=\"s-first\""), "{svg}");
        let bare = convergence(&[Curve { sigma: None, ..curve }]).inline();
        assert!(bare.len() < svg.len());
        assert!(convergence(&[]).inline().contains("could not be drawn") && convergence(&[]).png().is_err());
    }
}
