//! How to store a photon map for fast search of nearest neighbours: a scan, a sorted hash grid, a tree.
//!
//! `cargo bench --bench photons` goes from 10³ to 10⁶ photons, those of a Cornell box; `WHITEFURNACE_MOST=10000000` goes on to
//! 10⁷. The k nearest, k = 100, at points of the surfaces, as `whitefurnace plot stores` asks for them.

use std::env;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use whitefurnace::render::photon::grid::Grid;
use whitefurnace::render::photon::nearest::Nearest;
use whitefurnace::render::photon::stores::{Store, Trial};
use whitefurnace::render::photon::tree::Tree;
use whitefurnace::scene::Scene;
use whitefurnace::scene::builtin::builtin;

const K: usize = 100;

fn stores(criterion: &mut Criterion) {
    let most: usize = env::var("WHITEFURNACE_MOST").ok().and_then(|text| text.parse().ok()).unwrap_or(1_000_000);
    let scene = Scene::new(builtin("cornell-original", &[]).expect("a built-in scene").expect("its defaults"))
        .expect("a scene");
    let trial = Trial::new(&scene, most, K, 1).expect("light");
    for size in [1_000, 10_000, 100_000, 1_000_000, 10_000_000].into_iter().filter(|&size| size <= most) {
        let stores = trial.stores(size);
        let (photons, radius) = (stores.photons(), stores.radius());
        let mut builds = criterion.benchmark_group("build");
        builds.throughput(Throughput::Elements(size as u64)).sample_size(10).measurement_time(Duration::from_secs(2));
        builds.bench_function(BenchmarkId::new("tree", size), |b| b.iter(|| Tree::new(black_box(photons))));
        builds.bench_function(BenchmarkId::new("grid", size), |b| b.iter(|| Grid::new(black_box(photons), radius)));
        builds.finish();

        let mut queries = trial.queries().iter().cycle();
        let mut nearest = Nearest::default();
        let mut group = criterion.benchmark_group("nearest 100");
        group.throughput(Throughput::Elements(1)).sample_size(10).measurement_time(Duration::from_secs(2));
        for store in Store::ALL {
            group.bench_function(BenchmarkId::new(store.name(), size), |b| {
                b.iter(|| {
                    if let Some(&q) = queries.next() {
                        stores.find(store, q, &mut nearest);
                    }
                    black_box(nearest.finish().len())
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, stores);
criterion_main!(benches);
