//! Radiosity against closed forms, and against path tracing.

#[path = "../common/mod.rs"]
#[allow(dead_code, unused_imports, reason = "shared with other tests")]
mod common;

mod adaptive;
mod enclosures;
mod paths;
mod view_factors;

use whitefurnace::math::color::Rgb;
use whitefurnace::render::radiosity::model::{Radiosity, SolvedScene};
use whitefurnace::render::radiosity::patches::Fineness;
use whitefurnace::scene::Scene;

/// The scene in about so many patches.
fn solved(scene: &Scene, patches: usize) -> SolvedScene {
    Radiosity { fineness: Fineness::Count(patches), ..Radiosity::default() }.solve(scene).expect("a solution")
}

/// Mean radiosity of the shape of this name.
fn radiosity(solved: &SolvedScene, name: &str) -> Rgb {
    solved.surfaces().into_iter().find(|surface| surface.name == name).expect("a surface of this name").radiosity
}

/// The limit of a sequence whose errors fall by the same factor each time (Aitken).
fn limit([a, b, c]: [f64; 3]) -> f64 {
    c - (c - b) * (c - b) / ((c - b) - (b - a))
}

/// The slope of log y against log x, by least squares.
fn order(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (mx, my) = logs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = logs.iter().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - mx) * (p.1 - my), xx + (p.0 - mx).powi(2)));
    xy / xx
}
