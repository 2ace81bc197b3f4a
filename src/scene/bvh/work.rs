//! Other work that is compiled once for each set of instructions, as traversal is.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::kernel::{Lanes, Task};
use super::triangles::TriangleBvh;

/// Something to do with the best instructions of the machine. The results are the same bits with any: nothing is fused
/// that is not written so.
pub(crate) trait Work {
    /// What comes out.
    type Output;
    /// Does it. Must be `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

struct WorkAsTask<W>(W);

impl<W: Work> Task for WorkAsTask<W> {
    type Output = W::Output;

    #[inline(always)]
    fn run<N: Lanes, V: Lanes>(self, _: N, _: V) -> W::Output {
        self.0.run()
    }
}

impl TriangleBvh {
    /// Does `work` with the instructions that this tree's traversal uses.
    #[inline]
    pub(crate) fn accelerate<W: Work>(&self, work: W) -> W::Output {
        self.level().run(WorkAsTask(work))
    }
}
