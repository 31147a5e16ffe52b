//! Frames of their own.

/// Does it with a frame of its own on the stack. A function with many arms has room for the largest of what
/// they hold at the same time, and for much of the rest: below a large one the others would lie there unused,
/// for as long as a sequence waits.
#[inline(never)]
pub fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}
