//! How many rays each thread has cast.

use std::cell::Cell;

thread_local! {
    static CAST: Cell<u64> = const { Cell::new(0) };
}

/// One more ray.
#[inline]
pub(super) fn count() {
    CAST.set(CAST.get() + 1);
}

/// The number of rays that this thread has cast so far: differences count the work in between.
pub fn cast() -> u64 {
    CAST.get()
}
