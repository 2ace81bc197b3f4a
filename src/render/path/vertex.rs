//! A point at which a path is scattered.

use glam::DVec3;

use crate::bsdf::{BsdfSample, Uniforms};
use crate::math::color::Rgb;
use crate::math::frame::Frame;
use crate::scene::{LocalBsdf, Ray, Scene, Surface};

/// A surface with its model of reflection, and the direction from which the path came.
#[derive(Debug)]
pub(in crate::render) struct Vertex<'a> {
    pub(in crate::render) surface: &'a Surface,
    /// The frame in which the model is evaluated.
    pub(in crate::render) frame: Frame,
    pub(in crate::render) bsdf: LocalBsdf<'a>,
    /// Local.
    pub(in crate::render) wo: DVec3,
}

impl<'a> Vertex<'a> {
    /// Where `ray` has met `surface`.
    ///
    /// Where an interpolated normal faces away from a viewer whom the triangle faces, the triangle's own normal counts,
    /// so that nothing turns black.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub(in crate::render) fn new(scene: &'a Scene, ray: &Ray, surface: &'a Surface) -> Self {
        let mut frame = surface.frame;
        let mut wo = frame.to_local(-ray.dir);
        if wo.z * surface.ng.dot(-ray.dir) <= 0.0 {
            frame = Frame::about(surface.ng);
            wo = frame.to_local(-ray.dir);
        }
        let bsdf = scene.material_of(surface.shape).at(surface.uv, surface.color);
        Self { surface, frame, bsdf, wo }
    }

    /// f |cos| towards `wi` in the world, and the density [1/sr] with which [`Vertex::sample`] draws it. Black where
    /// the interpolated normal and the triangle's disagree about the side, so that nothing leaks.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub(in crate::render) fn eval(&self, wi: DVec3) -> (Rgb, f64) {
        let local = self.frame.to_local(wi);
        if local.z * wi.dot(self.surface.ng) <= 0.0 {
            return (Rgb::BLACK, 0.0);
        }
        let (f, pdf) = self.bsdf.eval_pdf(self.wo, local);
        (f * local.z.abs(), pdf)
    }

    /// Draws a direction, in the world.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub(in crate::render) fn sample(&self, u: Uniforms) -> Option<BsdfSample> {
        let drawn = self.bsdf.sample_in(&self.frame, self.wo, u)?;
        (drawn.wi.dot(self.frame.n) * drawn.wi.dot(self.surface.ng) > 0.0).then_some(drawn)
    }
}
