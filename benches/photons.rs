//! How to store a photon map for fast search of nearest neighbours: a scan, a sorted hash grid, a tree.
//!
//! `cargo bench --bench photons` goes from 10³ to 10⁶ photons, those of a Cornell box; `WHITEFURNACE_MOST=10000000` goes on to
//! 10⁷. The k nearest, k = 100, at points of the surfaces. A grid cannot know the distance of the k-th: it is asked for all
//! within the radius that holds k on average, and the k nearest are taken of those.

use std::env;
use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use whitefurnace::glam::DVec3;
use whitefurnace::render::photon::grid::Grid;
use whitefurnace::render::photon::nearest::{Nearest, scan};
use whitefurnace::render::photon::shoot::Shooting;
use whitefurnace::render::photon::tree::Tree;
use whitefurnace::sampling::stream::{stream, uniform};
use whitefurnace::scene::Scene;
use whitefurnace::scene::builtin::builtin;

const K: usize = 100;
/// Queries before the same one comes again: their points, and what is around them, do not fit into a core's own memory.
const QUERIES: usize = 1 << 14;

/// So many photons of a Cornell box.
fn photons(count: usize) -> Vec<DVec3> {
    let scene = Scene::new(builtin("cornell-original", &[]).expect("a built-in scene").expect("its defaults"))
        .expect("a scene");
    // About two and a half of each that is emitted are stored.
    let shooting = Shooting { photons: count as u64, ..Shooting::default() };
    let mut points: Vec<DVec3> = shooting.shoot(&scene).expect("light").photons.iter().map(|photon| photon.p).collect();
    points.truncate(count);
    points
}

fn queries(points: &[DVec3]) -> Vec<DVec3> {
    let mut rng = stream(6, 0, 0);
    (0..QUERIES).map(|_| points[(uniform(&mut rng) * points.len() as f64) as usize] + DVec3::splat(1e-3)).collect()
}

/// The radius within which K photons lie on average.
fn radius(points: &[DVec3]) -> f64 {
    let (tree, mut nearest) = (Tree::new(points), Nearest::default());
    let of_each = queries(points).into_iter().take(200).map(|q| {
        nearest.begin(K, f32::INFINITY);
        tree.nearest(q, &mut nearest, |_| true);
        nearest.finish().last().map_or(0.0, |last| PI * f64::from(last.distance2()))
    });
    (of_each.sum::<f64>() / 200.0 / PI).sqrt()
}

fn sizes() -> Vec<usize> {
    let most: usize = env::var("WHITEFURNACE_MOST").ok().and_then(|text| text.parse().ok()).unwrap_or(1_000_000);
    [1_000, 10_000, 100_000, 1_000_000, 10_000_000].into_iter().filter(|&size| size <= most).collect()
}

fn stores(criterion: &mut Criterion) {
    for size in sizes() {
        let points = photons(size);
        let (at, radius) = (queries(&points), radius(&points));
        let mut builds = criterion.benchmark_group("build");
        builds.throughput(Throughput::Elements(size as u64)).sample_size(10).measurement_time(Duration::from_secs(2));
        builds.bench_function(BenchmarkId::new("tree", size), |b| b.iter(|| Tree::new(black_box(&points))));
        builds.bench_function(BenchmarkId::new("grid", size), |b| b.iter(|| Grid::new(black_box(&points), radius)));
        builds.finish();

        let (tree, grid) = (Tree::new(&points), Grid::new(&points, radius));
        let (mut nearest, mut next) = (Nearest::default(), 0);
        let mut query = || {
            next = (next + 1) % QUERIES;
            at[next]
        };
        let mut group = criterion.benchmark_group("nearest 100");
        group.throughput(Throughput::Elements(1)).sample_size(10).measurement_time(Duration::from_secs(2));
        group.bench_function(BenchmarkId::new("tree", size), |b| {
            b.iter(|| {
                nearest.begin(K, f32::INFINITY);
                tree.nearest(query(), &mut nearest, |_| true);
                black_box(nearest.finish().len())
            });
        });
        group.bench_function(BenchmarkId::new("grid", size), |b| {
            b.iter(|| {
                nearest.begin(K, f32::INFINITY);
                grid.within(query(), radius, |found| {
                    if found.distance2() < nearest.limit() {
                        nearest.push(found);
                    }
                });
                black_box(nearest.finish().len())
            });
        });
        group.bench_function(BenchmarkId::new("scan", size), |b| {
            b.iter(|| {
                nearest.begin(K, f32::INFINITY);
                scan(&points, query(), &mut nearest, |_| true);
                black_box(nearest.finish().len())
            });
        });
        group.finish();
    }
}

criterion_group!(benches, stores);
criterion_main!(benches);
