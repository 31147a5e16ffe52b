//! Work in stack frames of its own.

/// Does the work in a stack frame of its own. The frame of a function with many arms has room for the largest
/// of what its arms hold at the same time, and for much of the rest: below a long sequence this room would
/// lie unused for as long as the sequence waits.
#[inline(never)]
pub fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}
