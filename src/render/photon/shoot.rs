//! Photons on their way: emitted in proportion to power, scattered by any model, ended by roulette.
//!
//! Roulette goes on with probability min(1, max Φ' / max Φ), the largest channels after and before a reflection, and
//! divides by it: the largest channel of a photon never changes where surfaces take away light, and colours do. Past
//! [`LONG`] reflections the probability is at most 9/10, so that light in a room that absorbs nothing is given up.
//!
//! The photons are cut into batches of [`BATCH`], each with its own stream: the same seed gives the same bits for any number of
//! threads.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::tally::Tally;
use super::{History, Kept, Photon, PhotonError};
use crate::bsdf::{Density, Lobes};
use crate::math::color::Rgb;
use crate::render::path::vertex::Vertex;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{Ray, Scene, Surface, opaque_share};
use glam::DVec3;

/// Photons with one stream.
pub const BATCH: u64 = 1024;
/// Reflections from which on roulette ends every path.
pub const LONG: u32 = 1000;
/// Batches under way before their photons are put together.
const WAVE: u64 = 64;
/// Photons that a batch stores before the others hear of it.
const NEWS: usize = 1 << 12;
/// The number of the sample whose stream a batch takes, less the pass: beyond all samples of images.
const PHOTONS: u64 = u64::MAX;

/// How photons are sent out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shooting {
    /// How many.
    pub photons: u64,
    /// Which are kept.
    pub kept: Kept,
    /// The largest number of reflections before a photon arrives where it is kept; None for no limit.
    pub bounces: Option<u32>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of the map, of several under one seed that have nothing in common.
    pub pass: u64,
    /// The most that may be stored.
    pub most: usize,
}

impl Default for Shooting {
    /// 100 000 photons, all kept, up to 2²⁶ that are stored.
    fn default() -> Self {
        Self { photons: 100_000, kept: Kept::Global, bounces: None, seed: 1, pass: 0, most: 1 << 26 }
    }
}

/// What was kept, and what became of all light.
#[derive(Clone, Debug, Default)]
pub struct Shot {
    /// In the order in which they were sent out.
    pub photons: Vec<Photon>,
    /// The light.
    pub tally: Tally,
}

impl Shooting {
    /// Sends them out. The flux of each is its share: the sum of what is emitted does not depend on their number.
    ///
    /// # Errors
    /// Without photons or light, and where more than `most` would be stored.
    pub fn shoot(&self, scene: &Scene) -> Result<Shot, PhotonError> {
        if self.photons == 0 {
            return Err(PhotonError::NoPhotons);
        }
        if scene.emitters().is_empty() {
            return Err(PhotonError::NoLight);
        }
        let batches = self.photons.div_ceil(BATCH);
        let mut photons = Vec::new();
        let mut tally = Tally::new(scene.shapes().len());
        let mut first = 0;
        while first < batches {
            let end = batches.min(first + WAVE);
            let stored = AtomicUsize::new(photons.len());
            let wave: Vec<Shot> = (first..end).into_par_iter().map(|batch| self.batch(scene, batch, &stored)).collect();
            for shot in wave {
                if photons.len() + shot.photons.len() > self.most {
                    return Err(PhotonError::TooMany { most: self.most });
                }
                photons.extend(shot.photons);
                tally.add(&shot.tally);
            }
            first = end;
        }
        Ok(Shot { photons, tally: tally.scaled(self.share()) })
    }

    /// Of the light of one photon what it stands for.
    fn share(&self) -> f64 {
        1.0 / self.photons as f64
    }

    /// `stored` counts the photons of all batches. Where it passes the limit each stops short, for nothing of them will be used.
    fn batch(&self, scene: &Scene, batch: u64, stored: &AtomicUsize) -> Shot {
        let mut told = 0;
        let mut shot = Shot { photons: Vec::new(), tally: Tally::new(scene.shapes().len()) };
        let mut sampler = Independent::at(self.seed, batch, PHOTONS.wrapping_sub(self.pass));
        for _ in batch * BATCH..self.photons.min((batch + 1) * BATCH) {
            self.one(scene, &mut sampler, &mut shot);
            let news = shot.photons.len() - told;
            if news >= NEWS {
                told += news;
                if stored.fetch_add(news, Ordering::Relaxed) + news > self.most {
                    break;
                }
            }
        }
        for photon in &mut shot.photons {
            photon.flux = photon.flux * self.share();
        }
        shot
    }

    fn one(&self, scene: &Scene, sampler: &mut Independent, shot: &mut Shot) {
        let (choice, at, along) = (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        let tally = &mut shot.tally;
        tally.emitted += 1;
        let Some((mut ray, mut flux)) = scene.emit(choice, at, along) else { return };
        tally.emitted_flux += flux;
        let (mut bounces, mut hits, mut history, mut basic) = (0_u32, 0_u64, History::Direct, 1.0);
        loop {
            let Some(surface) = next_surface(scene, &mut ray, sampler) else {
                tally.escaped += 1;
                tally.escaped_flux += flux;
                break;
            };
            hits += 1;
            let of_shape = &mut tally.shapes[surface.shape];
            of_shape.hits += 1;
            of_shape.incident += flux;
            if bounces == 0 {
                of_shape.first += flux;
            }
            let vertex = Vertex::new(scene, &ray, &surface);
            if self.kept.holds(history) && stores(&vertex) {
                let n = if surface.ng.dot(ray.dir) < 0.0 { surface.ng } else { -surface.ng };
                let shape = surface.shape as u32;
                // An estimate of what the surface reflects is made where it is there, as this photon was.
                let flux = flux / opaque(scene, &surface);
                shot.photons.push(Photon { p: surface.p, wi: -ray.dir, n, flux, basic, shape, bounces, history });
                tally.stored += 1;
            }
            let gone = if self.bounces.is_some_and(|most| bounces >= most) {
                None
            } else {
                scattered(&vertex, &ray, bounces, flux, sampler)
            };
            let Some((wi, after, dirac)) = gone else {
                tally.absorbed += 1;
                tally.absorbed_flux += flux;
                tally.shapes[surface.shape].absorbed += flux;
                break;
            };
            tally.absorbed_flux += flux - after;
            tally.shapes[surface.shape].absorbed += flux - after;
            flux = after;
            basic *= density_of_crossing(&vertex, wi);
            bounces += 1;
            history = match (dirac, history) {
                (true, History::Direct | History::Caustic) => History::Caustic,
                _ => History::Indirect,
            };
            ray = scene.leave(&surface, wi);
        }
        tally.hits.add(hits as f64);
    }
}

/// The surface that the light along `ray` meets, past masked ones that are not there this time.
pub(super) fn next_surface<S: Sampler + ?Sized>(scene: &Scene, ray: &mut Ray, sampler: &mut S) -> Option<Surface> {
    loop {
        let surface = scene.intersect(ray)?;
        let opaque = opaque(scene, &surface);
        if opaque >= 1.0 || sampler.next_1d() < opaque {
            return Some(surface);
        }
        *ray = scene.leave(&surface, ray.dir);
    }
}

/// The probability that a masked surface is there.
fn opaque(scene: &Scene, surface: &Surface) -> f64 {
    scene.material_of(surface.shape).opacity().map_or(1.0, |opacity| opaque_share(opacity, surface))
}

/// Whether light that arrives can be seen by an estimate of its density: somewhere the model is no Dirac lobe.
pub(super) fn stores(vertex: &Vertex) -> bool {
    if !vertex.bsdf.lobes().contains(Lobes::DIRAC) {
        return true;
    }
    let oblique = DVec3::new(0.48, -0.36, 0.8);
    [DVec3::Z, oblique, -DVec3::Z, -oblique].iter().any(|&wi| vertex.bsdf.pdf(vertex.wo, wi) > 0.0)
}

/// By how much 1 / η² grows where light leaves along `wi`: it changes where the surface is crossed alone.
fn density_of_crossing(vertex: &Vertex, wi: DVec3) -> f64 {
    if wi.dot(vertex.frame.n) * vertex.wo.z >= 0.0 {
        return 1.0;
    }
    let eta = vertex.bsdf.eta();
    if vertex.wo.z > 0.0 { 1.0 / (eta * eta) } else { eta * eta }
}

/// Direction and flux after a reflection, and whether it was a Dirac lobe; None where the photon ends.
fn scattered(
    vertex: &Vertex,
    ray: &Ray,
    bounces: u32,
    flux: Rgb,
    sampler: &mut Independent,
) -> Option<(DVec3, Rgb, bool)> {
    let (u, luck) = (sampler.next_uniforms(), sampler.next_1d());
    let drawn = vertex.sample(u)?;
    // A path from the eye has the cosine of the shading normal where light has that of the geometry (Veach 1997, eq. 5.19).
    let (n, ng) = (vertex.frame.n, vertex.surface.ng);
    let correction = (ray.dir.dot(n) * drawn.wi.dot(ng)) / (ray.dir.dot(ng) * drawn.wi.dot(n));
    let weighed = flux * drawn.weight * correction.abs();
    if !weighed.is_finite() {
        return None;
    }
    let kept = weighed.max_channel() / flux.max_channel();
    let survival = kept.min(if bounces < LONG { 1.0 } else { 0.9 });
    (luck < survival).then(|| (drawn.wi, weighed / survival, matches!(drawn.density, Density::Dirac(_))))
}
