//! Where a sampler's draws fall, against where its pdf says they do.

use std::f64::consts::FRAC_PI_2;

use plotters::prelude::*;

use super::Figure;
use super::marks::{Sign, legend};
use super::style::{Role, SIZE, colour, framed, label, line, px, ruled};
use crate::report::probe::Histogram;

/// A tick's number.
fn three_digits(x: f64) -> String {
    if x == 0.0 || x >= 0.1 { format!("{x:.1}").trim_end_matches(".0").into() } else { format!("{x:.2e}") }
}

/// Shares of the draws in rings about the mirror direction: bars for the sampler, a line for the pdf.
pub fn histogram(histogram: &Histogram) -> Figure<'_> {
    let n = histogram.edges.len().saturating_sub(1);
    let reach = histogram.edges.last().copied().unwrap_or(FRAC_PI_2);
    // The two shares that belong to no ring stand apart on the right.
    let place = move |bar: usize| bar as f64 + if bar >= n { 1.5 * (bar - n + 1) as f64 } else { 0.0 };
    let right = place(n + 1) + 2.0;
    let top = histogram.sampled.iter().chain(&histogram.claimed).copied().filter(|x| x.is_finite());
    // The legend stands above the tallest bar and its name.
    let top = top.fold(1e-6, f64::max) * 1.45;
    Figure::new("Sampled against claimed histogram", move |area| {
        let mut chart = framed(area, 64).build_cartesian_2d(0.0..right, 0.0..top)?;
        let mut mesh = chart.configure_mesh();
        ruled(&mut mesh);
        mesh.disable_x_mesh()
            .x_labels(8)
            .x_label_formatter(&|x| {
                let angle = reach * (x / n as f64).powi(2);
                if *x <= n as f64 { format!("{}°", three_digits(angle.to_degrees())) } else { String::new() }
            })
            .x_desc("angle from the mirror direction (quadratic scale)")
            .y_desc("share of the draws")
            .draw()?;
        let style = colour(Role::First).mix(0.55).filled();
        let bars = histogram.sampled.iter().enumerate().map(|(bar, &share)| {
            Rectangle::new([(place(bar) + 0.06, 0.0), (place(bar) + 0.94, share.clamp(0.0, top))], style)
        });
        chart.draw_series(bars)?;
        let step = line(Role::Second, 2);
        let level = |bar: usize| histogram.claimed.get(bar).copied().unwrap_or(0.0).clamp(0.0, top);
        let steps = (0..n).flat_map(|bar| [(place(bar), level(bar)), (place(bar) + 1.0, level(bar))]);
        chart.draw_series(LineSeries::new(steps, step))?;
        for (bar, name) in [(n, "rest"), (n + 1, "lost")] {
            chart
                .draw_series(LineSeries::new([(place(bar) - 0.2, level(bar)), (place(bar) + 1.2, level(bar))], step))?;
            let above = histogram.sampled.get(bar).copied().unwrap_or(0.0).max(level(bar)) + 0.05 * top;
            chart.draw_series([Text::new(name, (place(bar) - 0.5, above.min(top)), label(Role::Ink))])?;
        }
        let entries = [(Sign::Box(style), "sampled"), (Sign::Line(step), "claimed by the pdf")];
        legend(area, (px(SIZE.0 - 36), px(24)), true, &entries)?;
        Ok(())
    })
}
