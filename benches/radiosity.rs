//! Time of the dense radiosity solver for grey reflectances: I − ρF is made, factored once, and solved for three channels.
//!
//! The same work as a general solver does for a matrix and three right sides, and the residual besides. `cargo bench --bench
//! radiosity -- 4000` runs one size; two threads at most.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use whitefurnace::math::color::Rgb;
use whitefurnace::render::radiosity::matrix::FactorMatrix;
use whitefurnace::render::radiosity::solve::{Method, Settings};
use whitefurnace::render::radiosity::system::System;
use whitefurnace::sampling::stream::{stream, uniform};

const SIZES: [usize; 3] = [1000, 2000, 4000];
const THREADS: usize = 2;

/// Patches of the same size that exchange at random, in a nearly closed scene.
fn system(n: usize) -> System {
    let mut rng = stream(1, 0, 0);
    let mut values = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let value = 1.8 * uniform(&mut rng) / n as f64;
            (values[i * n + j], values[j * n + i]) = (value, value);
        }
    }
    let factors = FactorMatrix::new(n, values).expect("shares");
    let emission = (0..n).map(|_| Rgb::new(uniform(&mut rng), uniform(&mut rng), uniform(&mut rng))).collect();
    System::new(factors, vec![1.0; n], vec![Rgb::grey(0.7); n], emission).expect("a valid system")
}

fn dense(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build().expect("threads");
    let mut group = criterion.benchmark_group("radiosity/dense");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(5));
    for n in SIZES {
        let system = system(n);
        group.bench_function(BenchmarkId::from_parameter(n), |bencher| {
            bencher.iter(|| pool.install(|| black_box(Method::Dense.solve(&system, Settings::default()))));
        });
    }
    group.finish();
}

criterion_group!(benches, dense);
criterion_main!(benches);
