//! The laser at the motion object: what it is like, its memory, and the block that may grow.

use units::{TickTime, Ticks};

use crate::{config, elsewhere::Elsewhere};

mod growth;

pub(crate) use growth::{Growth, MOST_MOVES};
pub(crate) use laser_power::{Kind, Law, NextChange, Output, Pending, Step};
pub use laser_power::{LaserConfig, MOST_CURVE_POINTS, Power, PowerCurve, PowerStore};

const _: () = assert!(laser_power::MOST_BLOCKS == config::MOST_BLOCKS);

/// A laser, if the machine has one. At the start all bits are zero.
#[derive(Debug)]
pub(crate) struct Laser {
    /// The laser at the cursor and at the output.
    pub at: laser_power::Laser,
    /// Place of the levels along blocks and of the changes to come. A motion object that makes no steps has
    /// none.
    pub store: Option<Elsewhere<PowerStore>>,
    /// The last block of the queue, while it may grow.
    pub growth: Growth,
}

impl Laser {
    /// No laser.
    pub const NONE: Self = Self { at: laser_power::Laser::NONE, store: None, growth: Growth::NONE };

    /// Whether there is a laser.
    pub const fn is_configured(&self) -> bool {
        self.at.config.is_some()
    }

    /// Whether power goes to the step queue.
    pub const fn is_on(&self) -> bool {
        self.is_configured() && self.store.is_some()
    }

    /// Whether no change of power waits.
    pub fn is_quiet(&self) -> bool {
        self.store.as_ref().is_none_or(|store| store.changes.is_empty())
    }

    /// The level does not change within the block of this count, so far.
    pub fn begin_block(&mut self, block: u32) {
        if let (true, Some(store)) = (self.is_configured(), &mut self.store) {
            store.levels.begin(block);
        }
    }

    /// Blocks from `first` up to that of count `behind`, which waits, have been put in front of it: the level
    /// does not change within them.
    pub fn skip_levels(&mut self, first: u32, behind: u32) {
        if let Some(store) = &mut self.store {
            store.skip_levels(first, behind);
        }
    }

    /// Whether the levels of a released block are still there.
    pub fn keeps(&self, block: u32) -> bool {
        self.store.as_ref().is_none_or(|store| store.levels.keeps(block))
    }

    /// Takes up the levels of the block in execution, `level` being its first, from this distance on.
    pub fn run_block(&mut self, block: u32, level: u16, travelled: f64) {
        if let Some(store) = &self.store {
            self.at.run_block(store, block, level, travelled);
        }
    }

    /// Takes the next change of level before this distance along the block in execution: the distance and how
    /// much the tag grows by there.
    pub fn next_step(&mut self, before: f64) -> Option<(f64, u16)> {
        self.at.next_step(self.store.as_ref()?, before)
    }

    /// The law in force holds for `seconds` from `from` on, while the speed changes evenly from the first to
    /// the second, mm/s.
    pub fn along(&mut self, from: TickTime, seconds: f64, speeds: [f64; 2]) {
        if let Some(store) = &mut self.store {
            self.at.along(store, from, seconds, speeds);
        }
    }

    /// The laser is off from then on, before delays.
    #[inline(never)]
    pub fn rest(&mut self, at: TickTime) {
        if let Some(store) = &mut self.store {
            self.at.rest(store, at);
        }
    }

    /// This law holds from a time of the trajectory on.
    pub fn send(&mut self, time: u64, law: Law) {
        if let Some(store) = &mut self.store {
            self.at.send(store, time, law);
        }
    }

    /// Forgets the laws that hold from this time of the trajectory on.
    pub fn take_back(&mut self, time: u64) {
        if let Some(store) = &mut self.store {
            self.at.take_back(store, time);
        }
    }

    /// Shifts the laws to come in time.
    pub fn shift(&mut self, by: TickTime) {
        if let Some(store) = &mut self.store {
            store.shift(by);
        }
    }

    /// Forgets all power that is to come, as nothing of it is played.
    #[inline(never)]
    pub fn clear(&mut self) {
        self.growth.moves = 0;
        if let Some(store) = &mut self.store {
            self.at.clear(store);
        }
    }

    /// Forgets all power that is to come; the first event is that the laser goes off.
    pub fn off_at_once(&mut self, at: Ticks) {
        self.clear();
        if let (true, Some(store)) = (self.is_configured(), &mut self.store) {
            store.changes.off_at_once(at);
        }
    }
}
