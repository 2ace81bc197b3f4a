//! Links: what an element receives from another, and how well that is known.
//!
//! F = (1/A) ∫ F(p) dA(p) over the receiver, F(p) the share of what is sent from its point p that meets the source. F(p) is
//! exact for a polygon (Lambert's formula). Of five points, one in each quarter of the receiver and its centre, the mean is F of
//! elements that are not near each other, and the differences are by how much F varies over the receiver. The same the other
//! way round, from five points of the source, is by how much it varies over the source: that is no error unless the source is
//! brighter in one part than in another.
//!
//! Visibility is that of [`RAYS`] rays, weighted by the kernel, whose ends are spread over both, and each quarter has its
//! own. Where an element is curved, or a cluster, the same pairs of points integrate the kernel too, and there are [`CURVED`]
//! times as many. Links between elements that cannot be cut may have more rays.

use std::f64::consts::FRAC_1_PI;

use glam::DVec2;

use super::tree::{Node, PROBES, Shape, Tree, quarter};
use crate::render::radiosity::factors::{Blockers, kernel, lattice};
use crate::render::radiosity::form::{self, Quadrature, point};
use crate::render::radiosity::patch::Form;
use crate::render::radiosity::polygon::Polygon;
use crate::sampling::stream::{stream, uniform};
use crate::scene::Scene;

/// Rays of a link.
const RAYS: u32 = 16;
/// Most rays, of a link whose elements cannot be cut.
const MOST_RAYS: u32 = 1024;
/// Pairs of points of a link with a curved element or a cluster, for each ray of others.
const CURVED: u32 = 4;
/// What a cluster's faces receive differs from the mean by the spread, and in part with the same sign for several links.
const ROUGH: f64 = 1.5;
/// Relative error of F where nothing is in between.
const TOLERANCE: f64 = 1e-3;
/// Nearer than so many sums of the radii the mean of five points is not trusted.
const NEAR: f64 = 2.0;
/// The error of a share that n rays of a lattice found partly hidden is about so much times n^(−3/4).
const PARTLY: f64 = 0.5;
/// If all n rays agree, what hides less than 1/n may have been missed: an error of so much times 1/n.
const MISSED: f64 = 0.25;

/// What an element receives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// The element that sends.
    pub(super) source: u32,
    /// How uncertain `factor` itself is, by the rays.
    pub(super) doubt: f32,
    /// Rays that were cast for it, or would have been.
    pub(super) rays: u32,
    /// F from the receiver to the source.
    pub(super) factor: f64,
    /// By how much F differs from its mean at the [`PROBES`] of the receiver.
    pub(super) over_receiver: [f32; PROBES.len()],
    /// Root mean square difference of F from its mean, if parts of the source sent alone.
    pub(super) over_source: f32,
}

impl Link {
    /// A link of nothing.
    pub(super) const NONE: Self =
        Self { source: 0, doubt: 0.0, rays: 0, factor: 0.0, over_receiver: [0.0; PROBES.len()], over_source: 0.0 };

    /// Whether its rays are all that there can be.
    pub(super) fn has_most_rays(&self) -> bool {
        self.rays >= MOST_RAYS
    }
}

/// Links with their receivers, as they are found.
pub(super) type Found = Vec<(u32, Link)>;

/// Makes links.
#[derive(Debug)]
pub(super) struct Linker<'a> {
    scene: &'a Scene,
    tree: &'a Tree,
    seed: u64,
    /// The most that links may take \[bytes\].
    pub(super) memory: u64,
    /// What can lie between elements.
    blockers: Blockers,
}

impl<'a> Linker<'a> {
    pub(super) fn new(scene: &'a Scene, tree: &'a Tree, seed: u64, memory: u64) -> Self {
        let blockers = Blockers::new(&tree.faces, tree.forms(), scene.extent());
        Self { scene, tree, seed, memory, blockers }
    }

    /// The link by which `receiver` receives from `source`; None if nothing is exchanged.
    pub(super) fn link(&self, receiver: usize, source: usize) -> Option<Link> {
        self.with_rays(receiver, source, RAYS)
    }

    /// A link once more, with four times the rays; None if nothing is exchanged.
    pub(super) fn surer(&self, receiver: usize, link: &Link) -> Option<Link> {
        self.with_rays(receiver, link.source as usize, 4 * link.rays)
    }

    fn with_rays(&self, receiver: usize, source: usize, rays: u32) -> Option<Link> {
        let (r, s) = (&self.tree.nodes[receiver], &self.tree.nodes[source]);
        let (Shape::Surface(to), Shape::Surface(from)) = (&r.shape, &s.shape) else {
            return Some(self.clustered(receiver, source, rays));
        };
        match (to, from) {
            (Form::Flat(_), Form::Flat(_)) if r.face == s.face => None,
            (Form::Flat(to), Form::Flat(from)) => {
                let free = Free::new(r, to, s, from)?;
                Some(if self.leave_free(receiver, source) {
                    free.link(source)
                } else {
                    self.hidden(receiver, source, rays, &free)
                })
            }
            _ => self.curved(receiver, source, rays),
        }
    }

    /// Whether certainly nothing lies between two elements that are no clusters.
    fn leave_free(&self, receiver: usize, source: usize) -> bool {
        let clusters = self.tree.clusters();
        self.blockers.leave_free(receiver - clusters, source - clusters)
    }

    /// The pairs of points of two elements: the places in the receiver's and the source's unit square.
    fn pairs(&self, receiver: usize, source: usize, count: u32) -> impl Iterator<Item = (DVec2, DVec2)> {
        let mut rng = stream(self.seed, receiver as u64, source as u64);
        let [to, from] = [(); 2].map(|()| DVec2::new(uniform(&mut rng), uniform(&mut rng)));
        (0..count as usize).map(move |k| (lattice(k, 0, to), lattice(k, 2, from)))
    }

    fn hidden(&self, receiver: usize, source: usize, rays: u32, free: &Free) -> Link {
        // Of each quarter the weights of all rays, and of those that get through.
        let (mut sums, mut through) = ([0.0; 4], [0.0; 4]);
        for (u, v) in self.pairs(receiver, source, rays) {
            let (to, from) = (self.tree.at(receiver, u), self.tree.at(source, v));
            let weight = kernel(to, from);
            if weight > 0.0 {
                sums[quarter(u)] += weight;
                if self.scene.sees(to, from) {
                    through[quarter(u)] += weight;
                }
            }
        }
        let (sum, got): (f64, f64) = (sums.iter().sum(), through.iter().sum());
        if sum == 0.0 {
            // Slivers in front of each other: their points see nothing.
            return Link { doubt: free.factor as f32, rays, ..free.link(source) };
        }
        let share = got / sum;
        let n = f64::from(rays);
        let partly = share > 0.0 && share < 1.0;
        let doubt = free.factor * if partly { PARTLY * n.powf(-0.75) } else { MISSED / n };
        // At the centre what gets through is that of all quarters.
        let visible = |q: usize| if q < 4 && sums[q] > 0.0 { through[q] / sums[q] } else { share };
        let at = std::array::from_fn(|q| free.at[q] * visible(q));
        let hidden = (share * (1.0 - share)).sqrt();
        Link {
            source: source as u32,
            doubt: doubt as f32,
            rays,
            factor: free.factor * share,
            over_receiver: differences(at),
            over_source: (free.over_source * share).hypot(free.factor * hidden) as f32,
        }
    }

    fn curved(&self, receiver: usize, source: usize, rays: u32) -> Option<Link> {
        let s = &self.tree.nodes[source];
        let (mut to_quarters, mut from_quarters) = ([(0.0, 0.0); 4], [(0.0, 0.0); 4]);
        let (mut bare, mut hidden, mut squares) = (0.0, 0_u32, 0.0);
        let free = self.leave_free(receiver, source);
        for (u, v) in self.pairs(receiver, source, CURVED * rays) {
            let (to, from) = (self.tree.at(receiver, u), self.tree.at(source, v));
            let mut weight = kernel(to, from);
            if weight > 0.0 {
                bare += weight;
                if !free && !self.scene.sees(to, from) {
                    weight = 0.0;
                    hidden += 1;
                }
            }
            squares += weight * weight;
            for (sum, count) in [&mut to_quarters[quarter(u)], &mut from_quarters[quarter(v)]] {
                *sum += weight;
                *count += 1.0;
            }
        }
        if bare == 0.0 {
            return None;
        }
        let unit = FRAC_1_PI * s.area;
        let n = f64::from(CURVED * rays);
        let mean = to_quarters.iter().map(|(sum, _)| sum).sum::<f64>() / n;
        let spread = (squares / n - mean * mean).max(0.0).sqrt();
        // Where all rays agree they may have missed what hides, or frees, a little.
        let missed = if free || mean > 0.0 && hidden > 0 { 0.0 } else { MISSED / f64::from(rays) * bare / n };
        let doubt = (PARTLY * 2.0 * spread * n.powf(-0.75)).hypot(missed);
        let of = |quarters: [(f64, f64); 4]| {
            let [a, b, c, d] = quarters.map(|(sum, count)| unit * sum / f64::max(count, 1.0));
            [a, b, c, d, 0.25 * (a + b + c + d)]
        };
        Some(Link {
            source: source as u32,
            doubt: (unit * doubt) as f32,
            rays,
            factor: (unit * mean).min(1.0),
            over_receiver: differences(of(to_quarters)),
            over_source: root_mean_square(differences(of(from_quarters))) as f32,
        })
    }

    /// Where one of both is a cluster. F is only the mean over all pairs of its points, and as uncertain as they differ.
    fn clustered(&self, receiver: usize, source: usize, rays: u32) -> Link {
        let (r, s) = (&self.tree.nodes[receiver], &self.tree.nodes[source]);
        let (mut sum, mut squares) = (0.0, 0.0);
        for (u, v) in self.pairs(receiver, source, CURVED * rays) {
            let (to, from) = (self.tree.at(receiver, u), self.tree.at(source, v));
            let weight = kernel(to, from);
            if weight > 0.0 && self.scene.sees(to, from) {
                sum += weight;
                squares += weight * weight;
            }
        }
        let (unit, n) = (FRAC_1_PI * s.area, f64::from(CURVED * rays));
        let mean = sum / n;
        let apart = r.centre.distance(s.centre) - r.radius - s.radius;
        let spread = if apart <= 0.0 {
            // Points may be as near as can be: nothing is known but F ≤ 1.
            1.0
        } else if sum > 0.0 {
            unit * (squares / n - mean * mean).max(0.0).sqrt()
        } else {
            // All n missed what less than 1/n of all pairs may exchange, of which none has a larger kernel.
            unit / (n * apart * apart)
        };
        Link {
            source: source as u32,
            doubt: (ROUGH * spread) as f32,
            rays,
            // Of no point can more than everything be seen.
            factor: (unit * mean).min(1.0),
            over_receiver: [0.0; PROBES.len()],
            over_source: spread as f32,
        }
    }
}

/// What is exchanged with nothing in between.
struct Free {
    factor: f64,
    /// F at the [`PROBES`] of the receiver.
    at: [f64; PROBES.len()],
    over_source: f64,
}

impl Free {
    fn new(r: &Node, to: &Polygon, s: &Node, from: &Polygon) -> Option<Self> {
        let at = r.points.map(|(p, n)| point::factor(p, n, from));
        let mean = mean_of(at);
        let far = r.centre.distance(s.centre) > NEAR * (r.radius + s.radius) && at.iter().all(|&f| f > 0.0);
        let factor = if far {
            mean
        } else {
            let [a, b] = [to, from].map(|polygon| Quadrature::without_nodes(polygon.clone()));
            form::of_pair(&a, &b, TOLERANCE).0 / r.area
        };
        if factor == 0.0 {
            return None;
        }
        let back = s.points.map(|(p, n)| point::factor(p, n, to));
        let sent = mean_of(back);
        let varies = if sent > 0.0 { root_mean_square(differences(back)) / sent } else { 1.0 };
        Some(Self { factor, at, over_source: factor * varies })
    }

    fn link(&self, source: usize) -> Link {
        Link {
            source: source as u32,
            doubt: 0.0,
            rays: RAYS,
            factor: self.factor,
            over_receiver: differences(self.at),
            over_source: self.over_source as f32,
        }
    }
}

/// The mean over an element, of values at its [`PROBES`].
fn mean_of(values: [f64; PROBES.len()]) -> f64 {
    values.iter().zip(PROBES).map(|(value, (_, weight))| weight * value).sum()
}

fn differences(values: [f64; PROBES.len()]) -> [f32; PROBES.len()] {
    let mean = mean_of(values);
    values.map(|value| (value - mean) as f32)
}

/// Of differences at the [`PROBES`].
pub(super) fn root_mean_square(differences: [f32; PROBES.len()]) -> f64 {
    mean_of(differences.map(|d| f64::from(d).powi(2))).sqrt()
}
