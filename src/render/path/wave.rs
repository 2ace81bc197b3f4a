//! Several paths under way at once: while one waits for a division, a square root or the memory, the core works on the next.
//!
//! All paths cast their rays, then all are scattered, then all ask for the light that they were promised. Each has the
//! same bits as alone.

use super::PathTracer;
use super::walk::Walk;
use crate::render::{Sample, WAVE};
use crate::scene::Scene;
use crate::scene::bvh::Work;

/// Paths under way at once, at most.
pub(super) const MOST: usize = WAVE;

/// Up to [`MOST`] samples, to be traced with the best instructions of the machine.
pub(super) struct Wave<'a> {
    pub(super) tracer: &'a PathTracer,
    pub(super) scene: &'a Scene,
    pub(super) samples: &'a mut [Sample],
}

impl Work for Wave<'_> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "inlined into a function that has those instructions enabled")]
    #[inline(always)]
    fn run(self) {
        let Self { tracer, scene, samples } = self;
        let mut walks: Vec<Walk> = samples.iter().map(|sample| Walk::new(sample.ray)).collect();
        let mut under_way: Vec<usize> = (0..samples.len()).collect();
        let mut going_on = under_way.clone();
        while !under_way.is_empty() {
            for &i in &under_way {
                walks[i].cast(scene);
            }
            going_on.clear();
            for &i in &under_way {
                if walks[i].step(tracer, scene, &mut samples[i].sampler) {
                    going_on.push(i);
                }
            }
            for &i in &under_way {
                walks[i].receive(scene);
            }
            std::mem::swap(&mut under_way, &mut going_on);
        }
        for (sample, walk) in samples.iter_mut().zip(&walks) {
            sample.radiance = walk.sum();
        }
    }
}
