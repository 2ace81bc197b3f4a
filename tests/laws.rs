//! Every example of every model in the catalog goes through the verdict sheet, and fails exactly what it says it breaks.

use rayon::prelude::*;
use whitefurnace::bsdf::catalog::MODELS;
use whitefurnace::bsdf::subject;
use whitefurnace::validate::{Effort, Outcome, Suite};

fn verdicts_are_as_declared(effort: Effort) {
    let examples: Vec<_> = MODELS.iter().flat_map(|entry| entry.examples).collect();
    // One family over all sheets: a level of 1e-5 each keeps a false alarm on any of them below one run in a thousand.
    let suite = Suite { effort, level: 1e-5, ..Suite::default() };
    let complaints: Vec<String> = examples
        .par_iter()
        .flat_map_iter(|example| {
            let model = subject::parse(example.subject).expect("the catalog's own example");
            let sheet = suite.run(&*model);
            sheet.checks.into_iter().filter_map(move |check| {
                let expected = example.breaks.contains(&check.name);
                let failed = check.outcome == Outcome::Fail;
                (failed != expected)
                    .then(|| format!("{}: {} {}: {}", example.subject, check.name, check.outcome, check.detail))
            })
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
    assert!(examples.len() >= 20, "the catalog has shrunk to {} examples", examples.len());
}

#[test]
fn the_catalog_breaks_exactly_what_it_declares() {
    verdicts_are_as_declared(Effort::Quick);
}

#[test]
#[ignore = "minutes"]
fn the_catalog_breaks_exactly_what_it_declares_at_default_effort() {
    verdicts_are_as_declared(Effort::Default);
}
