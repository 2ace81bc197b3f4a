//! Time of one draw through `&dyn Bsdf`: sample, then eval and pdf of the direction drawn, on one core.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use whitefurnace::bsdf::{Bsdf, Uniforms, subject};
use whitefurnace::glam::DVec3;
use whitefurnace::math::sphere::direction_mu;
use whitefurnace::sampling::stream::{stream, uniform, uniforms};

/// Inputs that fit the first-level cache and come in no order that a branch predictor could learn.
const DRAWS: usize = 512;

const SUBJECTS: &[&str] = &[
    "lambert:rho=0.8",
    "phong:n=100,norm=n+2,ks=1",
    "ggx:alpha=0.3",
    "ggx:alpha=0.3,sampling=visible",
    "ggx:alpha=0.3,sampling=ndf",
    "ggx:alpha_x=0.1,alpha_y=0.5,eta=1.5",
    "ggx:alpha=0.3,compensation=kulla-conty",
    "beckmann:alpha=0.3",
    "blinn:n=50",
];

fn draws() -> Vec<(DVec3, Uniforms)> {
    let mut rng = stream(1, 0, 0);
    let mut draw = || {
        let wo = direction_mu(0.02 + 0.98 * uniform(&mut rng), std::f64::consts::TAU * uniform(&mut rng));
        (wo, uniforms(&mut rng))
    };
    (0..DRAWS).map(|_| draw()).collect()
}

fn sample_eval_pdf(bsdf: &dyn Bsdf, wo: DVec3, u: Uniforms) -> f64 {
    bsdf.sample(wo, u).map_or(0.0, |s| s.weight.0.x + bsdf.eval(wo, s.wi).0.x + bsdf.pdf(wo, s.wi))
}

fn models(criterion: &mut Criterion) {
    let draws = draws();
    let mut group = criterion.benchmark_group("sample+eval+pdf, 512 draws");
    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1)).sample_size(20);
    group.throughput(criterion::Throughput::Elements(DRAWS as u64));
    for subject in SUBJECTS {
        let bsdf = subject::parse(subject).expect("every subject here is valid");
        let bsdf: &dyn Bsdf = black_box(&*bsdf);
        group.bench_function(*subject, |bencher| {
            bencher.iter(|| draws.iter().map(|&(wo, u)| sample_eval_pdf(bsdf, wo, u)).sum::<f64>());
        });
    }
    group.finish();
}

criterion_group!(benches, models);
criterion_main!(benches);
