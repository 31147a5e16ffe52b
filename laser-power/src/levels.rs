//! Levels of power along the blocks that wait: places at which the level changes within a block.
//!
//! A block made of many collinear moves has an entry for each change of level behind its beginning. The
//! entries of blocks that have been released stay until they are overwritten, as the blocks do, so that
//! trajectory may be taken back.

/// Blocks of the planner's ring.
pub const MOST_BLOCKS: usize = 256;
/// Entries, a power of two.
const CAPACITY: usize = 4_096;
/// Entries of blocks that wait, at most: the others are kept behind them for trajectory taken back. Pixels of
/// 0.02 mm give 66 mm to brake in, enough for 500 mm/s at 2,000 mm/s^2.
const MOST_WAITING: u16 = 3_328;

/// Change of level within a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Path distance from the beginning of the block, mm.
    pub distance: f32,
    /// Share of full power from there on, in 1/65535.
    pub level: u16,
    /// Tag of the move that begins there, less the block's.
    pub later: u16,
}

/// Entries of a block: counts of the first and of the one behind the last, wrapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entries {
    /// Count of the first.
    pub next: u16,
    /// Count of the one behind the last.
    pub end: u16,
}

/// The entries of all blocks.
#[derive(Debug)]
pub struct Levels {
    steps: [Step; CAPACITY],
    blocks: [Entries; MOST_BLOCKS],
    /// Count of entries ever made.
    end: u16,
}

impl Default for Levels {
    fn default() -> Self {
        Self::new()
    }
}

impl Levels {
    /// Creates an empty table.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            steps: [Step { distance: 0.0, level: 0, later: 0 }; CAPACITY],
            blocks: [Entries { next: 0, end: 0 }; MOST_BLOCKS],
            end: 0,
        }
    }

    fn block_mut(&mut self, block: u32) -> &mut Entries {
        // The remainder is always in range: the check disappears.
        &mut self.blocks[block as usize % MOST_BLOCKS]
    }

    /// Says that the level does not change within this block, so far.
    pub fn begin(&mut self, block: u32) {
        *self.block_mut(block) = Entries { next: self.end, end: self.end };
    }

    /// Adds a change to the newest block that was begun.
    pub fn push(&mut self, block: u32, step: Step) {
        self.steps[usize::from(self.end) % CAPACITY] = step;
        self.end = self.end.wrapping_add(1);
        self.block_mut(block).end = self.end;
    }

    /// Says that the level does not change within a block that was put in front of another.
    pub fn skip(&mut self, block: u32, behind: u32) {
        let next = self.of(behind).next;
        *self.block_mut(block) = Entries { next, end: next };
    }

    /// Whether no change can be added while this block is the first that waits.
    #[must_use]
    pub fn is_full(&self, first: u32) -> bool {
        self.end.wrapping_sub(self.of(first).next) >= MOST_WAITING
    }

    /// Returns the entries of a block.
    #[must_use]
    pub fn of(&self, block: u32) -> Entries {
        self.blocks[block as usize % MOST_BLOCKS]
    }

    /// Whether the entries of a block have not been overwritten.
    #[must_use]
    pub fn keeps(&self, block: u32) -> bool {
        usize::from(self.end.wrapping_sub(self.of(block).next)) <= CAPACITY
    }

    /// Returns the first of some entries.
    #[must_use]
    pub fn first(&self, entries: Entries) -> Option<Step> {
        if entries.next == entries.end { None } else { Some(self.steps[usize::from(entries.next) % CAPACITY]) }
    }
}
