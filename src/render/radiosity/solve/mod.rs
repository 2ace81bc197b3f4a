//! Solvers of the radiosity system, by name.
//!
//! | name | what it does | one iteration | cost of one |
//! |---|---|---|---|
//! | `dense` | LU of I − ρF, once for each distinct channel of ρ | the whole | 2/3 n³ |
//! | `jacobi` | B ← E + ρ F B: one more reflection | a product | 2 n² |
//! | `gauss-seidel` | the same with the newest B, patch by patch | a sweep | 2 n² |
//! | `cg` | conjugate gradients of the symmetrised system | a product | 2 n² |
//! | `southwell` | shoots the largest unshot power | a shot | 2 n |
//!
//! Costs are for one channel. All give the same bits for any number of threads.

mod conjugate_gradient;
mod dense;
mod gauss_seidel;
mod jacobi;
mod lu;
mod progress;
mod southwell;

#[cfg(test)]
mod networks;

use std::fmt;
use std::str::FromStr;

use super::system::System;
use crate::math::color::Rgb;

/// A way to solve the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// LU factors of the matrix.
    Dense,
    /// Jacobi, in the form that adds one reflection at a time.
    Jacobi,
    /// Gauss-Seidel.
    GaussSeidel,
    /// Conjugate gradients.
    ConjugateGradient,
    /// Southwell: progressive refinement.
    Southwell,
}

/// When to stop. Either way [`Solved`] brings the bound of the error that was reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stop {
    /// When the certified bound of the error is at most `tolerance` times the largest B: ‖r‖_∞ / (1 − max ρ) ≤ tolerance · max B.
    #[default]
    Certified,
    /// When the last iteration changed no B by more than `tolerance` times the largest E; `southwell` when the power yet to be
    /// shot is at most `tolerance` times the power emitted. What textbooks count by: the error may be larger by 1 / (1 − max ρ).
    Change,
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Above 0 and finite. `dense` does not iterate, and says only whether it is met.
    pub tolerance: f64,
    /// Iterations (of `southwell`: shots) after which a solver gives up.
    pub max_iterations: u64,
    /// `jacobi` alone: exactly so many reflections, and neither a tolerance nor a largest number of iterations.
    pub bounces: Option<u32>,
    /// What the tolerance is held against.
    pub stop: Stop,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 1_000_000, bounces: None, stop: Stop::Certified }
    }
}

/// A radiosity, and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// B of every patch [W/m²].
    pub radiosity: Vec<Rgb>,
    /// Iterations done; of `southwell` shots, of `dense` 1.
    pub iterations: u64,
    /// Whether the tolerance was met. With `bounces`, whether that many reflections happen to meet it.
    pub converged: bool,
    /// ‖E − (I − ρF) B‖_∞ of the radiosity returned, computed afresh.
    pub residual: f64,
    /// The largest error that B can have against the exact solution of the system, in any patch and channel [W/m²].
    pub certified_bound: f64,
    /// The residual after each iteration, by the solver's own account, which costs nothing and differs by roundings. Of
    /// `southwell` sparse: the largest unshot radiosity after every n-th shot and after the last.
    pub history: Vec<f64>,
}

/// What a solver was asked that it cannot do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// A tolerance that is none.
    #[error("the tolerance is {0}: a finite number above 0 is allowed")]
    Tolerance(f64),
    /// Only Jacobi's iterates are numbers of reflections.
    #[error("{0} cannot stop after {1} reflections: only jacobi adds them one at a time")]
    Bounces(Method, u32),
    /// A name that no method has.
    #[error("there is no solver {0:?}: dense, jacobi, gauss-seidel, cg and southwell are known")]
    UnknownMethod(String),
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 5] = [Self::Dense, Self::Jacobi, Self::GaussSeidel, Self::ConjugateGradient, Self::Southwell];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dense => "dense",
            Self::Jacobi => "jacobi",
            Self::GaussSeidel => "gauss-seidel",
            Self::ConjugateGradient => "cg",
            Self::Southwell => "southwell",
        }
    }

    /// Solves the system. Not to have converged is no error, but said in [`Solved::converged`].
    pub fn solve(self, system: &System, settings: Settings) -> Result<Solved, SolveError> {
        if !(settings.tolerance > 0.0 && settings.tolerance.is_finite()) {
            return Err(SolveError::Tolerance(settings.tolerance));
        }
        if let Some(bounces) = settings.bounces.filter(|_| self != Self::Jacobi) {
            return Err(SolveError::Bounces(self, bounces));
        }
        Ok(match self {
            Self::Dense => dense::solve(system, settings),
            Self::Jacobi => jacobi::solve(system, settings),
            Self::GaussSeidel => gauss_seidel::solve(system, settings),
            Self::ConjugateGradient => conjugate_gradient::solve(system, settings),
            Self::Southwell => southwell::solve(system, settings),
        })
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = SolveError;

    fn from_str(name: &str) -> Result<Self, SolveError> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| SolveError::UnknownMethod(name.to_string()))
    }
}
