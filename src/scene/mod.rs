//! Scenes: shapes, materials, lights and a camera, and the rays that are cast among them.

pub mod builtin;
pub mod bvh;
pub mod camera;
pub mod description;
pub mod file;
pub mod light;
pub mod material;
pub mod mesh;
pub mod rays;
pub mod shape;
pub mod texture;

mod emitter;
mod geometry;
mod quadric;
pub mod ray;

pub use camera::{Camera, Projection};
pub use description::{FilmSettings, RenderSettings, SceneDescription};
pub use emitter::{Emitters, LightSample, LightSampling, Sought};
pub use geometry::{Hit, Surface};
pub use light::{EnvironmentMap, Light};
pub use material::{LocalBsdf, Material, Varying};
pub use mesh::{Mesh, MeshError};
pub(crate) use quadric::Quadric;
pub use ray::Ray;
pub use shape::{Geometry, Shape};
pub use texture::{Bitmap, Texture, Wrap};

use glam::{DVec2, DVec3};
use thiserror::Error;

use crate::math::color::Rgb;
use emitter::Target;
use geometry::Surfaces;
use ray::{NO_TRIANGLE, offset_origin_within};

/// A scene, ready for rays.
#[derive(Debug)]
pub struct Scene {
    name: String,
    camera: Camera,
    film: FilmSettings,
    render: RenderSettings,
    materials: Vec<Material>,
    shapes: Vec<Shape>,
    surfaces: Surfaces,
    emitters: Emitters,
    /// Of each material: whether its frame must follow the texture coordinates.
    needs_tangent: Vec<bool>,
    masked: bool,
    /// The largest coordinate that rays meet or start from, by which they are moved off surfaces.
    extent: f64,
}

/// Why a scene cannot be built from its description.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum BuildError {
    /// A shape cannot be.
    #[error("shape {shape}: {reason}")]
    Shape {
        /// Its name.
        shape: String,
        /// What is wrong and what is allowed.
        reason: String,
    },
    /// A light cannot be.
    #[error("light {number}: {reason}")]
    Light {
        /// Its number among the lights that are no surfaces, from 0.
        number: usize,
        /// What is wrong and what is allowed.
        reason: String,
    },
    /// A shape names a material that does not exist.
    #[error("shape {shape} names material {material}, but there are {materials}")]
    NoSuchMaterial {
        /// The shape's name.
        shape: String,
        /// The number it names.
        material: usize,
        /// How many there are.
        materials: usize,
    },
    /// The image is empty or too large.
    #[error("the image is {width}x{height}; allowed are 1 to 65536 pixels a side")]
    ImageSize {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// There are more triangles than can be numbered.
    #[error("too many triangles or vertices; allowed are {allowed}")]
    TooManyPrimitives {
        /// The largest number.
        allowed: usize,
    },
    /// A mesh is unsound.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl Scene {
    /// Builds the scene: checks the description, and sorts its surfaces so that rays find them.
    pub fn new(description: SceneDescription) -> Result<Self, BuildError> {
        let SceneDescription { name, camera, film, render, materials, shapes, lights } = description;
        let (width, height) = (film.width, film.height);
        if !((1..=1 << 16).contains(&width) && (1..=1 << 16).contains(&height)) {
            return Err(BuildError::ImageSize { width, height });
        }
        if let Some(shape) = shapes.iter().find(|shape| shape.material >= materials.len()) {
            return Err(BuildError::NoSuchMaterial {
                shape: shape.name.clone(),
                material: shape.material,
                materials: materials.len(),
            });
        }
        // A connection would find all of its light, a ray that meets it by chance only the share that is there.
        let shines = |shape: &&Shape| shape.emission.is_some_and(|emission| !emission.is_black());
        if let Some(shape) = shapes.iter().filter(shines).find(|s| materials[s.material].opacity().is_some()) {
            let reason = "a masked surface may not emit".into();
            return Err(BuildError::Shape { shape: shape.name.clone(), reason });
        }
        let surfaces = Surfaces::new(&shapes)?;
        let emitters = Emitters::new(&shapes, &lights, &surfaces)?;
        let needs_tangent = materials.iter().map(Material::needs_tangent).collect();
        let masked = shapes.iter().any(|shape| materials[shape.material].opacity().is_some());
        let extent = surfaces.extent().max(camera.to_world.translation.abs().max_element());
        Ok(Self { name, camera, film, render, materials, shapes, surfaces, emitters, needs_tangent, masked, extent })
    }

    /// The scene's name in reports.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where it is seen from.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Size and filter of the image.
    pub fn film(&self) -> &FilmSettings {
        &self.film
    }

    /// The same scene with an image of this size.
    pub fn with_size(mut self, width: usize, height: usize) -> Self {
        (self.film.width, self.film.height) = (width, height);
        self
    }

    /// How it asks to be rendered.
    pub fn render_settings(&self) -> RenderSettings {
        self.render
    }

    /// The materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The shapes.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Everything that emits.
    pub fn emitters(&self) -> &Emitters {
        &self.emitters
    }

    /// How many triangles and quadrics there are.
    pub fn primitives(&self) -> usize {
        self.surfaces.primitive_count()
    }

    /// How many triangles there are: the first primitives.
    pub(crate) fn triangles(&self) -> usize {
        self.surfaces.triangle_count()
    }

    /// The corners of a triangle, counter-clockwise seen from its outside, and the number of its shape.
    pub(crate) fn triangle(&self, primitive: usize) -> ([DVec3; 3], usize) {
        (self.surfaces.corners(primitive), self.surfaces.triangle_shape(primitive))
    }

    /// The quadrics, in the order of their primitives after the triangles: each with the number of its shape, and 1 or, where
    /// it is turned inside out, −1.
    pub(crate) fn quadrics(&self) -> impl Iterator<Item = (Quadric, usize, f64)> {
        let all = self.surfaces.quadrics().iter();
        all.map(|&(quadric, shape)| {
            (quadric, shape as usize, if self.surfaces.is_inside_out(shape as usize) { -1.0 } else { 1.0 })
        })
    }

    /// The surface at a point of one of two primitives.
    pub(crate) fn surface_at(&self, primitives: [usize; 2], p: DVec3) -> Surface {
        self.surfaces.surface_at(primitives, p)
    }

    /// The largest coordinate that rays meet or start from.
    pub(crate) fn extent(&self) -> f64 {
        self.extent
    }

    /// The ray along `dir` from just off the point `p` of a surface with this normal.
    pub(crate) fn ray_off(&self, p: DVec3, normal: DVec3, dir: DVec3) -> Ray {
        Ray::new(offset_origin_within(p, normal, dir, self.extent), dir)
    }

    /// A point of a surface with this normal, moved off it to that side.
    pub(crate) fn lifted(&self, p: DVec3, normal: DVec3) -> DVec3 {
        offset_origin_within(p, normal, normal, self.extent)
    }

    /// Whether nothing lies between two points that are off all surfaces.
    #[inline]
    pub(crate) fn is_free(&self, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        let distance = way.length();
        rays::count(1);
        !self.surfaces.occluded(&Ray::up_to(from, way / distance, distance))
    }

    /// Whether nothing lies between two points of surfaces with these normals, each seen from the side to which its normal
    /// points.
    #[inline]
    pub(crate) fn sees(&self, (p, n): (DVec3, DVec3), (q, m): (DVec3, DVec3)) -> bool {
        self.is_free(self.lifted(p, n), self.lifted(q, m))
    }

    /// The material of a shape.
    #[inline]
    pub fn material_of(&self, shape: usize) -> &Material {
        &self.materials[self.shapes[shape].material]
    }

    /// The camera's ray through a point of the film, in pixels from the upper left corner.
    pub fn camera_ray(&self, film: DVec2, lens: DVec2) -> Ray {
        let size = DVec2::new(self.film.width as f64, self.film.height as f64);
        self.camera.ray(film / size, size.x / size.y, lens)
    }

    /// The nearest surface that the ray meets.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Option<Surface> {
        self.closest(ray).map(|hit| self.surface(ray, &hit))
    }

    /// Where the ray meets the nearest surface.
    #[allow(clippy::inline_always, reason = "as for `intersect`")]
    #[inline(always)]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<Hit> {
        rays::count(1);
        self.surfaces.closest(ray)
    }

    /// [`Self::closest`] of each ray, appended to `hits`: faster for rays that go nearly the same way.
    pub(crate) fn closest_of_each(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        rays::count(rays.len() as u64);
        self.surfaces.closest_of_each(rays, hits);
    }

    /// The surface that the ray has met.
    #[allow(clippy::inline_always, reason = "as for `intersect`")]
    #[inline(always)]
    pub(crate) fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        self.surfaces.surface(ray, hit, |shape| self.needs_tangent[self.shapes[shape].material])
    }

    /// How much of the light along the ray gets through to its end, past at most `masks` masked surfaces: 0 or 1, and
    /// anything between where surfaces are masked.
    #[allow(
        clippy::inline_always,
        reason = "the parts of a path: across calls their results are copied, at a tenth of the time"
    )]
    #[inline(always)]
    pub fn transmittance(&self, ray: &Ray, masks: u32) -> Rgb {
        if self.masked {
            return self.through_masks(*ray, masks);
        }
        rays::count(1);
        if self.surfaces.occluded(ray) { Rgb::BLACK } else { Rgb::WHITE }
    }

    /// Does `work` with the best instructions of the machine.
    #[inline]
    pub(crate) fn accelerate<W: bvh::Work>(&self, work: W) -> W::Output {
        self.surfaces.accelerate(work)
    }

    /// The ray that leaves a surface along `dir`, started just off it.
    #[inline]
    pub fn leave(&self, surface: &Surface, dir: DVec3) -> Ray {
        let origin = offset_origin_within(surface.p, surface.ng, dir, self.extent);
        Ray { beside: [surface.primitive as u32, NO_TRIANGLE, NO_TRIANGLE], ..Ray::new(origin, dir) }
    }

    /// The ray from a surface to a point drawn on an emitter, both ends just off.
    #[inline]
    pub fn shadow_ray(&self, surface: &Surface, light: &LightSample) -> Ray {
        let ray = self.leave(surface, light.wi);
        match light.target {
            None => ray,
            Some(Target { point, normal, triangles: [first, second] }) => {
                let way = offset_origin_within(point, normal, -light.wi, self.extent) - ray.origin;
                let distance = way.length();
                let [start, ..] = ray.beside;
                Ray { beside: [start, first, second], ..Ray::up_to(ray.origin, way / distance, distance) }
            }
        }
    }

    /// Draws a ray of light that starts at an emitter, chosen in proportion to its power, and the power that it carries
    /// \[W\]: the mean of that is the power of all emitters. Light from infinitely far starts on the disk that just hides the
    /// scene. None where nothing emits.
    pub fn emit(&self, choice: f64, at: DVec2, along: DVec2) -> Option<(Ray, Rgb)> {
        let drawn = self.emitters.emit(choice, at, along)?;
        let ray = match drawn.normal {
            Some(normal) => self.ray_off(drawn.point, normal, drawn.dir),
            None => Ray::new(drawn.point, drawn.dir),
        };
        Some((ray, drawn.power))
    }

    /// Area of each shape, one side of its surface.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.shapes().len()];
        for primitive in 0..self.triangles() {
            let ([a, b, c], shape) = self.triangle(primitive);
            areas[shape] += 0.5 * (b - a).cross(c - a).length();
        }
        for (quadric, shape, _) in self.quadrics() {
            areas[shape] += quadric.area();
        }
        areas
    }

    /// Area of all surfaces, one side of each.
    pub fn area(&self) -> f64 {
        self.areas().into_iter().sum()
    }

    /// Centre and radius of a sphere around all surfaces.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        self.surfaces.bounding_sphere().unwrap_or((DVec3::ZERO, 0.0))
    }

    fn through_masks(&self, mut ray: Ray, masks: u32) -> Rgb {
        let mut left = Rgb::WHITE;
        for passed in 0..=u64::from(masks) {
            let Some(surface) = self.intersect(&ray) else { return left };
            let Some(opacity) = self.material_of(surface.shape).opacity() else { return Rgb::BLACK };
            left = left * (1.0 - opaque_share(opacity, &surface));
            if left.is_black() || passed == u64::from(masks) {
                return Rgb::BLACK;
            }
            let next = self.leave(&surface, ray.dir);
            let t_max = ray.t_max - next.origin.distance(ray.origin);
            if t_max <= 0.0 {
                return left;
            }
            ray = Ray::up_to(next.origin, ray.dir, t_max);
        }
        left
    }
}

/// The share of the surface that is there at this point, in [0, 1].
pub(crate) fn opaque_share(opacity: &Texture, surface: &Surface) -> f64 {
    let share = opacity.at(surface.uv, surface.color).mean();
    if share > 0.0 { share.min(1.0) } else { 0.0 }
}
