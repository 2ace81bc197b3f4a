//! Materials.

use super::Context;
use super::colour::{self, Role};
use super::document::NodeId;
use super::props::Props;
use super::tinted::Tinted;
use crate::bsdf::{Beckmann, Bsdf, Fresnel, Ggx, Masking, ParamError};
use crate::math::color::Rgb;
use crate::scene::file::error::SceneError;
use crate::scene::material::Material;
use crate::scene::texture::Texture;

const KNOWN: [&str; 4] = ["diffuse", "twosided", "mask", "roughconductor"];

/// The number of the material that `id` is, or of Mitsuba's default where there is none.
pub(super) fn index(context: &Context<'_>, id: Option<NodeId>) -> Result<usize, SceneError> {
    // No element has the last number.
    let key = id.unwrap_or(NodeId::MAX);
    if let Some(&known) = context.material_of.borrow().get(&key) {
        return Ok(known);
    }
    let material = match id {
        None => Material::diffuse("default", Texture::Constant(Rgb::grey(0.5))),
        Some(id) => surface(context, id, 0)?.into_material(context, id),
    };
    let mut materials = context.materials.borrow_mut();
    materials.push(material);
    context.material_of.borrow_mut().insert(key, materials.len() - 1);
    Ok(materials.len() - 1)
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
    Uniform(Box<dyn Bsdf>),
}

impl Surface {
    fn new(model: Model) -> Self {
        Self { model, two_sided: false, opacity: None }
    }

    fn into_material(self, context: &Context<'_>, id: NodeId) -> Material {
        let node = context.document.node(id);
        let name = if node.id.is_empty() { format!("{}-{id}", node.kind) } else { node.id.clone() };
        let mut material = match self.model {
            Model::Diffuse(reflectance) => Material::diffuse(name, reflectance),
            Model::Ggx(ggx) => Material::ggx(name, ggx),
            Model::Uniform(model) => Material::uniform(name, model),
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

fn surface(context: &Context<'_>, id: NodeId, depth: usize) -> Result<Surface, SceneError> {
    let props = Props::new(context.document, id)?;
    props.check_depth(depth)?;
    let surface = match props.node.kind.as_str() {
        "diffuse" => Surface::new(Model::Diffuse(texture(context, &props, "reflectance", 0.5)?)),
        "twosided" => two_sided(context, &props, depth)?,
        "roughconductor" => rough_conductor(context, &props)?,
        _ => {
            context.notes.unsupported(props.unknown_kind(&KNOWN), "a grey diffuse surface takes its place")?;
            return Ok(Surface::new(Model::Diffuse(Texture::Constant(Rgb::grey(0.5)))));
        }
    };
    props.finish(context.notes)?;
    Ok(surface)
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
    Ok(Surface { two_sided: true, ..surface(context, front, depth + 1)? })
}

fn rough_conductor(context: &Context<'_>, props: &Props<'_>) -> Result<Surface, SceneError> {
    let alpha = props.float("alpha", 0.1)?;
    let alpha_u = props.float("alpha_u", alpha)?;
    let alpha_v = props.float("alpha_v", alpha)?;
    let fresnel = conductor_fresnel(context, props)?;
    let tint = props.colour("specular_reflectance", Role::Reflectance, context.notes)?.unwrap_or(Rgb::WHITE);
    props.no_effect(&["sample_visible"]);
    let model = |error: ParamError| SceneError::Model { place: props.place(), source: Box::new(error) };
    let ggx = props.word("distribution", &["beckmann", "ggx"])? == "ggx";
    Ok(Surface::new(if ggx {
        let ggx = Ggx::anisotropic(alpha_u, alpha_v).map_err(model)?.with_masking(Masking::Separable);
        let ggx = ggx.with_fresnel(fresnel).map_err(model)?;
        if tint == Rgb::WHITE { Model::Ggx(ggx) } else { Model::Uniform(Box::new(Tinted { model: ggx, tint })) }
    } else {
        let beckmann = Beckmann::anisotropic(alpha_u, alpha_v).map_err(model)?.with_masking(Masking::Separable);
        let beckmann = beckmann.with_fresnel(fresnel).map_err(model)?;
        Model::Uniform(Box::new(Tinted { model: beckmann, tint }))
    }))
}

fn conductor_fresnel(context: &Context<'_>, props: &Props<'_>) -> Result<Fresnel, SceneError> {
    let material = props.string("material")?;
    let eta = props.colour("eta", Role::Index, context.notes)?;
    let k = props.colour("k", Role::Index, context.notes)?;
    // What lies above the metal divides both.
    let above = props.positive("ext_eta", 1.0)?;
    match (eta, k, material) {
        (None, None, None | Some("none")) => Ok(Fresnel::MIRROR),
        (Some(eta), Some(k), _) => Ok(Fresnel::Conductor { eta: eta / above, k: k / above }),
        (None, None, Some(name)) => {
            let error = props.unsupported("material", format!("the material `{name}`"), "none, or eta and k");
            context.notes.unsupported(error, "a perfect mirror takes its place")?;
            Ok(Fresnel::MIRROR)
        }
        _ => Err(props.missing("eta or k", "both, or neither")),
    }
}

fn texture(context: &Context<'_>, props: &Props<'_>, name: &'static str, default: f64) -> Result<Texture, SceneError> {
    let mut tags = vec!["texture"];
    tags.extend(colour::TAGS);
    let Some(id) = props.find(name, &tags)? else { return Ok(Texture::Constant(Rgb::grey(default))) };
    let node = context.document.node(id);
    if node.tag != "texture" {
        return colour::parse(context.document, node, Role::Reflectance, context.notes).map(Texture::Constant);
    }
    let error = props.unsupported(name, node.shown(), "a colour");
    context.notes.unsupported(error, "grey takes its place")?;
    Ok(Texture::Constant(Rgb::grey(0.5)))
}
