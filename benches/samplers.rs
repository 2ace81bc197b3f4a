//! What a number costs: one sample of six pairs and six single dimensions, as a path of two bounces takes them.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use whitefurnace::sampling::sampler::{Sampler, SamplerKind};

const SAMPLES: u64 = 64;

fn samplers(c: &mut Criterion) {
    let mut group = c.benchmark_group("pair_and_single");
    group.throughput(Throughput::Elements(6 * SAMPLES));
    for &(name, kind) in SamplerKind::ALL {
        let mut sampler = kind.sampler(1, SAMPLES, 512);
        group.bench_function(name, |b| {
            b.iter(|| {
                for sample in 0..SAMPLES {
                    sampler.begin(black_box(77), sample);
                    for _ in 0..6 {
                        black_box((sampler.next_2d(), sampler.next_1d()));
                    }
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, samplers);
criterion_main!(benches);
