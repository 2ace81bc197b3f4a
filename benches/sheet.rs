//! Time of certified albedos against the tolerance asked for, and of whole verdict sheets against the effort.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use whitefurnace::bsdf::subject;
use whitefurnace::integrate::{Hemisphere, Side};
use whitefurnace::math::sphere::direction_mu;
use whitefurnace::validate::{Effort, Suite};

fn albedo(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("albedo, one direction");
    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1)).sample_size(10);
    for (text, mu) in
        [("ggx:alpha=0.3", 0.5), ("ggx:alpha=0.3", 0.1), ("ggx:alpha=0.0001", 0.5), ("eon:rho=0.8,r=0.5", 0.5)]
    {
        let bsdf = subject::parse(text).expect("every subject here is valid");
        for tol in [1e-5, 1e-7, 1e-9] {
            let hemisphere = Hemisphere::with_tol(tol);
            let w = direction_mu(mu, 0.3);
            group.bench_function(BenchmarkId::new(format!("{text} mu={mu}"), tol), |bencher| {
                bencher.iter(|| {
                    let a = hemisphere.albedo(&*bsdf, Side::Eye, black_box(w));
                    assert!(a.resolved, "a bench of what is not resolved would flatter");
                    a.value
                });
            });
        }
    }
    group.finish();
}

fn sheets(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("verdict sheet, all cores");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(12)).sample_size(10);
    for text in ["lambert:rho=0.8", "ggx:alpha=0.1", "beckmann:alpha=0.3"] {
        let bsdf = subject::parse(text).expect("every subject here is valid");
        for (name, effort) in [("quick", Effort::Quick), ("default", Effort::Default)] {
            let suite = Suite { effort, ..Suite::default() };
            group.bench_function(BenchmarkId::new(text, name), |bencher| {
                bencher.iter(|| suite.run(black_box(&*bsdf)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, albedo, sheets);
criterion_main!(benches);
