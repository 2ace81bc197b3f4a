//! The house style: colours with their roles, sizes, and the frame of a chart.

use std::error::Error;

use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::canvas::{Canvas, width_of};
use super::font::FAMILY;

/// What a colour stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Paper,
    Ink,
    Grid,
    First,
    Second,
    Third,
    Fourth,
    Fifth,
    Sixth,
    Seventh,
    Eighth,
    Heat0,
    Heat1,
    Heat2,
    Heat3,
    Heat4,
    Heat5,
}

/// Each role with its class and its colour in light and in dark. The series differ in lightness, too: for the
/// colour-blind, and on paper without colour.
const THEME: [(Role, &str, RGBColor, RGBColor); 17] = [
    (Role::Paper, "paper", RGBColor(0xff, 0xff, 0xff), RGBColor(0x15, 0x18, 0x1c)),
    (Role::Ink, "ink", RGBColor(0x1b, 0x1f, 0x24), RGBColor(0xe6, 0xe9, 0xed)),
    (Role::Grid, "grid", RGBColor(0xd9, 0xde, 0xe4), RGBColor(0x35, 0x3b, 0x43)),
    (Role::First, "first", RGBColor(0x0f, 0x56, 0x9c), RGBColor(0x6c, 0xb2, 0xf0)),
    (Role::Second, "second", RGBColor(0xd4, 0x56, 0x0b), RGBColor(0xf5, 0x8a, 0x45)),
    (Role::Third, "third", RGBColor(0x2a, 0xa1, 0x8a), RGBColor(0x5f, 0xd9, 0xb9)),
    (Role::Fourth, "fourth", RGBColor(0x73, 0x3a, 0x98), RGBColor(0xb8, 0x86, 0xdc)),
    (Role::Fifth, "fifth", RGBColor(0xdc, 0x9f, 0x00), RGBColor(0xf2, 0xcf, 0x5b)),
    (Role::Sixth, "sixth", RGBColor(0x4a, 0x9f, 0xd8), RGBColor(0x3d, 0x8f, 0xc9)),
    (Role::Seventh, "seventh", RGBColor(0x6b, 0x2c, 0x0f), RGBColor(0xb8, 0x74, 0x50)),
    (Role::Eighth, "eighth", RGBColor(0xd1, 0x62, 0x9e), RGBColor(0xf0, 0xa3, 0xcb)),
    (Role::Heat0, "heat0", RGBColor(0xea, 0xf2, 0xfa), RGBColor(0x1e, 0x28, 0x33)),
    (Role::Heat1, "heat1", RGBColor(0xbd, 0xd7, 0xee), RGBColor(0x24, 0x44, 0x63)),
    (Role::Heat2, "heat2", RGBColor(0x7f, 0xb4, 0xdf), RGBColor(0x2f, 0x6b, 0x9e)),
    (Role::Heat3, "heat3", RGBColor(0xf6, 0xc2, 0x8b), RGBColor(0xa8, 0x6a, 0x2c)),
    (Role::Heat4, "heat4", RGBColor(0xe5, 0x7f, 0x3c), RGBColor(0xe0, 0x86, 0x3f)),
    (Role::Heat5, "heat5", RGBColor(0xa8, 0x1e, 0x1e), RGBColor(0xff, 0x6b, 0x5e)),
];

/// The roles of the lines of a chart, in the order in which they are used.
pub(super) const SERIES: [Role; 8] =
    [Role::First, Role::Second, Role::Third, Role::Fourth, Role::Fifth, Role::Sixth, Role::Seventh, Role::Eighth];

/// Units of the drawing in one pixel of the intended size: plotters rounds to whole units, and curves must stay smooth.
const UNIT: i32 = 4;
/// Error bars reach to 1.96 standard errors: 95 %.
pub(super) const BARS: f64 = 1.96;
/// Width and height of a plot in pixels.
pub(super) const SIZE: (i32, i32) = (640, 420);
/// In pixels, as plotters means it: 1.24 ems.
const FONT_SIZE: i32 = 17;

pub(super) type Area<'a> = DrawingArea<Canvas<'a>, Shift>;
pub(super) type Drawn = Result<(), Box<dyn Error>>;

/// So many pixels in units of the drawing.
pub(super) const fn px(pixels: i32) -> i32 {
    UNIT * pixels
}

/// A line in the colour of `role`, so many pixels wide.
pub(super) fn line(role: Role, pixels: u32) -> ShapeStyle {
    colour(role).stroke_width(UNIT as u32 * pixels)
}

pub(super) fn colour(role: Role) -> RGBColor {
    THEME.iter().find(|(r, ..)| *r == role).map_or(BLACK, |&(_, _, light, _)| light)
}

pub(super) fn label(role: Role) -> TextStyle<'static> {
    (FAMILY, px(FONT_SIZE)).into_font().color(&colour(role))
}

/// A label whose anchor is not its upper left corner.
pub(super) fn anchored(role: Role, h: HPos, v: VPos) -> TextStyle<'static> {
    label(role).pos(Pos::new(h, v))
}

/// Width of a label in units of the drawing.
pub(super) fn label_width(text: &str) -> i32 {
    width_of(text, f64::from(px(FONT_SIZE))).ceil() as i32
}

/// A chart with room for the labels of its axes: so many pixels for those of y.
pub(super) fn framed<'a, 'b>(area: &'a Area<'b>, y_labels: i32) -> ChartBuilder<'a, 'static, Canvas<'b>> {
    let mut chart = ChartBuilder::on(area);
    chart.margin(px(12)).margin_right(px(24)).x_label_area_size(px(44)).y_label_area_size(px(y_labels));
    chart
}

/// Axes in ink with their ticks and labels, and a line of the grid at each label.
pub(super) fn ruled<X: Ranged, Y: Ranged>(mesh: &mut MeshStyle<'_, '_, X, Y, Canvas<'_>>) {
    mesh.axis_style(line(Role::Ink, 1))
        .set_all_tick_mark_size(px(4))
        .bold_line_style(line(Role::Grid, 1))
        .light_line_style(TRANSPARENT)
        .label_style(label(Role::Ink));
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

/// Adds a class to everything that has the colour of a role, and a name for those who hear the page.
pub(super) fn themed(svg: &str, name: &str) -> String {
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
