//! Photons sorted by shape and by place, and the density of their light at a point.
//!
//! Each shape has a tree or a grid of its own, so that the photons of other walls are never among the nearest; of its own those
//! count whose normal agrees, and behind a wall that stands on it none ([`Gather::walls`]). Where the disk is cut off by an
//! edge of the shape, its area is that of the part that lies on it ([`Gather::edges`]).

use std::cell::RefCell;
use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::area::{Outline, SAME, outlines};
use super::grid::Grid;
use super::kernel::Estimator;
use super::nearest::{Found, Nearest};
use super::tree::Tree;
use super::{Photon, PhotonError, visible};
use crate::bsdf::Lobes;
use crate::math::color::Rgb;
use crate::render::path::vertex::Vertex;
use crate::scene::{Scene, Surface};

/// Which photons around a point count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Around {
    /// The k nearest, but none as far as `reach`: where there are fewer, all within it as in a fixed radius.
    Nearest {
        /// How many.
        k: usize,
        /// The largest radius, > 0; may be infinite.
        reach: f64,
    },
    /// All within this radius, > 0 and finite.
    Radius(f64),
}

/// How the density at a point is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// Which photons count.
    pub around: Around,
    /// How they are weighed.
    pub estimator: Estimator,
    /// Whether the area is that of the part of the disk that lies on the surface.
    pub edges: bool,
    /// Whether photons count only where they are seen from the point.
    pub walls: bool,
}

impl Default for Gather {
    /// The 50 nearest, with nothing left out.
    fn default() -> Self {
        let around = Around::Nearest { k: 50, reach: f64::INFINITY };
        Self { around, estimator: Estimator::default(), edges: true, walls: true }
    }
}

/// A density of light, and how well it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// What was asked for: irradiance [W/m²] or radiance [W/(sr m²)].
    pub value: Rgb,
    /// The variance of its mean channel: Σ (w Φ)² / A², times k / (k − 1) where the k-th of the nearest counts. Its expectation
    /// is that of the estimate in a field without slope, infinite for k ≤ 2 as that is; 0 where no photon is found.
    pub variance: f64,
    /// By how much it is too large for the curvature of the field, as the photons themselves tell: 6 m (C − P), with the
    /// estimates C of the constant and P of Epanechnikov's kernel, and m of [`Estimator::mean_u`]; and by a k-th of itself where
    /// the k-th counts. For a smooth field and away from edges; as noisy as the estimate.
    pub bias: Rgb,
    /// The radius within which photons counted.
    pub radius: f64,
    /// How many did.
    pub photons: usize,
}

#[derive(Debug)]
enum Store {
    Tree(Tree),
    Grid(Grid),
}

#[derive(Debug)]
struct OfShape {
    store: Store,
    /// In the order of the store.
    photons: Vec<Photon>,
    outline: Outline,
}

/// What counts at a point.
struct Near<'a> {
    found: &'a [Found],
    radius2: f64,
    /// Whether the last of them is the one that gave the radius.
    counts_last: bool,
}

/// A photon map.
#[derive(Debug)]
pub struct PhotonMap {
    shapes: Vec<OfShape>,
    gather: Gather,
    stored: usize,
    /// A radius² that is rounding.
    least: f64,
}

thread_local! {
    static SCRATCH: RefCell<Nearest> = RefCell::default();
}

impl PhotonMap {
    /// Sorts the photons of a scene, at most 2³² − 1.
    ///
    /// # Errors
    /// Where k or the radius is not in its domain, or k is above the number of photons.
    ///
    /// # Panics
    /// Where a photon lies on a shape that the scene does not have.
    pub fn new(scene: &Scene, photons: &[Photon], gather: Gather) -> Result<Self, PhotonError> {
        let stored = photons.len();
        match gather.around {
            Around::Nearest { k, reach } => {
                let least = gather.estimator.least();
                if k < least {
                    return Err(PhotonError::NoNeighbours { k, estimator: gather.estimator.name(), least });
                }
                if k > stored {
                    return Err(PhotonError::TooFew { k, stored });
                }
                if reach.is_nan() || reach <= 0.0 {
                    return Err(PhotonError::Radius(reach));
                }
            }
            Around::Radius(radius) if radius > 0.0 && radius.is_finite() => {}
            Around::Radius(radius) => return Err(PhotonError::Radius(radius)),
        }
        let mut by_shape: Vec<Vec<u32>> = vec![Vec::new(); scene.shapes().len()];
        for (photon, i) in photons.iter().zip(0..) {
            by_shape[photon.shape as usize].push(i);
        }
        let of_shape = |(of_shape, outline): (Vec<u32>, Outline)| {
            let points: Vec<DVec3> = of_shape.iter().map(|&i| photons[i as usize].p).collect();
            let store = match gather.around {
                Around::Nearest { .. } => Store::Tree(Tree::new(&points)),
                Around::Radius(radius) => Store::Grid(Grid::new(&points, radius)),
            };
            let order = match &store {
                Store::Tree(tree) => tree.order(),
                Store::Grid(grid) => grid.order(),
            };
            let photons = order.par_iter().map(|&i| photons[of_shape[i as usize] as usize]).collect();
            OfShape { store, photons, outline }
        };
        let shapes = by_shape.into_par_iter().zip(outlines(scene)).map(of_shape).collect();
        let step = scene.extent() * 2.0_f64.powi(-24);
        Ok(Self { shapes, gather, stored, least: step * step })
    }

    /// How many photons there are.
    pub fn len(&self) -> usize {
        self.stored
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.stored == 0
    }

    /// How the density is estimated.
    pub fn gather(&self) -> Gather {
        self.gather
    }

    /// The photons, shape by shape.
    pub fn photons(&self) -> impl Iterator<Item = &Photon> {
        self.shapes.iter().flat_map(|shape| &shape.photons)
    }

    /// The irradiance at a point of a surface [W/m²], on the side to which `towards` points.
    pub fn irradiance(&self, scene: &Scene, surface: &Surface, towards: DVec3) -> Reading {
        let n = if surface.ng.dot(towards) > 0.0 { surface.ng } else { -surface.ng };
        self.read(scene, surface, n, |photon| photon.n.dot(n) > SAME, |photon| photon.flux)
    }

    /// The radiance that `vertex` sends to where its path came from [W/(sr m²)], Dirac lobes apart, by photons that were
    /// scattered at most `bounces` times before.
    pub(super) fn reflected(&self, scene: &Scene, vertex: &Vertex, bounces: u32) -> Reading {
        let ng = vertex.surface.ng;
        // The side of the viewer.
        let n = if vertex.wo.z * vertex.frame.n.dot(ng) > 0.0 { ng } else { -ng };
        let through = vertex.bsdf.lobes().contains(Lobes::TRANSMIT);
        let keep = |photon: &Photon| {
            let cos = photon.n.dot(n);
            (cos > SAME || through && cos < -SAME) && photon.bounces <= bounces
        };
        let value = |photon: &Photon| {
            let (f_cos, _) = vertex.eval(photon.wi);
            // Flux is spread over the geometry, not over what its normals pretend: f without a cosine, for the cosine of the
            // shading normal over that of the surface (Veach 1997, §5.3.3).
            photon.flux * f_cos * (photon.basic / photon.wi.dot(ng).abs().max(1e-6))
        };
        self.read(scene, vertex.surface, n, keep, value)
    }

    fn read(
        &self,
        scene: &Scene,
        surface: &Surface,
        n: DVec3,
        keep: impl Fn(&Photon) -> bool,
        value: impl Fn(&Photon) -> Rgb,
    ) -> Reading {
        let shape = &self.shapes[surface.shape];
        if shape.photons.is_empty() {
            return Reading::default();
        }
        // Taken and put back, so that nothing is allocated.
        let mut nearest = SCRATCH.take();
        let reading = self.estimate(scene, surface, n, shape, self.find(surface.p, shape, &mut nearest, keep), value);
        SCRATCH.set(nearest);
        reading
    }

    /// The photons that count, and the radius.
    fn find<'a>(
        &self,
        q: DVec3,
        shape: &OfShape,
        nearest: &'a mut Nearest,
        keep: impl Fn(&Photon) -> bool,
    ) -> Near<'a> {
        let keep = |i: u32| keep(&shape.photons[i as usize]);
        match (&shape.store, self.gather.around) {
            (Store::Tree(tree), Around::Nearest { k, reach }) => {
                let reach2 = reach * reach;
                nearest.begin(k, (reach2 as f32).max(f32::MIN_POSITIVE));
                tree.nearest(q, nearest, keep);
                let found = nearest.finish();
                if found.len() < k && reach2.is_finite() {
                    return Near { found, radius2: reach2, counts_last: false };
                }
                // Exactly: trees tell near from far in single precision.
                let distance2 = |found: &Found| shape.photons[found.number() as usize].p.distance_squared(q);
                let radius2 = found.iter().map(distance2).fold(self.least, f64::max);
                let counts_last = self.gather.estimator.counts_last();
                let nearer = found.len().saturating_sub(1);
                Near { found: if counts_last { found } else { &found[..nearer] }, radius2, counts_last }
            }
            (Store::Grid(grid), Around::Radius(radius)) => {
                nearest.begin(shape.photons.len(), f32::INFINITY);
                grid.within(q, radius, |found| {
                    if keep(found.number()) {
                        nearest.push(found);
                    }
                });
                Near { found: nearest.finish(), radius2: radius * radius, counts_last: false }
            }
            // The store is the one that `around` asks for.
            _ => Near { found: &[], radius2: 0.0, counts_last: false },
        }
    }

    fn estimate(
        &self,
        scene: &Scene,
        surface: &Surface,
        n: DVec3,
        shape: &OfShape,
        Near { found, radius2, counts_last }: Near,
        value: impl Fn(&Photon) -> Rgb,
    ) -> Reading {
        let radius = radius2.sqrt();
        if found.is_empty() {
            return Reading { radius, ..Reading::default() };
        }
        let open = !self.gather.walls || visible::is_open(scene, surface.p, n, radius);
        let (mut sum, mut squares, mut bent, mut photons) = (Rgb::BLACK, 0.0, Rgb::BLACK, 0);
        // The one that gave the radius says nothing of the field's curvature.
        let inner = found.len() - usize::from(counts_last);
        for (at, found) in found.iter().enumerate() {
            let photon = &shape.photons[found.number() as usize];
            if open || visible::sees(scene, (surface.p, n), (photon.p, photon.n)) {
                let (light, u) = (value(photon), (photon.p.distance_squared(surface.p) / radius2).min(1.0));
                let part = light * self.gather.estimator.weight(u);
                sum += part;
                if at < inner {
                    bent += light * (1.0 - Estimator::Epanechnikov.weight(u));
                }
                squares += part.mean() * part.mean();
                photons += 1;
            }
        }
        let mut area = PI * radius2;
        if self.gather.edges && photons > 0 {
            area *= shape.outline.share(scene, surface, radius);
            if !open {
                area *= visible::share(scene, surface, n, radius, &shape.outline);
            }
        }
        let (k, value) = (found.len() as f64, sum / area);
        let (mut variance, mut bias) = (squares / (area * area), bent * (6.0 * self.gather.estimator.mean_u() / area));
        if counts_last {
            variance *= k / (k - 1.0).max(1.0);
            bias += value / k;
        }
        Reading { value, variance, bias, radius, photons }
    }
}
