//! View factors in closed form, with nothing in between: of rectangles, and by contours.

use super::fill::by_pairs;
use super::{Found, ViewFactors};
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::form::contour;
use crate::render::radiosity::form::rectangles::{self, Rectangle};
use crate::render::radiosity::patches::Patches;
use crate::render::radiosity::polygon::Polygon;
use crate::scene::Scene;

/// Closed form of rectangles whose sides follow one frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rectangles;

/// Contour integral of plane patches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contour;

impl ViewFactors for Rectangles {
    fn name(&self) -> &'static str {
        "rectangles"
    }

    fn sees_what_is_between(&self) -> bool {
        false
    }

    fn find(&self, _: &Scene, patches: &Patches) -> Result<Found, RadiosityError> {
        let refuse = |reason: String| RadiosityError::NotApplicable { method: self.name(), reason };
        let shape = |patch: usize| &patches.shapes()[patches.all()[patch].shape];
        let each = patches.all().iter().enumerate().map(|(i, patch)| {
            let rectangle = patch.form.polygon().and_then(Rectangle::of);
            rectangle.ok_or_else(|| {
                refuse(format!("patch {i} of shape {} is no rectangle; allowed are rectangles", shape(i)))
            })
        });
        let rectangles = each.collect::<Result<Vec<_>, _>>()?;
        for j in 1..rectangles.len() {
            // Frames are transitive: what fits the first fits all.
            if rectangles::exchange(&rectangles[0], &rectangles[j]).is_none() {
                return Err(refuse(format!(
                    "patch {j} of shape {} is turned against patch 0 of shape {}; allowed are rectangles whose sides follow \
                     one frame",
                    shape(j),
                    shape(0)
                )));
            }
        }
        Ok(by_pairs(patches, |i, j| {
            if i == j {
                return (0.0, 0.0);
            }
            let (a, b) = (&rectangles[i], &rectangles[j]);
            let reach = patches.extent();
            (rectangles::exchange(a, b).unwrap_or(0.0).max(0.0), rectangles::ERROR * reach * reach)
        }))
    }
}

impl ViewFactors for Contour {
    fn name(&self) -> &'static str {
        "contour"
    }

    fn sees_what_is_between(&self) -> bool {
        false
    }

    fn find(&self, _: &Scene, patches: &Patches) -> Result<Found, RadiosityError> {
        let polygons = polygons(patches, self.name())?;
        Ok(by_pairs(patches, |i, j| {
            if i == j {
                return (0.0, 0.0);
            }
            let exchange = contour::exchange(polygons[i], polygons[j]);
            (exchange, CONTOUR_ERROR * exchange)
        }))
    }
}

/// The relative error of a contour integral.
const CONTOUR_ERROR: f64 = 1e-12;

/// The polygons of all patches, if all are plane.
pub(super) fn polygons<'p>(patches: &'p Patches, method: &'static str) -> Result<Vec<&'p Polygon>, RadiosityError> {
    let each = patches.all().iter().enumerate().map(|(i, patch)| {
        patch.form.polygon().ok_or_else(|| RadiosityError::NotApplicable {
            method,
            reason: format!(
                "patch {i} of shape {} is curved; allowed are plane patches, or one of the methods monte-carlo and visibility",
                patches.shapes()[patch.shape]
            ),
        })
    });
    each.collect()
}
