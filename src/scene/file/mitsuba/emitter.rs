//! Lights that are no surfaces.

use glam::{DAffine3, DMat3, DVec3};

use super::Context;
use super::colour::Role;
use super::document::NodeId;
use super::props::Props;
use super::texture::{self, Pixels};
use crate::math::color::Rgb;
use crate::scene::file::error::SceneError;
use crate::scene::light::{EnvironmentMap, Light};

const KNOWN: [&str; 6] = ["area (in a shape)", "constant", "directional", "envmap", "point", "spot"];

/// Adds the light `id` to the scene.
pub(super) fn add(context: &Context<'_>, id: NodeId) -> Result<(), SceneError> {
    let props = Props::new(context.document, id)?;
    // How often a light is sampled changes no mean.
    props.no_effect(&["sampling_weight"]);
    let colour = |name| Ok(props.colour(name, Role::Light, context.notes)?.unwrap_or(Rgb::WHITE));
    let light = match props.node.kind.as_str() {
        "constant" => Light::Constant { radiance: colour("radiance")? },
        "point" => {
            let to_world = props.transform("to_world")?;
            let position = match (props.vector("position")?, to_world) {
                (Some(_), Some(_)) => return Err(props.bad("position", "both", "either position or to_world")),
                (Some(position), None) => position,
                (None, to_world) => to_world.map_or(DVec3::ZERO, |map| map.translation),
            };
            Light::Point { position, intensity: colour("intensity")? }
        }
        "spot" => {
            let to_world = props.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
            let cutoff = props.float("cutoff_angle", 20.0)?;
            let beam = props.float("beam_width", 0.75 * cutoff)?;
            if !(cutoff > 0.0 && cutoff < 180.0) {
                return Err(props.bad("cutoff_angle", &cutoff.to_string(), "a number of degrees in (0, 180)"));
            }
            if !(beam >= 0.0 && beam <= cutoff) {
                return Err(props.bad("beam_width", &beam.to_string(), "a number of degrees from 0 to cutoff_angle"));
            }
            if props.object("texture")?.is_some() {
                let error = props.unsupported("texture", "a textured spot", "a spot without a texture");
                context.notes.unsupported(error, "its texture is ignored")?;
            }
            Light::Spot {
                position: to_world.translation,
                direction: direction(&props, to_world.transform_vector3(DVec3::Z))?,
                intensity: colour("intensity")?,
                beam: beam.to_radians(),
                cutoff: cutoff.to_radians(),
            }
        }
        "directional" => {
            let to_world = props.transform("to_world")?;
            let along = match (props.vector("direction")?, to_world) {
                (Some(_), Some(_)) => return Err(props.bad("direction", "both", "either direction or to_world")),
                (Some(along), None) => along,
                (None, to_world) => to_world.unwrap_or(DAffine3::IDENTITY).transform_vector3(DVec3::Z),
            };
            Light::Directional { direction: direction(&props, along)?, irradiance: colour("irradiance")? }
        }
        "envmap" => Light::Environment(environment(&props, context)?),
        _ => {
            context.notes.unsupported(props.unknown_kind(&KNOWN), "it is left out")?;
            return Ok(());
        }
    };
    props.finish(context.notes)?;
    context.lights.borrow_mut().push(light);
    Ok(())
}

fn environment(props: &Props<'_>, context: &Context<'_>) -> Result<EnvironmentMap, SceneError> {
    let Some(file) = props.string("filename")? else {
        return Err(props.missing("filename", "the name of an image"));
    };
    let path = context.document.find_file(props.node, file);
    let scale = props.float("scale", 1.0)?;
    if !(0.0..=f64::MAX).contains(&scale) {
        return Err(props.bad("scale", &scale.to_string(), "a number ≥ 0"));
    }
    let to_world = props.transform("to_world")?.map_or(DMat3::IDENTITY, |map| map.matrix3);
    // 1e-3: exporters write matrices with five digits.
    if !(to_world.transpose() * to_world).abs_diff_eq(DMat3::IDENTITY, 1e-3) {
        return Err(props.bad("to_world", "a map that distorts", "a rotation"));
    }
    props.no_effect(&["mis_compensation", "cache"]);
    let Pixels { rgb, width, height } = texture::read_pixels(props, &path, false)?;
    Ok(EnvironmentMap { pixels: rgb, width, height, to_world, scale })
}

fn direction(props: &Props<'_>, along: DVec3) -> Result<DVec3, SceneError> {
    along.try_normalize().ok_or_else(|| props.bad("direction", "0, 0, 0", "a vector that is not 0"))
}
