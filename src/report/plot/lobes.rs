//! Lobes in the plane of incidence.

use plotters::prelude::*;

use super::Figure;
use super::style::{Role, SIZE, label, line, px};
use crate::report::table::short;

/// Angles of the eye whose lobes are drawn, in degrees.
pub const LOBE_ANGLES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

/// Lobes in the plane of incidence, one for each of [`LOBE_ANGLES`], each scaled to its own largest value.
pub fn lobes(lobes: &[Vec<(f64, f64)>]) -> Figure<'_> {
    let roles = [Role::First, Role::Second, Role::Third, Role::Fourth];
    Figure::new("Lobes in the plane of incidence", move |area| {
        // Equal scales on both axes; the legend stands above the half disk.
        let height = 2.3 * f64::from(SIZE.1) / f64::from(SIZE.0);
        let mut chart = ChartBuilder::on(area).build_cartesian_2d(-1.15..1.15, -0.06..height - 0.06)?;
        let ray = |angle: f64, r: f64| (r * angle.sin(), r * angle.cos());
        for r in [0.25, 0.5, 0.75, 1.0] {
            let arc = (-90..=90).map(|deg| ray(f64::from(deg).to_radians(), r));
            chart.draw_series(LineSeries::new(arc, line(Role::Grid, 1)))?;
        }
        for deg in (-90..=90).step_by(30) {
            let spoke = [(0.0, 0.0), ray(f64::from(deg).to_radians(), 1.0)];
            chart.draw_series(LineSeries::new(spoke, line(Role::Grid, 1)))?;
        }
        chart.draw_series(LineSeries::new([(-1.1, 0.0), (1.1, 0.0)], line(Role::Ink, 1)))?;
        for (at, ((lobe, role), theta_deg)) in (0_i32..).zip(lobes.iter().zip(roles).zip(LOBE_ANGLES)) {
            let peak = lobe.iter().map(|p| p.1).fold(0.0, f64::max);
            let radius = |value: f64| if peak > 0.0 { value / peak } else { 0.0 };
            let shape = lobe.iter().map(|&(angle, value)| ray(angle, radius(value)));
            chart.draw_series(LineSeries::new(shape, line(role, 2)))?;
            let eye = -theta_deg.to_radians();
            chart.draw_series(LineSeries::new([ray(eye, 1.0), ray(eye, 1.06)], line(role, 4)))?;
            let (x, y) = (px(12 + 320 * (at % 2)), px(14 + 22 * (at / 2)));
            area.draw(&PathElement::new(vec![(x, y), (x + px(22), y)], line(role, 2)))?;
            let text = format!("eye at {theta_deg}°, maximum {}/sr", short(peak));
            area.draw(&Text::new(text, (x + px(30), y - px(7)), label(Role::Ink)))?;
        }
        Ok(())
    })
}
