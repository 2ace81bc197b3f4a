//! A tree over anything that has a box.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use rayon::prelude::*;

use super::aabb::Aabb;
use super::build::Tree;
use super::kernel::{Lanes, Level, Task};
use super::node::{Beam, Node};
use super::query::{Frame, Query, Straight, up};
use super::triangles::item;
use super::walk::{self, Prefetch, Visit};
use crate::scene::ray::Ray;

/// Boxes of things that a caller intersects: spheres, disks, whole meshes.
///
/// Things whose box is empty, or not finite, are never asked for.
#[derive(Clone, Debug)]
pub struct BoxBvh {
    level: Level,
    frame: Frame,
    bounds: Aabb,
    nodes: Vec<Node>,
    /// The thing in each leaf.
    things: Vec<u32>,
    root: Option<u32>,
}

/// Whether a box can be put into a tree.
fn sound(bounds: &Aabb) -> bool {
    !bounds.is_empty() && bounds.min.is_finite() && bounds.max.is_finite()
}

/// Whether a ray has one.
#[inline]
fn direction(ray: &Ray) -> bool {
    let long = ray.dir.length_squared();
    debug_assert!((0.81..1.21).contains(&long) || !(long > 0.0 && long < f64::INFINITY), "a unit vector: {}", ray.dir);
    (0.81..1.21).contains(&long)
}

impl BoxBvh {
    /// Builds the tree, in parallel, and the same one on any number of threads. No more than 2³⁰ boxes.
    pub fn build(boxes: &[Aabb]) -> Self {
        let bounds = boxes.iter().copied().filter(sound).fold(Aabb::EMPTY, Aabb::union);
        let frame = Frame::of(&bounds);
        let items = boxes.par_iter().enumerate().filter(|(_, bounds)| sound(bounds));
        let items = items.map(|(index, bounds)| item(&frame, bounds, index as u32));
        let level = Level::best();
        let tree = Tree::build(items.collect(), 1, level);
        let things = tree.leaves.iter().map(|leaf| tree.items[leaf.start as usize].index()).collect();
        Self { level, frame, bounds, nodes: tree.nodes, things, root: tree.root }
    }

    /// The nearest hit: the thing, and its distance.
    ///
    /// `hit(thing, t_max)` returns the thing's nearest hit with 0 < t < t_max, t_max being that of the ray; it is asked
    /// for things whose boxes the ray enters, near boxes first. Of hits at the same distance, that of the lowest index
    /// counts.
    #[inline]
    pub fn closest(&self, ray: &Ray, hit: impl FnMut(u32, f64) -> Option<f64>) -> Option<(u32, f64)> {
        if !direction(ray) {
            return None;
        }
        self.level.run(Closest { tree: self, ray, hit })
    }

    /// Whether `hit(thing, t_max)` is true of any thing whose box the ray enters before `ray.t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, hit: impl FnMut(u32, f64) -> bool) -> bool {
        direction(ray) && self.level.run(Occluded { tree: self, ray, hit })
    }

    /// The box around all boxes; empty if there is none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// What the tree occupies.
    pub fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.things.capacity() * size_of::<u32>() + size_of::<Self>()
    }
}

/// Leaves without memory of their own.
struct Nothing;

impl Prefetch for Nothing {
    #[inline(always)]
    fn prefetch<S: Lanes>(&self, _: S, _: u32) {}
}

struct Closest<'a, H> {
    tree: &'a BoxBvh,
    ray: &'a Ray,
    hit: H,
}

impl<H: FnMut(u32, f64) -> Option<f64>> Task for Closest<'_, H> {
    type Output = Option<(u32, f64)>;

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(self, narrow: N, _: W) -> Option<(u32, f64)> {
        let query = Query::new::<Straight>(narrow, &self.tree.frame, self.ray)?;
        let beam = Beam::new(narrow, &query.slabs::<Straight>(narrow));
        let (nodes, root, reach) = (&self.tree.nodes, self.tree.root?, query.reach);
        let mut nearest = Nearest { of: self, best: None, reach };
        walk::nearest_first(narrow, nodes, root, &beam, reach, &Nothing, &mut nearest);
        nearest.best
    }
}

struct Nearest<'a, H> {
    of: Closest<'a, H>,
    best: Option<(u32, f64)>,
    reach: f32,
}

impl<S, H: FnMut(u32, f64) -> Option<f64>> Visit<S> for Nearest<'_, H> {
    #[inline(always)]
    fn visit(&mut self, _: S, leaf: u32) -> f32 {
        let Closest { tree, ray, hit } = &mut self.of;
        let thing = tree.things[leaf as usize];
        if let Some(t) = hit(thing, ray.t_max)
            && self.best.is_none_or(|(other, least)| t < least || (t == least && thing < other))
        {
            self.reach = up(t * tree.frame.scale);
            self.best = Some((thing, t));
        }
        self.reach
    }
}

struct Occluded<'a, H> {
    tree: &'a BoxBvh,
    ray: &'a Ray,
    hit: H,
}

impl<H: FnMut(u32, f64) -> bool> Task for Occluded<'_, H> {
    type Output = bool;

    #[inline(always)]
    fn run<N: Lanes, W: Lanes>(mut self, narrow: N, _: W) -> bool {
        let Some(root) = self.tree.root else { return false };
        let Some(query) = Query::new::<Straight>(narrow, &self.tree.frame, self.ray) else { return false };
        let beam = Beam::new(narrow, &query.slabs::<Straight>(narrow));
        walk::any(narrow, &self.tree.nodes, root, &beam, query.reach, &Nothing, |leaf| {
            (self.hit)(self.tree.things[leaf as usize], self.ray.t_max)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{stream, uniform};
    use glam::DVec3;

    fn sphere(ray: &Ray, (centre, radius): (DVec3, f64)) -> Option<f64> {
        let to = centre - ray.origin;
        let along = to.dot(ray.dir);
        let half = (radius * radius - (to - along * ray.dir).length_squared()).sqrt();
        [along - half, along + half].into_iter().find(|&t| t > 0.0 && t < ray.t_max)
    }

    #[test]
    fn spheres_are_those_that_brute_force_finds() {
        let mut rng = stream(5, 0, 0);
        let mut number = || uniform(&mut rng);
        for count in [0, 1, 2, 7, 9, 300] {
            let mut point = || DVec3::from_array([(); 3].map(|()| 2.0 * number() - 1.0));
            let mut spheres: Vec<(DVec3, f64)> = (0..count).map(|_| (point(), 0.2 * point().x.abs())).collect();
            if let Some(&first) = spheres.first() {
                spheres.push(first);
            }
            let boxes: Vec<Aabb> =
                spheres.iter().map(|&(c, r)| Aabb { min: c - DVec3::splat(r), max: c + DVec3::splat(r) }).collect();
            let tree = BoxBvh::build(&boxes);
            for _ in 0..2000 {
                let ray = Ray::up_to(1.5 * point(), point().normalize(), 4.0 * point().x.abs());
                let every = (0..).zip(&spheres).filter_map(|(i, &s)| Some((i, sphere(&ray, s)?)));
                let expected = every.min_by(|a, b| a.1.total_cmp(&b.1));
                let hit = |thing: u32, _: f64| sphere(&ray, spheres[thing as usize]);
                assert_eq!(tree.closest(&ray, hit), expected);
                assert_eq!(tree.occluded(&ray, |thing, t_max| hit(thing, t_max).is_some()), expected.is_some());
            }
        }
    }

    #[test]
    fn boxes_that_are_none_are_left_out() {
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let boxes =
            [Aabb::EMPTY, Aabb { min: DVec3::NAN, max: DVec3::ONE }, unit, Aabb { max: DVec3::INFINITY, ..unit }];
        let tree = BoxBvh::build(&boxes);
        assert_eq!(tree.bounds(), unit);
        let asked = tree.closest(&Ray::new(DVec3::new(0.5, 0.5, -1.0), DVec3::Z), |thing, _| Some(f64::from(thing)));
        assert_eq!(asked, Some((2, 2.0)));
    }
}
