//! Large data of a laser's power: looked at when power changes, never per step.

/// Levels along the blocks that wait, and the changes of power to come (about 26 KiB, all zero at the start).
#[derive(Debug)]
pub struct PowerStore {}

impl Default for PowerStore {
    fn default() -> Self {
        Self::new()
    }
}

impl PowerStore {
    /// Creates an empty store.
    #[must_use]
    pub const fn new() -> Self {
        Self {}
    }
}
