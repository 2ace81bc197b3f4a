//! Diffuse bases under dielectric coats, smooth and rough.

use super::super::Context;
use super::super::colour::Role;
use super::super::props::Props;
use super::super::texture;
use super::dielectric::relative_index;
use super::metal::distribution;
use super::{Model, refused, textured};
use crate::bsdf::microfacet::Normals;
use crate::bsdf::{BeckmannNormals, GgxNormals, InternalReflectance, Masking, ParamError, Plastic, RoughPlastic};
use crate::math::color::Rgb;
use crate::scene::file::error::SceneError;
use crate::scene::texture::Texture;

pub(super) fn smooth(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let eta = relative_index(props, "polypropylene")?;
    let nonlinear = props.boolean("nonlinear", false)?;
    let coated = || {
        let exact = Plastic::new(eta, Rgb::BLACK)?.with_nonlinear(nonlinear);
        // Outside its range Mitsuba's fit is not one of anything.
        Ok(exact.with_internal_reflectance(InternalReflectance::Mitsuba).unwrap_or(exact))
    };
    let coated = coated().map_err(refused(props))?;
    textured::model(reflectances(context, props)?.into(), move |values| {
        Ok(Box::new(coated.with_rho(values.unit(0))?.with_tint(values.unit(1))?))
    })
    .map_err(refused(props))
}

pub(super) fn rough(context: &Context<'_>, props: &Props<'_>) -> Result<Model, SceneError> {
    let alpha = props.float("alpha", 0.1)?;
    props.no_effect(&["sample_visible"]);
    let normals = if distribution(props)? {
        GgxNormals::new(alpha, alpha).map(|normals| coated(context, props, normals))
    } else {
        BeckmannNormals::new(alpha, alpha).map(|normals| coated(context, props, normals))
    };
    normals.map_err(refused(props))?
}

fn coated<N: Normals + Clone + 'static>(
    context: &Context<'_>,
    props: &Props<'_>,
    normals: N,
) -> Result<Model, SceneError> {
    let eta = relative_index(props, "polypropylene")?;
    let nonlinear = props.boolean("nonlinear", false)?;
    let (masking, internal) = (Masking::Separable, InternalReflectance::Mitsuba);
    let coated = RoughPlastic::from_normals(normals, masking, eta, Rgb::BLACK, internal);
    let coated = coated.map_err(|e: ParamError| refused(props)(e))?.with_nonlinear(nonlinear);
    textured::model(reflectances(context, props)?.into(), move |values| {
        Ok(Box::new(coated.clone().with_rho(values.unit(0))?.with_tint(values.unit(1))?))
    })
    .map_err(refused(props))
}

/// Of the base and of the coat.
fn reflectances(context: &Context<'_>, props: &Props<'_>) -> Result<[Texture; 2], SceneError> {
    let find = |name, default| texture::find(context, props, name, Role::Reflectance, default);
    Ok([find("diffuse_reflectance", 0.5)?, find("specular_reflectance", 1.0)?])
}
