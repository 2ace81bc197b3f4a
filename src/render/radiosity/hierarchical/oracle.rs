//! Which links are good enough, and what error they leave together.
//!
//! With B of the source and ρ of the receiver r, a link's F that varies by ΔF over r leaves an error of ρ B ΔF in the radiosity
//! of r. One that varies by ΔF over the source leaves ρ S ΔF at most, S the spread of B over the source. And one that is
//! itself known to δ leaves ρ B δ. A dim source and a dark receiver thus need no accuracy: the oracle is weighted by
//! brightness. In the norm (Σ A B²)^½ the link brings
//!
//! e = √A_r ρ [(B ΔF)² + (S ΔF_s)² + (B δ)²]^½
//!
//! and is refined if e > ε ‖B‖: where the error is made by the receiver it is cut, else the source. Between elements that cannot
//! be cut, F is found again with more rays.
//!
//! # The error of all links
//! What the links of a receiver leave out at each of its probes adds up with its signs before it is squared; what different
//! receivers leave out is orthogonal, as in Haar's wavelets. The next levels, where there are any, leave out a quarter of
//! the square, a sixteenth and so on: 4/3 in all. What is lost for a source's brighter half being nearer, or farther, has the
//! same sign for all sources that an edge of a room lights, and for all elements above a leaf: its bounds are added up over
//! all of them. What rays miss is independent of each other.
//! # References
//! - Hanrahan, Salzman & Aupperle 1991, A rapid hierarchical radiosity algorithm, SIGGRAPH (BF refinement)

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::link::{Found, Link, Linker, root_mean_square};
use super::network::{Light, Network};
use super::tree::{Node, PROBES, Tree};
use crate::math::color::Rgb;
use crate::render::radiosity::RadiosityError;
use crate::scene::rays;

/// What is done with a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Keep,
    CutReceiver,
    CutSource,
    /// More rays.
    Recast,
}

/// Refines links.
#[derive(Debug)]
pub(super) struct Oracle<'a> {
    pub(super) tree: &'a Tree,
    pub(super) linker: &'a Linker<'a>,
    pub(super) light: &'a Light,
    /// ε ‖B‖ [W/m].
    pub(super) threshold: f64,
}

/// What a refinement took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Refined {
    /// Whether there was anything to refine.
    pub(super) refined: bool,
    /// Rays cast.
    pub(super) rays: u64,
}

/// Receivers that one thread takes at a time.
const RECEIVERS: usize = 32;
/// Of a link: itself, that which it comes from, and itself before it was sorted, in a list that has room for twice as many.
const BYTES: u64 = 4 * size_of::<(u32, Link)>() as u64;

/// How many links are kept, and how many may be. Whether all are too many does not depend on the order in which they are found.
#[derive(Debug)]
struct Budget {
    kept: AtomicU64,
    most: u64,
}

impl Budget {
    fn is_spent(&self) -> bool {
        self.kept.load(Ordering::Relaxed) > self.most
    }
}

impl Oracle<'_> {
    /// All links, those that are not good enough replaced by finer ones, and what that took.
    pub(super) fn refine(&self, network: &Network) -> Result<(Vec<Found>, Refined), RadiosityError> {
        let n = self.tree.nodes.len();
        let budget = Budget { kept: AtomicU64::new(0), most: self.linker.memory / BYTES };
        let (links, took): (Vec<Found>, Vec<Refined>) = (0..n.div_ceil(RECEIVERS))
            .into_par_iter()
            .map(|chunk| {
                let (mut out, mut refined) = (Vec::new(), false);
                let before = rays::cast();
                for receiver in chunk * RECEIVERS..((chunk + 1) * RECEIVERS).min(n) {
                    for link in network.of(receiver) {
                        refined |= self.one(receiver, *link, &mut out, &budget);
                    }
                }
                (out, Refined { refined, rays: rays::cast() - before })
            })
            .unzip();
        let all = took.iter().fold(Refined::default(), |all, one| Refined {
            refined: all.refined || one.refined,
            rays: all.rays + one.rays,
        });
        if budget.is_spent() {
            return Err(RadiosityError::Links { allowed: self.linker.memory >> 20 });
        }
        Ok((links, all))
    }

    fn one(&self, receiver: usize, link: Link, out: &mut Found, budget: &Budget) -> bool {
        let nodes = &self.tree.nodes;
        let source = link.source as usize;
        let pairs: Vec<(usize, usize)> = match self.verdict(receiver, &link) {
            Verdict::Keep => {
                out.push((receiver as u32, link));
                budget.kept.fetch_add(1, Ordering::Relaxed);
                return false;
            }
            Verdict::Recast => {
                if let Some(link) = self.linker.surer(receiver, &link) {
                    self.one(receiver, link, out, budget);
                }
                return true;
            }
            Verdict::CutReceiver => nodes[receiver].parts().map(|part| (part, source)).collect(),
            Verdict::CutSource => nodes[source].parts().map(|part| (receiver, part)).collect(),
        };
        for (to, from) in pairs {
            if budget.is_spent() {
                break;
            }
            if let Some(link) = self.linker.link(to, from) {
                self.one(to, link, out, budget);
            }
        }
        true
    }

    fn verdict(&self, receiver: usize, link: &Link) -> Verdict {
        let source = link.source as usize;
        let (r, s) = (&self.tree.nodes[receiver], &self.tree.nodes[source]);
        let errors = Errors::of(r, link, self.light.b[source], self.light.spread[source]);
        let scale = r.area.sqrt();
        let over = |square: f64| scale * square.sqrt() > self.threshold;
        if !over(errors.receiver + errors.source + errors.doubt) {
            return Verdict::Keep;
        }
        // What is doubted of F itself is better known of the parts of either: of those of the larger, to keep rays apart.
        let doubted = |node: &Node, other: &Node| if node.area >= other.area { errors.doubt } else { 0.0 };
        let by_receiver = errors.receiver + doubted(r, s) >= errors.source + doubted(s, r);
        match (r.divisible(), s.divisible()) {
            (true, true) if by_receiver => Verdict::CutReceiver,
            (true, true) => Verdict::CutSource,
            (true, false) if over(errors.receiver + errors.doubt) => Verdict::CutReceiver,
            (false, true) if over(errors.source + errors.doubt) => Verdict::CutSource,
            // There is nothing to cut that would make it better.
            _ if over(errors.doubt) && !link.has_most_rays() => Verdict::Recast,
            _ => Verdict::Keep,
        }
    }
}

/// Mean squares of the errors of the radiosity that a link brings, all channels together [(W/m²)²].
#[derive(Clone, Copy, Debug)]
struct Errors {
    receiver: f64,
    source: f64,
    doubt: f64,
}

impl Errors {
    fn of(r: &Node, link: &Link, b: Rgb, spread: f64) -> Self {
        let bright = (r.reflectance * b).0.length_squared();
        // The spread is over all channels: the largest reflectance bounds what comes of it.
        let rho = r.reflectance.max_channel();
        Self {
            receiver: bright * root_mean_square(link.over_receiver).powi(2),
            source: (rho * spread * f64::from(link.over_source)).powi(2),
            doubt: bright * f64::from(link.doubt).powi(2),
        }
    }
}

/// How much of the bound of what a source's unevenness does is so: brightness and nearness do not vary along one line.
const ALIGNED: f64 = 0.5;

/// The errors that the links leave, relative to ‖B‖.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    /// Against the solution on the finest elements, by links that can be refined.
    links: f64,
    /// The same by the rays of those that cannot.
    rays: f64,
    /// What the finest elements that were used leave out themselves.
    pub(super) elements: f64,
}

/// The error is at most about so many times what these sums give: shadows on large elements are less smooth than they suppose.
/// Measured against matrices it was .36 to 1.25 times.
const MARGIN: f64 = 1.25;
/// If what cannot be refined is too much alone, refinement ends where the rest is less than this share of it.
const FUTILE: f64 = 0.5;

impl Estimate {
    /// Against the solution on the finest elements.
    pub(super) fn total(&self) -> f64 {
        MARGIN * self.links.hypot(self.rays)
    }

    /// Whether finer links would not make it as small as `error`, and hardly smaller than it is.
    pub(super) fn is_final(&self, error: f64) -> bool {
        MARGIN * self.rays > error && self.links <= FUTILE * self.rays
    }

    pub(super) fn of(tree: &Tree, network: &Network, light: &Light) -> Self {
        let each: Vec<Left> =
            (0..tree.nodes.len()).into_par_iter().map(|i| Left::of(tree, network, light, i)).collect();
        let (mut links, mut rays, mut elements) = (0.0, 0.0, 0.0);
        let mut aligned = vec![0.0; tree.nodes.len()];
        for (i, left) in each.iter().enumerate() {
            let r = &tree.nodes[i];
            aligned[i] = left.aligned + if i < tree.roots { 0.0 } else { aligned[r.parent as usize] };
            links += left.doubts;
            rays += left.fixed;
            if r.divisible() {
                links += left.within * 4.0 / 3.0;
            } else {
                elements += left.within;
            }
            if !(r.divisible() && network.open[i]) && network.is_used(tree, i) {
                links += r.area * aligned[i].powi(2);
            }
        }
        let norm = light.norm(tree);
        let relative = |square: f64| if norm == 0.0 { 0.0 } else { square.sqrt() / norm };
        Self { links: relative(links), rays: relative(rays), elements: relative(elements) }
    }
}

/// What the links of an element leave out.
struct Left {
    /// Mean over its probes, times the area: the signed sum squared.
    within: f64,
    /// The sum of what may have one sign.
    aligned: f64,
    /// Squares, times the area, of links that can be refined.
    doubts: f64,
    /// The same of links that cannot.
    fixed: f64,
}

impl Left {
    fn of(tree: &Tree, network: &Network, light: &Light, i: usize) -> Self {
        let r = &tree.nodes[i];
        let (mut probes, mut aligned, mut doubts, mut fixed) = ([Rgb::BLACK; PROBES.len()], 0.0, 0.0, 0.0);
        for link in network.of(i) {
            let source = link.source as usize;
            let reflected = r.reflectance * light.b[source];
            for (sum, &difference) in probes.iter_mut().zip(&link.over_receiver) {
                *sum += reflected * f64::from(difference);
            }
            let errors = Errors::of(r, link, light.b[source], light.spread[source]);
            aligned += ALIGNED * errors.source.sqrt();
            if r.divisible() || tree.nodes[source].divisible() || !link.has_most_rays() {
                doubts += errors.doubt;
            } else {
                fixed += errors.doubt;
            }
        }
        let squares = probes.iter().zip(PROBES).map(|(sum, (_, weight))| weight * sum.0.length_squared());
        let within = r.area * squares.sum::<f64>();
        Self { within, aligned, doubts: r.area * doubts, fixed: r.area * fixed }
    }
}
