//! Metallic-roughness materials and their textures.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine2, DMat2, DVec2};

use super::buffers::{Buffers, get, resource};
use super::json::{self, Root, TextureInfo};
use super::metallic_roughness::MetallicRoughness;
use crate::bsdf::{Bsdf, Lambert, Lobes};
use crate::image::Image;
use crate::math::color::Rgb;
use crate::scene::file::Notes;
use crate::scene::file::error::{Place, SceneError, one_line, quoted};
use crate::scene::file::source;
use crate::scene::material::{Material, Varying};
use crate::scene::texture::{Bitmap, Texture, Wrap};

/// What a mesh has for its material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Uses {
    pub(super) vertex_color: bool,
    pub(super) uv: bool,
}

/// The materials that are built, each once.
pub(super) struct Library<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    notes: &'a Notes,
    materials: Vec<Material>,
    built: BTreeMap<(Option<usize>, Uses), (usize, Option<Rgb>)>,
    images: BTreeMap<(usize, Content), Pixels>,
}

/// What is taken from an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Content {
    /// Linear colours.
    Colour,
    /// The numbers as they are stored.
    Raw,
    /// The opacity.
    Alpha,
}

#[derive(Clone)]
struct Pixels {
    values: Arc<Vec<[f32; 3]>>,
    width: usize,
    height: usize,
}

impl<'a> Library<'a> {
    pub(super) fn new(path: &'a Path, root: &'a Root, buffers: &'a Buffers<'a>, notes: &'a Notes) -> Self {
        let (materials, built, images) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
        Self { path, root, buffers, notes, materials, built, images }
    }

    pub(super) fn into_materials(self) -> Vec<Material> {
        self.materials
    }

    /// The number of material `index` for a mesh, and its radiance.
    pub(super) fn material(
        &mut self,
        index: Option<usize>,
        uses: Uses,
        asked: &Place,
    ) -> Result<(usize, Option<Rgb>), SceneError> {
        if let Some(&known) = self.built.get(&(index, uses)) {
            return Ok(known);
        }
        let default = json::Material::default();
        let material = match index {
            Some(index) => get(&self.root.materials, index, "material", asked)?,
            None => &default,
        };
        let place = index.map_or_else(|| asked.clone(), |i| Place::element(self.path, format!("materials[{i}]")));
        let (material, emission) = self.build(material, uses, &place)?;
        self.materials.push(material);
        let built = (self.materials.len() - 1, emission);
        self.built.insert((index, uses), built);
        Ok(built)
    }

    fn build(
        &mut self,
        material: &json::Material,
        uses: Uses,
        place: &Place,
    ) -> Result<(Material, Option<Rgb>), SceneError> {
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, alpha] = pbr.base_color_factor;
        let unit = |what: &str, values: &[f64]| {
            if values.iter().all(|x| (0.0..=1.0).contains(x)) {
                return Ok(());
            }
            let (given, allowed) = (format!("{values:?}"), "numbers in [0, 1]".into());
            Err(SceneError::Value { place: place.clone(), what: what.into(), given, allowed })
        };
        unit("baseColorFactor", &pbr.base_color_factor)?;
        unit("metallicFactor", &[pbr.metallic_factor])?;
        unit("roughnessFactor", &[pbr.roughness_factor])?;
        for (name, texture) in
            [("normalTexture", &material.normal_texture), ("emissiveTexture", &material.emissive_texture)]
        {
            if texture.is_some() {
                let (what, known) = (format!("`{name}`"), "baseColorTexture, metallicRoughnessTexture".to_string());
                let error = SceneError::Unsupported { place: place.clone(), what, known };
                self.notes.unsupported(error, "it is ignored")?;
            }
        }
        let factor = Rgb::new(r, g, b);
        let base = match &pbr.base_color_texture {
            Some(info) => Texture::Bitmap(Bitmap { scale: factor, ..self.bitmap(info, Content::Colour, uses, place)? }),
            None => Texture::Constant(factor),
        };
        let (metallic, roughness) = (pbr.metallic_factor, pbr.roughness_factor);
        // Of the texture green is roughness, and blue metallic.
        let surface = match &pbr.metallic_roughness_texture {
            Some(info) => {
                let scale = Rgb::new(0.0, roughness, metallic);
                Texture::Bitmap(Bitmap { scale, ..self.bitmap(info, Content::Raw, uses, place)? })
            }
            None => Texture::Constant(Rgb::new(0.0, roughness, metallic)),
        };
        let name = one_line(material.name.as_deref().unwrap_or("material"), 80);
        let model = Pbr { base, surface, vertex_color: uses.vertex_color };
        let constant = !model.vertex_color
            && matches!((&model.base, &model.surface), (Texture::Constant(_), Texture::Constant(_)));
        let built = if constant {
            Material::uniform(name, model.at(DVec2::ZERO, Rgb::WHITE))
        } else {
            Material::varying(name, Box::new(model))
        };
        let built = match self.opacity(material, alpha, uses, place)? {
            Some(opacity) => built.two_sided().with_opacity(opacity),
            None => built.two_sided(),
        };
        let strength = material.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
        let emission = Rgb::from(material.emissive_factor) * strength;
        if !(emission.is_finite() && emission.min_channel() >= 0.0) {
            let (given, allowed) = (emission.to_string(), "finite numbers ≥ 0".to_string());
            return Err(SceneError::Value { place: place.clone(), what: "emissiveFactor".into(), given, allowed });
        }
        Ok((built, (!emission.is_black()).then_some(emission)))
    }

    /// The share of the surface that is there, where it is not all of it.
    fn opacity(
        &mut self,
        material: &json::Material,
        alpha: f64,
        uses: Uses,
        place: &Place,
    ) -> Result<Option<Texture>, SceneError> {
        let mode = material.alpha_mode.as_deref().unwrap_or("OPAQUE");
        let cutoff = match mode {
            "OPAQUE" => return Ok(None),
            "BLEND" => None,
            "MASK" => Some(material.alpha_cutoff.unwrap_or(0.5)),
            other => {
                let (given, allowed) = (quoted(other), "OPAQUE, MASK, BLEND".to_string());
                return Err(SceneError::Value { place: place.clone(), what: "alphaMode".into(), given, allowed });
            }
        };
        let share = |alpha: f64| cutoff.map_or(alpha, |cutoff| if alpha >= cutoff { 1.0 } else { 0.0 });
        let Some(info) = &material.pbr_metallic_roughness.base_color_texture else {
            let share = share(alpha);
            return Ok((share < 1.0).then_some(Texture::Constant(Rgb::grey(share))));
        };
        let bitmap = self.bitmap(info, Content::Alpha, uses, place)?;
        let pixels = bitmap.pixels.iter().map(|[a, ..]| [share(alpha * f64::from(*a)) as f32; 3]).collect();
        Ok(Some(Texture::Bitmap(Bitmap { pixels: Arc::new(pixels), ..bitmap })))
    }

    fn bitmap(
        &mut self,
        info: &TextureInfo,
        content: Content,
        uses: Uses,
        place: &Place,
    ) -> Result<Bitmap, SceneError> {
        let transform = info.extensions.texture_transform.as_ref();
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        if set != 0 || !uses.uv {
            let what = format!("a texture over TEXCOORD_{set}, which the mesh has not, or which is not read");
            let error = SceneError::Unsupported { place: place.clone(), what, known: "TEXCOORD_0".into() };
            self.notes.unsupported(error, "TEXCOORD_0 takes its place")?;
        }
        let texture = get(&self.root.textures, info.index, "texture", place)?;
        let missing = || SceneError::Missing {
            place: Place::element(self.path, format!("textures[{}]", info.index)),
            what: "source".into(),
            allowed: "the number of an image".into(),
        };
        let Pixels { values, width, height } = self.pixels(texture.source.ok_or_else(missing)?, content, place)?;
        let sampler = match texture.sampler {
            Some(index) => get(&self.root.samplers, index, "sampler", place)?,
            None => &json::Sampler::default(),
        };
        let wrap = match (sampler.wrap_s.unwrap_or(10497), sampler.wrap_t.unwrap_or(10497)) {
            (10497, 10497) => Wrap::Repeat,
            (33648, 33648) => Wrap::Mirror,
            (33071, 33071) => Wrap::Clamp,
            (s, t) => {
                let what = format!("the wrap modes {s} and {t}");
                let known = "10497, 33648 or 33071 for both directions".to_string();
                let error = SceneError::Unsupported { place: place.clone(), what, known };
                self.notes.unsupported(error, "the texture is repeated")?;
                Wrap::Repeat
            }
        };
        let placed = transform.map_or(DAffine2::IDENTITY, |t| {
            let scale = DVec2::from(t.scale.unwrap_or([1.0; 2]));
            // There v runs downwards, and a turn from u to v is the other way around.
            DAffine2::from_scale_angle_translation(DVec2::ONE, -t.rotation, t.offset.into())
                * DAffine2::from_scale(scale)
        });
        let upwards = DAffine2::from_mat2_translation(DMat2::from_diagonal(DVec2::new(1.0, -1.0)), DVec2::Y);
        let (to_uv, bilinear) = (upwards * placed, sampler.mag_filter != Some(9728));
        Ok(Bitmap { pixels: values, width, height, to_uv, wrap, bilinear, scale: Rgb::WHITE })
    }

    fn pixels(&mut self, index: usize, content: Content, asked: &Place) -> Result<Pixels, SceneError> {
        if let Some(known) = self.images.get(&(index, content)) {
            return Ok(known.clone());
        }
        let image = self.image(index, asked)?;
        let values = match content {
            Content::Colour => image.pixels_linear_rgb(),
            Content::Raw => image.pixels_rgb(),
            Content::Alpha => match image.alpha() {
                Some(alpha) => alpha.iter().map(|&a| [a; 3]).collect(),
                None => vec![[1.0; 3]; image.width() * image.height()],
            },
        };
        let pixels = Pixels { values: Arc::new(values), width: image.width(), height: image.height() };
        self.images.insert((index, content), pixels.clone());
        Ok(pixels)
    }

    fn image(&self, index: usize, asked: &Place) -> Result<Image, SceneError> {
        let image = get(&self.root.images, index, "image", asked)?;
        let place = Place::element(self.path, format!("images[{index}]"));
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => source::decode_image(&resource(self.path, uri, &place)?, self.path, &place),
            (None, Some(view)) => source::decode_image(self.buffers.view(view, &place)?.0, self.path, &place),
            (None, None) => {
                let allowed = "a uri or a bufferView".into();
                Err(SceneError::Missing { place, what: "the image".into(), allowed })
            }
        }
    }
}

/// The model where its parameters vary.
#[derive(Debug)]
struct Pbr {
    base: Texture,
    /// Roughness in green, metallic in blue.
    surface: Texture,
    vertex_color: bool,
}

impl Varying for Pbr {
    fn at(&self, uv: DVec2, vertex_color: Rgb) -> Box<dyn Bsdf> {
        let unit = |x: f64| if x > 0.0 { x.min(1.0) } else { 0.0 };
        let tint = if self.vertex_color { vertex_color } else { Rgb::WHITE };
        let base = (self.base.at(uv, vertex_color) * tint).map(unit);
        let [_, roughness, metallic] = self.surface.at(uv, vertex_color).map(unit).to_array();
        match MetallicRoughness::new(base, metallic, roughness) {
            Ok(model) => Box::new(model),
            // All parameters are in their domains.
            Err(_) => Box::new(Lambert::default()),
        }
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT
    }
}
