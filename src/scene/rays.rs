//! How many rays each thread has cast.

use std::cell::Cell;

thread_local! {
    static CAST: Cell<u64> = const { Cell::new(0) };
}

/// So many more rays.
#[inline]
pub(super) fn count(rays: u64) {
    CAST.set(CAST.get() + rays);
}

/// The number of rays that this thread has cast so far: differences count the work in between.
pub fn cast() -> u64 {
    CAST.get()
}
