//! Furnace tests of a path tracer: scenes whose answer is known, and laws that hold in any scene.
//!
//! Two kinds of sheets. [`Furnace::path_tracer`] puts an engine, anything that makes an estimator from the settings of a
//! [`PathTracer`], through closed rooms, swaps of eye and light, and what is known of its spread. [`Furnace::subjects`]
//! is the bridge from BRDFs to images: a convex surface of the model in constant light of radiance 1, of which every
//! pixel is the directional albedo, which the hemisphere integrator knows without sampling.
//!
//! All p-values of a run share one family-wise level (Holm).

pub mod broken;

mod agreement;
mod compare;
mod convex;
mod emitter;
mod energy;
mod rate;
mod reciprocity;
mod rooms;
mod roulette;

use std::sync::Arc;

use rayon::prelude::*;

use super::Radiance;
use super::path::PathTracer;
use crate::bsdf::Bsdf;
use crate::validate::{Check, Sheet, judge};

use compare::Plan;

/// Makes an estimator from settings: [`PathTracer`] itself, or what claims to do the same.
pub type Engine<'a> = dyn Fn(PathTracer) -> Box<dyn Radiance> + Sync + 'a;

/// The checks of an engine by name, with what they ask, in the order of the sheet.
pub const ENGINE_CHECKS: &[(&str, &str)] = &[
    ("furnace_exact", "does every path of a uniform furnace bring e (1 + ρ + … + ρ^r), to the last digit?"),
    ("furnace_mean", "is the mean the same with every strategy, number of reflections, roulette and split?"),
    ("one_emitter", "are the faces of a cube as bright as they must be where only one emits?"),
    ("one_sided", "does light leave only the outside of an emitter?"),
    ("strategies", "do all strategies agree where nothing is known in closed form?"),
    ("transport_reciprocity", "may eye and light be swapped?"),
    ("rate", "does the error fall as N^(-1/2)?"),
    ("roulette_variance", "does roulette leave the variance finite?"),
];

/// The checks of a subject by name, with what they ask: each with one strategy.
pub const SUBJECT_CHECKS: &[(&str, &str)] = &[
    ("albedo_bsdf", "is a sphere in constant light as bright as the albedo, by BSDF sampling?"),
    ("albedo_direct", "the same by light sampling?"),
    ("albedo_mis", "the same by both, weighted?"),
    ("albedo_random", "the same by a connection at a random bounce?"),
];

/// The settings of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Furnace {
    /// Seed of every random number.
    pub seed: u64,
    /// Family-wise level: the probability that anything correct fails anywhere in the run.
    pub level: f64,
    /// Samples of each estimate.
    pub samples: u64,
    /// Names of the checks to run; empty for all.
    pub only: Vec<&'static str>,
}

impl Default for Furnace {
    fn default() -> Self {
        Self { seed: 1, level: 0.01, samples: 16384, only: Vec::new() }
    }
}

impl Furnace {
    /// The sheet of an engine.
    pub fn path_tracer(&self, engine: &Engine) -> Sheet {
        self.path_tracer_reporting(engine, &|_| {})
    }

    /// The sheet of an engine; calls `progress` with the name of each check as it ends.
    pub fn path_tracer_reporting(&self, engine: &Engine, progress: &(dyn Fn(&'static str) + Sync)) -> Sheet {
        let names = self.wanted(ENGINE_CHECKS);
        let plan = self.plan(names.len());
        let check = |&name: &&'static str| {
            let check = match name {
                "furnace_exact" => energy::exact(engine, &plan),
                "furnace_mean" => energy::mean(engine, &plan),
                "one_emitter" => emitter::cube(engine, &plan),
                "one_sided" => emitter::one_sided(engine, &plan),
                "strategies" => agreement::check(engine, &plan),
                "transport_reciprocity" => reciprocity::check(engine, &plan),
                "rate" => rate::check(engine, &plan),
                _ => roulette::check(engine, &plan),
            };
            progress(name);
            check
        };
        let mut checks: Vec<Check> = names.iter().map(check).collect();
        judge(checks.iter_mut(), self.level);
        self.sheet("path tracer".into(), checks)
    }

    /// A sheet for each model, all judged together.
    pub fn subjects(&self, models: &[Arc<dyn Bsdf>]) -> Vec<Sheet> {
        self.subjects_reporting(models, &|_| {})
    }

    /// The same; calls `progress` with the number of each model as it ends.
    pub fn subjects_reporting(&self, models: &[Arc<dyn Bsdf>], progress: &(dyn Fn(usize) + Sync)) -> Vec<Sheet> {
        let names = self.wanted(SUBJECT_CHECKS);
        let plan = self.plan(names.len() * models.len());
        let one = |(at, model): (usize, &Arc<dyn Bsdf>)| {
            let checks = convex::checks(model, &names, !self.only.is_empty(), at as u64, &plan);
            progress(at);
            self.sheet(format!("{model:?}").chars().take(200).collect(), checks)
        };
        let mut sheets: Vec<Sheet> = models.par_iter().enumerate().map(one).collect();
        judge(sheets.iter_mut().flat_map(|sheet| &mut sheet.checks), self.level);
        sheets
    }

    fn sheet(&self, subject: String, checks: Vec<Check>) -> Sheet {
        Sheet { subject, checks, seed: self.seed, level: self.level }
    }

    fn wanted(&self, known: &[(&'static str, &str)]) -> Vec<&'static str> {
        let names = known.iter().map(|(name, _)| *name);
        names.filter(|name| self.only.is_empty() || self.only.contains(name)).collect()
    }

    fn plan(&self, checks: usize) -> Plan {
        Plan { seed: self.seed, samples: self.samples.max(1), share: self.level / checks.max(1) as f64 }
    }
}
