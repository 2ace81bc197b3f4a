//! The HTML page of `validate`: one file that needs no other, in light and in dark, on any width of screen.

use std::fmt::Write;

use rayon::prelude::*;

use super::plot::{self, ALBEDO_CUT, LOBE_ANGLES};
use super::table::short;
use super::text::{caught, worst_pair};
use super::{Judged, probe};
use crate::integrate::Side;
use crate::validate::{Check, Outcome};

/// Most subjects whose plots are drawn: beyond that, a page is slow to make and to open.
const MOST_PLOTS: usize = 24;
/// Draws behind a histogram: its bars then stand within some hundredths of their height.
const DRAWS: u64 = 100_000;
/// Angle of the eye in the histogram, in degrees.
const HISTOGRAM_ANGLE: f64 = 60.0;

const PAGE_CSS: &str = "
:root{color-scheme:light dark;--pass:#1b7f4b;--fail:#b3261e;--inconclusive:#8a5a00;--soft:#5a636d;--card:#f6f8fa}
@media(prefers-color-scheme:dark){:root{--pass:#58c98b;--fail:#ff7b72;--inconclusive:#e3b341;--soft:#9aa4af;--card:#1d2126}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:84rem;padding:1.5rem clamp(.8rem,3vw,2.5rem);background:var(--paper);color:var(--ink);
font:16px/1.5 system-ui,sans-serif}
h1{font-size:1.6rem;margin:0 0 .3rem;overflow-wrap:anywhere}h2{font-size:1.25rem;margin:2.5rem 0 .6rem;overflow-wrap:anywhere}
code{font-family:ui-monospace,monospace;font-size:.95em;overflow-wrap:anywhere}
a{color:var(--first)}
p.soft,figcaption,td .soft{color:var(--soft)}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%}
th,td{text-align:left;vertical-align:top;padding:.4rem .7rem .4rem 0;border-bottom:1px solid var(--grid)}
th{font-weight:600;font-size:.9rem;white-space:nowrap}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
td.d{min-width:18rem}td.c{white-space:nowrap}
@media(max-width:44rem){.sheet tr:first-child{display:none}.sheet tr{display:block;padding:.5rem 0;
border-bottom:1px solid var(--grid)}.sheet td{display:inline-block;border:0;padding:0 .8rem 0 0}
.sheet td.n::before{content:attr(data-name) ' ';color:var(--soft)}.sheet td.d{display:block;min-width:0;padding-top:.2rem}}
td.d div{overflow-wrap:anywhere}
.v{font-weight:600;white-space:nowrap}
.v.pass{color:var(--pass)}.v.fail{color:var(--fail)}.v.inconclusive{color:var(--inconclusive)}
.v.pass::before{content:'✓ '}.v.fail::before{content:'✗ '}.v.inconclusive::before{content:'? '}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,30rem),1fr));gap:1rem;margin-top:1.2rem}
figure{margin:0;padding:.8rem;border:1px solid var(--grid);border-radius:.5rem;min-width:0}
figure h3{margin:0 0 .3rem;font-size:1rem}
figure svg{display:block;width:100%;height:auto}
figcaption{font-size:.875rem;margin-top:.3rem}
";

/// The page for all sheets of one run.
pub fn page(judged: &[Judged], seed: u64, level: f64) -> String {
    let few = judged.len() <= MOST_PLOTS;
    let wants_plots: Vec<bool> = {
        let mut left = MOST_PLOTS;
        let mut take = |j: &Judged| {
            let take = left > 0 && (few || j.sheet.outcome() == Outcome::Fail);
            left -= usize::from(take);
            take
        };
        judged.iter().map(&mut take).collect()
    };
    let sections: Vec<String> = judged
        .par_iter()
        .zip(wants_plots)
        .enumerate()
        .map(|(at, (j, plots))| section(at, j, &if plots { figures(j, seed) } else { String::new() }))
        .collect();
    let title = match judged {
        [one] => format!("Verdict sheet of {}", escaped(&one.name)),
        many => format!("Verdict sheets of {} BRDFs", many.len()),
    };
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>{title}</title>\n\
         <style>{}{PAGE_CSS}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"soft\">whitefurnace {}, seed {seed}, level {level} for each sheet</p>\n",
        plot::css(),
        env!("CARGO_PKG_VERSION"),
    );
    if judged.len() > 1 {
        page.push_str(&contents(judged));
    }
    if !few {
        let _ = writeln!(page, "<p class=\"soft\">Plots are drawn for the first {MOST_PLOTS} subjects that fail.</p>");
    }
    page.extend(sections);
    page.push_str("</body>\n</html>\n");
    page
}

fn contents(judged: &[Judged]) -> String {
    let mut text =
        String::from("<div class=\"scroll\"><table><tr><th>verdict</th><th>subject</th><th>not passed</th></tr>\n");
    for (at, j) in judged.iter().enumerate() {
        let troubled = j.sheet.checks.iter().filter(|c| c.outcome != Outcome::Pass).map(|c| c.name);
        let troubled: Vec<&str> = troubled.collect();
        let _ = writeln!(
            text,
            "<tr><td>{}</td><td><a href=\"#s{at}\"><code>{}</code></a></td><td>{}</td></tr>",
            verdict(j.sheet.outcome()),
            escaped(&j.name),
            escaped(&troubled.join(", "))
        );
    }
    text + "</table></div>\n"
}

fn section(at: usize, judged: &Judged, figures: &str) -> String {
    let rows: String = judged.sheet.checks.iter().map(row).collect();
    format!(
        "<section id=\"s{at}\">\n<h2><code>{}</code> {}</h2>\n<div class=\"scroll\"><table class=\"sheet\">\n\
         <tr><th>verdict</th><th>check</th><th class=\"n\">statistic</th><th class=\"n\">bound</th>\
         <th class=\"n\">p-value</th><th>what was found</th></tr>\n{rows}</table></div>\n{figures}</section>\n",
        escaped(&judged.name),
        verdict(judged.sheet.outcome()),
    )
}

fn row(check: &Check) -> String {
    let mut found = format!("<div>{}</div>", escaped(&check.detail));
    if let Some(worst) = check.worst.filter(|_| check.outcome != Outcome::Pass) {
        let _ = write!(found, "<div class=\"soft\">{}</div>", escaped(&worst_pair(worst)));
    }
    if !check.detects.is_empty() {
        let _ = write!(found, "<div class=\"soft\">{}</div>", escaped(&caught(check)));
    }
    format!(
        "<tr><td>{}</td><td class=\"c\"><code>{}</code></td>\
         <td class=\"n\" data-name=\"statistic\">{}</td><td class=\"n\" data-name=\"bound\">{}</td>\
         <td class=\"n\" data-name=\"p\">{}</td><td class=\"d\">{found}</td></tr>\n",
        verdict(check.outcome),
        escaped(check.name),
        short(check.statistic),
        short(check.bound),
        check.p_value.map_or_else(|| "–".into(), short),
    )
}

fn verdict(outcome: Outcome) -> String {
    format!("<span class=\"v {outcome}\">{outcome}</span>")
}

fn figures(judged: &Judged, seed: u64) -> String {
    let bsdf = &*judged.bsdf;
    let (eye, light) = (probe::albedo_curve(bsdf, Side::Eye), probe::albedo_curve(bsdf, Side::Light));
    let lobes = LOBE_ANGLES.map(|deg| probe::lobe(bsdf, deg.to_radians()));
    let histogram = probe::histogram(bsdf, HISTOGRAM_ANGLE.to_radians(), DRAWS, seed);

    let unresolved = eye.iter().chain(&light).filter(|p| !p.resolved).count();
    let cut = eye.iter().chain(&light).any(|p| p.albedo > ALBEDO_CUT);
    let mut about_albedo =
        "Above 1, energy is made out of nothing. Where the curves differ, f is not reciprocal.".to_string();
    if cut {
        let _ = write!(about_albedo, " Values above {ALBEDO_CUT} are drawn at {ALBEDO_CUT}.");
    }
    if unresolved > 0 {
        let _ = write!(about_albedo, " {unresolved} of the points are not resolved to 0.001.");
    }
    let mut about_histogram = format!(
        "{} draws with the eye at {HISTOGRAM_ANGLE}°. Right: draws farther out, and lost ones.",
        histogram.draws
    );
    if !histogram.resolved {
        about_histogram.push_str(" The pdf could not be integrated to the accuracy of this picture.");
    }
    let figure = |title: &str, svg: &str, caption: &str| {
        format!("<figure><h3>{title}</h3>{svg}<figcaption>{}</figcaption></figure>\n", escaped(caption))
    };
    [
        "<div class=\"plots\">\n",
        &figure("Albedo from both sides", &plot::albedo(&eye, &light).inline(), &about_albedo),
        &figure(
            "Lobes",
            &plot::lobes(&lobes).inline(),
            "f·cos in the plane of incidence, each lobe scaled to its own maximum (1/sr); the ticks on the left mark the eye.",
        ),
        &figure(
            "Reciprocity residual",
            &plot::asymmetry(&probe::asymmetry(bsdf)).inline(),
            "Relative gap between f(a, b) and f(b, a), the largest over azimuths.",
        ),
        &figure("Sampled and claimed", &plot::histogram(&histogram).inline(), &about_histogram),
        "</div>\n",
    ]
    .concat()
}

/// `text` for HTML: no character of it can end or start an element or an attribute.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            other => safe.push(other),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lambert;
    use crate::validate::Sheet;
    use glam::DVec3;

    fn judged(name: &str, outcome: Outcome) -> Judged {
        let check = Check {
            name: "energy_eye",
            outcome,
            statistic: f64::NAN,
            p_value: Some(0.5),
            bound: 1.0,
            worst: Some((DVec3::Z, DVec3::X)),
            detail: "<b> & \"x\"".into(),
            detects: [("energy_gain", 1e-4)].into(),
        };
        let sheet = Sheet { subject: String::new(), checks: vec![check], seed: 5, level: 0.01 };
        Judged { name: name.into(), bsdf: Box::new(Lambert::new(0.5).unwrap()), sheet }
    }

    #[test]
    fn no_text_becomes_markup_and_nothing_is_fetched() {
        let page = page(&[judged("<script>alert('1')</script>", Outcome::Fail)], 5, 0.01);
        assert!(!page.contains("<script") && page.contains("&lt;script&gt;"));
        assert!(page.contains("&lt;b&gt; &amp; &quot;x&quot;"));
        for outside in ["src=", "@import", "url(", "<link"] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert_eq!(page.matches("<svg ").count(), 4);
        assert_eq!(page.matches("<figure>").count(), page.matches("</figure>").count());
    }

    #[test]
    fn a_long_run_draws_what_fails() {
        let mut all: Vec<Judged> = (0..40).map(|i| judged(&format!("s{i}"), Outcome::Pass)).collect();
        all[33] = judged("bad", Outcome::Fail);
        let page = page(&all, 5, 0.01);
        assert_eq!(page.matches("<svg ").count(), 4);
        assert!(page.contains("href=\"#s33\"") && page.contains("id=\"s33\""));
    }
}
