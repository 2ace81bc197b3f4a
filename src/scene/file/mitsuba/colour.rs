//! Colours: `<rgb>`, `<spectrum>` and plain numbers.
//!
//! Spectra become the colours that Mitsuba 3 computes in its variant `scalar_rgb`: reflectances and refractive indices are
//! weighted by D65, so that constants are grey; light is not, so that `<spectrum value="1"/>` in an emitter is the reddish
//! equal-energy white.

use super::document::{Document, Node};
use super::props::{Props, number, numbers};
use crate::math::color::Rgb;
use crate::math::spectrum::{Spectrum, equal_energy};
use crate::scene::file::Notes;
use crate::scene::file::error::{Place, SceneError, quoted};
use crate::scene::file::source;

/// The elements that hold a colour.
pub(super) const TAGS: [&str; 5] = ["rgb", "spectrum", "float", "integer", "srgb"];

/// What a colour is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A share of light, in [0, 1].
    Reflectance,
    /// Light, ≥ 0.
    Light,
    /// An index of refraction or another parameter of a material, ≥ 0.
    Index,
}

impl Props<'_> {
    /// The colour `name`, if it is there.
    pub(super) fn colour(&self, name: &'static str, role: Role, notes: &Notes) -> Result<Option<Rgb>, SceneError> {
        let Some(id) = self.find(name, &TAGS)? else { return Ok(None) };
        let (document, node) = (self.document, self.document.node(id));
        parse(document, node, role, notes).map(Some)
    }
}

/// The colour that `node`, one of [`TAGS`], holds.
pub(super) fn parse(document: &Document, node: &Node, role: Role, notes: &Notes) -> Result<Rgb, SceneError> {
    let place = document.place(node);
    let text = match (node.attribute("value"), node.attribute("filename")) {
        (Some(text), None) => text.trim(),
        (None, Some(_)) if node.tag == "spectrum" => "",
        _ => {
            let (what, allowed) = (format!("the value of {}", node.shown()), "the attribute `value`".into());
            return Err(SceneError::Missing { place, what, allowed });
        }
    };
    let bad = |allowed: &str| SceneError::Value {
        place: place.clone(),
        what: node.shown(),
        given: quoted(text),
        allowed: allowed.into(),
    };
    let colour = match node.tag.as_str() {
        "spectrum" => spectrum(document, node, text, role, &place)?,
        "float" | "integer" => Rgb::grey(number(text).ok_or_else(|| bad("a finite number"))?),
        tag => {
            let linear = match numbers(text).as_deref() {
                Some(&[grey]) => Rgb::grey(grey),
                Some(&[r, g, b]) => Rgb::new(r, g, b),
                _ => return Err(bad("one or three finite numbers")),
            };
            if tag == "srgb" { linear.map(from_srgb) } else { linear }
        }
    };
    match (role, node.tag.as_str()) {
        // Narrow spectra leave the gamut.
        (Role::Reflectance, "spectrum") if !in_range(colour, role) => {
            let clamped = colour.map(|x| x.clamp(0.0, 1.0));
            notes
                .warn(format!("{place}: {} has the colour {colour}, out of gamut; it becomes {clamped}", node.shown()));
            Ok(clamped)
        }
        (_, "spectrum") => Ok(colour.map(|x| x.max(0.0))),
        _ if in_range(colour, role) => Ok(colour),
        _ => Err(bad(if role == Role::Reflectance { "numbers in [0, 1]" } else { "numbers ≥ 0" })),
    }
}

fn in_range(colour: Rgb, role: Role) -> bool {
    let highest = if role == Role::Reflectance { 1.0 } else { f64::MAX };
    colour.to_array().iter().all(|x| (0.0..=highest).contains(x))
}

/// A constant, a list `wavelength:value, …`, or the name of a file with a pair in every line.
fn spectrum(document: &Document, node: &Node, text: &str, role: Role, place: &Place) -> Result<Rgb, SceneError> {
    const ALLOWED: &str = "a number, `wavelength:value, …` in nm, or a file of pairs";
    if let Some(constant) = number(text) {
        return Ok(if role == Role::Light { equal_energy(constant) } else { Rgb::grey(constant) });
    }
    let malformed = |place: Place, problem: String| SceneError::Malformed { place, problem, allowed: ALLOWED.into() };
    let (samples, place) = if text.contains(':') {
        let pair = |word: &str| {
            let (wavelength, value) = word.split_once(':')?;
            Some((number(wavelength.trim())?, number(value.trim())?))
        };
        // Blanks may stand beside colons, but also instead of commas.
        let tight = text.split(':').map(str::trim).collect::<Vec<_>>().join(":");
        let words = tight.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
        let samples: Option<Vec<_>> = words.map(pair).collect();
        (samples.ok_or_else(|| malformed(place.clone(), quoted(text)))?, place.clone())
    } else {
        let name = node.attribute("filename").unwrap_or(text);
        let path = document.find_file(node, name);
        let file = source::read_text(&path, Some(place))?;
        let lines = file.lines().enumerate().map(|(at, line)| (at, line.split('#').next().unwrap_or_default().trim()));
        let pair = |(at, line): (usize, &str)| match numbers(line).as_deref() {
            Some(&[wavelength, value]) => Ok((wavelength, value)),
            _ => Err(malformed(Place::line(&path, at as u64 + 1), quoted(line))),
        };
        let samples: Result<Vec<_>, _> = lines.filter(|(_, line)| !line.is_empty()).map(pair).collect();
        (samples?, Place::whole(&path))
    };
    let spectrum = Spectrum::new(samples).map_err(|e| malformed(place, e.to_string()))?;
    Ok(if role == Role::Light { spectrum.emitted() } else { spectrum.reflected() })
}

/// The linear value of one encoded as sRGB (IEC 61966-2-1).
fn from_srgb(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
