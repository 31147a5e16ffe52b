//! The laser's output as the firmware drives it: a duty, which the path changes with its steps.

use super::World;
use crate::trace::PowerChange;

/// The laser, locked off at the start.
#[derive(Clone, Debug, Default)]
pub struct Laser {
    is_unlocked: bool,
    duty: u16,
}

impl Laser {
    /// Returns the duty, 1/65535.
    #[must_use]
    pub const fn duty(&self) -> u16 {
        self.duty
    }
}

impl World {
    /// Returns the output of the laser.
    #[must_use]
    pub const fn laser(&self) -> &Laser {
        &self.laser
    }

    /// Gives the laser another duty, 1/65535, unless it is locked.
    pub fn set_laser(&mut self, at_ns: u64, duty: u16) {
        if self.laser.is_unlocked {
            self.change_laser(at_ns, duty);
        }
    }

    /// Locks the laser off, or lets what comes from now on through.
    pub fn lock_laser(&mut self, at_ns: u64, is_locked: bool) {
        self.laser.is_unlocked = !is_locked;
        self.change_laser(at_ns, 0);
    }

    fn change_laser(&mut self, time_ns: u64, duty: u16) {
        if core::mem::replace(&mut self.laser.duty, duty) != duty {
            self.trace_mut().push_power(PowerChange { time_ns, duty });
        }
    }
}
