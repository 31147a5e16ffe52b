//! Device under test, as a simulated host sees it.

/// Handler of the bus's events.
pub trait Device {
    /// Handles all pending events.
    fn run(&mut self);
}
