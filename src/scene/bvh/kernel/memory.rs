//! Memory: the stack of a traversal, and arrays so large that the size of pages matters.
#![allow(clippy::inline_always, reason = "a stack in memory instead of registers and cache lines would be slow")]

use std::mem::MaybeUninit;

/// What a traversal has put off; its slots are not written before they are used.
pub(in crate::scene::bvh) struct Stack {
    slots: [MaybeUninit<u64>; Self::SLOTS],
    used: u8,
}

impl Stack {
    /// Seven siblings on each level of the deepest tree that the builder makes, with room to spare. The number of slots is
    /// that of a byte's values, so that no index needs a check.
    pub(in crate::scene::bvh) const SLOTS: usize = 256;

    #[inline(always)]
    pub(in crate::scene::bvh) fn new() -> Self {
        // SAFETY: an array of `MaybeUninit` needs no initialisation. `[MaybeUninit::uninit(); SLOTS]` would be a constant, and
        // be copied.
        Self { slots: unsafe { MaybeUninit::<[MaybeUninit<u64>; Self::SLOTS]>::uninit().assume_init() }, used: 0 }
    }

    #[inline(always)]
    pub(in crate::scene::bvh) fn push(&mut self, waiting: u64) {
        debug_assert!(self.used < u8::MAX, "the builder bounds the depth");
        self.slots[usize::from(self.used)].write(waiting);
        self.used = self.used.wrapping_add(1);
    }

    #[inline(always)]
    pub(in crate::scene::bvh) fn pop(&mut self) -> Option<u64> {
        self.used = self.used.checked_sub(1)?;
        // SAFETY: the slots below the former `used` have been written by `push`, even if it had come round.
        Some(unsafe { self.slots[usize::from(self.used)].assume_init() })
    }

    /// Orders the topmost `count` so that the least comes off first.
    #[inline(always)]
    pub(in crate::scene::bvh) fn sort_top(&mut self, count: u8) {
        let first = self.used - count;
        for end in first + 1..self.used {
            // SAFETY: slots below `used` have been written by `push`.
            let moved = unsafe { self.slots[usize::from(end)].assume_init() };
            let mut at = end;
            while at > first {
                // SAFETY: as above.
                let before = unsafe { self.slots[usize::from(at - 1)].assume_init() };
                if before >= moved {
                    break;
                }
                self.slots[usize::from(at)].write(before);
                at -= 1;
            }
            self.slots[usize::from(at)].write(moved);
        }
    }
}

/// An empty vector of some capacity, in huge pages if it is large and the system grants them.
///
/// A traversal reads all over the place, and a miss of the cache that is also one of the page table's costs twice.
pub(in crate::scene::bvh) fn in_huge_pages<T>(capacity: usize) -> Vec<T> {
    let vec = Vec::<T>::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 1 << 12;
        const HUGE: usize = 1 << 21;
        let bytes = capacity * size_of::<T>();
        if bytes >= 2 * HUGE {
            let start = vec.as_ptr().addr().next_multiple_of(PAGE);
            let len = (vec.as_ptr().addr() + bytes - start) / PAGE * PAGE;
            // SAFETY: the range lies within the vector's allocation; the advice changes no byte of it. It may be declined.
            unsafe { libc::madvise(vec.as_ptr().with_addr(start).cast_mut().cast(), len, libc::MADV_HUGEPAGE) };
        }
    }
    vec
}

/// Asks for the first cache line of something that will be read soon.
#[inline]
pub(crate) fn prefetch<T>(at: &T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 processor has the instruction, and it never fails.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(at).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = at;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stack_gives_the_least_first() {
        let mut stack = Stack::new();
        for waiting in [9, 3, 1, 2, 2] {
            stack.push(waiting);
        }
        stack.sort_top(4);
        let popped: Vec<u64> = std::iter::from_fn(|| stack.pop()).collect();
        assert_eq!(popped, [1, 2, 2, 3, 9]);
    }

    #[test]
    fn large_vectors_are_vectors() {
        for capacity in [0, 1, 1 << 20] {
            let mut vec = in_huge_pages::<u64>(capacity);
            vec.extend(0..capacity as u64);
            assert!(vec.capacity() >= capacity && vec.iter().sum::<u64>() == (0..capacity as u64).sum::<u64>());
        }
    }
}
