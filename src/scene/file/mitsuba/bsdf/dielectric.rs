//! Glass: smooth, thin and rough.

use super::super::Context;
use super::super::colour::Role;
use super::super::props::Props;
use super::super::texture;
use super::metal::{alphas, distribution};
use super::{Model, refused, textured};
use crate::bsdf::microfacet::RoughDielectric;
use crate::bsdf::{BeckmannNormals, Dielectric, GgxNormals, Masking, ThinDielectric, ior};
use crate::scene::file::error::{SceneError, listed, quoted};
use crate::scene::texture::Texture;

pub(super) fn smooth(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let eta = relative_index(props, "bk7")?;
    textured::model(tints(context, props)?.into(), move |values| {
        Ok(Box::new(Dielectric::new(eta)?.with_tints(values.unit(0), values.unit(1))?))
    })
    .map_err(refused(props))
}

pub(super) fn thin(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let eta = relative_index(props, "bk7")?;
    textured::model(tints(context, props)?.into(), move |values| {
        Ok(Box::new(ThinDielectric::new(eta)?.with_tints(values.unit(0), values.unit(1))?))
    })
    .map_err(refused(props))
}

pub(super) fn rough(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let eta = relative_index(props, "bk7")?;
    let ggx = distribution(props)?;
    let ([reflect, transmit], [u, v]) = (tints(context, props)?, alphas(context, props)?);
    textured::model(vec![reflect, transmit, u, v], move |values| {
        let (reflect, transmit, u, v) = (values.unit(0), values.unit(1), values.alpha(2), values.alpha(3));
        Ok(if ggx {
            let model = RoughDielectric::from_normals(GgxNormals::new(u, v)?, eta)?.with_masking(Masking::Separable);
            Box::new(model.with_tints(reflect, transmit)?)
        } else {
            let model = RoughDielectric::from_normals(BeckmannNormals::new(u, v)?, eta)?;
            Box::new(model.with_masking(Masking::Separable).with_tints(reflect, transmit)?)
        })
    })
    .map_err(refused(props))
}

/// Factors on what is reflected and what passes.
fn tints(context: &Context<'_>, props: &Props<'_>) -> Result<[Texture; 2], SceneError> {
    let tint = |name| texture::find(context, props, name, Role::Reflectance, 1.0);
    Ok([tint("specular_reflectance")?, tint("specular_transmittance")?])
}

/// The index of the inside, or of `inside` by name, over that of the outside.
pub(super) fn relative_index(props: &Props<'_>, inside: &'static str) -> Result<f64, SceneError> {
    let index = |name: &'static str, default: &'static str| {
        if let Some(number) = props.number(name)? {
            return if number > 0.0 { Ok(number) } else { Err(props.bad(name, &number.to_string(), "a number > 0")) };
        }
        let material = props.string(name)?.unwrap_or(default);
        let names = || format!("a number > 0, or one of {}", listed(ior::dielectric_names()));
        ior::dielectric_ior(material).ok_or_else(|| props.bad(name, &quoted(material), &names()))
    };
    Ok(index("int_ior", inside)? / index("ext_ior", "air")?)
}
