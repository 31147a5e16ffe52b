//! Where what happens is kept.

use events::EventRing;

/// The ring of events, which survives a reset.
pub trait EventLog {
    /// The ring. Whoever has it may write: nothing in it decides anything.
    fn events(&self) -> EventRing<'_>;
}
