//! View factors by projection onto the hemisphere of a point: the lecture's, exact at the point, averaged over the patch.

use glam::DVec2;

use super::closed::polygons;
use super::fill::by_rows;
use super::{Found, ViewFactors};
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::form::point;
use crate::render::radiosity::patches::Patches;
use crate::render::radiosity::polygon::Polygon;
use crate::sampling::stream::{stream, uniform};
use crate::scene::Scene;

/// Lambert's formula at the centres of equal parts of each patch. One ray from each of them decides whether a target is
/// hidden.
///
/// With a single point it is wrong by the variation over the patch, which neither closure nor reciprocity shows.
#[derive(Clone, Copy, Debug)]
pub struct Points {
    /// Points along each side of a patch, at least 1.
    pub across: u32,
    /// Seed of the rays' ends.
    pub seed: u64,
}

impl Default for Points {
    fn default() -> Self {
        Self { across: 4, seed: 1 }
    }
}

impl ViewFactors for Points {
    fn name(&self) -> &'static str {
        "point"
    }

    /// The error of a row is judged by half as many points along each side, whose own error is four times as large where the
    /// factors are smooth. A single point cannot judge itself: its error is unknown.
    fn find(&self, scene: &Scene, patches: &Patches) -> Result<Found, RadiosityError> {
        let polygons = polygons(patches, self.name())?;
        let across = self.across.max(1);
        let coarse = across / 2;
        Ok(by_rows(patches, |i, row| {
            self.project(scene, patches, &polygons, i, across, row);
            if coarse == 0 {
                return f64::NAN;
            }
            let mut judge = vec![0.0; row.len()];
            self.project(scene, patches, &polygons, i, coarse, &mut judge);
            let share = 1.0 / (f64::from(across * across) / f64::from(coarse * coarse) - 1.0);
            let squares: f64 = row.iter().zip(&judge).map(|(fine, coarse)| (share * (fine - coarse)).powi(2)).sum();
            (squares / row.len() as f64).sqrt()
        }))
    }
}

impl Points {
    /// The factors of patch `i` by so many points along each side.
    fn project(&self, scene: &Scene, patches: &Patches, polygons: &[&Polygon], i: usize, across: u32, row: &mut [f64]) {
        for at in 0..across * across {
            let u = (DVec2::new(f64::from(at % across), f64::from(at / across)) + 0.5) / f64::from(across);
            let (p, normal) = patches.all()[i].form.at(u);
            let mut rng = stream(self.seed, i as u64, u64::from(across) << 32 | u64::from(at));
            for (j, polygon) in polygons.iter().enumerate() {
                let factor = point::factor(p, normal, polygon);
                if factor > 0.0 {
                    let v = DVec2::new(uniform(&mut rng), uniform(&mut rng));
                    if scene.sees((p, normal), patches.all()[j].form.at(v)) {
                        row[j] += factor / f64::from(across * across);
                    }
                }
            }
        }
    }
}
