//! From a scene to its radiosities, in one call.

use std::time::Instant;

use super::RadiosityError;
use super::factors::enforce::{Enforce, Repair};
use super::factors::{self, MEMORY, Report, ViewFactors, Visibility};
use super::patches::{Fineness, Materials, Patches};
use super::solution::{Display, RadiositySolution};
use super::solve::{Method, Settings, Solved};
use super::surface_light::SurfaceLight;
use super::system::System;
use super::system::energy::Energy;
use crate::math::color::Rgb;
use crate::scene::Scene;

/// What is solved, and how.
#[derive(Debug)]
pub struct Radiosity {
    /// How fine the patches are.
    pub fineness: Fineness,
    /// Whether the patches are made finer where the light changes: begun with a third of them.
    pub adaptive: bool,
    /// What is taken for diffuse.
    pub materials: Materials,
    /// Where the view factors come from.
    pub factors: Box<dyn ViewFactors>,
    /// A law that they are made to obey.
    pub enforce: Option<Enforce>,
    /// The solver.
    pub method: Method,
    /// How far it goes.
    pub settings: Settings,
    /// The largest matrix \[bytes\].
    pub memory: u64,
}

/// An adaptive solution begins with one in so many of its patches.
const COARSER: usize = 3;

/// Number of patches where nothing is said.
pub const DEFAULT_PATCHES: usize = 2000;

impl Default for Radiosity {
    fn default() -> Self {
        Self {
            fineness: Fineness::Count(DEFAULT_PATCHES),
            adaptive: false,
            materials: Materials::Diffuse,
            factors: Box::new(Visibility::default()),
            enforce: None,
            method: Method::GaussSeidel,
            settings: Settings::default(),
            memory: MEMORY,
        }
    }
}

/// A solved scene.
#[derive(Debug)]
pub struct SolvedScene {
    /// The patches.
    pub patches: Patches,
    /// Their equations.
    pub system: System,
    /// Their radiosities, and how well the equations are solved.
    pub solved: Solved,
    /// H of every patch [W/m²].
    pub irradiance: Vec<Rgb>,
    /// What is known of the view factors.
    pub report: Report,
    /// By how much they were changed, if it was asked for.
    pub repair: Option<Repair>,
    /// Seconds for the patches, the view factors, and the equations.
    pub seconds: [f64; 3],
}

impl Radiosity {
    /// Solves the scene.
    pub fn solve(&self, scene: &Scene) -> Result<SolvedScene, RadiosityError> {
        if scene.emitters().has_others_than_surfaces() {
            return Err(RadiosityError::NotASurface);
        }
        let start = Instant::now();
        let patches = Patches::new(scene, self.fineness, self.materials)?;
        if !self.adaptive {
            return self.solve_for(scene, patches, start);
        }
        let wanted = patches.all().len();
        let mut patches = Patches::new(scene, Fineness::Count(wanted.div_ceil(COARSER)), self.materials)?;
        loop {
            let solved = self.solve_for(scene, patches, start)?;
            match solved.patches.refined(scene, self.materials, &solved.irradiance, wanted)? {
                Some(finer) => patches = finer,
                None => return Ok(solved),
            }
        }
    }

    /// Solves the scene in these patches, which were begun at `start`.
    fn solve_for(&self, scene: &Scene, patches: Patches, start: Instant) -> Result<SolvedScene, RadiosityError> {
        let cut = start.elapsed().as_secs_f64();
        let (matrix, report, repair) = factors::find(&*self.factors, scene, &patches, self.enforce, self.memory)?;
        let found = start.elapsed().as_secs_f64();
        let all = patches.all();
        let system = System::new(
            matrix,
            all.iter().map(|patch| patch.area).collect(),
            all.iter().map(|patch| patch.reflectance).collect(),
            all.iter().map(|patch| patch.emission).collect(),
        )?;
        let solved = self.method.solve(&system, self.settings)?;
        let irradiance = system.irradiance(&solved.radiosity);
        let seconds = [cut, found - cut, start.elapsed().as_secs_f64() - found];
        Ok(SolvedScene { patches, system, solved, irradiance, report, repair, seconds })
    }
}

impl SolvedScene {
    /// The light of each shape that has patches, in the order of the shapes.
    pub fn surfaces(&self) -> Vec<SurfaceLight> {
        SurfaceLight::of_all(&self.patches, &self.solved.radiosity, &self.irradiance)
    }

    /// The solution as light.
    pub fn shown(self, display: Display) -> RadiositySolution {
        RadiositySolution::new(self.patches, self.solved.radiosity, display)
    }

    /// Where the power goes.
    pub fn energy(&self) -> Energy {
        self.system.energy(&self.solved.radiosity)
    }
}
