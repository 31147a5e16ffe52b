//! Blocks read ahead for one reader, in the order of the reader's needs.

use super::{AHEAD_BLOCKS, AHEAD_SLOT};

/// Run of consecutive blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Number of the first block.
    pub first: u32,
    /// Number of blocks in the run.
    pub count: u32,
}

/// Most runs that can wait.
const RUNS: usize = 8;

/// Blocks at hand, and runs that come next.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    numbers: [u32; AHEAD_BLOCKS],
    /// Place of the oldest block at hand; `count` blocks follow, of which the last `coming` are still on the
    /// bus.
    first: usize,
    count: usize,
    coming: usize,
    runs: [Run; RUNS],
    waiting: usize,
    /// Blocks on the bus are not wanted any more.
    is_stale: bool,
    /// The next block cannot be read; a direct read reports the reason.
    has_failed: bool,
}

impl Ahead {
    /// Creates a reader without blocks and runs.
    pub const fn new() -> Self {
        Self {
            numbers: [0; AHEAD_BLOCKS],
            first: 0,
            count: 0,
            coming: 0,
            runs: [Run { first: 0, count: 0 }; RUNS],
            waiting: 0,
            is_stale: false,
            has_failed: false,
        }
    }

    fn number(&self, nth: usize) -> u32 {
        self.numbers.get((self.first + nth) % AHEAD_BLOCKS).copied().unwrap_or(0)
    }

    const fn slot(&self, nth: usize) -> usize {
        AHEAD_SLOT + (self.first + nth) % AHEAD_BLOCKS
    }

    const fn at_hand(&self) -> usize {
        self.count - self.coming
    }

    /// Returns the number of blocks that could be read on.
    pub const fn room(&self) -> usize {
        AHEAD_BLOCKS - self.count
    }

    /// Returns whether a reader is followed.
    pub const fn is_used(&self) -> bool {
        self.count > 0 || self.waiting > 0
    }

    /// Takes a run that comes next; false without room.
    pub fn follow(&mut self, run: Run) -> bool {
        if run.count == 0 {
            return true;
        }
        if let Some(last) = self.waiting.checked_sub(1).and_then(|last| self.runs.get_mut(last))
            && last.first.checked_add(last.count) == Some(run.first)
        {
            last.count = last.count.saturating_add(run.count);
            return true;
        }
        let Some(free) = self.runs.get_mut(self.waiting) else { return false };
        *free = run;
        self.waiting += 1;
        true
    }

    /// Drops the followed reader and its blocks.
    pub const fn forget(&mut self) {
        self.is_stale = self.coming > 0;
        (self.first, self.count, self.waiting, self.has_failed) = (0, self.coming, 0, false);
        // Blocks on the bus keep their slots until they have come.
    }

    /// Returns the slot of a block at hand and drops the blocks before it.
    pub fn take(&mut self, number: u32) -> Option<usize> {
        let nth = self.position(number)?;
        self.first = (self.first + nth) % AHEAD_BLOCKS;
        self.count -= nth;
        Some(self.slot(0))
    }

    fn position(&self, number: u32) -> Option<usize> {
        if self.is_stale {
            return None;
        }
        (0..self.at_hand()).find(|nth| self.number(*nth) == number)
    }

    /// Returns the slot of a block at hand, which stays.
    pub fn find(&self, number: u32) -> Option<usize> {
        self.position(number).map(|nth| self.slot(nth))
    }

    /// Returns whether a block is on its way. A block that waits for a place does not count while every place
    /// has a block before it: a reader who wants it first takes none of those.
    pub fn brings(&self, number: u32) -> bool {
        let within = |run: &Run| number.checked_sub(run.first).is_some_and(|offset| offset < run.count);
        let comes = !self.is_stale && (self.at_hand()..self.count).any(|nth| self.number(nth) == number);
        comes || !self.has_failed && self.room() > 0 && self.runs.iter().take(self.waiting).any(within)
    }

    /// Returns the next blocks to read, at most so many, in consecutive slots, and the first slot.
    pub fn next(&self, most: usize) -> Option<(Run, usize)> {
        if self.waiting == 0 || self.coming > 0 || self.has_failed {
            return None;
        }
        let run = self.runs.first()?;
        let behind = (self.first + self.count) % AHEAD_BLOCKS;
        let room = (AHEAD_BLOCKS - self.count).min(AHEAD_BLOCKS - behind).min(most);
        let count = run.count.min(room as u32);
        (count > 0).then_some((Run { first: run.first, count }, AHEAD_SLOT + behind))
    }

    /// Returns whether the waiting run is longer than this one, so that waiting allows a longer transfer.
    pub fn has_longer(&self, run: Run) -> bool {
        self.runs.first().is_some_and(|first| first.count > run.count)
    }

    /// Marks the run as on the bus from now on.
    pub fn begin(&mut self, run: Run) {
        for number in run.first..run.first + run.count {
            let place = (self.first + self.count) % AHEAD_BLOCKS;
            if let Some(free) = self.numbers.get_mut(place) {
                *free = number;
            }
            self.count += 1;
        }
        self.coming = run.count as usize;
        let Some(next) = self.runs.first_mut() else { return };
        *next = Run { first: next.first + run.count, count: next.count - run.count };
        if next.count == 0 {
            self.runs.rotate_left(1);
            self.waiting -= 1;
        }
    }

    /// Notes the end of the transfer on the bus: its blocks have come, or never will.
    pub const fn finish(&mut self, has_come: bool) {
        if self.is_stale {
            (self.is_stale, self.first, self.count) = (false, 0, 0);
        } else if !has_come {
            self.count -= self.coming;
            self.has_failed = true;
        }
        self.coming = 0;
    }

    /// Returns the slot of a block at hand or on the bus.
    pub fn slot_of_any(&self, number: u32) -> Option<usize> {
        (0..self.count).find(|nth| self.number(*nth) == number).map(|nth| self.slot(nth))
    }
}
