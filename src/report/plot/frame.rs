//! A chart's axes, linear or logarithmic, with their ticks.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::style::{Area, Drawn, Role, SIZE, anchored, label, label_width, line, px};

/// The numbers along one side of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) from: f64,
    pub(super) to: f64,
    /// Equal factors have equal lengths; both ends are above 0.
    pub(super) log: bool,
}

/// A mark of an axis, with a number where it is one of the main ones.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) at: f64,
    pub(super) number: Option<String>,
}

/// Numbers that a log axis spells out; others are powers of ten.
const PLAIN: std::ops::RangeInclusive<i32> = -3..=3;

/// Decades that a log axis numbers at most: every one, every second, …
const MOST_DECADES: i32 = 9;

impl Axis {
    pub(super) fn linear(from: f64, to: f64) -> Self {
        Self { from, to, log: false }
    }

    pub(super) fn log(from: f64, to: f64) -> Self {
        Self { from, to, log: true }
    }

    /// 0 at `from`, 1 at `to`.
    pub(super) fn share(&self, x: f64) -> f64 {
        if self.log {
            (x / self.from).ln() / (self.to / self.from).ln()
        } else {
            (x - self.from) / (self.to - self.from)
        }
    }

    pub(super) fn ticks(&self) -> Vec<Tick> {
        if self.log { self.log_ticks() } else { self.linear_ticks() }
    }

    fn log_ticks(&self) -> Vec<Tick> {
        let inside = |x: f64| x >= self.from * (1.0 - 1e-9) && x <= self.to * (1.0 + 1e-9);
        let decades = self.from.log10().floor() as i32..=self.to.log10().floor() as i32;
        let whole: i32 = decades.clone().map(|k| i32::from(inside(10_f64.powi(k)))).sum();
        // Few decades show their 2 and 5, too.
        let numbered: &[i32] = if whole <= 2 { &[1, 2, 5] } else { &[1] };
        let every = 1 + (whole - 1).max(0) / MOST_DECADES;
        let mut ticks = Vec::new();
        for decade in decades {
            for digit in 1..10 {
                let at = f64::from(digit) * 10_f64.powi(decade);
                if inside(at) {
                    let main = numbered.contains(&digit) && decade % every == 0;
                    let number = main.then(|| number(digit, decade, numbered.len() > 1));
                    ticks.push(Tick { at, number });
                }
            }
        }
        ticks
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        // Steps of 1, 2 or 5 times a power of ten, some seven of them.
        let raw = (self.to - self.from) / 7.0;
        let power = 10_f64.powf(raw.log10().floor());
        let step = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= raw * 0.999).unwrap_or(10.0);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let numbers = (self.from / step - 1e-9).ceil() as i64..=(self.to / step + 1e-9).floor() as i64;
        let tick = |i: i64| Tick { at: i as f64 * step, number: Some(format!("{:.decimals$}", i as f64 * step)) };
        numbers.map(tick).collect()
    }
}

/// `digit` · 10^`decade`.
fn number(digit: i32, decade: i32, plain: bool) -> String {
    if plain && PLAIN.contains(&decade) {
        let decimals = (-decade).max(0) as usize;
        return format!("{:.decimals$}", f64::from(digit) * 10_f64.powi(decade));
    }
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    let power = match decade {
        0 => return digit.to_string(),
        1 if digit == 1 => "10".into(),
        k => format!("10{}", k.to_string().chars().map(raised).collect::<String>()),
    };
    if digit == 1 { power } else { format!("{digit}·{power}") }
}

/// The rectangle in which a chart's lines are, in units of the drawing, and what its sides mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
}

impl Frame {
    /// With room for the numbers and names of its axes, and `right` pixels to the right.
    pub(super) fn new(x: Axis, y: Axis, right: i32) -> Self {
        let numbers = y.ticks().into_iter().filter_map(|tick| tick.number);
        let widest = numbers.map(|number| label_width(&number)).max().unwrap_or(0);
        Self {
            x,
            y,
            left: px(12 + 18 + 8 + 8) + widest,
            right: px(SIZE.0 - right),
            top: px(14),
            bottom: px(SIZE.1 - 54),
        }
    }

    /// Where a point lies; one outside lies on the rim.
    pub(super) fn at(&self, x: f64, y: f64) -> (i32, i32) {
        let place =
            |share: f64, from: i32, to: i32| from + (share.clamp(0.0, 1.0) * f64::from(to - from)).round() as i32;
        (place(self.x.share(x), self.left, self.right), place(self.y.share(y), self.bottom, self.top))
    }

    /// A line through points, cut off at the rim.
    pub(super) fn path(&self, points: impl IntoIterator<Item = (f64, f64)>) -> Vec<(i32, i32)> {
        points.into_iter().map(|(x, y)| self.at(x, y)).collect()
    }

    /// Grid, axes, ticks, numbers, names.
    pub(super) fn draw(&self, area: &Area<'_>, x_name: &str, y_name: &str) -> Drawn {
        let (grid, ink) = (line(Role::Grid, 1), line(Role::Ink, 1));
        let segment = |a: (i32, i32), b: (i32, i32), style: ShapeStyle| area.draw(&PathElement::new(vec![a, b], style));
        let (xs, ys) = (self.x.ticks(), self.y.ticks());
        for tick in xs.iter().filter(|tick| tick.number.is_some()) {
            let x = self.at(tick.at, self.y.from).0;
            segment((x, self.top), (x, self.bottom), grid)?;
        }
        for tick in ys.iter().filter(|tick| tick.number.is_some()) {
            let y = self.at(self.x.from, tick.at).1;
            segment((self.left, y), (self.right, y), grid)?;
        }
        segment((self.left, self.top), (self.left, self.bottom), ink)?;
        segment((self.left, self.bottom), (self.right, self.bottom), ink)?;
        for tick in &xs {
            let x = self.at(tick.at, self.y.from).0;
            segment((x, self.bottom), (x, self.bottom + px(if tick.number.is_some() { 5 } else { 3 })), ink)?;
            if let Some(number) = &tick.number {
                let style = anchored(Role::Ink, HPos::Center, VPos::Top);
                area.draw(&Text::new(number.clone(), (x, self.bottom + px(9)), style))?;
            }
        }
        for tick in &ys {
            let y = self.at(self.x.from, tick.at).1;
            segment((self.left - px(if tick.number.is_some() { 5 } else { 3 }), y), (self.left, y), ink)?;
            if let Some(number) = &tick.number {
                let style = anchored(Role::Ink, HPos::Right, VPos::Center);
                area.draw(&Text::new(number.clone(), (self.left - px(9), y), style))?;
            }
        }
        let below = (i32::midpoint(self.left, self.right), px(SIZE.1 - 12 - 7));
        area.draw(&Text::new(x_name.to_string(), below, anchored(Role::Ink, HPos::Center, VPos::Center)))?;
        let beside = (px(12 + 7), i32::midpoint(self.top, self.bottom));
        let upwards = label(Role::Ink).transform(FontTransform::Rotate270).pos(Pos::new(HPos::Center, VPos::Center));
        area.draw(&Text::new(y_name.to_string(), beside, upwards))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(axis: Axis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|tick| tick.number).collect()
    }

    #[test]
    fn many_decades_are_powers_and_few_are_plain() {
        assert_eq!(numbers(Axis::log(1e-2, 1e2)), ["10⁻²", "10⁻¹", "1", "10", "10²"]);
        assert_eq!(numbers(Axis::log(0.03, 0.6)), ["0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(numbers(Axis::log(1.5e-7, 1.2e-6)), ["2·10⁻⁷", "5·10⁻⁷", "10⁻⁶"]);
        assert_eq!(Axis::log(1.0, 100.0).ticks().len(), 19, "with the small ticks");
        let long = numbers(Axis::log(1e-30, 1.0));
        assert!((8..=12).contains(&long.len()), "{long:?}");
    }

    #[test]
    fn linear_axes_have_round_steps() {
        assert_eq!(numbers(Axis::linear(0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(numbers(Axis::linear(0.74, 1.0)).len(), 6);
        assert_eq!(numbers(Axis::linear(0.0, 90.0)), ["0", "20", "40", "60", "80"]);
    }

    #[test]
    fn points_lie_where_the_axes_say() {
        let frame = Frame::new(Axis::log(1.0, 100.0), Axis::linear(0.0, 2.0), 20);
        assert_eq!(frame.at(1.0, 0.0), (frame.left, frame.bottom));
        assert_eq!(frame.at(100.0, 2.0), (frame.right, frame.top));
        let (x, y) = frame.at(10.0, 1.0);
        assert!(
            (x - i32::midpoint(frame.left, frame.right)).abs() <= 1
                && (y - i32::midpoint(frame.top, frame.bottom)).abs() <= 1
        );
        assert_eq!(frame.at(1e9, -1.0), (frame.right, frame.bottom), "on the rim");
    }
}
