//! Hierarchical radiosity against a matrix of all view factors, both cut into the same finest elements: seconds, links, and
//! the error of either.
//!
//! `cargo bench --bench hierarchical -- [SCENE [ELEMENTS …]]`; the Cornell box with 4096 and 16384 elements where nothing is said.
//! The error against the matrix is that of the links alone. That against four times as many elements, solved
//! hierarchically to [`REFERENCE`], is what a user has: the size of the elements is in it, for both.
#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::time::Instant;

use whitefurnace::math::color::Rgb;
use whitefurnace::render::radiosity::hierarchical::{Hierarchical, HierarchicalSolution};
use whitefurnace::render::radiosity::model::Radiosity;
use whitefurnace::render::radiosity::patches::{Fineness, Patches};
use whitefurnace::scene::builtin::builtin;
use whitefurnace::scene::{Ray, Scene};

const ERRORS: [f64; 3] = [0.1, 0.03, 0.01];
/// Of the links of the reference.
const REFERENCE: f64 = 0.004;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let name = words.first().map_or("cornell-original", String::as_str);
    let given: Vec<usize> = words.iter().skip(1).filter_map(|word| word.parse().ok()).collect();
    let sizes = if given.is_empty() { vec![4096, 16384] } else { given };
    let description = builtin(name, &[]).expect("a built-in scene").expect("no parameters");
    let scene = Scene::new(description).expect("a scene");
    for size in sizes {
        compare(&scene, size);
    }
}

fn compare(scene: &Scene, size: usize) {
    let fineness = Fineness::Count(size);
    let fine = Hierarchical {
        fineness: Fineness::Count(4 * size),
        error: REFERENCE,
        memory: 12 << 30,
        ..Hierarchical::default()
    };
    let (fine, seconds) = timed(|| fine.solve(scene).expect("a diffuse scene"));
    println!(
        "{}: {} leaves for the reference, {seconds:.1} s, {}",
        scene.name(),
        fine.patches.all().len(),
        told(&fine)
    );
    let dense = Radiosity { fineness, memory: 4 << 30, ..Radiosity::default() };
    let (dense, dense_seconds) = timed(|| dense.solve(scene).expect("a diffuse scene"));
    let at_leaves = |found: &HierarchicalSolution| {
        relative(scene, &dense.patches, &dense.solved.radiosity, &found.patches, &found.solved.radiosity)
    };
    let against = |patches: &Patches, b: &[Rgb]| relative(scene, &fine.patches, &fine.solved.radiosity, patches, b);
    let dense_error = against(&dense.patches, &dense.solved.radiosity);
    let n = dense.patches.all().len();
    println!("dense {n}: {dense_seconds:.2} s, error {dense_error:.5}");
    println!("{:?} {:?}", means(&dense.patches, &dense.solved.radiosity), means(&fine.patches, &fine.solved.radiosity));
    for error in ERRORS {
        let model = Hierarchical { fineness, error, ..Hierarchical::default() };
        let (found, seconds) = timed(|| model.solve(scene).expect("a diffuse scene"));
        println!(
            "E {error}: {seconds:.3} s, {:.1} times as fast, error {:.5} ({:.2} E), against the reference {:.5}; {}",
            dense_seconds / seconds,
            at_leaves(&found),
            at_leaves(&found) / error,
            against(&found.patches, &found.solved.radiosity),
            told(&found),
        );
        println!("{:?}", means(&found.patches, &found.solved.radiosity));
    }
}

fn told(found: &HierarchicalSolution) -> String {
    let s = &found.statistics;
    let defect = found.energy.reciprocity_defect.0.abs().max_element() / found.energy.emitted.max_channel();
    format!(
        "{} leaves of {}, {} links, {} rays, {} rounds, estimated {:.5} + {:.5}, rows {:.4} to {:.4}, defect {defect:.1e}, s {:.2?}",
        s.leaves,
        s.finest,
        s.links,
        s.rays,
        s.rounds,
        s.estimated_error,
        s.discretisation,
        s.row_sums[0],
        s.row_sums[1],
        found.seconds
    )
}

/// Mean radiosity of each shape, its first channel.
fn means(patches: &Patches, radiosity: &[Rgb]) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; patches.shapes().len()];
    for (patch, b) in patches.all().iter().zip(radiosity) {
        sums[patch.shape][0] += patch.area * b.0.x;
        sums[patch.shape][1] += patch.area;
    }
    sums.iter().map(|[b, area]| b / area).collect()
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Root mean square difference by area, relative to the root mean square of what is reflected, over the patches of `fine`, each
/// of which lies in one of `coarse`.
fn relative(scene: &Scene, fine: &Patches, at_fine: &[Rgb], coarse: &Patches, at_coarse: &[Rgb]) -> f64 {
    let (mut gap, mut sum) = (0.0, 0.0);
    for (patch, b) in fine.all().iter().zip(at_fine) {
        let (_, n) = patch.form.at(whitefurnace::glam::DVec2::splat(0.5));
        let p = patch.form.centre();
        let ray = Ray::new(p + n * (1e-6 * fine.extent()), -n);
        let Some(other) = scene.intersect(&ray).and_then(|surface| coarse.at(&surface, n)) else { continue };
        gap += patch.area * (*b - at_coarse[other]).0.length_squared();
        sum += patch.area * (*b - patch.emission).0.length_squared();
    }
    (gap / sum).sqrt()
}
