//! From a scene to its radiosities, in one call.

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::link::{Found, Linker};
use super::network::{Light, Network};
use super::oracle::{Estimate, Oracle};
use super::tree::Tree;
use crate::math::color::Rgb;
use crate::render::radiosity::RadiosityError;
use crate::render::radiosity::factors::MEMORY;
use crate::render::radiosity::model::DEFAULT_PATCHES;
use crate::render::radiosity::patches::{Fineness, Materials, Patches};
use crate::render::radiosity::solution::{Display, RadiositySolution};
use crate::render::radiosity::solve::{Settings, SolveError, Solved};
use crate::render::radiosity::surface_light::SurfaceLight;
use crate::render::radiosity::system::energy::Energy;
use crate::scene::{Scene, rays};

/// What is solved, and how.
#[derive(Clone, Copy, Debug)]
pub struct Hierarchical {
    /// How fine the finest elements are. Where the error allows it they are coarser.
    pub fineness: Fineness,
    /// What is taken for diffuse.
    pub materials: Materials,
    /// The error to be reached against the solution on the finest elements everywhere: the root mean square difference of B
    /// by area, relative to the root mean square of what is reflected, B − E. In (0, 1).
    pub error: f64,
    /// Seed of the rays' ends.
    pub seed: u64,
    /// Certified error of the solution of the equations of the links, relative to the largest B.
    pub tolerance: f64,
    /// Iterations after which the last solution gives up.
    pub max_iterations: u64,
    /// Exactly so many reflections along the links of the full solution, and neither of the two.
    pub bounces: Option<u32>,
    /// The most that links may take \[bytes\]. The trees take about 1600 for each of the finest elements besides.
    pub memory: u64,
}

impl Default for Hierarchical {
    fn default() -> Self {
        let Settings { tolerance, max_iterations, .. } = Settings::default();
        Self {
            fineness: Fineness::Count(DEFAULT_PATCHES),
            materials: Materials::Diffuse,
            error: 0.01,
            seed: 1,
            tolerance,
            max_iterations,
            bounces: None,
            memory: MEMORY,
        }
    }
}

/// What it took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Faces, or convex parts of them, to begin with.
    pub roots: usize,
    /// Elements of all levels that are used.
    pub nodes: usize,
    /// Elements of which none is part of another: the patches.
    pub leaves: usize,
    /// What would be the number of leaves if all were as fine as allowed.
    pub finest: usize,
    /// Links.
    pub links: usize,
    /// Clusters; none where there are few faces.
    pub clusters: usize,
    /// Links of which an end is a cluster.
    pub cluster_links: usize,
    /// Links by how often the face of the receiver is cut, if it is no cluster.
    pub links_by_level: Vec<usize>,
    /// Rays cast.
    pub rays: u64,
    /// How often links were refined.
    pub rounds: usize,
    /// The bound of the error of one link, relative to what is reflected.
    pub epsilon: f64,
    /// The error asked for.
    pub error: f64,
    /// The estimate of the error that was to be reached. It is larger where even the most rays between the finest elements
    /// do not allow it.
    pub estimated_error: f64,
    /// An estimate of the error that comes from the size of the finest elements, and stays if there is no other.
    pub discretisation: f64,
    /// The smallest and the largest Σ F of a leaf.
    pub row_sums: [f64; 2],
}

/// A solved scene.
#[derive(Debug)]
pub struct HierarchicalSolution {
    /// The leaves.
    pub patches: Patches,
    /// Their radiosities, and how well the equations of the links are solved.
    pub solved: Solved,
    /// H of each leaf [W/m²].
    pub irradiance: Vec<Rgb>,
    /// Where the power goes. What links do not send both ways alike is its `reciprocity_defect`.
    pub energy: Energy,
    /// What it took.
    pub statistics: Statistics,
    /// Seconds for the trees, the links, and the equations.
    pub seconds: [f64; 3],
}

impl HierarchicalSolution {
    /// The light of each shape that has patches, in the order of the shapes.
    pub fn surfaces(&self) -> Vec<SurfaceLight> {
        SurfaceLight::of_all(&self.patches, &self.solved.radiosity, &self.irradiance)
    }

    /// The solution as light.
    pub fn shown(self, display: Display) -> RadiositySolution {
        RadiositySolution::new(self.patches, self.solved.radiosity, display)
    }
}

/// The first bound of a link, relative to the error that all may leave together.
const FIRST: f64 = 0.25;
/// The bound of each round relative to that of the last.
const STRICTER: f64 = 0.6;
/// Rounds before an estimate is believed: that of a few coarse links may be small by chance.
const LEAST: usize = 4;
/// Rounds after which what is left of the error is reported as it is.
const MOST: usize = 60;
/// With more faces than these there are clusters.
const MOST_ROOTS: usize = 256;
/// How well the equations are solved between rounds, if so many iterations will do.
const MEANWHILE: f64 = 1e-4;
const MOST_MEANWHILE: u64 = 100;
/// What is reflected is taken for no less than this share of what is emitted, were that spread evenly: the first links may have
/// missed all of it.
const LEAST_REFLECTED: f64 = 1e-3;
/// Where light grows more than this by reflections the last changes need not be smaller for it.
const MOST_CERTIFIED: f64 = 1e3;

impl Hierarchical {
    /// Solves the scene.
    pub fn solve(&self, scene: &Scene) -> Result<HierarchicalSolution, RadiosityError> {
        if scene.emitters().has_others_than_surfaces() {
            return Err(RadiosityError::NotASurface);
        }
        if !(self.error > 0.0 && self.error < 1.0) {
            return Err(RadiosityError::Error(self.error));
        }
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            return Err(SolveError::Tolerance(self.tolerance).into());
        }
        let start = Instant::now();
        let tree = Tree::new(scene, self.fineness, self.materials, MOST_ROOTS)?;
        let cut = start.elapsed().as_secs_f64();
        Ok(self.solve_tree(scene, &tree, cut)?.0)
    }

    /// Also the light of all elements.
    pub(super) fn solve_tree(
        &self,
        scene: &Scene,
        tree: &Tree,
        cut: f64,
    ) -> Result<(HierarchicalSolution, Light), RadiosityError> {
        let start = Instant::now();
        let linker = Linker::new(scene, tree, self.seed, self.memory);
        let (first, mut cast) = first_links(tree, &linker);
        let mut network = Network::new(tree, &first);
        let mut light = Light::emitted(tree);
        let least = LEAST_REFLECTED * light.spread_evenly(tree);
        let mut epsilon = FIRST * self.error;
        let (mut solving, mut rounds) = (0.0, 0);
        let estimate = loop {
            let begun = Instant::now();
            network.settle(tree, &mut light, MEANWHILE, MOST_MEANWHILE);
            let estimate = Estimate::of(tree, &network, &light);
            solving += begun.elapsed().as_secs_f64();
            if rounds >= MOST || (rounds >= LEAST && (estimate.total() <= self.error || estimate.is_final(self.error)))
            {
                break estimate;
            }
            let oracle =
                Oracle { tree, linker: &linker, light: &light, threshold: epsilon * light.norm(tree).max(least) };
            let (links, more) = oracle.refine(&network)?;
            cast += more.rays;
            if more.refined {
                network = Network::new(tree, &links);
            }
            rounds += 1;
            epsilon *= STRICTER;
        };
        let begun = Instant::now();
        let amplification = network.amplification(tree);
        if amplification == f64::INFINITY {
            return Err(RadiosityError::Endless);
        }
        let history = if let Some(bounces) = self.bounces {
            light = Light::emitted(tree);
            (0..bounces).map(|_| network.reflect(tree, &mut light)).collect()
        } else {
            // Where nothing is certified, as it would be for ρ = .999.
            let change = self.tolerance / amplification.min(MOST_CERTIFIED);
            network.settle(tree, &mut light, change, self.max_iterations)
        };
        let (received, residual) = network.received(tree, &light);
        let certified_bound = residual * amplification;
        let converged = certified_bound <= self.tolerance * light.largest();
        solving += begun.elapsed().as_secs_f64();
        let leaves = tree.ends(|i| network.open[i]);
        let of_leaves = |values: &[Rgb]| leaves.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let sums = network.row_sums(tree);
        let range = leaves.iter().fold([f64::INFINITY, 0.0], |[low, high], &i| [sums[i].min(low), sums[i].max(high)]);
        let statistics = Statistics {
            roots: tree.whole.len(),
            nodes: (0..tree.nodes.len()).filter(|&i| network.is_used(tree, i)).count(),
            leaves: leaves.len(),
            finest: tree.nodes.iter().filter(|node| !node.divisible()).count(),
            links: network.links().len(),
            clusters: tree.clusters(),
            cluster_links: network.of_clusters(tree),
            links_by_level: network.by_level(tree),
            rays: cast,
            rounds,
            epsilon: epsilon / STRICTER,
            error: self.error,
            estimated_error: estimate.total(),
            discretisation: estimate.elements,
            row_sums: range,
        };
        let solved = Solved {
            radiosity: of_leaves(&light.b),
            iterations: history.len() as u64,
            converged,
            residual,
            certified_bound,
            history,
        };
        let solution = HierarchicalSolution {
            patches: tree.patches(scene, &leaves)?,
            solved,
            irradiance: of_leaves(&received),
            energy: energy(tree, &leaves, [&light.b, &received], &sums),
            statistics,
            seconds: [cut, start.elapsed().as_secs_f64() - solving, solving],
        };
        Ok((solution, light))
    }
}

/// Links between all faces that see each other, or from the cluster of all to itself, and the rays that it took.
fn first_links(tree: &Tree, linker: &Linker<'_>) -> (Vec<Found>, u64) {
    let receivers = (0..tree.roots).into_par_iter().map(|receiver| {
        let before = rays::cast();
        let links = (0..tree.roots).filter_map(|source| Some((receiver as u32, linker.link(receiver, source)?)));
        let links: Vec<_> = links.collect();
        (links, rays::cast() - before)
    });
    let (links, cast): (Vec<_>, Vec<u64>) = receivers.unzip();
    (links, cast.into_iter().sum())
}

/// From B, H and the row sums.
fn energy(tree: &Tree, leaves: &[usize], [b, h]: [&[Rgb]; 2], sums: &[f64]) -> Energy {
    let mut energy = Energy {
        emitted: Rgb::BLACK,
        absorbed: Rgb::BLACK,
        escaped: Rgb::BLACK,
        reciprocity_defect: Rgb::BLACK,
        unsolved: Rgb::BLACK,
    };
    for &i in leaves {
        let node = &tree.nodes[i];
        let (b, h, area) = (b[i], h[i], node.area);
        energy.emitted += node.emission * area;
        energy.absorbed += (Rgb::WHITE - node.reflectance) * h * area;
        energy.escaped += b * ((1.0 - sums[i]) * area);
        energy.reciprocity_defect += (b * sums[i] - h) * area;
        energy.unsolved += (node.emission + node.reflectance * h - b) * area;
    }
    energy
}
