//! Marks that tell lines apart without colour, legends, and names at the ends of lines.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::style::{Area, Drawn, Role, SERIES, anchored, colour, label_width, line, px};

/// The colour of the line number `series`.
pub(super) fn role(series: usize) -> Role {
    SERIES[series % SERIES.len()]
}

/// The shape of the marks of the line number `series`: one of eight, shifted against the eight colours after each round.
fn shape(series: usize) -> usize {
    (series + series / SERIES.len()) % 8
}

/// The mark of the line number `series`.
pub(super) fn mark(area: &Area<'_>, series: usize, (x, y): (i32, i32)) -> Drawn {
    let (role, r) = (role(series), px(4));
    let fill = colour(role).filled();
    let polygon =
        |corners: &[(i32, i32)]| Polygon::new(corners.iter().map(|c| (x + c.0, y + c.1)).collect::<Vec<_>>(), fill);
    let stroke =
        |a: (i32, i32), b: (i32, i32)| PathElement::new(vec![(x + a.0, y + a.1), (x + b.0, y + b.1)], line(role, 2));
    match shape(series) {
        0 => area.draw(&Circle::new((x, y), r, fill))?,
        1 => area.draw(&polygon(&[(-r - 2, r), (r + 2, r), (0, -r - 5)]))?,
        2 => area.draw(&polygon(&[(-r + 1, -r + 1), (r - 1, -r + 1), (r - 1, r - 1), (-r + 1, r - 1)]))?,
        3 => {
            area.draw(&stroke((-r, -r), (r, r)))?;
            area.draw(&stroke((-r, r), (r, -r)))?;
        }
        4 => hollow(area, role, (x, y))?,
        5 => area.draw(&polygon(&[(0, -r - 6), (r + 6, 0), (0, r + 6), (-r - 6, 0)]))?,
        6 => area.draw(&polygon(&[(-r - 2, -r), (r + 2, -r), (0, r + 5)]))?,
        _ => {
            area.draw(&stroke((-r - 2, 0), (r + 2, 0)))?;
            area.draw(&stroke((0, -r - 2), (0, r + 2)))?;
        }
    }
    Ok(())
}

/// A ring.
pub(super) fn hollow(area: &Area<'_>, role: Role, at: (i32, i32)) -> Drawn {
    area.draw(&Circle::new(at, px(4), colour(role).filled()))?;
    area.draw(&Circle::new(at, px(2), colour(Role::Paper).filled()))?;
    Ok(())
}

/// The sign of an entry in a legend.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sign {
    Line(ShapeStyle),
    Box(ShapeStyle),
    Dashes(Role),
    /// A line with the marks of a series.
    Series(usize),
    /// The mark of a series with its bar.
    Mark(usize),
    /// A ring, without a bar.
    Hollow(Role),
    /// None.
    Space,
}

/// Width of a sign.
const SIGN: i32 = px(22);

/// Draws a sign whose left end is at `at`.
fn sign(area: &Area<'_>, sign: Sign, (x, y): (i32, i32)) -> Drawn {
    let across = |style| PathElement::new(vec![(x, y), (x + SIGN, y)], style);
    let bar = |role| PathElement::new(vec![(x + SIGN / 2, y - px(8)), (x + SIGN / 2, y + px(8))], line(role, 1));
    match sign {
        Sign::Line(style) => area.draw(&across(style))?,
        Sign::Box(style) => area.draw(&Rectangle::new([(x, y - px(6)), (x + SIGN, y + px(6))], style))?,
        Sign::Dashes(role) => dashes(area, (x, y), (x + SIGN, y), role)?,
        Sign::Series(series) => {
            area.draw(&across(line(role(series), 2)))?;
            mark(area, series, (x + SIGN / 2, y))?;
        }
        Sign::Mark(series) => {
            area.draw(&bar(role(series)))?;
            mark(area, series, (x + SIGN / 2, y))?;
        }
        Sign::Hollow(role) => hollow(area, role, (x + SIGN / 2, y))?,
        Sign::Space => {}
    }
    Ok(())
}

/// A dashed line, which stands for theory.
pub(super) fn dashes(area: &Area<'_>, from: (i32, i32), to: (i32, i32), role: Role) -> Drawn {
    let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
    let (length, period) = (dx.hypot(dy), f64::from(px(9)));
    let at = |t: f64| {
        let t = (t / length).min(1.0);
        (from.0 + (dx * t).round() as i32, from.1 + (dy * t).round() as i32)
    };
    for dash in 0..(length / period).ceil() as u32 {
        let start = f64::from(dash) * period;
        area.draw(&PathElement::new(vec![at(start), at(start + f64::from(px(5)))], line(role, 1)))?;
    }
    Ok(())
}

/// A column of signs with their names, whose upper corner is at `corner`: the left one, or with `leftwards` the right.
pub(super) fn legend(area: &Area<'_>, corner: (i32, i32), leftwards: bool, entries: &[(Sign, &str)]) -> Drawn {
    let width = SIGN + px(8 + 16) + entries.iter().map(|(_, name)| label_width(name)).max().unwrap_or(0);
    let (left, top) = (corner.0 - if leftwards { width } else { 0 }, corner.1);
    let height = px(12) + entries.iter().map(|_| px(20)).sum::<i32>();
    let frame = [(left, top), (left + width, top + height)];
    area.draw(&Rectangle::new(frame, colour(Role::Paper).filled()))?;
    area.draw(&Rectangle::new(frame, line(Role::Grid, 1)))?;
    for (row, (shown, name)) in (0_i32..).zip(entries) {
        let (x, y) = (left + px(8), top + px(16 + 20 * row));
        sign(area, *shown, (x, y))?;
        let style = anchored(Role::Ink, HPos::Left, VPos::Center);
        area.draw(&Text::new((*name).to_string(), (x + SIGN + px(8), y), style))?;
    }
    Ok(())
}

/// What stands at the end of a line: its sign and name, and below it those of what belongs to it.
#[derive(Clone, Debug)]
pub(super) struct EndLabel {
    /// Where the line ends.
    pub(super) end: (i32, i32),
    pub(super) role: Role,
    pub(super) rows: Vec<(Sign, String)>,
}

/// Height of a row, and of the gap between two labels.
const ROW: i32 = px(17);
const GAP: i32 = px(5);
/// From the right rim of the frame to the signs.
const LEADER: i32 = px(14);

impl EndLabel {
    fn height(&self) -> i32 {
        self.rows.iter().map(|_| ROW).sum::<i32>() + GAP
    }

    /// The width of a column of labels in pixels, with what leads to it and a margin.
    pub(super) fn column(labels: &[Self]) -> i32 {
        let rows = labels.iter().flat_map(|label| &label.rows);
        let widest = rows.map(|(_, text)| label_width(text)).max().unwrap_or(0);
        (LEADER + SIGN + px(6 + 10) + widest) / px(1) + 1
    }

    /// Draws them in a column right of `x`, the frame's rim, between two heights, each as near to the end of its line as can be.
    pub(super) fn draw(labels: &[Self], area: &Area<'_>, x: i32, (top, bottom): (i32, i32)) -> Drawn {
        // The first row belongs beside the line's end.
        let wanted: Vec<(i32, i32)> =
            labels.iter().map(|label| (label.end.1 - i32::midpoint(ROW, GAP), label.height())).collect();
        for (label, top) in labels.iter().zip(spread(&wanted, top, bottom)) {
            let first = top + i32::midpoint(ROW, GAP);
            let leader = vec![(x + px(2), label.end.1), (x + LEADER - px(3), first)];
            area.draw(&PathElement::new(leader, line(label.role, 1)))?;
            for (row, (shown, text)) in (0_i32..).zip(&label.rows) {
                let y = first + ROW * row;
                sign(area, *shown, (x + LEADER, y))?;
                let style = anchored(Role::Ink, HPos::Left, VPos::Center);
                area.draw(&Text::new(text.clone(), (x + LEADER + SIGN + px(6), y), style))?;
            }
        }
        Ok(())
    }
}

/// The upper ends of labels of these (wanted upper end, height): in their order, without overlap, between `top` and `bottom`
/// as far as they have room.
fn spread(labels: &[(i32, i32)], top: i32, bottom: i32) -> Vec<i32> {
    let mut order: Vec<usize> = (0..labels.len()).collect();
    order.sort_by_key(|&i| labels[i].0);
    let mut tops: Vec<i32> = labels.iter().map(|label| label.0).collect();
    let mut free = top;
    for &i in &order {
        tops[i] = tops[i].max(free);
        free = tops[i] + labels[i].1;
    }
    // Those pushed beyond the bottom come back up.
    let mut free = bottom;
    for &i in order.iter().rev() {
        tops[i] = tops[i].min(free - labels[i].1);
        free = tops[i];
    }
    tops
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_their_distance_and_their_order() {
        let wanted = [(50, 20), (10, 20), (12, 40), (99, 20), (98, 20)];
        let tops = spread(&wanted, 0, 130);
        let mut blocks: Vec<(i32, i32)> =
            tops.iter().zip(wanted).map(|(&top, (_, height))| (top, top + height)).collect();
        blocks.sort_unstable();
        assert!(blocks.windows(2).all(|pair| pair[1].0 >= pair[0].1), "{blocks:?}");
        assert!(tops[1] < tops[2] && tops[2] < tops[0] && tops[4] < tops[3], "{tops:?}");
        assert!(blocks[0].0 >= 0 && blocks[4].1 <= 130);
        assert_eq!(spread(&[(50, 20), (80, 60)], 0, 200), [50, 80], "where there is room, nothing moves");
    }

    #[test]
    fn no_two_of_sixteen_lines_look_alike() {
        let look = |series: usize| (role(series), shape(series));
        for a in 0..16 {
            assert!((0..a).all(|b| look(a) != look(b)), "{a}");
        }
    }
}
