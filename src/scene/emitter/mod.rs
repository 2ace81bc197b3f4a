//! Everything that emits, sampled from any point: one table of emitters, chosen by power.
//!
//! The density of a direction towards the surface of emitter i is P(i) · p(ω | i) [1/sr]. The choice knows nothing of
//! the point from which one looks, so that the density of a direction found otherwise costs no sum over the emitters.

mod area;
mod emission;
mod environment;
mod points;

use glam::{DVec2, DVec3};

use super::BuildError;
use super::geometry::{Surface, Surfaces};
use super::light::Light;
use super::ray::NO_TRIANGLE;
use super::shape::Shape;
use crate::bsdf::Density;
use crate::math::color::Rgb;
use crate::sampling::discrete::AliasTable;

use area::AreaEmitter;
use environment::EnvironmentSampler;
use points::{directional, point, spot};

/// How points of the surface of an emitter are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSampling {
    /// Uniformly in solid angle where the emitter is near, in area where the two hardly differ; spheres by their cone.
    #[default]
    SolidAngle,
    /// Uniformly in area.
    Area,
}

/// Which emitters are connected to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    /// All.
    Every,
    /// All but environments that are equally bright everywhere. A reflected ray finds those with a density that follows the
    /// reflection; a direction drawn without it can but be worse, and costs a ray more.
    Uneven,
}

/// A direction towards an emitter.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector towards it.
    pub wi: DVec3,
    /// Radiance from there; for a Dirac density the irradiance perpendicular to `wi`.
    pub radiance: Rgb,
    /// The density of the draw, the choice of the emitter included.
    pub density: Density,
    /// The point of the emitter, if it is not infinitely far.
    pub(super) target: Option<Target>,
}

/// A point of an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// The triangles of which the point is one, or two that are plane together.
    pub(super) triangles: [u32; 2],
}

#[derive(Clone, Debug)]
enum Emitter {
    Area { shape: AreaEmitter, radiance: Rgb, triangles: [u32; 2] },
    Point { position: DVec3, intensity: Rgb },
    Spot { position: DVec3, axis: DVec3, intensity: Rgb, beam: f64, cutoff: f64 },
    Directional { towards: DVec3, irradiance: Rgb },
    Environment(EnvironmentSampler),
}

/// All emitters of a scene.
#[derive(Debug)]
pub struct Emitters {
    all: Vec<Emitter>,
    every: Option<AliasTable>,
    uneven: Option<AliasTable>,
    /// Emitter of each primitive; empty where no surface emits.
    of_primitive: Vec<u32>,
    /// Numbers of those that are infinitely far and not Dirac.
    environments: Vec<usize>,
    dirac: bool,
    /// Centre and radius of the sphere around all surfaces.
    bounds: (DVec3, f64),
}

const NONE: u32 = u32::MAX;

impl Emitters {
    pub(super) fn new(shapes: &[Shape], lights: &[Light], surfaces: &Surfaces) -> Result<Self, BuildError> {
        let mut emitters = Vec::new();
        let mut of_primitive = Vec::new();
        if shapes.iter().any(|shape| shape.emission.is_some_and(|e| !e.is_black())) {
            of_primitive = vec![NONE; surfaces.primitive_count()];
        }
        for shape in shapes {
            if let Some(radiance) = shape.emission.filter(|e| !(e.is_finite() && e.min_channel() >= 0.0)) {
                let reason = format!("its emitted radiance {radiance} is not finite and ≥ 0");
                return Err(BuildError::Shape { shape: shape.name.clone(), reason });
            }
        }
        let radiance_of = |shape: usize| shapes[shape].emission.filter(|e| !e.is_black());
        let mut triangle = 0;
        while !of_primitive.is_empty() && triangle < surfaces.triangle_count() {
            let shape = surfaces.triangle_shape(triangle);
            let Some(radiance) = radiance_of(shape) else {
                triangle += 1;
                continue;
            };
            let number = emitters.len() as u32;
            let here = surfaces.corners(triangle);
            let next = (triangle + 1 < surfaces.triangle_count() && surfaces.triangle_shape(triangle + 1) == shape)
                .then(|| surfaces.corners(triangle + 1));
            of_primitive[triangle] = number;
            let mut triangles = [triangle as u32; 2];
            let shape = match next.and_then(|next| AreaEmitter::rectangle_of(here, next)) {
                Some(rectangle) => {
                    triangle += 1;
                    of_primitive[triangle] = number;
                    triangles[1] = triangle as u32;
                    rectangle
                }
                None => AreaEmitter::triangle(here),
            };
            emitters.push(Emitter::Area { shape, radiance, triangles });
            triangle += 1;
        }
        for (i, (quadric, shape)) in surfaces.quadrics().iter().enumerate() {
            if let Some(radiance) = radiance_of(*shape as usize) {
                of_primitive[surfaces.triangle_count() + i] = emitters.len() as u32;
                let inside_out = surfaces.is_inside_out(*shape as usize);
                let shape = AreaEmitter::quadric(*quadric, inside_out);
                emitters.push(Emitter::Area { shape, radiance, triangles: [NO_TRIANGLE; 2] });
            }
        }
        for (i, light) in lights.iter().enumerate() {
            emitters.push(Emitter::of_light(light, i)?);
        }
        let bounds = surfaces.bounding_sphere().unwrap_or((DVec3::ZERO, 1.0));
        let powers: Vec<f64> = emitters.iter().map(|emitter| emitter.power(bounds.1)).collect();
        let environments = (0..emitters.len()).filter(|&i| matches!(emitters[i], Emitter::Environment(_))).collect();
        let dirac = emitters.iter().any(Emitter::is_dirac);
        let is_even = |emitter: &Emitter| matches!(emitter, Emitter::Environment(EnvironmentSampler::Constant(_)));
        let of_uneven = powers.iter().zip(&emitters).map(|(power, e)| if is_even(e) { 0.0 } else { *power });
        let uneven = AliasTable::new(&of_uneven.collect::<Vec<_>>());
        Ok(Self { every: AliasTable::new(&powers), uneven, all: emitters, of_primitive, environments, dirac, bounds })
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        self.every.is_none()
    }

    /// Whether there is a light that no ray can hit by chance: a point, a spot or parallel light.
    pub fn has_dirac(&self) -> bool {
        self.dirac
    }

    /// Whether there is a light that is not a surface.
    pub fn has_others_than_surfaces(&self) -> bool {
        self.all.iter().any(|emitter| !matches!(emitter, Emitter::Area { .. }))
    }

    /// Whether there is an emitter to connect to.
    #[inline]
    pub fn any(&self, sought: Sought) -> bool {
        self.among(sought).is_some()
    }

    #[inline]
    fn among(&self, sought: Sought) -> Option<&AliasTable> {
        match sought {
            Sought::Every => self.every.as_ref(),
            Sought::Uneven => self.uneven.as_ref(),
        }
    }

    /// Draws a direction from `p` towards one of the emitters sought: `choice` picks the emitter, `u` the point of it.
    #[allow(clippy::inline_always, reason = "the part of a path that costs most besides rays")]
    #[inline(always)]
    pub fn sample(&self, sought: Sought, by: LightSampling, p: DVec3, choice: f64, u: DVec2) -> Option<LightSample> {
        let (number, probability, _) = self.among(sought)?.pick(choice);
        let mut sample = match &self.all[number] {
            Emitter::Area { shape, radiance, triangles } => {
                let drawn = shape.sample(by, p, u)?;
                LightSample {
                    wi: drawn.wi,
                    radiance: *radiance,
                    density: Density::SolidAngle(drawn.pdf),
                    target: Some(Target { point: drawn.point, normal: drawn.normal, triangles: *triangles }),
                }
            }
            Emitter::Point { position, intensity } => point(p, *position, *intensity)?,
            Emitter::Spot { position, axis, intensity, beam, cutoff } => {
                spot(p, *position, *axis, *intensity, (*beam, *cutoff))?
            }
            Emitter::Directional { towards, irradiance } => directional(*towards, *irradiance),
            Emitter::Environment(environment) => {
                let (wi, radiance, pdf) = environment.sample(u);
                LightSample { wi, radiance, density: Density::SolidAngle(pdf), target: None }
            }
        };
        sample.density = match sample.density {
            Density::SolidAngle(pdf) => Density::SolidAngle(pdf * probability),
            Density::Dirac(p) => Density::Dirac(p * probability),
        };
        Some(sample)
    }

    /// The radiance that leaves a surface towards `wo` by emission: that of its outside.
    #[inline]
    pub fn emitted(&self, surface: &Surface, wo: DVec3) -> Option<(usize, Rgb)> {
        let number = *self.of_primitive.get(surface.primitive)?;
        if number == NONE || surface.ng.dot(wo) <= 0.0 {
            return None;
        }
        match &self.all[number as usize] {
            Emitter::Area { radiance, .. } => Some((number as usize, *radiance)),
            _ => None,
        }
    }

    /// The density [1/sr] with which [`Emitters::sample`] draws, from `p` and among the uneven emitters, the direction `wi` to
    /// this point of emitter `number`.
    #[inline]
    pub fn pdf(&self, by: LightSampling, number: usize, p: DVec3, wi: DVec3, surface: &Surface) -> f64 {
        let (Emitter::Area { shape, .. }, Some(choice)) = (&self.all[number], &self.uneven) else { return 0.0 };
        choice.probability(number) * shape.pdf(by, p, wi, surface)
    }

    /// The radiance from infinitely far along `wi`, emitter by emitter, each with the density [1/sr] of drawing it among the
    /// uneven ones.
    #[inline]
    pub fn escaped(&self, wi: DVec3) -> impl Iterator<Item = (Rgb, f64)> {
        self.environments.iter().filter_map(move |&number| {
            let Emitter::Environment(environment) = &self.all[number] else { return None };
            let (radiance, pdf) = environment.eval(wi);
            Some((radiance, pdf * self.uneven.as_ref().map_or(0.0, |choice| choice.probability(number))))
        })
    }
}

impl Emitter {
    fn of_light(light: &Light, number: usize) -> Result<Self, BuildError> {
        let refuse = |reason: &str| BuildError::Light { number, reason: reason.into() };
        let sound = |name: &str, colour: Rgb| {
            let good = colour.is_finite() && colour.min_channel() >= 0.0;
            good.then_some(colour).ok_or_else(|| refuse(&format!("its {name} {colour} is not finite and ≥ 0")))
        };
        let unit = |w: DVec3| w.try_normalize().ok_or_else(|| refuse("its direction has no length"));
        Ok(match light {
            Light::Point { position, intensity } => {
                Self::Point { position: *position, intensity: sound("intensity", *intensity)? }
            }
            Light::Spot { position, direction, intensity, beam, cutoff } => {
                if !(*beam >= 0.0 && beam <= cutoff && *cutoff <= std::f64::consts::PI) {
                    return Err(refuse("its angles must be 0 ≤ beam ≤ cutoff ≤ π"));
                }
                let intensity = sound("intensity", *intensity)?;
                Self::Spot { position: *position, axis: unit(*direction)?, intensity, beam: *beam, cutoff: *cutoff }
            }
            Light::Directional { direction, irradiance } => {
                Self::Directional { towards: -unit(*direction)?, irradiance: sound("irradiance", *irradiance)? }
            }
            Light::Constant { radiance } => {
                Self::Environment(EnvironmentSampler::constant(sound("radiance", *radiance)?))
            }
            Light::Environment(map) => {
                let sampler = EnvironmentSampler::of_map(map.clone());
                Self::Environment(sampler.ok_or_else(|| refuse("its picture has no pixel that shines, or a bad one"))?)
            }
        })
    }

    /// Emitted power \[W\], up to what a scene of this radius receives.
    fn power(&self, radius: f64) -> f64 {
        use std::f64::consts::{PI, TAU};
        match self {
            Self::Area { shape, radiance, .. } => PI * shape.area() * radiance.mean(),
            Self::Point { intensity, .. } => 2.0 * TAU * intensity.mean(),
            Self::Spot { intensity, beam, cutoff, .. } => {
                TAU * (1.0 - (0.5 * (beam + cutoff)).cos()) * intensity.mean()
            }
            Self::Directional { irradiance, .. } => PI * radius * radius * irradiance.mean(),
            Self::Environment(environment) => PI * radius * radius * environment.total(),
        }
    }

    fn is_dirac(&self) -> bool {
        matches!(self, Self::Point { .. } | Self::Spot { .. } | Self::Directional { .. })
    }
}
