//! The laser's output as the firmware drives it: a duty, which the path changes with its steps.

use super::World;
use crate::trace::PowerChange;

/// The laser, locked off at the start.
#[derive(Clone, Debug, Default)]
pub struct Laser {
    is_unlocked: bool,
    /// Kept off while the machine holds.
    is_dark: bool,
    /// Duty that the path or the executor asks for.
    asked: u16,
    /// Duty at the output.
    duty: u16,
    /// Whether power went off because it was not renewed, since the firmware last looked.
    has_lapsed: bool,
}

impl Laser {
    /// Returns the duty at the output, 1/65535.
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
            self.laser.asked = duty;
            self.change_laser(at_ns, if self.laser.is_dark { 0 } else { duty });
        }
    }

    /// Keeps the output off, or lets the duty come out again.
    pub fn darken_laser(&mut self, at_ns: u64, is_dark: bool) {
        self.laser.is_dark = is_dark;
        self.set_laser(at_ns, self.laser.asked);
    }

    /// Locks the laser off, or lets what comes from now on through.
    pub fn lock_laser(&mut self, at_ns: u64, is_locked: bool) {
        self.laser.is_unlocked = !is_locked;
        self.laser.asked = 0;
        self.change_laser(at_ns, 0);
    }

    /// Has power go off as the board's watch does when the steps or the executor come late.
    pub fn let_laser_lapse(&mut self, at_ns: u64) {
        self.laser.has_lapsed = true;
        self.lock_laser(at_ns, true);
    }

    /// Returns whether power has gone off so since the last call.
    pub fn take_lapse(&mut self) -> bool {
        core::mem::take(&mut self.laser.has_lapsed)
    }

    /// Follows a laser's output pin, whatever the lock: from now on it has this duty, 1/65535.
    pub fn laser_pin(&mut self, at_ns: u64, duty: u16) {
        self.change_laser(at_ns, duty);
    }

    fn change_laser(&mut self, time_ns: u64, duty: u16) {
        if core::mem::replace(&mut self.laser.duty, duty) != duty {
            self.trace_mut().push_power(PowerChange { time_ns, duty });
        }
    }
}
