//! Why directions are drawn by the cosine, and better still by the model: the variance of one sample.

use super::{File, KNOWN, MEASURED, SEED, Set, csv, rounded, subject};
use crate::bsdf::{Bsdf, FnBsdf};
use crate::converge::albedo::albedo;
use crate::converge::variance::{moments, variance_std_err};
use crate::converge::{Estimator, Target};
use crate::math::sphere::direction_mu;
use crate::math::sum::Moments;

/// `cosine_sampling.csv`.
pub const SET: Set = Set {
    name: "directions by the cosine and by the model",
    files: &[File {
        name: "cosine_sampling.csv",
        about: "Variance of one sample of the reflected light, for each way of drawing the direction",
        columns: COLUMNS,
    }],
    make: || vec![csv(COLUMNS, rows())],
};

const COLUMNS: &[(&str, &str)] = &[
    ("subject", "the model"),
    ("light", "radiance from the direction wi: 1 everywhere, or its cosine"),
    ("mu", "cosine of the eye's angle"),
    ("estimator", "how wi is drawn; balance and power take one draw by the cosine and one by the model"),
    ("exact_mean", "the reflected radiance"),
    ("closed_form", "variance of one sample, where a formula is known"),
    ("quadrature", "variance of one sample, integrated"),
    ("mean", "mean of the samples"),
    ("variance", "variance of the samples"),
    ("variance_std_err", "its standard error"),
    ("samples", "how many"),
];

const SAMPLES: u64 = 1 << 17;

/// A model under a light, with the variances that are known in closed form.
struct Case {
    subject: &'static str,
    light: &'static str,
    mu: f64,
    closed: fn(&str) -> Option<f64>,
}

const CASES: &[Case] = &[
    Case {
        subject: "lambert:rho=1",
        light: "1",
        mu: 0.5,
        closed: |estimator| match estimator {
            "uniform" => Some(1.0 / 3.0),
            "cosine" | "bsdf" | "balance" | "power" => Some(0.0),
            _ => None,
        },
    },
    Case {
        subject: "lambert:rho=1",
        light: "cos",
        mu: 0.5,
        closed: |estimator| match estimator {
            "uniform" => Some(16.0 / 45.0),
            "cosine" | "bsdf" => Some(1.0 / 18.0),
            _ => None,
        },
    },
    phong_case("phong:n=1,norm=n+2", |estimator| phong_at_normal(1.0, estimator)),
    phong_case("phong:n=10,norm=n+2", |estimator| phong_at_normal(10.0, estimator)),
    phong_case("phong:n=100,norm=n+2", |estimator| phong_at_normal(100.0, estimator)),
    phong_case("phong:n=1000,norm=n+2", |estimator| phong_at_normal(1000.0, estimator)),
    ggx_case("ggx:alpha=0.1"),
    ggx_case("ggx:alpha=0.3"),
    ggx_case("ggx:alpha=0.5"),
    ggx_case("ggx:alpha=1"),
];

const fn phong_case(subject: &'static str, closed: fn(&str) -> Option<f64>) -> Case {
    Case { subject, light: "1", mu: 1.0, closed }
}

const fn ggx_case(subject: &'static str) -> Case {
    Case { subject, light: "1", mu: 0.5, closed: |_| None }
}

/// f = (n+2)/2π cosⁿ about the normal, where the eye is; E[X²] are moments of a power of the cosine.
fn phong_at_normal(n: f64, estimator: &str) -> Option<f64> {
    match estimator {
        "uniform" => Some((n + 1.0).powi(2) / (2.0 * n + 3.0)),
        "cosine" => Some(n * n / (4.0 * (n + 1.0))),
        "bsdf" => Some(1.0 / ((n + 1.0) * (n + 3.0))),
        _ => None,
    }
}

fn rows() -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for Case { subject: name, light, mu, closed } in CASES {
        let model = subject(name);
        // Light that varies is put into the model: what is integrated is the product.
        let under_light = FnBsdf::new(*name, move |wo, wi: glam::DVec3| model.eval(wo, wi) * wi.z.max(0.0));
        let plain = subject(name);
        let bsdf: &dyn Bsdf = if *light == "cos" { &under_light } else { &*plain };
        let target = albedo(name, bsdf, direction_mu(*mu, 0.0));
        for estimator in &target.estimators {
            let moments = moments(SAMPLES, SEED, rows.len() as u64, &estimator.draw);
            let known = closed(estimator.name);
            rows.push(row((*name, *light, *mu), &target, estimator, known, &moments));
        }
    }
    rows
}

fn row(
    (name, light, mu): (&str, &str, f64),
    target: &Target,
    estimator: &Estimator,
    known: Option<f64>,
    moments: &Moments,
) -> Vec<String> {
    let cell = |x: Option<f64>| x.map_or(String::new(), |x| rounded(x, MEASURED));
    let noise = |x: f64| rounded(if x < 1e-20 { 0.0 } else { x }, MEASURED);
    vec![
        name.into(),
        light.into(),
        mu.to_string(),
        estimator.name.into(),
        rounded(target.exact, MEASURED),
        known.map_or(String::new(), |x| rounded(x, KNOWN)),
        cell(estimator.sigma.map(|sigma| sigma * sigma)),
        rounded(moments.mean(), MEASURED),
        noise(moments.variance()),
        noise(variance_std_err(moments)),
        moments.count().to_string(),
    ]
}
