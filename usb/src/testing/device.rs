//! A device that a host plays with.

/// Whatever handles the bus's events.
pub trait Device {
    /// Handles what is there.
    fn run(&mut self);
}
