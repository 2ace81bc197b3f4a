//! MTL: the materials of OBJ files.
//!
//! The format says how to shade and not what reflects. A surface is read as
//! - diffuse, Kd, where Ks is 0 or `illum` is 0 or 1;
//! - Kd / π + Ks C (n·h)^Ns, Blinn's lobe whose albedo is Ks at normal incidence, for `illum` 2 or none;
//! - Kd / π and a mirror Ks for `illum` 3, 5 and 8;
//! - smooth glass of index Ni that reflects Ks and lets Tf through for `illum` 4, 6, 7 and 9;
//!
//! seen from both sides, except glass; `d` (or 1 − `Tr`) is the share that is there; `Ke` shines to the outside. Where the
//! sum of Kd and Ks exceeds 1, both are scaled down, with a warning.
//! # References
//! - Ramey, Rose & Tyerman 1995, MTL material format (Lightwave, OBJ)

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_PI;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine2, DVec2, DVec3};

use crate::bsdf::{BlinnPhong, BlinnPhongNorm, Bsdf, Dielectric, Lambert, Lobes, Mix, ParamError, SpecularReflector};
use crate::math::color::Rgb;
use crate::scene::file::Notes;
use crate::scene::file::error::{Place, SceneError, listed, quoted};
use crate::scene::file::source;
use crate::scene::material::{Material, Varying};
use crate::scene::texture::{Bitmap, Texture, Wrap};

const KNOWN: [&str; 13] = ["newmtl", "Kd", "Ks", "Ke", "Ka", "Ns", "Ni", "Tf", "Tr", "d", "illum", "map_Kd", "map_d"];

/// A material, and the radiance of what is made of it.
#[derive(Debug)]
pub(super) struct Finish {
    pub(super) material: Material,
    pub(super) emission: Option<Rgb>,
}

/// The statements of one material.
#[derive(Clone, Debug)]
struct Statements {
    name: String,
    place: Place,
    kd: Option<Rgb>,
    ks: Rgb,
    ke: Rgb,
    tf: Rgb,
    ns: f64,
    ni: f64,
    opacity: f64,
    illum: Option<u8>,
    map_kd: Option<Bitmap>,
    map_d: Option<Bitmap>,
}

/// The materials in `path`, which is named at `asked`.
pub(super) fn load(path: &Path, asked: &Place, notes: &Notes) -> Result<BTreeMap<String, Finish>, SceneError> {
    let text = source::read_text(path, Some(asked))?;
    let mut materials = Vec::new();
    let mut images = BTreeMap::new();
    for (number, line) in text.lines().enumerate() {
        let place = Place::line(path, number as u64 + 1);
        let line = line.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match (keyword, materials.last_mut()) {
            ("", _) => {}
            ("newmtl", _) => materials.push(Statements::new(rest.trim(), place)),
            (_, None) => {
                let allowed = "newmtl before any other statement".into();
                return Err(SceneError::Malformed { place, problem: quoted(line), allowed });
            }
            (_, Some(material)) => material.read(path, keyword, rest.trim(), &place, &mut images, notes)?,
        }
    }
    materials.into_iter().map(|m| Ok((m.name.clone(), m.finish(notes)?))).collect()
}

type Images = BTreeMap<String, Bitmap>;

impl Statements {
    fn new(name: &str, place: Place) -> Self {
        let name = name.to_string();
        let (ks, ke, tf) = (Rgb::BLACK, Rgb::BLACK, Rgb::WHITE);
        let (kd, illum, map_kd, map_d) = (None, None, None, None);
        Self { name, place, kd, ks, ke, tf, ns: 1.0, ni: 1.5, opacity: 1.0, illum, map_kd, map_d }
    }

    fn read(
        &mut self,
        path: &Path,
        keyword: &str,
        rest: &str,
        place: &Place,
        images: &mut Images,
        notes: &Notes,
    ) -> Result<(), SceneError> {
        let bad = |allowed: &str| SceneError::Value {
            place: place.clone(),
            what: keyword.to_string(),
            given: quoted(rest),
            allowed: allowed.to_string(),
        };
        let number = |low: f64, high: f64| {
            let value = rest.parse().ok().filter(|x| (low..=high).contains(x));
            value.ok_or_else(|| bad(&format!("a number in [{low}, {high}]")))
        };
        let colour = |high: f64| {
            let values: Option<Vec<f64>> = rest.split_whitespace().map(|word| word.parse().ok()).collect();
            let colour = match values.as_deref() {
                Some(&[grey]) => Some(Rgb::grey(grey)),
                Some(&[r, g, b]) => Some(Rgb::new(r, g, b)),
                _ => None,
            };
            let colour = colour.filter(|c| c.to_array().iter().all(|x| (0.0..=high).contains(x)));
            colour.ok_or_else(|| bad(&format!("one or three numbers in [0, {high}]")))
        };
        match keyword {
            "Kd" => self.kd = Some(colour(1.0)?),
            "Ks" => self.ks = colour(1.0)?,
            "Tf" => self.tf = colour(1.0)?,
            "Ke" => self.ke = colour(f64::MAX)?,
            "Ns" => self.ns = number(0.0, 1e6)?,
            "Ni" => self.ni = number(1e-3, 1e3)?,
            "d" => self.opacity = number(0.0, 1.0)?,
            "Tr" => self.opacity = 1.0 - number(0.0, 1.0)?,
            "illum" => {
                let model = rest.parse().ok().filter(|model| *model <= 9);
                self.illum = Some(model.ok_or_else(|| bad("a whole number from 0 to 9"))?);
            }
            "map_Kd" => self.map_kd = Some(bitmap(path, rest, place, images, notes)?),
            "map_d" => self.map_d = Some(bitmap(path, rest, place, images, notes)?),
            // Light from everywhere that meets everything: what rendering computes.
            "Ka" | "map_Ka" | "sharpness" => {}
            _ => {
                let what = format!("the statement {}", quoted(keyword));
                let error = SceneError::Unsupported { place: place.clone(), what, known: listed(KNOWN) };
                notes.unsupported(error, "it is ignored")?;
            }
        }
        Ok(())
    }

    fn finish(self, notes: &Notes) -> Result<Finish, SceneError> {
        let refused = |e: ParamError| SceneError::Model { place: self.place.clone(), source: Box::new(e) };
        let mut kd = self.kd.unwrap_or(if self.map_kd.is_some() { Rgb::WHITE } else { Rgb::grey(0.8) });
        let mut ks = if matches!(self.illum, Some(0 | 1)) { Rgb::BLACK } else { self.ks };
        let glass = matches!(self.illum, Some(4 | 6 | 7 | 9));
        let sum = (kd + ks).max_channel();
        if sum > 1.0 && !glass {
            notes.warn(format!(
                "{}: Kd + Ks of {} is {sum:.3}; both are divided by it",
                self.place,
                quoted(&self.name)
            ));
            (kd, ks) = (kd / sum, ks / sum);
        }
        let diffuse = match self.map_kd {
            Some(bitmap) => Texture::Bitmap(Bitmap { scale: kd, ..bitmap }),
            None => Texture::Constant(kd),
        };
        let name = self.name;
        let material = if glass {
            let model = Dielectric::new(self.ni).and_then(|glass| glass.with_tints(ks, self.tf)).map_err(refused)?;
            Material::uniform(name, Box::new(model))
        } else if ks.is_black() {
            Material::diffuse(name, diffuse).two_sided()
        } else {
            let mirror = matches!(self.illum, Some(3 | 5 | 8));
            let shiny = Shiny { diffuse, specular: ks, shininess: (!mirror).then_some(self.ns) };
            let material = match shiny.diffuse {
                Texture::Constant(kd) => Material::uniform(name, shiny.model(kd).map_err(refused)?),
                _ => Material::varying(name, Box::new(shiny)),
            };
            material.two_sided()
        };
        let material = match (self.map_d, self.opacity) {
            (Some(bitmap), d) => material.with_opacity(Texture::Bitmap(Bitmap { scale: Rgb::grey(d), ..bitmap })),
            (None, 1.0) => material,
            (None, d) => material.with_opacity(Texture::Constant(Rgb::grey(d))),
        };
        Ok(Finish { material, emission: (!self.ke.is_black()).then_some(self.ke) })
    }
}

/// A diffuse base with a highlight, or with a mirror where there is no `shininess`.
#[derive(Debug)]
struct Shiny {
    diffuse: Texture,
    specular: Rgb,
    shininess: Option<f64>,
}

impl Shiny {
    fn model(&self, kd: Rgb) -> Result<Box<dyn Bsdf>, ParamError> {
        if let Some(n) = self.shininess {
            return Ok(Box::new(BlinnPhong::new(n, kd * FRAC_1_PI, self.specular, BlinnPhongNorm::Exact)?));
        }
        // Shares of a mixture whose parts reflect at most 1, since Kd + Ks is at most 1.
        let (diffuse, specular) = (kd.max_channel(), self.specular.max_channel());
        let share = diffuse / (diffuse + specular);
        let mirror = SpecularReflector::mirror((self.specular / (1.0 - share)).map(|x| x.min(1.0)))?;
        if diffuse == 0.0 {
            return Ok(Box::new(mirror));
        }
        let lambert = Lambert::new((kd / share).map(|x| x.min(1.0)))?;
        Ok(Box::new(Mix::new([(share, Box::new(lambert) as Box<dyn Bsdf>), (1.0 - share, Box::new(mirror))])?))
    }
}

impl Varying for Shiny {
    fn at(&self, uv: DVec2, vertex_color: Rgb) -> Box<dyn Bsdf> {
        let kd = self.diffuse.at(uv, vertex_color).map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 });
        // In the domains, as the constructor saw to it.
        self.model(kd).unwrap_or_else(|_| Box::new(Lambert::default()))
    }

    fn lobes(&self) -> Lobes {
        let dirac = if self.shininess.is_none() { Lobes::DIRAC } else { Lobes::REFLECT };
        Lobes::REFLECT.union(dirac)
    }
}

/// A texture: options, then the name of a file, which may contain spaces.
fn bitmap(
    path: &Path,
    statement: &str,
    place: &Place,
    images: &mut Images,
    notes: &Notes,
) -> Result<Bitmap, SceneError> {
    let mut rest = statement;
    let (mut scale, mut offset, mut wrap) = (DVec3::ONE, DVec3::ZERO, Wrap::Repeat);
    while let Some(option) = rest.strip_prefix('-') {
        let (option, behind) = option.split_once(char::is_whitespace).unwrap_or((option, ""));
        rest = behind.trim_start();
        match option {
            "s" => scale = numbers(&mut rest, 1.0),
            "o" => offset = numbers(&mut rest, 0.0),
            "clamp" | "blendu" | "blendv" | "cc" => {
                let (word, behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
                rest = behind.trim_start();
                if option == "clamp" && word == "on" {
                    wrap = Wrap::Clamp;
                }
            }
            _ => {
                let known = "-s, -o, -clamp, -blendu, -blendv, -cc".to_string();
                let error =
                    SceneError::Unsupported { place: place.clone(), what: quoted(&format!("-{option}")), known };
                notes.unsupported(error, "it is ignored, with its number")?;
                numbers(&mut rest, 0.0);
            }
        }
    }
    let file = rest.trim().replace('\\', "/");
    let to_uv = DAffine2::from_scale_angle_translation(scale.truncate(), 0.0, offset.truncate());
    let known = images.get(&file).cloned();
    let image = if let Some(known) = known {
        known
    } else {
        let image = source::read_image(&path.with_file_name(&file), place)?;
        let read = Bitmap {
            pixels: Arc::new(image.pixels_linear_rgb()),
            width: image.width(),
            height: image.height(),
            to_uv: DAffine2::IDENTITY,
            wrap: Wrap::Repeat,
            bilinear: true,
            scale: Rgb::WHITE,
        };
        images.insert(file, read.clone());
        read
    };
    Ok(Bitmap { to_uv, wrap, ..image })
}

/// Up to three numbers at the start of `rest`, which is left with what follows; `absent` for those that are not there.
fn numbers(rest: &mut &str, absent: f64) -> DVec3 {
    let mut values = [absent; 3];
    for value in &mut values {
        let (word, behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let Some(number) = word.parse().ok().filter(|x: &f64| x.is_finite()) else { break };
        (*value, *rest) = (number, behind.trim_start());
    }
    DVec3::from_array(values)
}
