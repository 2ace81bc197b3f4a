//! What continuing a path many times from its first surface saves, and what ending it by chance costs.

use super::{File, KNOWN, MEASURED, SEED, Set, csv, literal, rounded, scene};
use crate::converge::first_split::{Fit, Floor, Law, Pixel, Point};
use crate::converge::roulette::Furnace;
use crate::converge::variance::variance_std_err;
use crate::render::path::PathTracer;

/// `first_split.csv`, `first_split_fits.csv` and `roulette.csv`.
pub const SET: Set = Set {
    name: "splitting and roulette",
    files: &[
        File {
            name: "first_split.csv",
            about: "Variance of one sample against the number of continuations from its first surface",
            columns: SPLIT_COLUMNS,
        },
        File {
            name: "first_split_fits.csv",
            about: "The law Var = V0 + V1/M fitted to these variances",
            columns: FIT_COLUMNS,
        },
        File {
            name: "roulette.csv",
            about: "Variance of the light of a path in a furnace that goes on with probability q at each reflection",
            columns: ROULETTE_COLUMNS,
        },
    ],
    make: || {
        let studies = splits();
        vec![
            csv(SPLIT_COLUMNS, studies.iter().flat_map(Study::points)),
            csv(FIT_COLUMNS, studies.iter().map(Study::fit)),
            csv(ROULETTE_COLUMNS, roulette()),
        ]
    },
};

const SPLIT_COLUMNS: &[(&str, &str)] = &[
    (
        "subject",
        "floor: a floor of random albedo under a square, known in closed form; cornell: a pixel of the Cornell box",
    ),
    ("m", "continuations of each first event"),
    ("mean", "mean of the samples"),
    ("variance", "variance of one sample of m continuations"),
    ("std_err", "its standard error"),
];

const FIT_COLUMNS: &[(&str, &str)] = &[
    ("subject", "as in first_split.csv"),
    ("v0", "fitted: what splitting leaves"),
    ("v0_std_err", "its standard error"),
    ("v1", "fitted: what splitting divides"),
    ("v1_std_err", "its standard error"),
    ("p_value", "probability of a misfit as large as this, were the law true"),
    ("v0_exact", "the same where it is known"),
    ("v1_exact", "the same where it is known"),
];

const ROULETTE_COLUMNS: &[(&str, &str)] = &[
    ("rho", "albedo of the walls"),
    ("q", "probability of going on"),
    ("samples", "paths"),
    ("exact_mean", "rho / (1 - rho)"),
    ("mean", "mean of the paths"),
    ("closed_form", "variance of a path, inf for q <= rho^2"),
    ("variance", "variance of the paths"),
    ("std_err", "its standard error; empty where the fourth moment is infinite and the paths cannot tell it"),
];

const SPLITS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Samples of each variance.
const FLOOR_SAMPLES: u64 = 1 << 16;
const PIXEL_SAMPLES: u64 = 1 << 13;

/// The variances of one subject, and its law where that is known.
struct Study {
    subject: &'static str,
    points: Vec<Point>,
    exact: Option<Law>,
}

fn splits() -> Vec<Study> {
    let floor = literal(Floor::new().ok_or("unit-square"));
    // A large pixel on the back wall, over which the light varies.
    let room = scene("cornell-original", &[]).with_size(4, 4);
    let pixel = Pixel { scene: &room, at: [1, 2], tracer: PathTracer { bounces: Some(3), ..PathTracer::default() } };
    vec![
        Study { subject: "floor", points: floor.measure(&SPLITS, FLOOR_SAMPLES, SEED), exact: Some(floor.law()) },
        Study { subject: "cornell", points: pixel.measure(&SPLITS, PIXEL_SAMPLES, SEED), exact: None },
    ]
}

impl Study {
    fn points(&self) -> impl Iterator<Item = Vec<String>> {
        self.points.iter().map(|point| {
            let numbers = [point.mean, point.variance, point.std_err].map(|x| rounded(x, MEASURED));
            [self.subject.to_string(), point.m.to_string()].into_iter().chain(numbers).collect()
        })
    }

    fn fit(&self) -> Vec<String> {
        let fit = literal(Fit::of(&self.points).ok_or(self.subject));
        let fitted = [fit.law.v0, fit.std_err.v0, fit.law.v1, fit.std_err.v1, fit.p_value()];
        let exact =
            self.exact.map_or([String::new(), String::new()], |law| [law.v0, law.v1].map(|x| rounded(x, KNOWN)));
        let numbers = fitted.map(|x| rounded(x, MEASURED)).into_iter().chain(exact);
        std::iter::once(self.subject.to_string()).chain(numbers).collect()
    }
}

const RHO: f64 = 0.8;
/// From below ρ² = .64, where no variance is, to next to no roulette.
const SURVIVALS: [f64; 9] = [0.5, 0.6, 0.66, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95];
/// Numbers of paths: a variance that is finite settles, another one grows.
const PATHS: [u64; 3] = [1 << 10, 1 << 14, 1 << 18];

fn roulette() -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for (number, q) in SURVIVALS.into_iter().enumerate() {
        let furnace = literal(Furnace::new(RHO, q));
        for samples in PATHS {
            let found = furnace.measure(samples, SEED, number as u64);
            let error = furnace.has_fourth_moment().then(|| rounded(variance_std_err(&found), MEASURED));
            rows.push(vec![
                RHO.to_string(),
                q.to_string(),
                samples.to_string(),
                rounded(furnace.mean(), KNOWN),
                rounded(found.mean(), MEASURED),
                rounded(furnace.variance(), KNOWN),
                rounded(found.variance(), MEASURED),
                error.unwrap_or_default(),
            ]);
        }
    }
    rows
}
