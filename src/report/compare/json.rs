//! The JSON of `compare`, schema 1.
//!
//! ```text
//! {"schema": 1, "version", "a": FILE, "b": FILE, "reference": "a|b", "width", "height",
//!  "verdict": "equal|differ|undecided", "identical", "level", "outliers",
//!  "metrics": [{"name", "formula", "epsilon", "value"}], "flip": {"mean", "pixels_per_degree"},
//!  "noise": {"tested", "untested", "mean_z", "mean_z2", "expected_z2",
//!            "pixels": MANY, "blocks": MANY, "image": {"holds", "bound", "channels": [{"difference", "std_err", "z"}]}}}
//! FILE = {"path", "mean": [r, g, b], "nonfinite", "noise"}
//! MANY = {"holds", "tested", "failing", "allowed", "bound", "worst": {"x", "y", "channel", "z"}}
//! ```
//! `noise` is null where nothing is known of it; differences are those of the other file less the reference; a number
//! that is NaN or infinite is null. A later version may add fields; one that changes or removes a field changes `schema`.

use serde_json::{Value, json};

use super::noise::{ManyTests, NoiseTest};
use super::{Comparison, Side};

/// The comparison of `sides` (A and B as typed) as JSON text, with a final line break.
pub fn comparison(result: &Comparison, sides: [&Side; 2], reference_first: bool) -> String {
    // Means and counts are in the order test, reference.
    let file = |at: usize| {
        let from = usize::from(reference_first) ^ at;
        json!({
            "path": sides[at].name,
            "mean": result.means[from],
            "nonfinite": result.nonfinite[from],
            "noise": sides[at].noise_source,
        })
    };
    let metric =
        |m: &super::Metric| json!({"name": m.name, "formula": m.formula, "epsilon": m.epsilon, "value": m.value});
    let report = json!({
        "schema": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "a": file(0),
        "b": file(1),
        "reference": if reference_first { "a" } else { "b" },
        "width": result.width,
        "height": result.height,
        "verdict": result.verdict().to_string(),
        "identical": result.identical,
        "level": result.settings.level,
        "outliers": result.settings.outliers,
        "metrics": result.metrics.iter().map(metric).collect::<Vec<_>>(),
        "flip": {"mean": result.flip, "pixels_per_degree": result.settings.pixels_per_degree},
        "noise": result.noise.as_ref().map(noise),
    });
    format!("{report:#}\n")
}

fn noise(test: &NoiseTest) -> Value {
    let channel = |c: &super::noise::ChannelTest| json!({"difference": c.difference, "std_err": c.std_err, "z": c.z});
    json!({
        "tested": test.pixels.tested,
        "untested": test.untested,
        "mean_z": test.mean_z,
        "mean_z2": test.mean_z2,
        "expected_z2": test.expected_z2,
        "pixels": many(&test.pixels),
        "blocks": many(&test.blocks),
        "image": {
            "holds": test.image_holds(),
            "bound": test.image_bound,
            "channels": test.image.iter().map(channel).collect::<Vec<_>>(),
        },
    })
}

fn many(tests: &ManyTests) -> Value {
    let worst = tests.worst;
    let channel = ["red", "green", "blue"][worst.channel];
    json!({
        "holds": tests.holds(),
        "tested": tests.tested,
        "failing": tests.failing,
        "allowed": tests.allowed,
        "bound": tests.bound,
        "worst": {"x": worst.x, "y": worst.y, "channel": channel, "z": worst.z},
    })
}
