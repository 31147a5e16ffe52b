//! Viewers of the machine: pages in browsers, and displays.

use crate::snapshot::Snapshot;

/// Access to those who look at the machine. A board without any leaves all of it out.
pub trait Viewers {
    /// Whether somebody looks, and was last shown the machine long enough ago.
    fn wants_snapshot(&self) -> bool {
        false
    }

    /// Shows the machine as it is now.
    fn show(&mut self, _snapshot: &Snapshot) {}
}
