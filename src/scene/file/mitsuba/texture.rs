//! Textures.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine2, DAffine3, DMat2, DVec2};

use super::Context;
use super::bsdf::Uses;
use super::colour::{self, Role};
use super::document::NodeId;
use super::props::Props;
use crate::math::color::Rgb;
use crate::scene::file::error::{SceneError, quoted};
use crate::scene::file::source;
use crate::scene::texture::{Bitmap, Texture, Wrap};

const KNOWN: [&str; 3] = ["bitmap", "checkerboard", "mesh_attribute"];

/// The colours of the bitmaps that are read already, by file and by whether they are as stored.
#[derive(Clone, Debug)]
pub(super) struct Pixels {
    pub(super) rgb: Arc<Vec<[f32; 3]>>,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// The texture or colour `name` of `props`, grey of `default` where there is none.
pub(super) fn find(
    context: &Context<'_>,
    props: &Props<'_>,
    name: &'static str,
    role: Role,
    default: f64,
) -> Result<Texture, SceneError> {
    Ok(optional(context, props, name, role)?.unwrap_or(Texture::Constant(Rgb::grey(default))))
}

/// The texture or colour `name` of `props`, if it is there.
pub(super) fn optional(
    context: &Context<'_>,
    props: &Props<'_>,
    name: &'static str,
    role: Role,
) -> Result<Option<Texture>, SceneError> {
    let mut tags = vec!["texture"];
    tags.extend(colour::TAGS);
    let Some(id) = props.find(name, &tags)? else { return Ok(None) };
    let node = context.document.node(id);
    if node.tag == "texture" {
        return texture(context, id, role).map(Some);
    }
    colour::parse(context.document, node, role, context.notes).map(|colour| Some(Texture::Constant(colour)))
}

fn texture(context: &Context<'_>, id: NodeId, role: Role) -> Result<Texture, SceneError> {
    let props = Props::new(context.document, id)?;
    let uses = context.uses.get();
    let colour_of_mesh = props.node.kind == "mesh_attribute";
    context.uses.set(Uses { uv: uses.uv || !colour_of_mesh, vertex_color: uses.vertex_color || colour_of_mesh });
    let texture = match props.node.kind.as_str() {
        "bitmap" => bitmap(context, &props)?,
        "checkerboard" => {
            let colour = |name, default| Ok(props.colour(name, role, context.notes)?.unwrap_or(Rgb::grey(default)));
            let (first, second) = (colour("color0", 0.4)?, colour("color1", 0.2)?);
            Texture::Checkerboard { first, second, to_uv: to_uv(&props)? }
        }
        "mesh_attribute" => {
            let name = props.string("name")?.unwrap_or_default();
            if name != "vertex_color" {
                let error = props.unsupported("name", format!("the attribute {}", quoted(name)), "vertex_color");
                context.notes.unsupported(error, "the colour of the vertices takes its place")?;
            }
            if props.float("scale", 1.0)? != 1.0 {
                let error = props.unsupported("scale", "a scaled attribute", "1");
                context.notes.unsupported(error, "it is not scaled")?;
            }
            Texture::VertexColor
        }
        _ => {
            context.notes.unsupported(props.unknown_kind(&KNOWN), "grey takes its place")?;
            return Ok(Texture::Constant(Rgb::grey(0.5)));
        }
    };
    props.finish(context.notes)?;
    Ok(texture)
}

fn bitmap(context: &Context<'_>, props: &Props<'_>) -> Result<Texture, SceneError> {
    let Some(file) = props.string("filename")? else {
        return Err(props.missing("filename", "the name of an image"));
    };
    let path = context.document.find_file(props.node, file);
    // 0.6 spells `raw` as a gamma of 1.
    let gamma = props.optional_float("gamma")?;
    if let Some(other) = gamma.filter(|g| *g != 1.0 && *g != -1.0) {
        let error = props.unsupported("gamma", format!("the gamma {other}"), "-1 for that of the file, 1 for none");
        context.notes.unsupported(error, "that of the file takes its place")?;
    }
    let raw = props.boolean("raw", gamma == Some(1.0))?;
    let pixels = pixels(context, props, &path, raw)?;
    // Sampling and storage are ours to choose.
    props.no_effect(&["format", "accel", "cache", "max_anisotropy"]);
    let bilinear = match props.word("filter_type", &["bilinear", "nearest", "trilinear", "ewa"])? {
        "nearest" => false,
        "bilinear" => true,
        other => {
            let error = props.unsupported("filter_type", format!("the filter {other}"), "bilinear, nearest");
            context.notes.unsupported(error, "bilinear takes its place")?;
            true
        }
    };
    let wrap = match props.word("wrap_mode", &["repeat", "mirror", "clamp"])? {
        "mirror" => Wrap::Mirror,
        "clamp" => Wrap::Clamp,
        _ => Wrap::Repeat,
    };
    // There v runs downwards, here upwards.
    let upwards = DAffine2::from_mat2_translation(DMat2::from_diagonal(DVec2::new(1.0, -1.0)), DVec2::Y);
    let Pixels { rgb, width, height } = pixels;
    let to_uv = upwards * to_uv(props)?;
    Ok(Texture::Bitmap(Bitmap { pixels: rgb, width, height, to_uv, wrap, bilinear, scale: Rgb::WHITE }))
}

/// The colours of the image `path`: as stored if `raw`, else linear.
fn pixels(context: &Context<'_>, props: &Props<'_>, path: &Path, raw: bool) -> Result<Pixels, SceneError> {
    let key = (path.to_path_buf(), raw);
    if let Some(known) = context.pixels.borrow().get(&key) {
        return Ok(known.clone());
    }
    let pixels = read_pixels(props, path, raw)?;
    context.pixels.borrow_mut().insert(key, pixels.clone());
    Ok(pixels)
}

/// The same, read afresh.
pub(super) fn read_pixels(props: &Props<'_>, path: &Path, raw: bool) -> Result<Pixels, SceneError> {
    let image = source::read_image(path, &props.place())?;
    let rgb = if raw { image.pixels_rgb() } else { image.pixels_linear_rgb() };
    Ok(Pixels { rgb: Arc::new(rgb), width: image.width(), height: image.height() })
}

/// The map of the texture coordinates; 0.6 spells it as scales and offsets.
fn to_uv(props: &Props<'_>) -> Result<DAffine2, SceneError> {
    let map = props.transform("to_uv")?.unwrap_or(DAffine3::IDENTITY);
    let (m, t) = (map.matrix3, map.translation);
    let map = DAffine2::from_cols(m.x_axis.truncate(), m.y_axis.truncate(), t.truncate());
    let scale = DVec2::new(props.float("uscale", 1.0)?, props.float("vscale", 1.0)?);
    let offset = DVec2::new(props.float("uoffset", 0.0)?, props.float("voffset", 0.0)?);
    Ok(DAffine2::from_scale_angle_translation(scale, 0.0, offset) * map)
}
