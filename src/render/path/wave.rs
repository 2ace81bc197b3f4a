//! Several paths under way at once: while one waits for a division, a square root or the memory, the core works on the next.
//!
//! All paths cast their rays, then all are scattered, then all ask for the light that they were promised. Each has the
//! same bits as alone.

#![allow(clippy::inline_always, reason = "inlined into a function that has the best instructions enabled")]

use super::PathTracer;
use super::walk::Walk;
use crate::render::{Sample, WAVE};
use crate::sampling::sampler::Sampler;
use crate::scene::bvh::Work;
use crate::scene::{Ray, Scene};

/// Paths under way at once, at most.
pub(super) const MOST: usize = WAVE;

/// Up to [`MOST`] samples, to be traced with the best instructions of the machine.
pub(super) struct Wave<'a, S> {
    pub(super) tracer: &'a PathTracer,
    pub(super) scene: &'a Scene,
    pub(super) samples: &'a mut [Sample<S>],
}

impl<S: Sampler> Work for Wave<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { tracer, scene, samples } = self;
        // Samples that come together are often of neighbouring pixels.
        let rays: Vec<Ray> = samples.iter().map(|sample| sample.ray).collect();
        let mut hits = Vec::with_capacity(rays.len());
        scene.closest_of_each(&rays, &mut hits);
        let mut walks: Vec<Walk> = rays.into_iter().zip(hits).map(|(ray, hit)| Walk::new(ray, hit)).collect();
        let mut under_way = List::EMPTY;
        for i in 0..walks.len() {
            under_way.push_if(true, i);
        }
        while !under_way.is_empty() {
            let (mut promised, mut going_on) = (List::EMPTY, List::EMPTY);
            for i in under_way.paths() {
                going_on.push_if(walks[i].step(tracer, scene, &mut samples[i].sampler), i);
                promised.push_if(walks[i].is_promised_light(), i);
            }
            for i in promised.paths() {
                walks[i].receive(scene);
            }
            under_way = going_on;
            for i in under_way.paths() {
                walks[i].cast(scene);
            }
        }
        for (sample, walk) in samples.iter_mut().zip(&walks) {
            sample.radiance = walk.sum();
        }
    }
}

/// Some of the paths. Which ones is not known to any predictor, so there is no branch on it.
struct List {
    /// The first `count` count.
    numbers: [u8; MOST],
    count: usize,
}

impl List {
    const EMPTY: Self = Self { numbers: [0; MOST], count: 0 };

    #[inline(always)]
    fn push_if(&mut self, yes: bool, path: usize) {
        self.numbers[self.count % MOST] = path as u8;
        self.count += usize::from(yes);
    }

    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.count == 0
    }

    #[inline(always)]
    fn paths(&self) -> impl Iterator<Item = usize> {
        self.numbers.iter().take(self.count).map(|&number| usize::from(number))
    }
}
