//! What a scene file says: plain data, from which a [`Scene`](super::Scene) is built.

use super::camera::Camera;
use super::light::Light;
use super::material::Material;
use super::shape::Shape;
use crate::sampling::filter::Filter;

/// Everything that a scene file or a built-in scene says.
#[derive(Debug)]
pub struct SceneDescription {
    /// Its name in reports: the file's name without folder, or that of the built-in scene.
    pub name: String,
    /// Where it is seen from.
    pub camera: Camera,
    /// The image.
    pub film: FilmSettings,
    /// How it should be rendered; the command line goes before.
    pub render: RenderSettings,
    /// The materials.
    pub materials: Vec<Material>,
    /// The surfaces.
    pub shapes: Vec<Shape>,
    /// The lights that are no surfaces.
    pub lights: Vec<Light>,
}

/// Size and filter of the image.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The reconstruction filter.
    pub filter: Filter,
}

/// How a scene asks to be rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderSettings {
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// The largest number of reflections: None where nothing is said, `Some(None)` for no limit.
    pub bounces: Option<Option<u32>>,
    /// The number of reflections after which Russian roulette may end a path.
    pub roulette_from: Option<u32>,
}
