//! Materials.
//!
//! Microfacets mask separably, G1(wo) G1(wi), and are drawn among the visible ones, as in Mitsuba. Its fit of Beckmann's
//! masking, good to 0.35 %, is exact here; its internal reflectance of plastic is kept.

mod dielectric;
mod legacy;
mod metal;
mod plastic;
mod textured;

use std::sync::Arc;

use glam::DVec2;

use super::Context;
use super::colour::Role;
use super::document::NodeId;
use super::props::Props;
use super::texture;
use crate::bsdf::{Bsdf, Ggx, Lambert, Lobes, Mix, Null, ParamError};
use crate::math::color::Rgb;
use crate::scene::file::error::SceneError;
use crate::scene::material::{Material, Varying};
use crate::scene::texture::Texture;
use textured::Values;

const KNOWN: [&str; 14] = [
    "diffuse",
    "twosided",
    "mask",
    "blendbsdf",
    "conductor",
    "roughconductor",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "plastic",
    "roughplastic",
    "null",
    "phong",
    "ward",
];

/// A material that is built, and what it needs of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Built {
    pub(super) index: usize,
    pub(super) uses: Uses,
}

/// What textures need of the surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Uses {
    pub(super) uv: bool,
    pub(super) vertex_color: bool,
}

/// The material that `id` is, or Mitsuba's default where there is none: grey, and black for what `shines`.
pub(super) fn built(context: &Context<'_>, id: Option<NodeId>, shines: bool) -> Result<Built, SceneError> {
    // No element has one of the last two numbers.
    let key = id.unwrap_or(NodeId::MAX - usize::from(shines));
    if let Some(&known) = context.material_of.borrow().get(&key) {
        return Ok(known);
    }
    context.uses.set(Uses::default());
    let material = match id {
        None if shines => Material::diffuse("default-of-lights", Texture::Constant(Rgb::BLACK)),
        None => Material::diffuse("default", Texture::Constant(Rgb::grey(0.5))),
        Some(id) => surface(context, id, 0)?.into_material(context, id),
    };
    let mut materials = context.materials.borrow_mut();
    materials.push(material);
    let built = Built { index: materials.len() - 1, uses: context.uses.get() };
    context.material_of.borrow_mut().insert(key, built);
    Ok(built)
}

/// A material while its parts are put together.
struct Surface {
    model: Model,
    two_sided: bool,
    opacity: Option<Texture>,
}

enum Model {
    Diffuse(Texture),
    Ggx(Ggx),
    Uniform(Arc<dyn Bsdf>),
    Varying(Box<dyn Varying>),
}

impl From<Model> for Surface {
    fn from(model: Model) -> Self {
        Self { model, two_sided: false, opacity: None }
    }
}

impl Surface {
    fn into_material(self, context: &Context<'_>, id: NodeId) -> Material {
        let node = context.document.node(id);
        let name = if node.id.is_empty() { format!("{}-{id}", node.kind) } else { node.id.clone() };
        let mut material = match self.model {
            Model::Diffuse(reflectance) => Material::diffuse(name, reflectance),
            Model::Ggx(ggx) => Material::ggx(name, ggx),
            Model::Uniform(model) => Material::uniform(name, Box::new(model)),
            Model::Varying(model) => Material::varying(name, model),
        };
        if self.two_sided {
            material = material.two_sided();
        }
        match self.opacity {
            Some(opacity) => material.with_opacity(opacity),
            None => material,
        }
    }
}

impl Model {
    fn lobes(&self) -> Lobes {
        match self {
            Self::Diffuse(_) | Self::Ggx(_) => Lobes::REFLECT,
            Self::Uniform(model) => model.lobes(),
            Self::Varying(model) => model.lobes(),
        }
    }

    /// As a part of another model.
    fn into_varying(self) -> Box<dyn Varying> {
        match self {
            Self::Diffuse(texture) => {
                let make = |values: &Values| Ok(Box::new(Lambert::new(values.unit(0))?) as Box<dyn Bsdf>);
                Box::new(textured::Textured { textures: vec![texture], lobes: Lobes::REFLECT, make })
            }
            Self::Ggx(ggx) => Box::new(Everywhere(Arc::new(ggx))),
            Self::Uniform(model) => Box::new(Everywhere(model)),
            Self::Varying(model) => model,
        }
    }
}

/// The same model everywhere, as one that varies.
#[derive(Debug)]
struct Everywhere(Arc<dyn Bsdf>);

impl Varying for Everywhere {
    fn at(&self, _: DVec2, _: Rgb) -> Box<dyn Bsdf> {
        Box::new(Arc::clone(&self.0))
    }

    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }
}

fn surface(context: &Context<'_>, id: NodeId, depth: usize) -> Result<Surface, SceneError> {
    let props = Props::new(context.document, id)?;
    props.check_depth(depth)?;
    let surface = match props.node.kind.as_str() {
        "diffuse" | "lambertian" => {
            Model::Diffuse(texture::find(context, &props, "reflectance", Role::Reflectance, 0.5)?).into()
        }
        "twosided" => two_sided(context, &props, depth)?,
        "mask" => mask(context, &props, depth)?,
        "blendbsdf" => blend(context, &props, depth)?,
        "conductor" => metal::smooth(context, &props)?.into(),
        "roughconductor" => metal::rough(context, &props)?.into(),
        "dielectric" => dielectric::smooth(context, &props)?.into(),
        "thindielectric" => dielectric::thin(context, &props)?.into(),
        "roughdielectric" => dielectric::rough(context, &props)?.into(),
        "plastic" => plastic::smooth(context, &props)?.into(),
        "roughplastic" => plastic::rough(context, &props)?.into(),
        "null" => Model::Uniform(Arc::new(Null)).into(),
        "phong" => legacy::phong(context, &props)?.into(),
        "ward" => legacy::ward(context, &props)?.into(),
        _ => return substitute(context, &props, depth),
    };
    props.finish(context.notes)?;
    Ok(surface)
}

/// What takes the place of a model that is not known: the one model within it, or a diffuse one of its colour.
fn substitute(context: &Context<'_>, props: &Props<'_>, depth: usize) -> Result<Surface, SceneError> {
    let error = props.unknown_kind(&KNOWN);
    if let [inner] = props.objects("bsdf").as_slice() {
        context.notes.unsupported(error, "what is in it takes its place")?;
        return surface(context, *inner, depth + 1);
    }
    context.notes.unsupported(error, "a diffuse surface takes its place")?;
    for name in ["reflectance", "base_color", "diffuse_reflectance"] {
        if let Some(colour) = texture::optional(context, props, name, Role::Reflectance)? {
            return Ok(Model::Diffuse(colour).into());
        }
    }
    Ok(Model::Diffuse(Texture::Constant(Rgb::grey(0.5))).into())
}

/// The error for a parameter outside the domain of a model.
fn refused(props: &Props<'_>) -> impl Fn(ParamError) -> SceneError {
    let place = props.place();
    move |error| SceneError::Model { place: place.clone(), source: Box::new(error) }
}

fn two_sided(context: &Context<'_>, props: &Props<'_>, depth: usize) -> Result<Surface, SceneError> {
    let sides = props.objects("bsdf");
    let Some(&front) = sides.first() else {
        return Err(props.missing("a <bsdf>", "the front"));
    };
    if sides.len() > 1 {
        let error = props.unsupported("", "a back other than the front", "one <bsdf>, for both sides");
        context.notes.unsupported(error, "the back is like the front")?;
    }
    let front = surface(context, front, depth + 1)?;
    let two_sided = !front.model.lobes().contains(Lobes::TRANSMIT);
    if !two_sided {
        let error = props.unsupported("", "a two-sided surface that light passes", "models of reflection");
        context.notes.unsupported(error, "it has two sides of its own")?;
    }
    Ok(Surface { two_sided, ..front })
}

fn mask(context: &Context<'_>, props: &Props<'_>, depth: usize) -> Result<Surface, SceneError> {
    let opacity = texture::find(context, props, "opacity", Role::Reflectance, 0.5)?;
    let Some(inner) = props.object("bsdf")? else {
        return Err(props.missing("a <bsdf>", "what is there where the mask is 1"));
    };
    let inner = surface(context, inner, depth + 1)?;
    if inner.opacity.is_some() {
        context.notes.unsupported(props.unsupported("", "a mask in a mask", "one mask"), "the outer one counts")?;
    }
    Ok(Surface { opacity: Some(opacity), ..inner })
}

/// Two models, the second by the share `weight`.
#[derive(Debug)]
struct Blend {
    parts: [Box<dyn Varying>; 2],
    weight: Texture,
}

impl Blend {
    fn mix(parts: [Box<dyn Bsdf>; 2], weight: f64) -> Box<dyn Bsdf> {
        let weight = if weight > 0.0 { weight.min(1.0) } else { 0.0 };
        let [first, second] = parts;
        // The weights are ≥ 0 and their sum is 1.
        Mix::new([(1.0 - weight, first), (weight, second)]).map_or_else(|_| textured::black(), |mix| Box::new(mix))
    }
}

impl Varying for Blend {
    fn at(&self, uv: DVec2, vertex_color: Rgb) -> Box<dyn Bsdf> {
        let parts = [&self.parts[0], &self.parts[1]].map(|part| part.at(uv, vertex_color));
        Self::mix(parts, self.weight.at(uv, vertex_color).luminance())
    }

    fn lobes(&self) -> Lobes {
        self.parts[0].lobes().union(self.parts[1].lobes())
    }
}

fn blend(context: &Context<'_>, props: &Props<'_>, depth: usize) -> Result<Surface, SceneError> {
    let weight = texture::find(context, props, "weight", Role::Reflectance, 0.5)?;
    let &[first, second] = props.objects("bsdf").as_slice() else {
        return Err(props.missing("one <bsdf> or both", "two"));
    };
    let parts = [surface(context, first, depth + 1)?, surface(context, second, depth + 1)?];
    if parts.iter().any(|part| part.opacity.is_some()) || parts[0].two_sided != parts[1].two_sided {
        let known = "parts without masks that both are two-sided or both are not";
        let error = props.unsupported("", "a blend of these parts", known);
        context.notes.unsupported(error, "masks are ignored, and both are two-sided")?;
    }
    let two_sided = parts.iter().any(|part| part.two_sided);
    let parts = parts.map(|part| part.model.into_varying());
    let model = Model::Varying(Box::new(Blend { parts, weight }));
    Ok(Surface { two_sided, ..model.into() })
}
