//! The map of the reciprocity residual.

use plotters::prelude::*;

use super::Figure;
use super::style::{Role, colour, framed, label, line, px, ruled};
use crate::report::probe::AsymmetryMap;

/// Upper ends of the classes of asymmetry; the last class has none.
const CLASSES: [(Role, f64, &str); 6] = [
    (Role::Heat0, 1e-12, "≤ 1e-12 (rounding)"),
    (Role::Heat1, 1e-9, "≤ 1e-9"),
    (Role::Heat2, 1e-6, "≤ 1e-6"),
    (Role::Heat3, 1e-3, "≤ 1e-3"),
    (Role::Heat4, 1e-1, "≤ 0.1"),
    (Role::Heat5, f64::INFINITY, "> 0.1, or not finite"),
];

fn class_of(residual: f64) -> usize {
    // NaN is below no end, and so falls into the last class.
    CLASSES.iter().position(|&(_, end, _)| residual <= end).unwrap_or(CLASSES.len() - 1)
}

/// The map of relative asymmetry over both polar angles.
pub fn asymmetry(map: &AsymmetryMap) -> Figure<'_> {
    Figure::new("Map of the reciprocity residual", move |area| {
        let (plot, legend) = area.split_horizontally(px(430));
        let mut chart = framed(&plot, 56).build_cartesian_2d(0.0..90.0, 0.0..90.0)?;
        let step = 90.0 / map.size as f64;
        for (i, row) in map.cells.chunks(map.size).enumerate() {
            let mut from = 0;
            // Neighbours of one class are one rectangle: a reciprocal model makes a small file.
            for run in row.chunk_by(|a, b| class_of(*a) == class_of(*b)) {
                let to = from + run.len();
                let corners = [(from as f64 * step, i as f64 * step), (to as f64 * step, (i + 1) as f64 * step)];
                let fill = colour(CLASSES[class_of(run[0])].0).filled();
                chart.draw_series([Rectangle::new(corners, fill)])?;
                from = to;
            }
        }
        let mut mesh = chart.configure_mesh();
        ruled(&mut mesh);
        mesh.disable_mesh()
            .x_labels(10)
            .y_labels(10)
            .x_label_formatter(&|x| format!("{x:.0}°"))
            .y_label_formatter(&|x| format!("{x:.0}°"))
            .x_desc("angle of b from the normal")
            .y_desc("angle of a")
            .draw()?;
        legend.draw(&Text::new("relative gap", (px(8), px(14)), label(Role::Ink)))?;
        for (row, (role, _, text)) in (0_i32..).zip(CLASSES) {
            let corners = [(px(8), px(40 + 30 * row)), (px(28), px(58 + 30 * row))];
            legend.draw(&Rectangle::new(corners, colour(role).filled()))?;
            legend.draw(&Rectangle::new(corners, line(Role::Grid, 1)))?;
            legend.draw(&Text::new(text, (px(36), px(42 + 30 * row)), label(Role::Ink)))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_residual_has_a_class() {
        assert_eq!([0.0, 1e-10, 0.05, 2.0, f64::NAN].map(class_of), [0, 1, 4, 5, 5]);
    }
}
