//! The laser's output as the firmware drives it: a duty, which the path changes with its steps.

use super::World;

/// The laser, locked off at the start.
#[derive(Clone, Debug, Default)]
pub struct Laser {
    is_unlocked: bool,
    duty: u16,
    /// Changes of the duty with their times, nanoseconds, once somebody asked for them.
    edges: Option<Vec<(u64, u16)>>,
}

impl Laser {
    /// Gives the output another duty, 1/65535, unless it is locked.
    pub fn set(&mut self, at_ns: u64, duty: u16) {
        if self.is_unlocked && duty != self.duty {
            self.change(at_ns, duty);
        }
    }

    /// Locks the output off, or lets what comes from now on through.
    pub fn lock(&mut self, at_ns: u64, is_locked: bool) {
        self.is_unlocked = !is_locked;
        if self.duty != 0 {
            self.change(at_ns, 0);
        }
    }

    fn change(&mut self, at_ns: u64, duty: u16) {
        self.duty = duty;
        if let Some(edges) = &mut self.edges {
            edges.push((at_ns, duty));
        }
    }

    /// Returns the duty, 1/65535.
    #[must_use]
    pub const fn duty(&self) -> u16 {
        self.duty
    }

    /// Returns the changes of the duty since the last call, nanoseconds and 1/65535 each; the first call
    /// begins the record.
    pub fn take_edges(&mut self) -> Vec<(u64, u16)> {
        self.edges.replace(Vec::new()).unwrap_or_default()
    }
}

impl World {
    /// Returns the laser.
    pub const fn laser(&mut self) -> &mut Laser {
        &mut self.laser
    }
}
