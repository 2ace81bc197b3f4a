//! Plots as SVG that reads in light and in dark.
//!
//! plotters draws with one fixed colour for each role; a class is then added to each of these, and [`css`] says
//! what the classes look like in either colour scheme. A viewer without CSS still shows the light colours. No font is
//! needed: texts stay texts.

mod convergence;

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::probe::{AlbedoPoint, AsymmetryMap, Histogram};
use super::table::short;

pub use convergence::{Curve, convergence};

/// What a colour stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Paper,
    Ink,
    Grid,
    First,
    Second,
    Third,
    Fourth,
    Heat0,
    Heat1,
    Heat2,
    Heat3,
    Heat4,
    Heat5,
}

/// Each role with its class and its colour in light and in dark. The four series differ for the colour-blind, too.
const THEME: [(Role, &str, RGBColor, RGBColor); 13] = [
    (Role::Paper, "paper", RGBColor(0xff, 0xff, 0xff), RGBColor(0x15, 0x18, 0x1c)),
    (Role::Ink, "ink", RGBColor(0x1b, 0x1f, 0x24), RGBColor(0xe6, 0xe9, 0xed)),
    (Role::Grid, "grid", RGBColor(0xd9, 0xde, 0xe4), RGBColor(0x35, 0x3b, 0x43)),
    (Role::First, "first", RGBColor(0x1f, 0x6f, 0xb4), RGBColor(0x6c, 0xb2, 0xf0)),
    (Role::Second, "second", RGBColor(0xc2, 0x55, 0x0a), RGBColor(0xf5, 0x9a, 0x57)),
    (Role::Third, "third", RGBColor(0x1b, 0x85, 0x60), RGBColor(0x58, 0xc9, 0x9c)),
    (Role::Fourth, "fourth", RGBColor(0x86, 0x4f, 0xa9), RGBColor(0xc7, 0x9a, 0xe6)),
    (Role::Heat0, "heat0", RGBColor(0xea, 0xf2, 0xfa), RGBColor(0x1e, 0x28, 0x33)),
    (Role::Heat1, "heat1", RGBColor(0xbd, 0xd7, 0xee), RGBColor(0x24, 0x44, 0x63)),
    (Role::Heat2, "heat2", RGBColor(0x7f, 0xb4, 0xdf), RGBColor(0x2f, 0x6b, 0x9e)),
    (Role::Heat3, "heat3", RGBColor(0xf6, 0xc2, 0x8b), RGBColor(0xa8, 0x6a, 0x2c)),
    (Role::Heat4, "heat4", RGBColor(0xe5, 0x7f, 0x3c), RGBColor(0xe0, 0x86, 0x3f)),
    (Role::Heat5, "heat5", RGBColor(0xa8, 0x1e, 0x1e), RGBColor(0xff, 0x6b, 0x5e)),
];

/// Upper ends of the classes of asymmetry; the last class has none.
const ASYMMETRY_CLASSES: [(Role, f64, &str); 6] = [
    (Role::Heat0, 1e-12, "≤ 1e-12 (rounding)"),
    (Role::Heat1, 1e-9, "≤ 1e-9"),
    (Role::Heat2, 1e-6, "≤ 1e-6"),
    (Role::Heat3, 1e-3, "≤ 1e-3"),
    (Role::Heat4, 1e-1, "≤ 0.1"),
    (Role::Heat5, f64::INFINITY, "> 0.1, or not finite"),
];

/// Albedos above this are drawn at it.
pub const ALBEDO_CUT: f64 = 3.0;

/// Angles of the eye whose lobes are drawn, in degrees.
pub const LOBE_ANGLES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

/// Units of the SVG in one pixel of the intended size: plotters rounds to whole units, and curves must stay smooth.
const UNIT: i32 = 4;
/// Width and height of a plot in pixels.
const SIZE: (i32, i32) = (640, 420);
const FONT: &str = "sans-serif";
/// In pixels; plotters writes the size of a font divided by 1.24 into the SVG.
const FONT_SIZE: i32 = 17;

type Drawn = Result<(), Box<dyn Error>>;

/// So many pixels in units of the SVG.
const fn px(pixels: i32) -> i32 {
    UNIT * pixels
}

/// A line in the colour of `role`, so many pixels wide.
fn line(role: Role, pixels: u32) -> ShapeStyle {
    colour(role).stroke_width(UNIT as u32 * pixels)
}

fn colour(role: Role) -> RGBColor {
    THEME.iter().find(|(r, ..)| *r == role).map_or(BLACK, |&(_, _, light, _)| light)
}

/// The rules that go with the plots' classes: to stand in a `<style>` of the page or of the SVG itself.
pub fn css() -> String {
    let hex = |c: RGBColor| format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2);
    let variables = |dark: bool| {
        let one =
            |&(_, name, l, d): &(Role, &str, RGBColor, RGBColor)| format!("--{name}:{}", hex(if dark { d } else { l }));
        THEME.iter().map(one).collect::<Vec<_>>().join(";")
    };
    let rule = |(_, name, ..): &(Role, &str, RGBColor, RGBColor)| {
        format!(".f-{name}{{fill:var(--{name})}}.s-{name}{{stroke:var(--{name})}}")
    };
    let rules: Vec<String> = THEME.iter().map(rule).collect();
    let (light, dark) = (variables(false), variables(true));
    [
        &format!(":root{{{light}}}@media(prefers-color-scheme:dark){{:root{{{dark}}}}}"),
        rules.concat().as_str(),
        // Without anti-aliasing, no seams show between the cells of a map.
        "[class^=f-heat]{shape-rendering:crispEdges}",
        "svg text{font-family:system-ui,sans-serif}",
    ]
    .join("\n")
}

/// A themed plot as a file of its own: with its rules and its paper.
pub fn standalone(svg: &str) -> String {
    let head_end = svg.find('>').map_or(0, |at| at + 1);
    let (head, body) = svg.split_at(head_end);
    format!(
        "{head}\n<style>{}</style>\n<rect width=\"100%\" height=\"100%\" class=\"f-paper\" fill=\"#ffffff\"/>{body}",
        css()
    )
}

/// Adds a class to everything that has the colour of a role, and a name for those who hear the page.
fn themed(svg: &str, name: &str) -> String {
    let mut text = svg.to_string();
    for (_, class, c, _) in THEME {
        let hex = format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2);
        text = text.replace(&format!("fill=\"{hex}\""), &format!("class=\"f-{class}\" fill=\"{hex}\""));
        text = text.replace(&format!("stroke=\"{hex}\""), &format!("class=\"s-{class}\" stroke=\"{hex}\""));
    }
    let (width, height) = SIZE;
    let drawn = format!("width=\"{}\" height=\"{}\" viewBox", px(width), px(height));
    text = text.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\" viewBox"), 1);
    text.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{name}\" "), 1)
}

/// Draws and returns the themed SVG; a plot that cannot be drawn says why.
fn drawn(name: &str, draw: impl Fn(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawn) -> String {
    let mut svg = String::new();
    let result = {
        let area = SVGBackend::with_string(&mut svg, (px(SIZE.0) as u32, px(SIZE.1) as u32)).into_drawing_area();
        draw(&area).and_then(|()| area.present().map_err(Into::into))
    };
    match result {
        Ok(()) => themed(&svg, name),
        Err(_) => format!("<p>{name} could not be drawn.</p>"),
    }
}

fn label(role: Role) -> TextStyle<'static> {
    (FONT, px(FONT_SIZE)).into_font().color(&colour(role))
}

/// A chart with room for the labels of its axes: so many pixels for those of y.
fn framed<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, Shift>,
    y_labels: i32,
) -> ChartBuilder<'a, 'static, SVGBackend<'b>> {
    let mut chart = ChartBuilder::on(area);
    chart.margin(px(12)).margin_right(px(24)).x_label_area_size(px(44)).y_label_area_size(px(y_labels));
    chart
}

/// Axes in ink with their ticks and labels, and a line of the grid at each label.
fn ruled<X: Ranged, Y: Ranged>(mesh: &mut MeshStyle<'_, '_, X, Y, SVGBackend<'_>>) {
    mesh.axis_style(line(Role::Ink, 1))
        .set_all_tick_mark_size(px(4))
        .bold_line_style(line(Role::Grid, 1))
        .light_line_style(TRANSPARENT)
        .label_style(label(Role::Ink));
}

/// The albedo against the angle of the fixed direction, from both sides.
pub fn albedo(eye: &[AlbedoPoint], light: &[AlbedoPoint]) -> String {
    let finite = |points: &[AlbedoPoint]| -> Vec<(f64, f64)> {
        let shown = points.iter().filter(|p| p.albedo.is_finite());
        shown.map(|p| (p.theta_deg, p.albedo.clamp(0.0, ALBEDO_CUT))).collect()
    };
    let curves = [("eye fixed", Role::First, finite(eye)), ("light fixed", Role::Second, finite(light))];
    let top = curves.iter().flat_map(|(_, _, curve)| curve).map(|p| p.1).fold(1.0, f64::max) * 1.08;
    drawn("Albedo against angle", |area| {
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
        for ((name, role, curve), width) in curves.iter().zip([7, 2]) {
            let style = line(*role, width);
            chart
                .draw_series(LineSeries::new(curve.iter().copied(), style))?
                .label(*name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + px(22), y)], style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .margin(px(14))
            .legend_area_size(px(30))
            .background_style(colour(Role::Paper))
            .border_style(line(Role::Grid, 1))
            .label_font(label(Role::Ink))
            .draw()?;
        Ok(())
    })
}

/// Lobes in the plane of incidence, one for each of [`LOBE_ANGLES`], each scaled to its own largest value.
pub fn lobes(lobes: &[Vec<(f64, f64)>]) -> String {
    let roles = [Role::First, Role::Second, Role::Third, Role::Fourth];
    drawn("Lobes in the plane of incidence", |area| {
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
            let text = format!("eye at {theta_deg}°, maximum {}", short(peak));
            area.draw(&Text::new(text, (x + px(30), y - px(7)), label(Role::Ink)))?;
        }
        Ok(())
    })
}

/// A tick's number.
fn three_digits(x: f64) -> String {
    if x == 0.0 || x >= 0.1 { format!("{x:.1}").trim_end_matches(".0").into() } else { format!("{x:.2e}") }
}

fn class_of(residual: f64) -> usize {
    // NaN is below no end, and so falls into the last class.
    ASYMMETRY_CLASSES.iter().position(|&(_, end, _)| residual <= end).unwrap_or(ASYMMETRY_CLASSES.len() - 1)
}

/// The map of relative asymmetry over both polar angles.
pub fn asymmetry(map: &AsymmetryMap) -> String {
    drawn("Map of the reciprocity residual", |area| {
        let (plot, legend) = area.split_horizontally(px(430));
        let mut chart = framed(&plot, 56).build_cartesian_2d(0.0..90.0, 0.0..90.0)?;
        let step = 90.0 / map.size as f64;
        for (i, row) in map.cells.chunks(map.size).enumerate() {
            let mut from = 0;
            // Neighbours of one class are one rectangle: a reciprocal model makes a small file.
            for run in row.chunk_by(|a, b| class_of(*a) == class_of(*b)) {
                let to = from + run.len();
                let corners = [(from as f64 * step, i as f64 * step), (to as f64 * step, (i + 1) as f64 * step)];
                let fill = colour(ASYMMETRY_CLASSES[class_of(run[0])].0).filled();
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
        for (row, (role, _, text)) in (0_i32..).zip(ASYMMETRY_CLASSES) {
            let corners = [(px(8), px(40 + 30 * row)), (px(28), px(58 + 30 * row))];
            legend.draw(&Rectangle::new(corners, colour(role).filled()))?;
            legend.draw(&Rectangle::new(corners, line(Role::Grid, 1)))?;
            legend.draw(&Text::new(text, (px(36), px(42 + 30 * row)), label(Role::Ink)))?;
        }
        Ok(())
    })
}

/// Shares of the draws in rings about the mirror direction: bars for the sampler, a line for the pdf.
pub fn histogram(histogram: &Histogram) -> String {
    let n = histogram.edges.len().saturating_sub(1);
    let reach = histogram.edges.last().copied().unwrap_or(FRAC_PI_2);
    // The two shares that belong to no ring stand apart on the right.
    let place = |bar: usize| bar as f64 + if bar >= n { 1.5 * (bar - n + 1) as f64 } else { 0.0 };
    let right = place(n + 1) + 2.0;
    let top = histogram.sampled.iter().chain(&histogram.claimed).copied().filter(|x| x.is_finite());
    // The legend stands above the tallest bar.
    let top = top.fold(1e-6, f64::max) * 1.3;
    drawn("Sampled against claimed histogram", |area| {
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
        chart
            .draw_series(bars)?
            .label("sampled")
            .legend(move |(x, y)| Rectangle::new([(x, y - px(6)), (x + px(22), y + px(6))], style));
        let step = line(Role::Second, 2);
        let level = |bar: usize| histogram.claimed.get(bar).copied().unwrap_or(0.0).clamp(0.0, top);
        let steps = (0..n).flat_map(|bar| [(place(bar), level(bar)), (place(bar) + 1.0, level(bar))]);
        chart
            .draw_series(LineSeries::new(steps, step))?
            .label("claimed by the pdf")
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + px(22), y)], step));
        for (bar, name) in [(n, "rest"), (n + 1, "lost")] {
            chart
                .draw_series(LineSeries::new([(place(bar) - 0.2, level(bar)), (place(bar) + 1.2, level(bar))], step))?;
            let above = histogram.sampled.get(bar).copied().unwrap_or(0.0).max(level(bar)) + 0.05 * top;
            chart.draw_series([Text::new(name, (place(bar) - 0.5, above.min(top)), label(Role::Ink))])?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .margin(px(14))
            .legend_area_size(px(30))
            .background_style(colour(Role::Paper))
            .border_style(line(Role::Grid, 1))
            .label_font(label(Role::Ink))
            .draw()?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_are_themed_and_no_element_has_two_classes() {
        let point = |theta_deg, albedo| AlbedoPoint { theta_deg, albedo, resolved: true };
        let curve = [point(0.0, 0.5), point(80.0, 7.0), point(89.0, f64::NAN)];
        let map = AsymmetryMap { size: 2, cells: vec![0.0, 1e-7, 0.5, f64::NAN] };
        let h = Histogram {
            edges: vec![0.0, 0.5, 1.0],
            sampled: vec![0.5, 0.3, 0.1, 0.1],
            claimed: vec![0.4, 0.4, 0.1, 0.1],
            draws: 10,
            resolved: true,
        };
        let empty = Histogram { edges: vec![0.0], sampled: vec![], claimed: vec![], draws: 0, resolved: false };
        let black = vec![vec![(0.0, 0.0)]];
        for svg in [albedo(&curve, &[]), asymmetry(&map), histogram(&h), histogram(&empty), lobes(&black), lobes(&[])] {
            assert!(svg.starts_with("<svg role=\"img\""), "{}", &svg[..80.min(svg.len())]);
            assert!(svg.contains("width=\"640\" height=\"420\" viewBox=\"0 0 2560 1680\""));
            for element in svg.split('<') {
                assert!(element.matches("class=").count() <= 1, "{element}");
                for colour in ["fill=\"#", "stroke=\"#"] {
                    assert!(!element.contains(colour) || element.contains("class="), "no role: {element}");
                }
            }
        }
    }

    #[test]
    fn every_residual_has_a_class() {
        assert_eq!([0.0, 1e-10, 0.05, 2.0, f64::NAN].map(class_of), [0, 1, 4, 5, 5]);
    }
}
