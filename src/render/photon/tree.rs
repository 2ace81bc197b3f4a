//! A balanced k-d tree over points.
//!
//! Every node halves its points at the median along the longest side of their box, so that neither coplanar nor identical
//! points are a problem: the split is by number, and ties may lie on either side. All leaves have the same depth, nodes are in
//! preorder, and a node's range of points follows from its place; a node is thus an axis and a number.
//! # References
//! - Arya & Mount 1993, Algorithms for fast vector quantization, DCC (incremental distance to a box)
//! - Bentley 1975, Multidimensional binary search trees used for associative searching, CACM 18(9)

use glam::DVec3;
use rayon::join;

use super::nearest::{Found, Nearest};

/// Points of a leaf, at most.
const LEAF: usize = 24;
/// Points below which a tree is built by one thread.
const ALONE: usize = 1 << 13;

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    split: f64,
    axis: u32,
}

/// A k-d tree. Points have the numbers in which it sorts them: [`Tree::order`] tells what they were.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    points: Vec<DVec3>,
    order: Vec<u32>,
    nodes: Vec<Node>,
    /// Levels of nodes above the leaves.
    levels: u32,
}

impl Tree {
    /// The tree of these points, each finite; at most 2³² − 1 of them.
    pub fn new(points: &[DVec3]) -> Self {
        let mut items: Vec<(DVec3, u32)> = points.iter().copied().zip(0..).collect();
        let leaves = points.len().div_ceil(LEAF).max(1);
        let levels = leaves.next_power_of_two().ilog2();
        let mut nodes = vec![Node::default(); (1 << levels) - 1];
        build(&mut items, &mut nodes);
        let (points, order) = items.into_iter().unzip();
        Self { points, order, nodes, levels }
    }

    /// The points as they are sorted.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Of each point its number before it was sorted.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Adds to `nearest` what it wants of the points for which `keep` holds.
    pub fn nearest(&self, q: DVec3, nearest: &mut Nearest, keep: impl Fn(u32) -> bool) {
        if !self.points.is_empty() {
            let mut search = Search { tree: self, q, keep, nearest };
            search.visit(0, self.levels, 0, self.points.len(), DVec3::ZERO, 0.0);
        }
    }

    /// Tells `each` of the points closer than `radius` to `q`.
    pub fn within(&self, q: DVec3, radius: f64, mut each: impl FnMut(Found)) {
        if !self.points.is_empty() {
            self.range((0, self.levels, 0, self.points.len()), q, radius * radius, &mut each);
        }
    }

    fn range(
        &self,
        (node, levels, from, to): (usize, u32, usize, usize),
        q: DVec3,
        radius2: f64,
        each: &mut impl FnMut(Found),
    ) {
        if levels == 0 {
            for (i, p) in self.points[from..to].iter().enumerate() {
                let distance2 = p.distance_squared(q);
                if distance2 < radius2 {
                    each((distance2, (from + i) as u32));
                }
            }
            return;
        }
        let Node { split, axis } = self.nodes[node];
        let (mid, below) = (from + (to - from) / 2, q[axis as usize] - split);
        let near = below * below < radius2;
        if below <= 0.0 || near {
            self.range((node + 1, levels - 1, from, mid), q, radius2, each);
        }
        if below >= 0.0 || near {
            self.range((node + (1 << (levels - 1)), levels - 1, mid, to), q, radius2, each);
        }
    }
}

struct Search<'a, K> {
    tree: &'a Tree,
    q: DVec3,
    keep: K,
    nearest: &'a mut Nearest,
}

impl<K: Fn(u32) -> bool> Search<'_, K> {
    /// `off` is the vector to the node's box, as far as splits have told, and `off2` its square.
    fn visit(&mut self, node: usize, levels: u32, from: usize, to: usize, off: DVec3, off2: f64) {
        if levels == 0 {
            for (i, p) in self.tree.points[from..to].iter().enumerate() {
                let distance2 = p.distance_squared(self.q);
                let number = (from + i) as u32;
                if distance2 < self.nearest.limit() && (self.keep)(number) {
                    self.nearest.push(distance2, number);
                }
            }
            return;
        }
        let Node { split, axis } = self.tree.nodes[node];
        let (axis, mid) = (axis as usize, from + (to - from) / 2);
        let below = self.q[axis] - split;
        let (left, right) = (node + 1, node + (1 << (levels - 1)));
        let mut beyond = off;
        beyond[axis] = below;
        let beyond2 = off2 - off[axis] * off[axis] + below * below;
        if below < 0.0 {
            self.visit(left, levels - 1, from, mid, off, off2);
            if beyond2 < self.nearest.limit() {
                self.visit(right, levels - 1, mid, to, beyond, beyond2);
            }
        } else {
            self.visit(right, levels - 1, mid, to, off, off2);
            if beyond2 < self.nearest.limit() {
                self.visit(left, levels - 1, from, mid, beyond, beyond2);
            }
        }
    }
}

fn build(items: &mut [(DVec3, u32)], nodes: &mut [Node]) {
    let Some((node, below)) = nodes.split_first_mut() else { return };
    let (min, max) = items.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), (p, _)| (a.min(*p), b.max(*p)));
    let size = max - min;
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    let mid = items.len() / 2;
    if mid < items.len() {
        let (_, median, _) =
            items.select_nth_unstable_by(mid, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
        *node = Node { split: median.0[axis], axis: axis as u32 };
    }
    let (left, right) = items.split_at_mut(mid);
    let (nodes_left, nodes_right) = below.split_at_mut(below.len() / 2);
    if left.len() < ALONE {
        build(left, nodes_left);
        build(right, nodes_right);
    } else {
        join(|| build(left, nodes_left), || build(right, nodes_right));
    }
}

#[cfg(test)]
mod tests {
    use super::super::nearest::scan;
    use super::*;
    use crate::sampling::stream::{stream, uniform};

    fn cloud(n: usize, shape: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
        let mut rng = stream(9, n as u64, 0);
        (0..n).map(|_| shape(DVec3::new(uniform(&mut rng), uniform(&mut rng), uniform(&mut rng)))).collect()
    }

    fn clouds() -> Vec<Vec<DVec3>> {
        let mut all: Vec<_> = [0, 1, 2, 23, 24, 25, 48, 49, 1000].map(|n| cloud(n, |p| p)).into();
        all.push(cloud(100_000, |p| DVec3::new(p.x, 0.0, p.z)));
        all.push(vec![DVec3::new(0.1, 0.2, 0.3); 1000]);
        all.push(cloud(3000, |p| if p.x < 0.5 { DVec3::splat(0.5) } else { p }));
        all
    }

    fn distances(found: &[Found]) -> Vec<f64> {
        let mut all: Vec<f64> = found.iter().map(|(d, _)| *d).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    #[test]
    fn the_nearest_are_those_of_a_scan() {
        for points in clouds() {
            let tree = Tree::new(&points);
            assert!(tree.order.iter().zip(&tree.points).all(|(&i, &p)| points[i as usize] == p));
            let (mut by_tree, mut by_scan) = (Nearest::default(), Nearest::default());
            for q in cloud(20, |p| p * 1.4 - 0.2) {
                for (k, limit) in [(1, f64::INFINITY), (10, f64::INFINITY), (100, 0.01), (2000, f64::INFINITY)] {
                    by_tree.begin(k, limit);
                    by_scan.begin(k, limit);
                    let even = |i: u32| tree.order[i as usize].is_multiple_of(2);
                    tree.nearest(q, &mut by_tree, even);
                    scan(&points, q, &mut by_scan, |i| i.is_multiple_of(2));
                    assert_eq!(distances(by_tree.finish()), distances(by_scan.finish()), "{} {k}", points.len());
                }
                let mut near = Vec::new();
                tree.within(q, 0.2, |found| near.push(found));
                by_scan.begin(points.len(), 0.2 * 0.2);
                scan(&points, q, &mut by_scan, |_| true);
                assert_eq!(distances(&near), distances(by_scan.finish()));
            }
        }
    }

    #[test]
    fn a_tree_that_forgets_the_far_side_is_found_out() {
        // The twin: the near half alone.
        let points = cloud(1000, |p| p);
        let tree = Tree::new(&points);
        let half =
            Tree { points: tree.points[..500].to_vec(), order: tree.order[..500].to_vec(), levels: 0, nodes: vec![] };
        let wrong = cloud(20, |p| p).into_iter().any(|q| {
            let (mut a, mut b) = (Nearest::default(), Nearest::default());
            a.begin(10, f64::INFINITY);
            b.begin(10, f64::INFINITY);
            half.nearest(q, &mut a, |_| true);
            scan(&points, q, &mut b, |_| true);
            distances(a.finish()) != distances(b.finish())
        });
        assert!(wrong, "the comparison has lost its power");
    }
}
