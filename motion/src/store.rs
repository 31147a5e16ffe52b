//! Large data of motion that is looked at per knot or per block, never per step.
//!
//! The store is separate from [`crate::Motion`], so that a board can give the motion object its fastest
//! memory and the store a larger one.

use crate::{compensation::Surface, filters::History, laser::Laser, path::CurveRing, timeline::Timeline};

/// The past that filters look back on, the curves of the blocks that wait (about 32 KiB), the bed's surface
/// (42 KiB), what the moves are made for, and a laser.
#[derive(Debug)]
pub struct Store {
    pub(crate) history: History,
    pub(crate) curves: CurveRing,
    pub(crate) surface: Surface,
    pub(crate) timeline: Timeline,
    pub(crate) laser: Laser,
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

impl Store {
    /// Creates an empty store.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            history: History::new(),
            curves: CurveRing::new(),
            surface: Surface::new(),
            timeline: Timeline::new(),
            laser: Laser::NONE,
        }
    }
}
