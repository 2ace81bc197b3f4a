//! A solved scene, whichever way it was solved.

use super::args::{RadiosityArgs, Solver};
use crate::math::color::Rgb;
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::hierarchical::{Hierarchical, HierarchicalSolution};
use crate::render::radiosity::model::{DEFAULT_PATCHES, Radiosity, SolvedScene};
use crate::render::radiosity::patches::Patches;
use crate::render::radiosity::solution::{Display, RadiositySolution};
use crate::render::radiosity::solve::{Settings, Solved};
use crate::render::radiosity::surface_light::SurfaceLight;
use crate::render::radiosity::system::energy::Energy;
use crate::scene::Scene;

#[derive(Debug)]
pub(super) enum Answer {
    Matrix(Box<SolvedScene>),
    Hierarchical(Box<HierarchicalSolution>),
}

impl Answer {
    pub(super) fn of(args: &RadiosityArgs, scene: &Scene) -> Result<Self, RadiosityError> {
        let fineness = args.mesh.fineness(DEFAULT_PATCHES);
        let materials = args.mesh.materials();
        let memory = args.factors.memory();
        match args.solver() {
            Solver::Matrix(method) => {
                let model = Radiosity {
                    fineness,
                    adaptive: args.adaptive,
                    materials,
                    factors: args.factors.method(args.view_factors()),
                    enforce: args.factors.enforce(),
                    method,
                    settings: Settings { tolerance: args.tol, bounces: args.bounces, ..Settings::default() },
                    memory,
                };
                Ok(Self::Matrix(Box::new(model.solve(scene)?)))
            }
            Solver::Hierarchical => {
                let model = Hierarchical {
                    fineness,
                    materials,
                    error: args.error.unwrap_or(Hierarchical::default().error),
                    seed: args.factors.seed,
                    tolerance: args.tol,
                    bounces: args.bounces,
                    memory,
                    ..Hierarchical::default()
                };
                Ok(Self::Hierarchical(Box::new(model.solve(scene)?)))
            }
        }
    }

    pub(super) fn patches(&self) -> &Patches {
        match self {
            Self::Matrix(found) => &found.patches,
            Self::Hierarchical(found) => &found.patches,
        }
    }

    pub(super) fn solved(&self) -> &Solved {
        match self {
            Self::Matrix(found) => &found.solved,
            Self::Hierarchical(found) => &found.solved,
        }
    }

    pub(super) fn irradiance(&self) -> &[Rgb] {
        match self {
            Self::Matrix(found) => &found.irradiance,
            Self::Hierarchical(found) => &found.irradiance,
        }
    }

    pub(super) fn surfaces(&self) -> Vec<SurfaceLight> {
        match self {
            Self::Matrix(found) => found.surfaces(),
            Self::Hierarchical(found) => found.surfaces(),
        }
    }

    pub(super) fn energy(&self) -> Energy {
        match self {
            Self::Matrix(found) => found.energy(),
            Self::Hierarchical(found) => found.energy,
        }
    }

    /// For the patches, the view factors or links, and the equations.
    pub(super) fn seconds(&self) -> [f64; 3] {
        match self {
            Self::Matrix(found) => found.seconds,
            Self::Hierarchical(found) => found.seconds,
        }
    }

    pub(super) fn shown(self, display: Display) -> RadiositySolution {
        match self {
            Self::Matrix(found) => found.shown(display),
            Self::Hierarchical(found) => found.shown(display),
        }
    }

    /// Whether it is as good as was asked for. So many reflections exactly have no tolerance.
    pub(super) fn is_reached(&self, bounces: Option<u32>) -> bool {
        let solved = bounces.is_some() || self.solved().converged;
        match self {
            Self::Matrix(_) => solved,
            Self::Hierarchical(found) => solved && found.statistics.estimated_error <= found.statistics.error,
        }
    }
}
