//! Access to the log of events.

use events::EventRing;

/// Ring of events, which survives a reset.
pub trait EventLog {
    /// Returns the ring. Every holder may write: nothing in it decides anything.
    fn events(&self) -> EventRing<'_>;
}
