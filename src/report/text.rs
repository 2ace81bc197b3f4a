//! Sheets for reading on a terminal: aligned columns, and colour where it is wanted.

use std::fmt::Write;

use glam::DVec3;

use super::Judged;
use super::table::{Align, Table, short};
use crate::math::sphere::angles;
use crate::validate::{Check, Outcome, Sheet};

/// Where sentences are wrapped, in columns.
const WIDTH: usize = 100;

/// Whether text may carry colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Characters only: for files and pipes.
    Plain,
    /// With ANSI colours.
    Colour,
}

impl Style {
    fn paint(self, code: &str, text: &str) -> String {
        match self {
            Self::Plain => text.into(),
            Self::Colour => format!("\x1b[{code}m{text}\x1b[0m"),
        }
    }

    fn faint(self, text: &str) -> String {
        self.paint("2", text)
    }

    pub(super) fn outcome(self, outcome: Outcome, text: &str) -> String {
        let code = match outcome {
            Outcome::Pass => "32",
            Outcome::Fail => "1;31",
            Outcome::Inconclusive => "33",
        };
        self.paint(code, text)
    }
}

/// The whole sheet: each check with its numbers, its sentence and its power.
pub fn sheet(judged: &Judged, style: Style) -> String {
    named_sheet(&judged.name, &judged.sheet, style)
}

/// The same of a sheet that is of no model.
pub fn named_sheet(name: &str, sheet: &Sheet, style: Style) -> String {
    let mut text = format!("{}\n\n", style.paint("1", name));
    text.push_str(&checks(sheet.checks.iter(), style, true));
    let outcome = sheet.outcome();
    let verdict = style.outcome(outcome, &outcome.to_string().to_uppercase());
    let (n, seed, level) = (sheet.checks.len(), sheet.seed, sheet.level);
    let _ = writeln!(text, "\n{verdict}  {name} ({n} checks, seed {seed}, level {level})");
    text
}

/// One line for the subject, and the details of the checks that did not pass.
pub fn brief(judged: &Judged, style: Style) -> String {
    let outcome = judged.sheet.outcome();
    let troubled: Vec<&Check> = judged.sheet.checks.iter().filter(|c| c.outcome != Outcome::Pass).collect();
    let names: Vec<&str> = troubled.iter().map(|c| c.name).collect();
    let verdict = style.outcome(outcome, &format!("{:<12}", outcome.to_string()));
    let mut text = format!("{verdict}  {}", judged.name);
    if !names.is_empty() {
        let _ = write!(text, "  {}", style.faint(&format!("[{}]", names.join(", "))));
    }
    text.push('\n');
    if outcome == Outcome::Fail {
        text.push_str(&checks(troubled.into_iter(), style, false));
    }
    text
}

/// How many subjects came out how.
pub fn summary(judged: &[Judged], style: Style) -> String {
    let count = |outcome| judged.iter().filter(|j| j.sheet.outcome() == outcome).count();
    let parts = [Outcome::Pass, Outcome::Fail, Outcome::Inconclusive].map(|outcome| {
        let (n, text) = (count(outcome), format!("{} {outcome}", count(outcome)));
        if n > 0 { style.outcome(outcome, &text) } else { text }
    });
    let settings = judged.first().map(|j| format!(" (seed {}, level {})", j.sheet.seed, j.sheet.level));
    format!("{} subjects: {}{}\n", judged.len(), parts.join(", "), settings.unwrap_or_default())
}

fn checks<'a>(checks: impl Iterator<Item = &'a Check> + Clone, style: Style, power: bool) -> String {
    let mut table = Table::new(&[
        ("verdict", Align::Left),
        ("check", Align::Left),
        ("statistic", Align::Right),
        ("bound", Align::Right),
        ("p-value", Align::Right),
    ]);
    for check in checks.clone() {
        let p = check.p_value.map_or_else(|| "-".into(), short);
        table.row([check.outcome.to_string(), check.name.into(), short(check.statistic), short(check.bound), p]);
    }
    let rows = table.text("  ");
    let mut lines = rows.lines();
    let mut text = format!("{}\n", style.faint(lines.next().unwrap_or_default()));
    for (check, line) in checks.zip(lines) {
        let word = check.outcome.to_string();
        let _ = writeln!(text, "{}", line.replacen(&word, &style.outcome(check.outcome, &word), 1));
        let mut note = |sentence: &str| {
            for line in wrapped(sentence, WIDTH - 16) {
                let _ = writeln!(text, "                {}", style.faint(&line));
            }
        };
        note(&check.detail);
        if let Some(worst) = check.worst.filter(|_| check.outcome != Outcome::Pass) {
            note(&worst_pair(worst));
        }
        if power && !check.detects.is_empty() {
            note(&caught(check));
        }
    }
    text
}

/// The worst pair of directions, as angles.
pub fn worst_pair((wo, wi): (DVec3, DVec3)) -> String {
    format!("worst at wo {}, wi {}", degrees(wo), degrees(wi))
}

fn degrees(w: DVec3) -> String {
    let (theta, phi) = angles(w);
    // Enough digits to tell 89.9999° from 90°: near the horizon they decide.
    let text = |x: f64| format!("{:.6}", x.to_degrees());
    let trimmed = |t: String| t.trim_end_matches('0').trim_end_matches('.').to_string();
    format!("(θ {}°, φ {}°)", trimmed(text(theta)), trimmed(text(phi)))
}

/// The errors that a check would have caught, in words.
pub fn caught(check: &Check) -> String {
    let sizes: Vec<String> =
        check.detects.iter().map(|(kind, &size)| format!("{} {}", kind.replace('_', " "), short(size))).collect();
    format!("would catch at 99 %: {}", sizes.join(", "))
}

/// The words of `text` on lines of at most `width` characters, where the words allow.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lambert;

    fn judged(outcome: Outcome) -> Judged {
        let check = Check {
            name: "energy_eye",
            outcome,
            statistic: 1.25,
            p_value: None,
            bound: 1.0,
            worst: Some((DVec3::Z, DVec3::X)),
            detail: "a sentence ".repeat(20),
            detects: [("energy_gain", 1e-4)].into(),
        };
        let sheet = Sheet { subject: String::new(), checks: vec![check], seed: 5, level: 0.01 };
        Judged { name: "mine".into(), bsdf: Box::new(Lambert::new(0.5).unwrap()), sheet }
    }

    #[test]
    fn plain_text_has_no_escapes_and_short_lines() {
        let text = sheet(&judged(Outcome::Fail), Style::Plain);
        assert!(!text.contains('\x1b'));
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!(text.contains("worst at wo (θ 0°, φ 0°), wi (θ 90°, φ 0°)"), "{text}");
        assert!(text.contains("would catch at 99 %: energy gain 1e-4"), "{text}");
        assert!(text.contains("FAIL  mine (1 checks, seed 5, level 0.01)"), "{text}");
        assert!(sheet(&judged(Outcome::Fail), Style::Colour).contains("\x1b[1;31mfail"));
    }

    #[test]
    fn a_brief_says_more_only_of_what_fails() {
        assert_eq!(brief(&judged(Outcome::Pass), Style::Plain), "pass          mine\n");
        let inconclusive = brief(&judged(Outcome::Inconclusive), Style::Plain);
        assert_eq!(inconclusive, "inconclusive  mine  [energy_eye]\n");
        assert!(brief(&judged(Outcome::Fail), Style::Plain).lines().count() > 2);
        let all = [judged(Outcome::Pass), judged(Outcome::Fail), judged(Outcome::Fail)];
        let expected = "3 subjects: 1 pass, 2 fail, 0 inconclusive (seed 5, level 0.01)\n";
        assert_eq!(summary(&all, Style::Plain), expected);
    }
}
