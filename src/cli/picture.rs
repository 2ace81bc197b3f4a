//! A picture of light that has been found already: so many samples of each pixel, written in every format asked for.

use std::path::PathBuf;

use anyhow::Context;

use super::progress;
use crate::image::{Format, Image};
use crate::render::Radiance;
use crate::render::film::Film;
use crate::render::photon::stated::{OfMap, map_errors};
use crate::render::progressive::{self, Job, Stop};
use crate::render::provenance::{Provenance, Run};
use crate::report::save::Target;
use crate::sampling::sampler::SamplerKind;
use crate::scene::Scene;

/// An image that is to be written: where, how, and under what name.
pub(super) type Named = (Target, Format, PathBuf);

/// Samples of a pixel by which the error of a map in it is found, at most.
const MAP_SAMPLES: u64 = 4;

/// The planes `Map.StdErr` and `Map.Bias` of an image that a photon map is part of.
#[derive(Debug)]
pub(super) struct MapErrors([Vec<f32>; 2]);

impl MapErrors {
    /// By no more samples of a pixel than it has. None where no image has room for planes.
    pub(super) fn of(
        scene: &Scene,
        light: &dyn OfMap,
        images: &[Named],
        samples: u64,
        (seed, quiet): (u64, bool),
    ) -> Option<Self> {
        let wanted = images.iter().any(|(_, format, _)| *format == Format::Exr);
        wanted.then(|| {
            let clock = progress::clock(quiet, "error of the photon map".into());
            let errors = map_errors(scene, light, samples.min(MAP_SAMPLES) as u32, seed);
            clock.finish_and_clear();
            Self(errors)
        })
    }

    pub(super) fn push(&self, image: &mut Image) -> anyhow::Result<()> {
        for (name, plane) in ["Map.StdErr", "Map.Bias"].into_iter().zip(&self.0) {
            image.push(name, plane.clone())?;
        }
        Ok(())
    }
}

pub(super) struct Picture<'a> {
    pub(super) scene: &'a Scene,
    pub(super) light: &'a dyn Radiance,
    /// Where a photon map is part of it.
    pub(super) map_errors: Option<MapErrors>,
    /// What the light is, in words.
    pub(super) how: String,
    /// Samples per pixel.
    pub(super) samples: u64,
    pub(super) seed: u64,
    /// Stops by which a PNG is made brighter.
    pub(super) exposure: f64,
    pub(super) quiet: bool,
}

impl Picture<'_> {
    /// Renders it with a bar on standard error, and writes the files.
    pub(super) fn write(&self, images: &[Named]) -> anyhow::Result<()> {
        let Self { scene, samples, .. } = *self;
        let (width, height) = (scene.film().width, scene.film().height);
        let kind = SamplerKind::default();
        let sampler = kind.sampler(self.seed, samples, width as u64);
        let job = Job { scene, radiance: self.light, filter: &scene.film().filter, sampler: &sampler };
        let mut film = Film::new(width, height).with_batches(progressive::batch_for(kind, Some(samples)));
        let interrupted = progress::interruption();
        let bar = progress::bar(self.quiet);
        let cost = progressive::render(&job, &mut film, Stop::Samples(samples), &interrupted, &mut |_, now| {
            progress::show(&bar, &format!("{} samples per pixel", now.samples), now.seconds, 0.0, now.share);
        });
        bar.finish_and_clear();
        let settings = format!("{width}x{height}, {}", self.how);
        let run = Run { seed: self.seed, first: 0, count: film.most_drawn() };
        let mut image = film.to_image(&Provenance::new(scene.name(), &settings, run, cost.seconds).metadata());
        if let Some(errors) = &self.map_errors {
            errors.push(&mut image)?;
        }
        for (target, format, path) in images {
            let bytes = image.encode(*format, self.exposure)?;
            target.write(&bytes).with_context(|| format!("-o {}: cannot be written", path.display()))?;
        }
        Ok(())
    }
}
