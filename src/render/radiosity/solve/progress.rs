//! When an iteration may stop, the same for all solvers.

use super::super::system::{System, largest};
use super::{Settings, Solved, Stop};
use crate::math::color::Rgb;

/// What a solver claims after an iteration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim {
    /// The residual ‖E − (I − ρF) B‖_∞, or more.
    pub(super) residual: f64,
    /// What [`Stop::Change`] looks at, of the same unit as `scale`.
    pub(super) change: f64,
    /// What the change is small or large against.
    pub(super) scale: f64,
    /// The largest B.
    pub(super) largest: f64,
}

/// An iteration under way.
#[derive(Debug)]
pub(super) struct Progress<'a> {
    system: &'a System,
    settings: Settings,
    pub(super) iterations: u64,
    pub(super) history: Vec<f64>,
}

impl<'a> Progress<'a> {
    pub(super) fn new(system: &'a System, settings: Settings) -> Self {
        Self { system, settings, iterations: 0, history: Vec::new() }
    }

    /// One more iteration may be done, and makes sense: what is infinite or NaN stays so.
    pub(super) fn may_go_on(&self, claim: Claim) -> bool {
        self.iterations < self.settings.max_iterations && claim.residual.is_finite()
    }

    /// Whether the tolerance is met, as far as the claim goes: to be [confirmed](Self::confirms), which costs a product.
    pub(super) fn claims(&self, claim: Claim) -> bool {
        match self.settings.stop {
            Stop::Certified => self.certified(claim.residual, claim.largest),
            Stop::Change => claim.change <= self.settings.tolerance * claim.scale,
        }
    }

    /// Whether the residual, computed afresh, meets it too. A change is what it is.
    pub(super) fn confirms(&self, b: &[Rgb]) -> bool {
        self.settings.stop == Stop::Change || self.certified(self.system.residual(b), largest(b.iter().copied()))
    }

    fn certified(&self, residual: f64, largest: f64) -> bool {
        self.system.certified_bound(residual) <= self.settings.tolerance * largest
    }

    /// The end, whether or not the tolerance is met; where the changes were not `settled`, [`Stop::Change`] is not.
    pub(super) fn finish(self, radiosity: Vec<Rgb>, settled: bool) -> Solved {
        let residual = self.system.residual(&radiosity);
        let converged = match self.settings.stop {
            Stop::Certified => self.certified(residual, largest(radiosity.iter().copied())),
            Stop::Change => settled,
        };
        Solved {
            converged,
            residual,
            certified_bound: self.system.certified_bound(residual),
            iterations: self.iterations,
            history: self.history,
            radiosity,
        }
    }
}
