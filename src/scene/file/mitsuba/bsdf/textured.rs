//! Models whose parameters are textures.

use std::fmt;
use std::sync::Arc;

use glam::DVec2;

use super::Model;
use crate::bsdf::{Bsdf, Lambert, Lobes, ParamError};
use crate::math::color::Rgb;
use crate::scene::material::Varying;
use crate::scene::texture::Texture;

/// The narrowest and widest slopes that microfacet models take.
const ALPHA: (f64, f64) = (1e-4, 1.0);

/// The values of textures at one point.
#[derive(Debug)]
pub(super) struct Values(Vec<Rgb>);

impl Values {
    /// The colour number `at` in [0, 1]; NaN is 0.
    pub(super) fn unit(&self, at: usize) -> Rgb {
        self.0.get(at).map_or(Rgb::BLACK, |colour| colour.map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 }))
    }

    /// The slope width number `at`, within what models take.
    pub(super) fn alpha(&self, at: usize) -> f64 {
        let alpha = self.0.get(at).map_or(0.0, |colour| colour.luminance());
        if alpha > ALPHA.0 { alpha.min(ALPHA.1) } else { ALPHA.0 }
    }
}

/// A model that `make` builds from the values of `textures`.
pub(super) struct Textured<F> {
    pub(super) textures: Vec<Texture>,
    pub(super) lobes: Lobes,
    pub(super) make: F,
}

impl<F> fmt::Debug for Textured<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Textured").field("textures", &self.textures).finish_non_exhaustive()
    }
}

impl<F> Varying for Textured<F>
where
    F: Fn(&Values) -> Result<Box<dyn Bsdf>, ParamError> + Send + Sync,
{
    fn at(&self, uv: DVec2, vertex_color: Rgb) -> Box<dyn Bsdf> {
        let values = Values(self.textures.iter().map(|texture| texture.at(uv, vertex_color)).collect());
        // Values are within the domains, so that this fails nowhere; were it to, nothing would be reflected.
        (self.make)(&values).unwrap_or_else(|_| black())
    }

    fn lobes(&self) -> Lobes {
        self.lobes
    }
}

/// What `make` builds: once, if no texture varies.
pub(super) fn model<F>(textures: Vec<Texture>, make: F) -> Result<Model, ParamError>
where
    F: Fn(&Values) -> Result<Box<dyn Bsdf>, ParamError> + Send + Sync + 'static,
{
    let first = Values(textures.iter().map(|texture| texture.at(DVec2::ZERO, Rgb::WHITE)).collect());
    let first = make(&first)?;
    if textures.iter().all(|texture| matches!(texture, Texture::Constant(_))) {
        return Ok(Model::Uniform(Arc::from(first)));
    }
    Ok(Model::Varying(Box::new(Textured { lobes: first.lobes(), textures, make })))
}

pub(super) fn black() -> Box<dyn Bsdf> {
    Box::new(Lambert::default())
}
