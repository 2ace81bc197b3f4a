//! The albedo against angle, from both sides.

use plotters::prelude::*;

use super::Figure;
use super::marks::{Sign, legend};
use super::style::{Role, SIZE, framed, line, px, ruled};
use crate::report::probe::AlbedoPoint;

/// Albedos above this are drawn at it.
pub const ALBEDO_CUT: f64 = 3.0;

/// The wide line lies below the narrow one, so that both are seen where they agree, as they should.
const WIDTHS: [u32; 2] = [7, 2];

/// The albedo against the angle of the fixed direction, from both sides.
pub fn albedo(eye: &[AlbedoPoint], light: &[AlbedoPoint]) -> Figure<'static> {
    let finite = |points: &[AlbedoPoint]| -> Vec<(f64, f64)> {
        let shown = points.iter().filter(|p| p.albedo.is_finite());
        shown.map(|p| (p.theta_deg, p.albedo.clamp(0.0, ALBEDO_CUT))).collect()
    };
    let curves = [("eye fixed", Role::First, finite(eye)), ("light fixed", Role::Second, finite(light))];
    let top = curves.iter().flat_map(|(_, _, curve)| curve).map(|p| p.1).fold(1.0, f64::max) * 1.08;
    // The legend stands below the curves, or above those that are as low as itself.
    let is_low = curves.iter().flat_map(|(_, _, curve)| curve).any(|p| p.0 < 35.0 && p.1 < 0.25 * top);
    Figure::new("Albedo against angle", move |area| {
        let mut chart = framed(area, 56).build_cartesian_2d(0.0..90.0, 0.0..top)?;
        let mut mesh = chart.configure_mesh();
        ruled(&mut mesh);
        mesh.x_labels(10)
            .x_label_formatter(&|x| format!("{x:.0}°"))
            .x_desc("angle of the fixed direction from the normal")
            .y_desc("albedo (largest channel)")
            .draw()?;
        chart.draw_series(LineSeries::new([(0.0, 1.0), (90.0, 1.0)], line(Role::Ink, 1)))?;
        // The wide line lies below the narrow one, so that both are seen where they agree, as they should.
        for ((_, role, curve), width) in curves.iter().zip(WIDTHS) {
            chart.draw_series(LineSeries::new(curve.iter().copied(), line(*role, width)))?;
        }
        let entries: Vec<(Sign, &str)> =
            curves.iter().zip(WIDTHS).map(|((name, role, _), width)| (Sign::Line(line(*role, width)), *name)).collect();
        legend(area, (px(84), px(if is_low { 150 } else { SIZE.1 - 130 })), false, &entries)?;
        Ok(())
    })
}
