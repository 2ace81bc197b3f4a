//! A balanced k-d tree over points.
//!
//! Every node halves its leaves along the longest side of the box of its points, so that neither coplanar nor identical points
//! are a problem: the split is by number, and ties may lie on either side. All leaves but the last are full, nodes are in
//! preorder, and a node's range of leaves follows from its place; a node is thus an axis and a number.
//!
//! Places are kept in single precision, relative to the middle of all: twice as many to a line of memory, which is what a search
//! waits for, and distances of a whole leaf at once. Which of two points is nearer is thus known to 10⁻⁷ of the extent; the
//! extent may be from 10⁻¹² to 10¹⁸.
//! # References
//! - Arya & Mount 1993, Algorithms for fast vector quantization, DCC (incremental distance to a box)
//! - Bentley 1975, Multidimensional binary search trees used for associative searching, CACM 18(9)

use std::array::from_fn;

use glam::{DVec3, Vec3};
use rayon::join;

use super::nearest::{Found, Nearest};

/// Points of a leaf.
const LEAF: usize = 32;
/// Points below which a tree is built by one thread.
const ALONE: usize = 1 << 13;

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    split: f32,
    axis: u32,
}

/// The coordinates of its points; infinite past the last.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Leaf([[f32; LEAF]; 3]);

/// A k-d tree. Points have the numbers in which it sorts them: [`Tree::order`] tells what they were.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    leaves: Vec<Leaf>,
    order: Vec<u32>,
    nodes: Vec<Node>,
    middle: DVec3,
}

impl Tree {
    /// The tree of these points, each finite; at most 2³² − 1 of them.
    pub fn new(points: &[DVec3]) -> Self {
        let (min, max) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        let middle = 0.5 * (min + max);
        let mut items: Vec<(Vec3, u32)> = points.iter().map(|p| (*p - middle).as_vec3()).zip(0..).collect();
        let mut nodes = vec![Node::default(); points.len().div_ceil(LEAF).saturating_sub(1)];
        build(&mut items, &mut nodes);
        let leaves = items.chunks(LEAF).map(Leaf::new).collect();
        Self { leaves, order: items.into_iter().map(|(_, number)| number).collect(), nodes, middle }
    }

    /// Of each point its number before it was sorted.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Adds to `nearest` what it wants of the points for which `keep` holds.
    pub fn nearest(&self, q: DVec3, nearest: &mut Nearest, keep: impl Fn(u32) -> bool) {
        if !self.leaves.is_empty() {
            let mut search = Search { tree: self, q: (q - self.middle).as_vec3(), keep, nearest };
            search.visit(0, 0, self.leaves.len(), Vec3::ZERO);
        }
    }
}

impl Leaf {
    fn new(items: &[(Vec3, u32)]) -> Self {
        Self(from_fn(|axis| from_fn(|i| items.get(i).map_or(f32::INFINITY, |(p, _)| p[axis]))))
    }

    /// The squared distance of each point.
    fn distances(&self, q: Vec3) -> [f32; LEAF] {
        let Self([xs, ys, zs]) = self;
        from_fn(|i| {
            let (x, y, z) = (xs[i] - q.x, ys[i] - q.y, zs[i] - q.z);
            x * x + y * y + z * z
        })
    }
}

struct Search<'a, K> {
    tree: &'a Tree,
    q: Vec3,
    keep: K,
    nearest: &'a mut Nearest,
}

impl<K: Fn(u32) -> bool> Search<'_, K> {
    /// `off` is the vector to the box of the node and its leaves, as far as splits have told.
    fn visit(&mut self, node: usize, from: usize, to: usize, off: Vec3) {
        if to - from == 1 {
            self.look(from);
            return;
        }
        let Node { split, axis } = self.tree.nodes[node];
        let (axis, mid) = (axis as usize, from + halved(to - from));
        let below = self.q[axis] - split;
        let mut beyond = off;
        beyond[axis] = below;
        let (left, right) = ((node + 1, from, mid), (node + mid - from, mid, to));
        let (near, far) = if below < 0.0 { (left, right) } else { (right, left) };
        self.visit(near.0, near.1, near.2, off);
        if beyond.length_squared() < self.nearest.limit() {
            self.visit(far.0, far.1, far.2, beyond);
        }
    }

    fn look(&mut self, leaf: usize) {
        let (distances, limit) = (self.tree.leaves[leaf].distances(self.q), self.nearest.limit());
        // Without a branch on what cannot be foreseen.
        let (mut close, mut count) = ([0; LEAF], 0);
        for (i, &distance2) in (0..).zip(&distances) {
            close[count] = i;
            count += usize::from(distance2 < limit);
        }
        for &i in &close[..count] {
            let number = (leaf * LEAF) as u32 + i;
            if (self.keep)(number) {
                self.nearest.push(Found::new(distances[i as usize], number));
            }
        }
    }
}

/// How many of the leaves go to the left.
fn halved(leaves: usize) -> usize {
    leaves.div_ceil(2)
}

fn build(items: &mut [(Vec3, u32)], nodes: &mut [Node]) {
    let Some((node, below)) = nodes.split_first_mut() else { return };
    let (min, max) = items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), (p, _)| (a.min(*p), b.max(*p)));
    let size = max - min;
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    let leaves = halved(below.len() + 2);
    let mid = leaves * LEAF;
    let (_, median, _) = items.select_nth_unstable_by(mid, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    *node = Node { split: median.0[axis], axis: axis as u32 };
    let (left, right) = items.split_at_mut(mid);
    let (nodes_left, nodes_right) = below.split_at_mut(leaves - 1);
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
        let mut all: Vec<_> = [0, 1, 2, 31, 32, 33, 64, 65, 97, 1000].map(|n| cloud(n, |p| p)).into();
        all.push(cloud(100_000, |p| DVec3::new(p.x, 0.0, p.z)));
        all.push(vec![DVec3::new(0.1, 0.2, 0.3); 1000]);
        all.push(cloud(3000, |p| if p.x < 0.5 { DVec3::splat(0.5) } else { p }));
        // Far from the origin and small.
        all.push(cloud(3000, |p| p * 1e-3 + 1e4));
        all
    }

    /// The distances, in order, of what was found of these points.
    fn distances(found: &[Found], q: DVec3, place: impl Fn(u32) -> DVec3) -> Vec<f64> {
        let mut all: Vec<f64> = found.iter().map(|found| place(found.number()).distance(q)).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    /// The largest gap between what a tree and a scan find, as a share of the extent; infinite where they find different
    /// numbers of points.
    fn gap(tree: &Tree, points: &[DVec3], q: DVec3, k: usize, limit: f32) -> f64 {
        let extent = points.iter().map(|p| p.distance(q)).fold(0.0, f64::max);
        let (mut by_tree, mut by_scan) = (Nearest::default(), Nearest::default());
        by_tree.begin(k, limit);
        by_scan.begin(k, limit);
        tree.nearest(q, &mut by_tree, |i| tree.order[i as usize].is_multiple_of(2));
        scan(points, q, &mut by_scan, |i| i.is_multiple_of(2));
        let by_tree = distances(by_tree.finish(), q, |i| points[tree.order[i as usize] as usize]);
        let by_scan = distances(by_scan.finish(), q, |i| points[i as usize]);
        if by_tree.len() != by_scan.len() {
            return f64::INFINITY;
        }
        by_tree.iter().zip(&by_scan).map(|(a, b)| (a - b).abs() / extent).fold(0.0, f64::max)
    }

    #[test]
    fn the_nearest_are_those_of_a_scan() {
        for points in clouds() {
            let tree = Tree::new(&points);
            let mut order = tree.order.clone();
            order.sort_unstable();
            assert!(order.iter().zip(0..).all(|(&i, j)| i == j) && order.len() == points.len());
            let (min, max) =
                points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
            for u in cloud(20, |p| p * 1.4 - 0.2) {
                // Off the points, where they are all at one.
                let q = if points.is_empty() || min == max { u } else { min + u * (max - min) };
                for (k, limit) in [(1, f32::INFINITY), (10, f32::INFINITY), (2000, f32::INFINITY)] {
                    // Roundings of places to 2⁻²⁴ of half an extent, of both ends in three axes.
                    let gap = gap(&tree, &points, q, k, limit);
                    assert!(gap <= 2e-7, "{} {k}: {gap}", points.len());
                }
                // A limit that no point is near to, as far as precision goes: those within 0.1 in the unit cube.
                if points.iter().all(|p| ((p.distance_squared(q) - 0.01) / 0.01).abs() > 1e-5) {
                    assert!(gap(&tree, &points, q, points.len(), 0.01) <= 2e-7);
                }
            }
        }
    }

    #[test]
    fn a_tree_that_forgets_the_far_side_is_found_out() {
        // The twin: the near half alone.
        let points = cloud(1024, |p| p);
        let tree = Tree::new(&points);
        let half = Tree { leaves: tree.leaves[..16].to_vec(), nodes: tree.nodes[1..16].to_vec(), ..tree };
        let wrong = cloud(20, |p| p).into_iter().any(|q| gap(&half, &points, q, 10, f32::INFINITY) > 2e-7);
        assert!(wrong, "the comparison has lost its power");
    }
}
