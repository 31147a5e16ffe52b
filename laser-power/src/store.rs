//! Large data of a laser's power: looked at when power changes, never per step.

use units::Ring;

use crate::{Changes, Law, Levels};

/// Changes of law that can be on their way through the filters: those of 10 ms at 25 000 a second.
const MOST_PENDING: usize = 256;

/// Law that holds from a place of the trajectory on.
#[derive(Clone, Copy, Debug)]
pub struct Pending {
    /// Time of the trajectory, low half.
    pub time: u64,
    /// The law.
    pub law: Law,
}

/// Levels along the blocks that wait, and the changes of power to come (about 42 KiB, all zero at the start).
#[derive(Debug)]
pub struct PowerStore {
    /// Levels along the blocks that wait.
    pub levels: Levels,
    /// Laws on their way through the filters.
    pub pending: Ring<Pending, MOST_PENDING>,
    /// Changes of duty on their way to the step queue.
    pub changes: Changes,
}

impl Default for PowerStore {
    fn default() -> Self {
        Self::new()
    }
}

impl PowerStore {
    /// Creates an empty store.
    #[must_use]
    pub const fn new() -> Self {
        let none = Pending { time: 0, law: Law::OFF };
        Self { levels: Levels::new(), pending: Ring::new(none), changes: Changes::new() }
    }
}
