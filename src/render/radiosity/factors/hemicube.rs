//! View factors by hemicubes: pictures of the scene from a few points of each patch.

use std::f64::consts::TAU;

use glam::DVec2;

use super::closed::polygons;
use super::fill::by_rows;
use super::{Found, ViewFactors};
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::form::hemicube;
use crate::render::radiosity::patches::Patches;
use crate::sampling::stream::{stream, uniform};
use crate::scene::Scene;

/// Hemicubes along each side of a patch.
const ACROSS: u32 = 2;

/// Hemicubes at the centres of the quarters of a patch, each turned at random.
///
/// The error of a row is judged by one more at the centre, whose own error is four times as large where the factors are
/// smooth: it holds what cells blur and what varies over the patch.
#[derive(Clone, Copy, Debug)]
pub struct Hemicube {
    /// Cells along the side of a cube's top; odd numbers are raised by one.
    pub resolution: u16,
    /// Seed of the turns.
    pub seed: u64,
}

impl Default for Hemicube {
    fn default() -> Self {
        Self { resolution: 256, seed: 1 }
    }
}

impl ViewFactors for Hemicube {
    fn name(&self) -> &'static str {
        "hemicube"
    }

    fn find(&self, _: &Scene, patches: &Patches) -> Result<Found, RadiosityError> {
        let polygons = polygons(patches, self.name())?;
        let empty = hemicube::Hemicube::new(usize::from(self.resolution).next_multiple_of(2));
        let empty =
            empty.map_err(|error| RadiosityError::NotApplicable { method: self.name(), reason: error.to_string() })?;
        Ok(by_rows(patches, |i, row| {
            let mut cube = empty.clone();
            let mut look = |u: DVec2, number: u64, shares: &mut [f64]| {
                let (eye, normal) = patches.all()[i].form.at(u);
                let turn = TAU * uniform(&mut stream(self.seed, i as u64, number));
                // What has another side is seen from there as that.
                let seen = polygons.iter().enumerate().filter(|(j, polygon)| {
                    *j != i && (polygon.distance_above(eye) > 0.0 || !patches.has_other_side(*j))
                });
                let _ = cube.shares((eye, normal, turn), seen.map(|(j, polygon)| (j as u32, *polygon)), shares);
            };
            for at in 0..ACROSS * ACROSS {
                let u = (DVec2::new(f64::from(at % ACROSS), f64::from(at / ACROSS)) + 0.5) / f64::from(ACROSS);
                look(u, at.into(), row);
            }
            let mut judge = vec![0.0; row.len()];
            look(DVec2::splat(0.5), (ACROSS * ACROSS).into(), &mut judge);
            let mut squares = 0.0;
            for (value, centre) in row.iter_mut().zip(&judge) {
                *value /= f64::from(ACROSS * ACROSS);
                squares += ((*value - centre) / 3.0).powi(2);
            }
            (squares / row.len() as f64).sqrt()
        }))
    }
}
