//! A comparison for reading on a terminal.

use std::fmt::Write;

use super::noise::{BLOCK, ManyTests, NoiseTest};
use super::{Comparison, Side, Verdict};
use crate::report::table::{Align, Table, short};
use crate::report::text::Style;
use crate::validate::Outcome;

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// The whole comparison of `sides` (A and B as typed), the second of which is the reference unless `reference_first`.
pub fn comparison(result: &Comparison, sides: [&Side; 2], reference_first: bool, style: Style) -> String {
    let mut text = String::new();
    let letters = if reference_first { ["B", "A"] } else { ["A", "B"] };
    let mut files = Table::new(&[("", Align::Left), ("", Align::Left), ("", Align::Left)]);
    for (at, side) in sides.into_iter().enumerate() {
        let letter = ["A", "B"][at];
        let role = if letter == letters[1] { "the reference; " } else { "" };
        files.row([letter.into(), side.name.clone(), format!("{role}{}", side.noise_source)]);
    }
    text.push_str(&files.text(""));
    let _ = writeln!(text, "   {} x {} pixels{}\n", result.width, result.height, notes(sides));
    text.push_str(&means(result, letters));
    let _ = writeln!(text);
    text.push_str(&metrics(result));
    let _ = writeln!(text);
    match &result.noise {
        Some(test) => text.push_str(&tests(test, style)),
        None if result.identical => text.push_str("no variance in either file, and none is needed\n"),
        None => text.push_str(
            "no variance in either file, so no z: that needs planes Variance.R, .G and .B,\nor --variance-a FILE with \
             --spp-a N\n",
        ),
    }
    let _ = writeln!(text, "\n{}", verdict(result, style));
    text
}

/// What a reader must know of the files.
fn notes(sides: [&Side; 2]) -> String {
    let mut notes = String::new();
    for (letter, side) in ["A", "B"].into_iter().zip(sides) {
        if side.image.is_srgb_encoded() {
            let _ = write!(notes, "; {letter} is decoded from sRGB, and clamped by its file");
        }
        if let Some(count) = side.image.metadata().get("nonfinite").filter(|count| *count != "0") {
            let _ = write!(notes, "; {letter} left out {count} samples that were not finite");
        }
    }
    notes
}

fn means(result: &Comparison, [test, reference]: [&str; 2]) -> String {
    let mut table = Table::new(&[
        ("", Align::Left),
        (CHANNELS[0], Align::Right),
        (CHANNELS[1], Align::Right),
        (CHANNELS[2], Align::Right),
    ]);
    let digits = |v: f64| if v.abs() >= 1e-3 || v == 0.0 { format!("{v:.6}") } else { format!("{v:.5e}") };
    let mut row = |name: String, values: [String; 3]| {
        let [r, g, b] = values;
        table.row([name, r, g, b]);
    };
    row(format!("mean of {test}"), result.means[0].map(digits));
    row(format!("mean of {reference}"), result.means[1].map(digits));
    let percent =
        |difference: f64, of: f64| if of == 0.0 { "-".into() } else { format!("{:+.4} %", 100.0 * difference / of) };
    let [a, b] = result.means;
    row(format!("{test} less {reference}"), [0, 1, 2].map(|c| percent(a[c] - b[c], b[c])));
    if let Some(test) = &result.noise {
        let plain =
            |error: f64, of: f64| if of == 0.0 { "-".into() } else { format!("{:.4} %", 100.0 * error / of.abs()) };
        row("standard error".into(), test.image.map(|c| plain(c.std_err, c.reference)));
        row("z".into(), test.image.map(|c| format!("{:+.2}", c.z)));
    }
    table.text("")
}

fn metrics(result: &Comparison) -> String {
    let mut table = Table::new(&[("metric", Align::Left), ("value", Align::Right), ("", Align::Left)]);
    for metric in &result.metrics {
        table.row([metric.name.into(), short(metric.value), metric.formula.into()]);
    }
    let flip = result.flip.map_or_else(|| "-".into(), short);
    let ppd = short(result.settings.pixels_per_degree);
    table.row(["flip".into(), flip, format!("mean LDR-FLIP at {ppd} pixels a degree, colours clamped to [0, 1]")]);
    table.text("")
}

fn tests(test: &NoiseTest, style: Style) -> String {
    let mut table = Table::new(&[
        ("noise", Align::Left),
        ("verdict", Align::Left),
        ("worst |z|", Align::Right),
        ("bound", Align::Right),
        ("", Align::Left),
    ]);
    let word = |holds: bool| if holds { Outcome::Pass } else { Outcome::Fail };
    let place = |tests: &ManyTests| format!("({}, {}) {}", tests.worst.x, tests.worst.y, CHANNELS[tests.worst.channel]);
    let pixels = &test.pixels;
    let failing = format!(
        "{} of {} beyond ({}), {} allowed; worst at {}",
        pixels.failing,
        pixels.tested,
        percent(pixels.failing as f64 / pixels.tested as f64),
        pixels.allowed,
        place(pixels)
    );
    let blocks = &test.blocks;
    let block_text = format!(
        "{} of {} beyond, {BLOCK} x {BLOCK} pixels each; worst at {}",
        blocks.failing,
        blocks.tested,
        place(blocks)
    );
    let worst = test.image.iter().fold(0.0, |most: f64, channel| most.max(channel.z.abs()));
    let relative = |c: &super::noise::ChannelTest| test.image_bound * c.std_err / c.reference.abs();
    let sees = test.image.iter().map(relative).filter(|share| share.is_finite()).fold(0.0, f64::max);
    let image_text = format!("a bias above {} of the mean would show", percent(sees));
    let rows = [
        ("pixels", pixels.holds(), pixels.worst.z.abs(), pixels.bound, failing),
        ("blocks", blocks.holds(), blocks.worst.z.abs(), blocks.bound, block_text),
        ("image", test.image_holds(), worst, test.image_bound, image_text),
    ];
    for (name, holds, worst, bound, words) in &rows {
        table.row([(*name).into(), word(*holds).to_string(), short(*worst), short(*bound), words.clone()]);
    }
    let shown = table.text("");
    let mut text = String::new();
    for (at, line) in shown.lines().enumerate() {
        let painted = match at.checked_sub(1).map(|row| word(rows[row].1)) {
            Some(outcome) => line.replacen(&outcome.to_string(), &style.outcome(outcome, &outcome.to_string()), 1),
            None => line.into(),
        };
        let _ = writeln!(text, "{painted}");
    }
    let expected = test
        .expected_z2
        .map_or_else(|| "no number expected: too few samples".into(), |z2| format!("{} expected", short(z2)));
    let _ = writeln!(text, "mean z {} (0 expected), mean z² {} ({expected})", short(test.mean_z), short(test.mean_z2));
    if test.untested > 0 {
        let _ =
            writeln!(text, "{} pixels have no z: their variance is not known, or they are not finite", test.untested);
    }
    text
}

fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

fn verdict(result: &Comparison, style: Style) -> String {
    let verdict = result.verdict();
    let word = verdict.to_string().to_uppercase();
    let level = result.settings.level;
    let (outcome, why) = match verdict {
        Verdict::Equal if result.identical => (Outcome::Pass, "every sample is the same".into()),
        Verdict::Equal => (Outcome::Pass, format!("within noise at level {level}")),
        Verdict::Differ if result.nonfinite != [0, 0] => {
            let [a, b] = result.nonfinite;
            (Outcome::Fail, format!("{a} and {b} pixels are not finite (test, reference)"))
        }
        Verdict::Differ => (Outcome::Fail, format!("beyond noise at level {level}")),
        Verdict::Undecided => (Outcome::Inconclusive, "the noise is not known".into()),
    };
    format!("{}  {why}", style.outcome(outcome, &word))
}
