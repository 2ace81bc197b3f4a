//! All links, and the light that runs along them.
//!
//! Gather: h_i = Σ F_is B_s over the links of element i.
//! Push:   H_i = h_i + H of what i is part of: irradiance is a mean over an area, and the same for all parts.
//! Pull:   B_i = E_i + ρ_i H_i at the ends, else B_i = Σ A_part B_part / A_i: radiosity is power per area, and parts need
//!         not be equal.

use rayon::prelude::*;

use super::link::{Found, Link};
use super::tree::{Node, Tree};
use crate::math::color::Rgb;

/// The links of all elements.
#[derive(Debug)]
pub(super) struct Network {
    /// Where those of each receiver begin, and where the last ones end.
    starts: Vec<usize>,
    links: Vec<Link>,
    /// Of each element whether its parts have links, or parts of them.
    pub(super) open: Vec<bool>,
}

/// The light of the elements.
#[derive(Clone, Debug)]
pub(super) struct Light {
    /// E [W/m²].
    e: Vec<Rgb>,
    /// B of every element [W/m²].
    pub(super) b: Vec<Rgb>,
    /// H [W/m²].
    pub(super) h: Vec<Rgb>,
    /// Root mean square difference of B from its mean over the element, all channels together.
    pub(super) spread: Vec<f64>,
}

impl Light {
    /// What is emitted.
    pub(super) fn emitted(tree: &Tree) -> Self {
        Self::of(tree.nodes.iter().map(|node| node.emission).collect())
    }

    fn of(e: Vec<Rgb>) -> Self {
        let n = e.len();
        Self { b: e.clone(), e, h: vec![Rgb::BLACK; n], spread: vec![0.0; n] }
    }

    /// The largest B, in any channel.
    pub(super) fn largest(&self) -> f64 {
        self.b.iter().map(|b| b.max_channel()).fold(0.0, f64::max)
    }

    /// √ΣA times the radiosity that what is emitted would have if it were spread over all faces.
    pub(super) fn spread_evenly(&self, tree: &Tree) -> f64 {
        let faces = || tree.whole.clone().map(|i| (tree.nodes[i].area, self.e[i]));
        let area: f64 = faces().map(|(area, _)| area).sum();
        faces().map(|(area, e)| area * e.0.length()).sum::<f64>() / area.sqrt()
    }

    /// Root of Σ A (B − E)² over the faces, all channels together: what is reflected. (What is emitted is known.)
    pub(super) fn norm(&self, tree: &Tree) -> f64 {
        // A face emits the same everywhere: its spread is that of what it reflects.
        let square = |i: usize| (self.b[i] - tree.nodes[i].emission).0.length_squared() + self.spread[i].powi(2);
        let squares = tree.whole.clone().map(|i| tree.nodes[i].area * square(i));
        squares.sum::<f64>().sqrt()
    }
}

/// Receivers that one thread takes at a time.
const RECEIVERS: usize = 64;
/// Times its beginning that light is thought to have no end.
const ENDLESS: f64 = 1e4;
/// Light of E = 1 that changes by no more is known well enough.
const NEARLY: f64 = 0.01;

impl Network {
    /// Of links with their receivers, in any order.
    pub(super) fn new(tree: &Tree, links: &[Found]) -> Self {
        let n = tree.nodes.len();
        let mut starts = vec![0; n + 1];
        let mut open: Vec<bool> = tree.nodes.iter().map(Node::is_cluster).collect();
        for (receiver, _) in links.iter().flatten() {
            starts[*receiver as usize + 1] += 1;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let mut sorted = vec![Link::NONE; starts[n]];
        let mut at = starts.clone();
        for (receiver, link) in links.iter().flatten() {
            let place = &mut at[*receiver as usize];
            sorted[*place] = *link;
            *place += 1;
        }
        for i in (tree.roots..n).rev() {
            let node = &tree.nodes[i];
            if open[i] || starts[i + 1] > starts[i] || tree.varying[node.face as usize] {
                open[node.parent as usize] = true;
            }
        }
        Self { starts, links: sorted, open }
    }

    /// Whether an element is used: a face, or part of an element that is open.
    pub(super) fn is_used(&self, tree: &Tree, i: usize) -> bool {
        i < tree.roots || self.open[tree.nodes[i].parent as usize]
    }

    pub(super) fn links(&self) -> &[Link] {
        &self.links
    }

    /// The links by which `receiver` receives.
    pub(super) fn of(&self, receiver: usize) -> &[Link] {
        &self.links[self.starts[receiver]..self.starts[receiver + 1]]
    }

    /// Of each element Σ F over its links and those of what it is part of.
    pub(super) fn row_sums(&self, tree: &Tree) -> Vec<f64> {
        let mut sums: Vec<f64> = (0..tree.nodes.len())
            .map(|i| self.of(i).iter().map(|link| link.factor).fold(0.0, |sum, f| sum + f))
            .collect();
        for i in tree.roots..sums.len() {
            sums[i] += sums[tree.nodes[i].parent as usize];
        }
        sums
    }

    /// One more reflection of `light`; the largest change of B at an end, in any channel.
    pub(super) fn reflect(&self, tree: &Tree, light: &mut Light) -> f64 {
        let Light { b, h, .. } = light;
        h.par_chunks_mut(RECEIVERS).enumerate().for_each(|(chunk, out)| {
            for (k, h) in out.iter_mut().enumerate() {
                let links = self.of(chunk * RECEIVERS + k);
                *h = links.iter().map(|link| b[link.source as usize] * link.factor).sum();
            }
        });
        Self::push(tree, light);
        self.pull(tree, light)
    }

    fn push(tree: &Tree, light: &mut Light) {
        for i in tree.roots..tree.nodes.len() {
            let above = light.h[tree.nodes[i].parent as usize];
            light.h[i] += above;
        }
    }

    fn pull(&self, tree: &Tree, light: &mut Light) -> f64 {
        let mut change = 0.0_f64;
        let Light { e, b, h, spread } = light;
        for i in (0..tree.nodes.len()).rev() {
            let node = &tree.nodes[i];
            if self.open[i] && node.divisible() {
                let (mut sum, mut squares, mut whole) = (Rgb::BLACK, 0.0, 0.0);
                for part in node.parts() {
                    let area = tree.nodes[part].area;
                    whole += area;
                    sum += b[part] * area;
                    squares += area * (b[part].0.length_squared() + spread[part].powi(2));
                }
                b[i] = sum / whole;
                spread[i] = (squares / whole - b[i].0.length_squared()).max(0.0).sqrt();
            } else {
                let new = e[i] + node.reflectance * h[i];
                let gap = (new - b[i]).map(f64::abs).max_channel();
                // A gap that is NaN stays one.
                change = if gap <= change { change } else { gap };
                (b[i], spread[i]) = (new, 0.0);
            }
        }
        change
    }

    /// Reflects until the largest change is at most `tolerance` times the largest B, at most `most` times; the changes.
    pub(super) fn settle(&self, tree: &Tree, light: &mut Light, tolerance: f64, most: u64) -> Vec<f64> {
        let mut history = Vec::new();
        for _ in 0..most {
            let change = self.reflect(tree, light);
            history.push(change);
            if change <= tolerance * light.largest() || !change.is_finite() {
                break;
            }
        }
        history
    }

    /// H = F B of every element, and ‖E + ρ H − B‖_∞ over the ends: how far B is from that of one more reflection.
    pub(super) fn received(&self, tree: &Tree, light: &Light) -> (Vec<Rgb>, f64) {
        let mut next = light.clone();
        let residual = self.reflect(tree, &mut next);
        (next.h, residual)
    }

    /// A bound of ‖(I − ρF)⁻¹‖_∞ = max w, where w is the light of E = 1: no residual is more times the error. Infinite if the
    /// light has no end.
    ///
    /// F ≥ 0, so (I − ρF) v ≥ c > 0 for a v ≥ 0 makes w ≤ v / c. After k reflections v is at most `change` short of the next one,
    /// and c = 1 − `change`. That needs no row sums below 1, which links do not have where they are rough.
    pub(super) fn amplification(&self, tree: &Tree) -> f64 {
        let mut light = Light::of(vec![Rgb::WHITE; tree.nodes.len()]);
        while light.largest() < ENDLESS {
            let before = light.largest();
            let change = self.reflect(tree, &mut light);
            if change <= NEARLY {
                return before / (1.0 - change);
            }
        }
        f64::INFINITY
    }

    /// How many links have a cluster at an end.
    pub(super) fn of_clusters(&self, tree: &Tree) -> usize {
        let at_source = self.links.iter().filter(|link| (link.source as usize) < tree.clusters()).count();
        let to_clusters = (0..tree.clusters()).flat_map(|i| self.of(i));
        at_source + to_clusters.filter(|link| link.source as usize >= tree.clusters()).count()
    }

    /// Links by the level of their receivers, clusters apart.
    pub(super) fn by_level(&self, tree: &Tree) -> Vec<usize> {
        let mut counts = Vec::new();
        for (i, node) in tree.nodes.iter().enumerate().skip(tree.clusters()) {
            let level = usize::from(node.level);
            if counts.len() <= level {
                counts.resize(level + 1, 0);
            }
            counts[level] += self.of(i).len();
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::radiosity::patches::{Fineness, Materials};
    use crate::scene::Scene;
    use crate::scene::builtin::builtin;

    /// A cube of 5 × 5 cells a face, whose parts are of 2 × 2, 2 × 3, 3 × 2 and 3 × 3.
    fn uneven() -> Tree {
        let scene = Scene::new(builtin("cube-one-emitter", &[]).unwrap().unwrap()).unwrap();
        Tree::new(&scene, Fineness::Count(150), Materials::Diffuse, 100).unwrap()
    }

    /// A network without links that is open all the way down.
    fn open(tree: &Tree) -> Network {
        let n = tree.nodes.len();
        Network { starts: vec![0; n + 1], links: Vec::new(), open: vec![true; n] }
    }

    /// Power of the whole, and that of the ends [W].
    fn powers(tree: &Tree, b: &[Rgb]) -> [f64; 2] {
        let power = |i: usize| b[i].0.x * tree.nodes[i].area;
        [(0..tree.roots).map(power).sum(), tree.ends(|_| true).into_iter().map(power).sum()]
    }

    /// A broken twin of the pull: parts count alike, whatever their areas.
    fn pull_of_equals(tree: &Tree, b: &mut [Rgb]) {
        for i in (0..tree.nodes.len()).rev().filter(|&i| tree.nodes[i].divisible()) {
            let parts = tree.nodes[i].parts();
            b[i] = b[parts.clone()].iter().copied().sum::<Rgb>() / parts.len() as f64;
        }
    }

    #[test]
    fn pulling_keeps_the_power_of_unequal_parts() {
        let tree = uneven();
        assert!(tree.nodes[tree.nodes[0].parts()].iter().any(|part| part.area < 0.2 * tree.nodes[0].area));
        let mut light = Light::emitted(&tree);
        // Irradiances that differ from place to place.
        for (i, h) in light.h.iter_mut().enumerate() {
            *h = Rgb::grey((i as f64 * 0.618_033_988_749_895).fract());
        }
        open(&tree).pull(&tree, &mut light);
        let [whole, ends] = powers(&tree, &light.b);
        // Roundings of 150 terms.
        assert!((whole - ends).abs() < 1e-13 * ends, "{whole} {ends}");
        let mut broken = light.b.clone();
        pull_of_equals(&tree, &mut broken);
        let [whole, ends] = powers(&tree, &broken);
        assert!((whole - ends).abs() > 1e-3 * ends, "parts that count alike are not seen: {whole} {ends}");
        // The spread is that of the ends.
        let end = tree.ends(|_| true).into_iter().filter(|&i| tree.nodes[i].face == tree.nodes[0].face);
        let squares: f64 = end.map(|i| tree.nodes[i].area * (light.b[i] - light.b[0]).0.length_squared()).sum();
        assert!((light.spread[0].powi(2) - squares / tree.nodes[0].area).abs() < 1e-12);
    }

    #[test]
    fn what_a_residual_can_become_is_bounded() {
        let tree = uneven();
        // Every face receives from its neighbour a share of 1.6, so that row sums are no bound, and on every other face it meets ρ.
        let faces = tree.whole.len() as u32;
        let link = |receiver: u32| (receiver, Link { source: (receiver + 1) % faces, factor: 1.6, ..Link::NONE });
        let network = Network::new(&tree, &[(0..faces).map(link).collect()]);
        let rho = tree.nodes[0].reflectance.max_channel();
        assert!(tree.nodes.iter().all(|node| node.reflectance == Rgb::grey(rho)));
        // The same everywhere: w = 1 + 1.6 ρ w.
        let exact = 1.0 / (1.0 - 1.6 * rho);
        let found = network.amplification(&tree);
        assert!(found >= exact * (1.0 - 1e-12) && found < 1.1 * exact, "{found} against {exact}");
        let endless = (0..faces).map(|i| (i, Link { factor: 2.0 / rho, ..link(i).1 })).collect();
        assert_eq!(Network::new(&tree, &[endless]).amplification(&tree), f64::INFINITY);
    }

    #[test]
    fn pushing_gives_every_part_the_irradiance_of_the_whole() {
        let tree = uneven();
        let mut light = Light::emitted(&tree);
        for (i, h) in light.h.iter_mut().enumerate() {
            *h = Rgb::grey(if i < tree.roots { 1.0 } else { 0.0 });
        }
        Network::push(&tree, &mut light);
        let received: f64 = tree.ends(|_| true).into_iter().map(|i| light.h[i].0.x * tree.nodes[i].area).sum();
        let area: f64 = tree.nodes[..tree.roots].iter().map(|node| node.area).sum();
        assert!((received - area).abs() < 1e-13 * area);
    }

    #[test]
    fn a_network_sorts_links_by_receiver_and_opens_what_is_above_them() {
        let tree = uneven();
        let link = |source: u32| Link { source, factor: 0.125, ..Link::NONE };
        let part = tree.nodes[0].parts().start;
        let network = Network::new(&tree, &[vec![(part as u32, link(1)), (2, link(0))], vec![(part as u32, link(3))]]);
        assert_eq!(network.of(part).iter().map(|link| link.source).collect::<Vec<_>>(), [1, 3]);
        assert_eq!((network.of(2).len(), network.of(0).len(), network.links().len()), (1, 0, 3));
        assert!(network.open[0] && !network.open[2] && !network.open[part]);
        let below = tree.nodes[part].parts().start;
        assert_eq!((network.row_sums(&tree)[below], network.row_sums(&tree)[2]), (0.25, 0.125));
        assert_eq!(network.by_level(&tree)[..2], [1, 2]);
    }
}
