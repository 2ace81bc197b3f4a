//! Metals, smooth and rough.

use super::super::Context;
use super::super::colour::Role;
use super::super::props::Props;
use super::super::texture;
use super::{Model, refused, textured};
use crate::bsdf::{Beckmann, Fresnel, Ggx, Masking, ParamError, SpecularReflector, ior};
use crate::math::color::Rgb;
use crate::scene::file::error::{SceneError, listed, quoted};
use crate::scene::texture::Texture;

/// The smallest index of refraction that models take. Spectra out of gamut have channels of 0, where F is 1 as it is here
/// to 0.4 %.
const LEAST_ETA: f64 = 1e-3;

pub(super) fn smooth(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let fresnel = fresnel(context, props)?;
    let tint = texture::find(context, props, "specular_reflectance", Role::Reflectance, 1.0)?;
    textured::model(vec![tint], move |values| Ok(Box::new(SpecularReflector::new(fresnel)?.with_tint(values.unit(0))?)))
        .map_err(refused(props))
}

pub(super) fn rough(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let fresnel = fresnel(context, props)?;
    let tint = texture::find(context, props, "specular_reflectance", Role::Reflectance, 1.0)?;
    let alphas = alphas(context, props)?;
    let ggx = distribution(props)?;
    if let (true, [Texture::Constant(u), Texture::Constant(v)], Texture::Constant(tint)) = (ggx, &alphas, &tint) {
        let model = Ggx::anisotropic(u.0.x, v.0.x).map(|ggx| ggx.with_masking(Masking::Separable));
        let model = model.and_then(|ggx| ggx.with_fresnel(fresnel)).and_then(|ggx| ggx.with_tint(*tint));
        return model.map(Model::Ggx).map_err(refused(props));
    }
    let [u, v] = alphas;
    textured::model(vec![u, v, tint], move |values| {
        let (u, v, tint) = (values.alpha(0), values.alpha(1), values.unit(2));
        Ok(if ggx {
            Box::new(Ggx::anisotropic(u, v)?.with_masking(Masking::Separable).with_fresnel(fresnel)?.with_tint(tint)?)
        } else {
            let model = Beckmann::anisotropic(u, v)?.with_masking(Masking::Separable).with_fresnel(fresnel)?;
            Box::new(model.with_tint(tint)?)
        })
    })
    .map_err(refused(props))
}

/// The slope widths along u and v. Constants are checked: textures are clamped where they are read.
pub(super) fn alphas(context: &Context<'_>, props: &Props<'_>) -> Result<[Texture; 2], SceneError> {
    let common = texture::find(context, props, "alpha", Role::Index, 0.1)?;
    let own = |name| Ok(texture::optional(context, props, name, Role::Index)?.unwrap_or_else(|| common.clone()));
    let alphas = [own("alpha_u")?, own("alpha_v")?];
    props.no_effect(&["sample_visible"]);
    for alpha in &alphas {
        if let Texture::Constant(alpha) = alpha {
            Beckmann::new(alpha.0.x).map_err(|e: ParamError| refused(props)(e))?;
        }
    }
    Ok(alphas)
}

/// Whether the distribution of normals is GGX, and not Beckmann's.
pub(super) fn distribution(props: &Props<'_>) -> Result<bool, SceneError> {
    Ok(props.word("distribution", &["beckmann", "ggx"])? == "ggx")
}

/// The reflectance of a named material, or of eta and k.
fn fresnel(context: &Context<'_>, props: &Props<'_>) -> Result<Fresnel, SceneError> {
    let name = props.string("material")?;
    let eta = props.colour("eta", Role::Index, context.notes)?;
    let k = props.colour("k", Role::Index, context.notes)?;
    // What lies above the metal divides both.
    let above = props.positive("ext_eta", 1.0)?;
    let relative = |eta: Rgb, k: Rgb| Fresnel::Conductor { eta: (eta / above).map(|x| x.max(LEAST_ETA)), k: k / above };
    match (eta, k, name) {
        (None, None, None) => Ok(Fresnel::MIRROR),
        // An index of 0 reflects everything: Mitsuba's own way to spell a mirror.
        (Some(eta), Some(_), None) if eta.is_black() => Ok(Fresnel::MIRROR),
        (Some(eta), Some(k), None) => Ok(relative(eta, k)),
        (None, None, Some(name)) => match ior::metal(name) {
            Some(Fresnel::Conductor { eta, k }) => Ok(relative(eta, k)),
            Some(other) => Ok(other),
            None => {
                let known = listed(ior::metal_names());
                let error = props.unsupported("material", format!("the material {}", quoted(name)), &known);
                context.notes.unsupported(error, "a perfect mirror takes its place")?;
                Ok(Fresnel::MIRROR)
            }
        },
        (_, _, Some(name)) => Err(props.bad("material", name, "either a material or eta and k")),
        _ => Err(props.missing("eta or k", "both, or neither")),
    }
}
