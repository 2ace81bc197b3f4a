//! The light of whole shapes.

use super::patches::Patches;
use crate::math::color::Rgb;

/// The light of a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLight {
    /// Its name.
    pub name: String,
    /// Its area, of all sides that are not black and nothing covers \[m²\].
    pub area: f64,
    /// Its mean radiosity [W/m²].
    pub radiosity: Rgb,
    /// Its mean irradiance [W/m²].
    pub irradiance: Rgb,
}

impl SurfaceLight {
    /// That of each shape that has patches, in the order of the shapes, from B and H of every patch [W/m²].
    pub(super) fn of_all(patches: &Patches, radiosity: &[Rgb], irradiance: &[Rgb]) -> Vec<Self> {
        let names = patches.shapes();
        let mut sums = vec![(0.0, Rgb::BLACK, Rgb::BLACK); names.len()];
        for ((patch, &b), &h) in patches.all().iter().zip(radiosity).zip(irradiance) {
            let sum = &mut sums[patch.shape];
            sum.0 += patch.area;
            sum.1 += b * patch.area;
            sum.2 += h * patch.area;
        }
        let each = names.iter().zip(sums).filter(|(_, (area, ..))| *area > 0.0);
        each.map(|(name, (area, b, h))| Self { name: name.clone(), area, radiosity: b / area, irradiance: h / area })
            .collect()
    }
}
