//! Tests of the judge itself: p-values are uniform on correct models, false alarms come at the stated level, and errors
//! of the stated size are caught with the stated probability.

#![allow(clippy::print_stdout, reason = "the tables of the README are these tests' output")]

use super::claim::Claim;
use super::draws::Tally;
use super::suite::{Effort, Suite};
use super::{Outcome, chi2, convergence, uniformity};
use crate::bsdf::{Bsdf, subject};
use crate::math::sphere::direction;

/// The components whose p-values must be uniform one by one.
const COMPONENTS: [&str; 6] = ["chi2 coarse", "chi2 fine", "transform 1", "transform 2", "agreement", "rate"];

/// P(sup |Fₙ − F| ≥ d) for n uniform numbers, by Kolmogorov's series with Stephens' correction of the argument.
fn kolmogorov_p(mut u: Vec<f64>) -> f64 {
    u.sort_by(f64::total_cmp);
    let n = u.len() as f64;
    let gap = |(i, x): (usize, &f64)| (x - i as f64 / n).max((i + 1) as f64 / n - x);
    let d = u.iter().enumerate().map(gap).fold(0.0, f64::max);
    let x = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * d;
    let term = |k: i32| 2.0 * (-1.0_f64).powi(k - 1) * (-2.0 * f64::from(k * k) * x * x).exp();
    (1..100).map(term).sum::<f64>().clamp(0.0, 1.0)
}

fn p_values(model: &dyn Bsdf, theta: f64, seeds: u64, draws_per_block: usize) -> Vec<[f64; 6]> {
    let wo = direction(theta, 0.3);
    let claim = Claim::new(model, wo);
    (0..seeds)
        .map(|seed| {
            let tally = Tally::draw(model, &claim, seed, 0, draws_per_block);
            let cells = chi2::Evidence::new(&claim, &tally);
            let [first, second] = uniformity::p_values(&tally.parts[0]);
            let [agreement, rate] = convergence::Evidence::new(model, wo, &tally).p_values();
            [cells.coarse, cells.fine, first, second, agreement, rate]
        })
        .collect()
}

/// Asserts that the first `components` p-values are uniform; the others of a model whose weights hardly spread are 1.
fn assert_uniform(subject: &str, theta: f64, components: usize, seeds: u64, draws_per_block: usize) {
    let model = subject::parse(subject).unwrap();
    let all = p_values(&*model, theta, seeds, draws_per_block);
    for (i, name) in COMPONENTS.iter().enumerate() {
        if i < components {
            let p = kolmogorov_p(all.iter().map(|p| p[i]).collect());
            println!("| `{subject}` at {theta} rad | {name} | {seeds} | {p:.3} |");
            // Some thirty components in all: 1e-4 keeps the family-wise false alarm below 1 %.
            assert!(p > 1e-4, "{subject} {name}: p-values are not uniform, KS p = {p:.2e}");
        } else {
            assert!(all.iter().all(|p| p[i] > 0.99), "{subject} {name}: there is nothing left to chance");
        }
    }
}

#[test]
fn kolmogorov_rejects_what_is_not_uniform() {
    let uniform: Vec<f64> = (0..500).map(|i| (f64::from(i) * 0.618_033_988_75).fract()).collect();
    assert!(kolmogorov_p(uniform.clone()) > 0.5);
    assert!(kolmogorov_p(uniform.iter().map(|u| u.powf(1.5)).collect()) < 1e-3);
}

#[test]
fn p_values_of_a_sound_model_are_uniform() {
    assert_uniform("phong:n=20,kd=0.1,ks=0.5,norm=n+2", 1.0, 6, 150, 1024);
}

#[test]
#[ignore = "minutes"]
fn p_values_are_uniform_over_a_thousand_seeds() {
    for (subject, theta, components) in [
        ("lambert:rho=0.5", 0.5, 4),
        ("phong:n=20,kd=0.1,ks=0.5,norm=n+2", 1.0, 6),
        ("ggx:alpha=0.3", 0.9, 6),
        ("ggx:alpha_x=0.05,alpha_y=0.4", 1.2, 6),
        ("beckmann:alpha=0.001", 0.4, 4),
        ("oren-nayar:rho=0.8,sigma=0.5", 0.7, 6),
    ] {
        assert_uniform(subject, theta, components, 1000, 2048);
    }
}

#[test]
#[ignore = "minutes"]
fn false_alarms_come_at_the_stated_level() {
    for subject in ["ggx:alpha=0.3", "phong:n=20,kd=0.1,ks=0.5,norm=n+2"] {
        let model = subject::parse(subject).unwrap();
        let mut alarms = 0_u32;
        for seed in 0..1000 {
            let only = vec!["pdf_mass", "chi2", "uniformity", "convergence"];
            let sheet = Suite { seed, effort: Effort::Quick, only, ..Suite::default() }.run(&*model);
            if sheet.outcome() == Outcome::Fail {
                alarms += 1;
            }
        }
        println!("| `{subject}` | 1000 sheets | {alarms} false alarms at level 1 % |");
        // Binomial(1000, 1 %): P(X > 20) = 1.5e-3. Fewer than 10 are expected, since Bonferroni and Holm are bounds.
        assert!(alarms <= 20, "{subject}: {alarms}");
    }
}
