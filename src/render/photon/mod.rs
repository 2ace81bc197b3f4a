//! Photon mapping: light is carried from the emitters to the surfaces, kept where it arrives, and its density estimated
//! where it is seen.
//!
//! [`Shooting`](shoot::Shooting) sends photons out, [`PhotonMap`](map::PhotonMap) keeps them sorted, a [`Gather`](map::Gather)
//! says how the density at a point is estimated. [`DirectView`](view::DirectView) shows the map itself,
//! [`FinalGather`](gather::FinalGather) uses it for light that is reflected twice and more, [`Sppm`](progressive::Sppm) makes
//! a new one for every sample of the image. [`stated`] tells what a map is wrong by.
//!
//! The density is irradiance E \[W/m²\]: E ≈ Σ w(r_i² / r²) Φ_i / (π r²), with the fluxes Φ_i of the photons within r and a
//! kernel w whose mean over the disk is 1. See [`kernel`] for the kernels, their bias and their variance.
//! # References
//! - Jensen 2001, Realistic image synthesis using photon mapping, A K Peters
//! - Veach 1997, Robust Monte Carlo methods for light transport simulation, thesis, §5.3 (shading normals of light paths)

pub mod area;
pub mod gather;
pub mod grid;
pub mod kernel;
pub mod map;
pub mod nearest;
pub mod progressive;
pub mod shoot;
pub mod stated;
pub mod stores;
pub mod tally;
pub mod tree;
pub mod view;

mod disk;
mod error;
#[cfg(test)]
mod tests;
mod visible;

pub use error::PhotonError;

use glam::DVec3;

use crate::math::color::Rgb;

/// Light that has arrived at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where.
    pub p: DVec3,
    /// Unit vector to where it came from.
    pub wi: DVec3,
    /// Unit normal of the geometry, on the side from which it came.
    pub n: DVec3,
    /// What it carries \[W\]; at a masked surface what it would if the mask were opaque.
    pub flux: Rgb,
    /// 1 / η² of the medium in which it arrived, with the index η relative to that at the light: flux times this is in the
    /// units of basic radiance, which paths carry.
    pub basic: f64,
    /// Number of the shape.
    pub shape: u32,
    /// How often it had been scattered before.
    pub bounces: u32,
    /// Where it had been.
    pub history: History,
}

/// Where a photon had been before it arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum History {
    /// Nowhere: it came from the light.
    Direct,
    /// At mirrors, glass and other Dirac lobes alone: L S⁺ D.
    Caustic,
    /// At a surface without, at least once.
    Indirect,
}

/// Which photons are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kept {
    /// All.
    #[default]
    Global,
    /// [`History::Caustic`].
    Caustic,
    /// [`History::Indirect`].
    Indirect,
    /// All but [`History::Direct`].
    Scattered,
}

impl Kept {
    /// The name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Global => "global",
            Self::Caustic => "caustic",
            Self::Indirect => "indirect",
            Self::Scattered => "scattered",
        }
    }

    /// Whether a photon of this history is one.
    pub fn holds(self, history: History) -> bool {
        match self {
            Self::Global => true,
            Self::Caustic => history == History::Caustic,
            Self::Indirect => history == History::Indirect,
            Self::Scattered => history != History::Direct,
        }
    }
}
