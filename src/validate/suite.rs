//! The whole verdict sheet, and its one judge.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use super::check::{Check, Outcome, Sheet};
use super::claim::Claim;
use super::draws::Tally;
use super::energy::Grid;
use super::power::holm;
use super::{chi2, consistency, convergence, energy, furnace, laws, mass, uniformity};
use crate::bsdf::Bsdf;
use crate::integrate::{Side, is_two_faced};
use crate::math::sphere::{direction, flip};
use crate::sampling::stream::{stream, uniform};

/// Every check by name, with what it asks, in the order of the sheet.
pub const CHECKS: &[(&str, &str)] = &[
    ("finite", "is every value finite and not negative, at the edges too?"),
    ("reciprocity", "does swapping eye and light leave f unchanged?"),
    ("energy_eye", "does any view see more light than comes in?"),
    ("energy_light", "does any beam of light come out brighter than it went in?"),
    ("pdf_mass", "do the pdf's mass and the lost draws add up to 1?"),
    ("chi2", "do samples fall where the pdf says?"),
    ("uniformity", "does the claimed cdf turn samples into uniform numbers?"),
    ("weight", "is each weight f cos / pdf, and each density the pdf?"),
    ("white_furnace", "is the albedo what the model claims?"),
    ("weak_white_furnace", "do the visible microfacets cover exactly the surface?"),
    ("convergence", "does sampling agree with quadrature, at the rate N^(-1/2)?"),
];

/// How much work is spent, and so how small an error is caught.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// A glance, in a tenth of the time.
    Quick,
    /// What a test suite should use; its power is stated on the sheet.
    #[default]
    Default,
    /// More directions and eight times the samples.
    Deep,
}

struct Plan {
    /// Polar angles, in degrees, from which samples are drawn.
    views: &'static [f64],
    draws_per_block: usize,
    pairs: usize,
    grid: Grid,
}

impl Effort {
    fn plan(self) -> Plan {
        match self {
            Self::Quick => Plan {
                views: &[20.0, 70.0],
                draws_per_block: 2048,
                pairs: 8 * 1024,
                grid: Grid { even: 24, grazing: 12, azimuths: 2 },
            },
            Self::Default => Plan {
                views: &[8.0, 40.0, 65.0, 84.0],
                draws_per_block: 16384,
                pairs: 64 * 1024,
                grid: Grid { even: 64, grazing: 32, azimuths: 3 },
            },
            Self::Deep => Plan {
                views: &[2.0, 15.0, 30.0, 45.0, 60.0, 75.0, 84.0, 88.5],
                draws_per_block: 131_072,
                pairs: 1024 * 1024,
                grid: Grid { even: 360, grazing: 90, azimuths: 12 },
            },
        }
    }
}

/// The settings of a verdict sheet.
///
/// ```
/// use whitefurnace::bsdf::Lambert;
/// use whitefurnace::validate::{Effort, Outcome, Suite};
///
/// let lambert = Lambert::new(0.5)?;
/// let sheet = Suite { effort: Effort::Quick, ..Suite::default() }.run(&lambert);
/// assert_eq!(sheet.outcome(), Outcome::Pass);
/// # Ok::<(), whitefurnace::bsdf::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// Seed of every random number.
    pub seed: u64,
    /// Family-wise level: the probability that a correct model fails anywhere on the sheet.
    pub level: f64,
    /// How much work is spent.
    pub effort: Effort,
    /// Names of the checks to run, of those in [`CHECKS`]; empty for all that apply.
    pub only: Vec<&'static str>,
}

impl Default for Suite {
    fn default() -> Self {
        Self { seed: 1, level: 0.01, effort: Effort::Default, only: Vec::new() }
    }
}

/// Runs the whole verdict sheet with the defaults.
pub fn suite(bsdf: &dyn Bsdf) -> Sheet {
    Suite::default().run(bsdf)
}

impl Suite {
    /// Runs the checks.
    pub fn run(&self, bsdf: &dyn Bsdf) -> Sheet {
        self.run_reporting(bsdf, &|_| {})
    }

    /// Runs the checks and calls `progress` with the name of each as it ends.
    pub fn run_reporting(&self, bsdf: &dyn Bsdf, progress: &(dyn Fn(&'static str) + Sync)) -> Sheet {
        let plan = self.effort.plan();
        let wanted = |name: &str| self.only.is_empty() || self.only.contains(&name);
        let statistical = ["pdf_mass", "chi2", "uniformity", "convergence"];
        // What a single p-value is sure to get of the level, however many others there are.
        let share = self.level / statistical.iter().filter(|name| wanted(name)).count().max(1) as f64;
        let sampled = statistical.iter().any(|name| wanted(name)) || wanted("weight");
        let runs = if sampled { self.draw(bsdf, &plan) } else { Vec::new() };

        let has_object = |name: &str| match name {
            "weak_white_furnace" => bsdf.normals().is_some(),
            "uniformity" => !runs.iter().all(|(claim, _)| claim.is_discrete()),
            _ => true,
        };
        let mut checks = Vec::new();
        for &(name, _) in CHECKS {
            // On the full sheet, a check that has no object is left out; asked for by name, it says so.
            if !wanted(name) || (self.only.is_empty() && !has_object(name)) {
                continue;
            }
            checks.push(match name {
                "finite" => laws::finite(bsdf, self.seed, plan.pairs / 4),
                "reciprocity" => laws::reciprocity(bsdf, self.seed, plan.pairs),
                "energy_eye" => energy::energy(bsdf, Side::Eye, self.seed, plan.grid),
                "energy_light" => energy::energy(bsdf, Side::Light, self.seed, plan.grid),
                "pdf_mass" => mass::check(&runs, share),
                "chi2" => chi2::check(&runs, share),
                "uniformity" => uniformity::check(&runs, share),
                "weight" => consistency::check(&runs),
                "white_furnace" => energy::white_furnace(bsdf, self.seed, plan.grid),
                "weak_white_furnace" => furnace::check(bsdf.normals(), self.seed),
                _ => convergence::check(bsdf, &runs, share),
            });
            progress(name);
        }
        judge(checks.iter_mut(), self.level);
        let mut subject = format!("{bsdf:?}");
        if let Some((end, _)) = subject.char_indices().nth(200) {
            subject.truncate(end);
        }
        Sheet { subject, checks, seed: self.seed, level: self.level }
    }

    /// Claims and draws from the plan's directions, each turned to a random azimuth and nudged by up to a degree, and
    /// from below too where there is light.
    fn draw(&self, bsdf: &dyn Bsdf, plan: &Plan) -> Vec<(Claim, Tally)> {
        let mut rng = stream(self.seed, 10, 0);
        let mut views: Vec<DVec3> = plan
            .views
            .iter()
            .map(|degrees| direction((degrees + uniform(&mut rng)).to_radians(), TAU * uniform(&mut rng)))
            .collect();
        if is_two_faced(bsdf) {
            let below: Vec<DVec3> = views.iter().map(|view| flip(*view)).collect();
            views.extend(below);
        }
        views
            .into_par_iter()
            .enumerate()
            .map(|(i, wo)| {
                let claim = Claim::new(bsdf, wo);
                let tally = Tally::draw(bsdf, &claim, self.seed, 1000 + i as u64, plan.draws_per_block);
                (claim, tally)
            })
            .collect()
    }
}

/// Turns the p-values of a family of checks into verdicts at one family-wise level (Holm).
pub(crate) fn judge<'a>(checks: impl Iterator<Item = &'a mut Check>, level: f64) {
    let mut family: Vec<(&mut Check, f64)> =
        checks.filter_map(|check| check.p_value.map(|p_value| (check, p_value))).collect();
    let p_values: Vec<f64> = family.iter().map(|(_, p_value)| *p_value).collect();
    for ((check, _), (rejected, bound)) in family.iter_mut().zip(holm(&p_values, level)) {
        check.bound = bound;
        if rejected {
            check.outcome = Outcome::Fail;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Lambert, subject};

    #[test]
    fn lambert_passes_and_the_sheet_repeats_for_any_thread_count() {
        let lambert = Lambert::new(0.8).unwrap();
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Suite { effort: Effort::Quick, ..Suite::default() }.run(&lambert))
        };
        let (one, three) = (run(1), run(3));
        assert_eq!(one.outcome(), Outcome::Pass, "{one:#?}");
        for (a, b) in one.checks.iter().zip(&three.checks) {
            assert_eq!((a.statistic.to_bits(), a.p_value), (b.statistic.to_bits(), b.p_value), "{}", a.name);
        }
    }

    #[test]
    fn black_is_inconclusive_and_never_a_pass() {
        let black = subject::parse("lambert:rho=0").unwrap();
        let sheet = Suite { effort: Effort::Quick, ..Suite::default() }.run(&*black);
        assert_eq!(sheet.outcome(), Outcome::Inconclusive);
        for name in ["finite", "reciprocity", "energy_eye", "energy_light", "white_furnace", "convergence"] {
            assert_eq!(sheet.check(name).unwrap().outcome, Outcome::Inconclusive, "{name}");
        }
    }

    #[test]
    fn nothing_sampled_is_inconclusive() {
        #[derive(Debug)]
        struct Never;
        impl Bsdf for Never {
            fn eval(&self, _: DVec3, _: DVec3) -> crate::math::color::Rgb {
                crate::math::color::Rgb::grey(0.1)
            }
            fn sample(&self, _: DVec3, _: crate::bsdf::Uniforms) -> Option<crate::bsdf::BsdfSample> {
                None
            }
        }
        let sheet = Suite { effort: Effort::Quick, ..Suite::default() }.run(&Never);
        for name in ["pdf_mass", "chi2", "uniformity", "weight"] {
            assert_eq!(sheet.check(name).unwrap().outcome, Outcome::Inconclusive, "{name}");
        }
        assert_ne!(sheet.outcome(), Outcome::Pass);
    }

    #[test]
    fn a_check_without_an_object_says_so_when_asked_for() {
        let lambert = Lambert::new(0.8).unwrap();
        let suite = Suite { only: vec!["weak_white_furnace"], ..Suite::default() };
        assert_eq!(suite.run(&lambert).outcome(), Outcome::Inconclusive);
    }
}
