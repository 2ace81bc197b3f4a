//! What became of the light: counts and fluxes of all photons, and of each surface.

use crate::math::color::Rgb;
use crate::math::sum::Moments;

/// The light of one shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShapeTally {
    /// Arrivals of photons.
    pub hits: u64,
    /// What arrived \[W\].
    pub incident: Rgb,
    /// What arrived straight from the lights \[W\].
    pub first: Rgb,
    /// What did not leave \[W\].
    pub absorbed: Rgb,
}

/// The light of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Photons emitted.
    pub emitted: u64,
    /// Photons that left the scene.
    pub escaped: u64,
    /// Photons that ended at a surface.
    pub absorbed: u64,
    /// Photons kept, whatever the map.
    pub stored: u64,
    /// What was emitted \[W\].
    pub emitted_flux: Rgb,
    /// What left the scene \[W\].
    pub escaped_flux: Rgb,
    /// What did not leave a surface \[W\]; with [`Self::escaped_flux`] it is what was emitted, but for rounding. In one channel it
    /// may be below 0 at a surface that photons happen to leave with more than they brought: the mean is not.
    pub absorbed_flux: Rgb,
    /// Arrivals at surfaces of each photon.
    pub hits: Moments,
    /// By number of shape.
    pub shapes: Vec<ShapeTally>,
}

impl Tally {
    /// Of a scene with so many shapes, before the first photon.
    pub(super) fn new(shapes: usize) -> Self {
        Self { shapes: vec![ShapeTally::default(); shapes], ..Self::default() }
    }

    /// Adds those of other photons, which came later.
    pub(super) fn add(&mut self, later: &Self) {
        self.emitted += later.emitted;
        self.escaped += later.escaped;
        self.absorbed += later.absorbed;
        self.stored += later.stored;
        self.emitted_flux += later.emitted_flux;
        self.escaped_flux += later.escaped_flux;
        self.absorbed_flux += later.absorbed_flux;
        self.hits = self.hits.merge(&later.hits);
        for (shape, more) in self.shapes.iter_mut().zip(&later.shapes) {
            shape.hits += more.hits;
            shape.incident += more.incident;
            shape.first += more.first;
            shape.absorbed += more.absorbed;
        }
    }

    /// The same light, shared by all photons that were emitted.
    pub(super) fn scaled(mut self, by: f64) -> Self {
        for flux in [&mut self.emitted_flux, &mut self.escaped_flux, &mut self.absorbed_flux] {
            *flux = *flux * by;
        }
        for shape in &mut self.shapes {
            for flux in [&mut shape.incident, &mut shape.first, &mut shape.absorbed] {
                *flux = *flux * by;
            }
        }
        self
    }

    /// Emitted less absorbed less escaped \[W\]: 0 but for rounding.
    pub fn missing(&self) -> Rgb {
        self.emitted_flux - self.absorbed_flux - self.escaped_flux
    }
}
