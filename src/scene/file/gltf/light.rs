//! The lights of KHR_lights_punctual.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DAffine3, DVec3};

use super::json;
use crate::math::color::Rgb;
use crate::scene::file::Notes;
use crate::scene::file::error::{Place, SceneError, quoted};
use crate::scene::light::Light;

/// The light at `to_world`, where it shines along −z.
pub(super) fn light(
    light: &json::Light,
    to_world: DAffine3,
    place: &Place,
    notes: &Notes,
) -> Result<Option<Light>, SceneError> {
    let bad = |what: &str, given: String, allowed: &str| SceneError::Value {
        place: place.clone(),
        what: format!("{what} of its light"),
        given,
        allowed: allowed.into(),
    };
    let colour = Rgb::from(light.color.unwrap_or([1.0; 3])) * light.intensity.unwrap_or(1.0);
    if !(colour.is_finite() && colour.min_channel() >= 0.0) {
        return Err(bad("color × intensity", colour.to_string(), "finite numbers ≥ 0"));
    }
    if light.range.is_some() {
        notes.warn(format!("{place}: the range of its light is not used: light falls off with the square of distance"));
    }
    let position = to_world.translation;
    let direction = to_world.transform_vector3(-DVec3::Z).try_normalize();
    let direction = || direction.ok_or_else(|| bad("direction", "0, 0, 0".into(), "a node that keeps the z axis"));
    Ok(Some(match light.kind.as_str() {
        "point" => Light::Point { position, intensity: colour },
        "directional" => Light::Directional { direction: direction()?, irradiance: colour },
        "spot" => {
            let cutoff = light.spot.outer_cone_angle.unwrap_or(FRAC_PI_4);
            let beam = light.spot.inner_cone_angle.unwrap_or(0.0);
            if !(beam >= 0.0 && beam <= cutoff && cutoff > 0.0 && cutoff <= FRAC_PI_2) {
                let given = format!("{beam} and {cutoff}");
                return Err(bad("innerConeAngle and outerConeAngle", given, "0 ≤ inner ≤ outer ≤ π/2, outer > 0"));
            }
            notes.warn(format!("{place}: between its cones the light falls linearly with the angle"));
            Light::Spot { position, direction: direction()?, intensity: colour, beam, cutoff }
        }
        other => {
            let what = format!("a light of type {}", quoted(other));
            let (place, known) = (place.clone(), "point, directional, spot".to_string());
            notes.unsupported(SceneError::Unsupported { place, what, known }, "it is left out")?;
            return Ok(None);
        }
    }))
}
