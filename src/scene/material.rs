//! Materials: a model of reflection at every point of a surface.

use std::fmt;

use glam::{DVec2, DVec3};

use super::texture::Texture;
use crate::bsdf::{Bsdf, BsdfSample, Density, Ggx, Lambert, Lobes, Uniforms};
use crate::math::color::Rgb;
use crate::math::frame::Frame;
use crate::sampling::warp::{cosine_about, cosine_about_pdf};

/// A model of reflection at every point of a surface, with the opacity of the surface.
#[derive(Debug)]
pub struct Material {
    name: String,
    model: Model,
    two_sided: bool,
    opacity: Option<Texture>,
}

/// A model whose parameters vary over the surface.
pub trait Varying: fmt::Debug + Send + Sync {
    /// The model at the texture coordinates `uv`, where the mesh has this colour.
    fn at(&self, uv: DVec2, vertex_color: Rgb) -> Box<dyn Bsdf>;

    /// The kinds of lobes that it has anywhere.
    fn lobes(&self) -> Lobes;
}

#[derive(Debug)]
enum Model {
    Lambert(Lambert),
    TexturedLambert(Texture),
    Ggx(Box<Ggx>),
    Uniform(Box<dyn Bsdf>),
    Varying(Box<dyn Varying>),
}

impl Material {
    /// A diffuse surface whose reflectance is a texture.
    pub fn diffuse(name: impl Into<String>, reflectance: Texture) -> Self {
        let model = match reflectance {
            Texture::Constant(rho) => match Lambert::new(rho) {
                Ok(lambert) => Model::Lambert(lambert),
                Err(_) => Model::TexturedLambert(Texture::Constant(rho)),
            },
            varying => Model::TexturedLambert(varying),
        };
        Self { name: name.into(), model, two_sided: false, opacity: None }
    }

    /// A GGX surface. The same as [`Material::uniform`], but faster.
    pub fn ggx(name: impl Into<String>, ggx: Ggx) -> Self {
        Self { name: name.into(), model: Model::Ggx(Box::new(ggx)), two_sided: false, opacity: None }
    }

    /// The same model everywhere.
    pub fn uniform(name: impl Into<String>, bsdf: Box<dyn Bsdf>) -> Self {
        Self { name: name.into(), model: Model::Uniform(bsdf), two_sided: false, opacity: None }
    }

    /// A model whose parameters vary over the surface.
    pub fn varying(name: impl Into<String>, varying: Box<dyn Varying>) -> Self {
        Self { name: name.into(), model: Model::Varying(varying), two_sided: false, opacity: None }
    }

    /// The same on both sides of the surface: a model of reflection whose back looks like its front.
    pub fn two_sided(mut self) -> Self {
        self.two_sided = true;
        self
    }

    /// The same where the surface is there only in part: 0 lets everything pass, 1 nothing.
    pub fn with_opacity(mut self, opacity: Texture) -> Self {
        self.opacity = Some(opacity);
        self
    }

    /// Its name in the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the back looks like the front.
    pub fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    /// The share of the surface that is there, if not all of it.
    pub fn opacity(&self) -> Option<&Texture> {
        self.opacity.as_ref()
    }

    /// The reflectance, if the surface is diffuse and the same everywhere.
    pub fn lambertian(&self) -> Option<Rgb> {
        match &self.model {
            Model::Lambert(lambert) => lambert.albedo(DVec3::Z),
            _ => None,
        }
    }

    /// Whether the surface is diffuse everywhere, with a reflectance that may vary.
    pub fn is_diffuse(&self) -> bool {
        matches!(self.model, Model::Lambert(_) | Model::TexturedLambert(_))
    }

    /// Whether the model may differ from point to point.
    pub fn varies(&self) -> bool {
        matches!(self.model, Model::TexturedLambert(_) | Model::Varying(_))
    }

    /// The kinds of lobes that it has anywhere.
    pub fn lobes(&self) -> Lobes {
        match &self.model {
            Model::Lambert(_) | Model::TexturedLambert(_) | Model::Ggx(_) => Lobes::REFLECT,
            Model::Uniform(bsdf) => bsdf.lobes(),
            Model::Varying(varying) => varying.lobes(),
        }
    }

    /// Whether the model may look different when it is turned about the normal, so that its frame must follow the
    /// texture coordinates.
    pub fn needs_tangent(&self) -> bool {
        match &self.model {
            Model::Lambert(_) | Model::TexturedLambert(_) => false,
            Model::Ggx(ggx) => ggx.normals().is_none_or(|normals| {
                let widths = normals.slope_widths();
                widths.x != widths.y
            }),
            Model::Uniform(_) | Model::Varying(_) => true,
        }
    }

    /// The model at a point of the surface.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub fn at(&self, uv: DVec2, vertex_color: Rgb) -> LocalBsdf<'_> {
        let model = match &self.model {
            Model::Lambert(lambert) => Local::Lambert(*lambert),
            Model::TexturedLambert(texture) => Local::Lambert(clamped_lambert(texture.at(uv, vertex_color))),
            Model::Ggx(ggx) => Local::Ggx(ggx),
            Model::Uniform(bsdf) => Local::Borrowed(&**bsdf),
            Model::Varying(varying) => Local::Owned(varying.at(uv, vertex_color)),
        };
        LocalBsdf { model, two_sided: self.two_sided }
    }
}

/// A diffuse model of this reflectance, clamped to [0, 1] where a picture exceeds it. NaN is 0.
fn clamped_lambert(rho: Rgb) -> Lambert {
    let clamped = rho.map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 });
    Lambert::new(clamped).unwrap_or_default()
}

/// The model of reflection at one point: built-in models are called directly, all others through the trait.
#[derive(Debug)]
pub struct LocalBsdf<'a> {
    model: Local<'a>,
    two_sided: bool,
}

#[derive(Debug)]
enum Local<'a> {
    Lambert(Lambert),
    Ggx(&'a Ggx),
    Borrowed(&'a dyn Bsdf),
    Owned(Box<dyn Bsdf>),
}

macro_rules! dispatch {
    ($local:expr, $model:ident => $call:expr) => {
        match &$local.model {
            Local::Lambert($model) => $call,
            Local::Ggx($model) => $call,
            Local::Borrowed($model) => $call,
            Local::Owned($model) => $call,
        }
    };
}

impl LocalBsdf<'_> {
    /// f(wo, wi) [1/sr] without the cosine.
    #[inline]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let (wo, wi) = (self.seen(wo, wo), self.seen(wo, wi));
        dispatch!(self, model => model.eval(wo, wi))
    }

    /// Both [`eval`](Self::eval) and [`pdf`](Self::pdf).
    #[inline]
    pub fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let (wo, wi) = (self.seen(wo, wo), self.seen(wo, wi));
        dispatch!(self, model => model.eval_pdf(wo, wi))
    }

    /// Density [1/sr] of `wi` given `wo`.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let (wo, wi) = (self.seen(wo, wo), self.seen(wo, wi));
        dispatch!(self, model => model.pdf(wo, wi))
    }

    /// Draws `wi`.
    #[inline]
    pub fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let seen = self.seen(wo, wo);
        let draw = dispatch!(self, model => model.sample(seen, u))?;
        Some(BsdfSample { wi: self.seen(wo, draw.wi), ..draw })
    }

    /// Draws `wi` as [`sample`](Self::sample) does, but in the world, where `frame` is the local space.
    ///
    /// A diffuse model's numbers stand for a point of a sphere that does not turn with the frame. Where normals vary within
    /// a pixel, close numbers then still give close directions, and points that are good in four dimensions, pixel and
    /// direction, stay so.
    #[inline]
    pub fn sample_in(&self, frame: &Frame, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let Local::Lambert(lambert) = &self.model else {
            let draw = self.sample(wo, u)?;
            return Some(BsdfSample { wi: frame.to_world(draw.wi), ..draw });
        };
        let n = if self.two_sided && wo.z < 0.0 { -frame.n } else { frame.n };
        let wi = cosine_about(n, u.dir);
        let pdf = cosine_about_pdf(n, wi);
        let lit = self.seen(wo, wo).z > 0.0 && pdf > 0.0;
        lit.then_some(BsdfSample { wi, weight: lambert.rho(), density: Density::SolidAngle(pdf) })
    }

    /// The kinds of lobes.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        dispatch!(self, model => model.lobes())
    }

    /// Index of refraction of the interior over that of the exterior.
    #[inline]
    pub fn eta(&self) -> f64 {
        dispatch!(self, model => model.eta())
    }

    /// `w`, mirrored where `wo` looks at the back of a surface whose back is like its front.
    #[inline]
    fn seen(&self, wo: DVec3, w: DVec3) -> DVec3 {
        if self.two_sided && wo.z < 0.0 { DVec3::new(w.x, w.y, -w.z) } else { w }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::warp::uniform_sphere;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn draws_in_the_world_are_of_the_model(
            (x, y, z) in (0.0..1.0_f64, 0.0..1.0_f64, -0.99..0.99_f64),
            (u, v) in (0.0..1.0_f64, 0.0..1.0_f64),
            (two_sided, diffuse) in any::<(bool, bool)>(),
        ) {
            let frame = Frame::about(uniform_sphere(DVec2::new(x, y)));
            let wo = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
            let material = if diffuse {
                Material::diffuse("", Rgb::grey(0.7).into())
            } else {
                Material::ggx("", Ggx::new(0.6).unwrap())
            };
            let material = if two_sided { material.two_sided() } else { material };
            let local = material.at(DVec2::ZERO, Rgb::WHITE);
            let drawn = local.sample_in(&frame, wo, Uniforms::new(0.5, u, v));
            if diffuse {
                prop_assert_eq!(drawn.is_some(), z > 0.0 || two_sided && z < 0.0);
            }
            let Some(drawn) = drawn else { return Ok(()) };
            let wi = frame.to_local(drawn.wi);
            let (f, pdf) = local.eval_pdf(wo, wi);
            let Density::SolidAngle(density) = drawn.density else { panic!("no Dirac lobes here") };
            // A thousand roundings, over a cosine that may be small.
            let tolerance = 1e-13 / wi.z.abs();
            prop_assert!((density / pdf - 1.0).abs() <= tolerance, "{density} against {pdf}");
            prop_assert!((drawn.weight.0.x / (f.0.x * wi.z.abs() / pdf) - 1.0).abs() <= tolerance);
        }
    }
}
