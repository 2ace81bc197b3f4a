//! A solution as light: what a camera, or any other ray, sees of it.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::patch::{Curved, Form};
use super::patches::Patches;
use crate::bsdf::Density;
use crate::math::color::Rgb;
use crate::math::frame::Frame;
use crate::render::Radiance;
use crate::sampling::sampler::Sampler;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::{LightSampling, Ray, Scene, Sought, Surface};

/// How a solution is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Display {
    /// Each patch in its own radiosity: what was solved, and nothing else.
    #[default]
    Patches,
    /// Interpolated between the corners of the patches of a face: it looks smooth, and is no more right.
    Smooth,
    /// What is seen gathers the light of the patches once more, by a ray of each sample.
    Gather,
    /// The same with the light of the emitters by connections, so that the patches bring what is reflected alone.
    GatherDirect,
}

/// Radiosities of the patches of a scene.
#[derive(Debug)]
pub struct RadiositySolution {
    patches: Patches,
    radiosity: Vec<Rgb>,
    display: Display,
    /// Radiosities at the corners of each patch, if they are shown.
    corners: Vec<Vec<Rgb>>,
}

impl RadiositySolution {
    /// Of one radiosity [W/m²] for each patch.
    pub(super) fn new(patches: Patches, radiosity: Vec<Rgb>, display: Display) -> Self {
        let corners = if display == Display::Smooth { at_corners(&patches, &radiosity) } else { Vec::new() };
        Self { patches, radiosity, display, corners }
    }

    /// The patches.
    pub fn patches(&self) -> &Patches {
        &self.patches
    }

    /// The radiosity of each patch [W/m²].
    pub fn radiosity(&self) -> &[Rgb] {
        &self.radiosity
    }

    /// The radiosity at a point of a surface, seen from `wo`; black on a side that is.
    fn shown(&self, surface: &Surface, wo: DVec3) -> Rgb {
        let Some(patch) = self.patches.at(surface, wo) else { return Rgb::BLACK };
        match self.corners.get(patch) {
            Some(corners) => interpolated(&self.patches.all()[patch].form, corners, surface.p),
            None => self.radiosity[patch],
        }
    }

    /// What the surface gathers in one sample, emission included.
    fn gathered(&self, scene: &Scene, surface: &Surface, wo: DVec3, sampler: &mut dyn Sampler) -> Rgb {
        let emitted = scene.emitters().emitted(surface, wo).map_or(Rgb::BLACK, |(_, radiance)| radiance);
        let Some(patch) = self.patches.at(surface, wo) else { return emitted };
        let n = if surface.ng.dot(wo) > 0.0 { surface.ng } else { -surface.ng };
        let ray = scene.ray_off(surface.p, n, Frame::about(n).to_world(cosine_hemisphere(sampler.next_2d())));
        let direct = self.display == Display::GatherDirect;
        let mut incoming = Rgb::BLACK;
        if let Some(sender) = scene.intersect(&ray).and_then(|met| self.patches.at(&met, -ray.dir)) {
            let own = if direct { self.patches.all()[sender].emission } else { Rgb::BLACK };
            // A density of cos / π: the mean of radiances is E / π, and B / π the radiance.
            incoming += self.radiosity[sender] - own;
        }
        if direct {
            incoming += irradiance_by_connection(scene, surface, n, sampler);
        }
        emitted + self.patches.reflectance_at(scene, patch, surface) * incoming * FRAC_1_PI
    }
}

/// One sample of the irradiance from the emitters, by a connection to one of them [W/m²].
fn irradiance_by_connection(scene: &Scene, surface: &Surface, n: DVec3, sampler: &mut dyn Sampler) -> Rgb {
    let (choice, u) = (sampler.next_1d(), sampler.next_2d());
    let drawn = scene.emitters().sample(Sought::Every, LightSampling::default(), surface.p, choice, u);
    drawn.filter(|light| light.wi.dot(n) > 0.0).map_or(Rgb::BLACK, |light| {
        let (Density::SolidAngle(p) | Density::Dirac(p)) = light.density;
        light.radiance * (light.wi.dot(n) / p) * scene.transmittance(&scene.shadow_ray(surface, &light), 0)
    })
}

impl Radiance for RadiositySolution {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        let Some(surface) = scene.intersect(&ray) else { return Rgb::BLACK };
        match self.display {
            Display::Patches | Display::Smooth => self.shown(&surface, -ray.dir) * FRAC_1_PI,
            Display::Gather | Display::GatherDirect => self.gathered(scene, &surface, -ray.dir, sampler),
        }
    }
}

/// Corners closer than this share of the largest coordinate are one.
const SAME: f64 = 1e-7;

/// Of every corner of every patch the mean radiosity, by area, of the patches of its face that have it.
fn at_corners(patches: &Patches, radiosity: &[Rgb]) -> Vec<Vec<Rgb>> {
    let unit = SAME * patches.extent();
    let key = |face: usize, p: DVec3| (face, (p / unit).round().as_i64vec3().to_array());
    let mut sums: BTreeMap<_, (Rgb, f64)> = BTreeMap::new();
    for (patch, &b) in patches.all().iter().zip(radiosity) {
        for corner in corners(&patch.form) {
            let sum = sums.entry(key(patch.face, corner)).or_default();
            *sum = (sum.0 + b * patch.area, sum.1 + patch.area);
        }
    }
    let mean = |face: usize, p: DVec3| {
        let (sum, area) = sums[&key(face, p)];
        sum / area
    };
    patches.all().iter().map(|patch| corners(&patch.form).map(|corner| mean(patch.face, corner)).collect()).collect()
}

/// The corners of a patch, around it.
fn corners(form: &Form) -> impl Iterator<Item = DVec3> + '_ {
    let (flat, curved) = match form {
        Form::Flat(polygon) => (polygon.corners(), None),
        Form::Curved(Curved { surface, from, size }) => {
            let around = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
            (&[][..], Some(around.map(|corner| surface.at(*from + *size * corner).0)))
        }
    };
    flat.iter().copied().chain(curved.into_iter().flatten())
}

/// The value at `p` between those at the corners: with Wachspress' weights in a polygon, bilinear on a curved patch.
fn interpolated(form: &Form, values: &[Rgb], p: DVec3) -> Rgb {
    match form {
        Form::Flat(polygon) => {
            let (at, n) = (polygon.corners(), polygon.normal());
            // Twice the areas of the triangles of p and each edge; on the edge itself not quite 0, so that all weights are finite.
            let least = 1e-9 * polygon.area();
            let beside: Vec<f64> = polygon.edges().map(|(a, b)| (a - p).cross(b - p).dot(n).max(least)).collect();
            let count = at.len();
            let weights = (0..count).map(|i| {
                let (before, after) = ((i + count - 1) % count, (i + 1) % count);
                let corner = (at[i] - at[before]).cross(at[after] - at[i]).dot(n);
                corner / (beside[before] * beside[i])
            });
            let (sum, weight) = weights
                .zip(values)
                .fold((Rgb::BLACK, 0.0), |(sum, total), (weight, &value)| (sum + value * weight, total + weight));
            sum / weight
        }
        Form::Curved(Curved { surface, from, size }) => {
            let u = ((surface.quadric.sample_area_inv(p) - *from) / *size).clamp(DVec2::ZERO, DVec2::ONE);
            let weights = [(1.0 - u.x) * (1.0 - u.y), u.x * (1.0 - u.y), u.x * u.y, (1.0 - u.x) * u.y];
            weights.iter().zip(values).map(|(&weight, &value)| value * weight).sum()
        }
    }
}
