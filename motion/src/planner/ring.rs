//! The ring of blocks: those that wait, and behind them released ones that can be taken back.

use super::block::{Block, Overrides};
use crate::{config::MOST_BLOCKS, elsewhere::Elsewhere};

/// Released blocks that stay in the ring behind those that wait, where trajectory may be taken back.
pub(crate) const KEPT: usize = 32;

/// The place of the blocks that wait. About 44 KiB, all zero at the start, looked at for every piece of the
/// trajectory: a board gives it its fastest memory.
#[derive(Debug)]
pub struct BlockRing([Block; MOST_BLOCKS]);

impl BlockRing {
    /// Creates an empty ring.
    #[must_use]
    pub const fn new() -> Self {
        Self([Block::ZERO; MOST_BLOCKS])
    }
}

impl Default for BlockRing {
    fn default() -> Self {
        Self::new()
    }
}

/// The queue of blocks that have not begun. Blocks are counted from the beginning of time (wrapping).
#[derive(Debug)]
pub struct Planner {
    pub(super) blocks: Elsewhere<BlockRing>,
    /// Count of the first block that may be taken back, if it is still there.
    pub(super) kept: u32,
    /// Count of blocks ever released.
    pub(super) first: u32,
    /// Count of blocks ever pushed.
    pub(super) end: u32,
    /// Blocks before this one have been through a reverse pass.
    pub(super) planned: u32,
    /// Newest block whose entry speed is as high as its corner allows: no block to come can change its entry,
    /// nor any before it.
    pub(super) settled: u32,
    /// Squared speed with which the last block ends: that of a standstill.
    pub(super) rest_sq: f64,
    /// Length of the last block that the rounding of a corner behind it may yet take, mm. The block's entry
    /// speed is planned without that length, so that it can only grow.
    pub(super) reserve: f64,
    /// Whether nothing will be appended soon: the path ends with the last block.
    pub(super) complete: bool,
    /// Overrides that are in force.
    pub(super) overrides: Overrides,
    /// Share of the acceleration that the cruise plan may use.
    pub(super) gentle_share: Option<f64>,
}

impl Planner {
    /// Creates an empty queue.
    pub(crate) const fn new(blocks: Elsewhere<BlockRing>) -> Self {
        Self {
            blocks,
            kept: 0,
            first: 0,
            end: 0,
            planned: 0,
            settled: 0,
            rest_sq: 0.0,
            reserve: 0.0,
            complete: true,
            overrides: Overrides { feed: 1.0, rapid: 1.0 },
            gentle_share: None,
        }
    }

    /// Returns the number of blocks that wait.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.end.wrapping_sub(self.first) as usize
    }

    /// Returns whether no block waits.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.first == self.end
    }

    /// Count of blocks ever pushed, wrapping: changes whenever something new comes.
    pub(crate) const fn pushed(&self) -> u32 {
        self.end
    }

    /// Count of blocks ever released, wrapping.
    pub(crate) const fn released(&self) -> u32 {
        self.first
    }

    /// Returns the block of this count.
    pub(super) fn block(&self, count: u32) -> &Block {
        // The remainder is always in range: the check disappears.
        &self.blocks.0[count as usize % MOST_BLOCKS]
    }

    /// Returns the block of this count.
    pub(super) fn block_mut(&mut self, count: u32) -> &mut Block {
        &mut self.blocks.0[count as usize % MOST_BLOCKS]
    }

    /// The block so many after the front.
    pub(crate) fn ahead(&self, index: usize) -> Option<&Block> {
        if index < self.len() { Some(self.block(self.first.wrapping_add(index as u32))) } else { None }
    }

    /// The block that would be released next.
    #[must_use]
    pub fn front(&self) -> Option<&Block> {
        if self.is_empty() { None } else { Some(self.block(self.first)) }
    }

    /// Sets the length of the last block that a corner behind it may yet take, mm.
    pub(crate) fn set_reserve(&mut self, reserve: f64) {
        if reserve != self.reserve && !self.is_empty() {
            self.reserve = reserve;
            let last = self.end.wrapping_sub(1);
            if self.planned.wrapping_sub(last) as i32 > 0 {
                self.planned = last;
            }
        }
    }

    /// Lets the last block end earlier by `by` mm, no more than its reserve, at `target`.
    pub(crate) fn shorten_last(&mut self, by: f64, target: &units::PerAxis<f64>) {
        let last = self.block_mut(self.end.wrapping_sub(1));
        last.length -= by;
        last.target = *target;
    }

    /// Whether the exit speed of the next block to be released is final, whatever comes behind.
    pub(crate) fn front_is_settled(&self) -> bool {
        self.settled.wrapping_sub(self.first) as i32 > 0
    }

    /// Takes the next block out. Plan first.
    pub(crate) fn release(&mut self) -> Option<Block> {
        let block = *self.front()?;
        self.first = self.first.wrapping_add(1);
        // The marks never lag behind the queue, so that counts compare rightly for ever.
        for mark in [&mut self.planned, &mut self.settled] {
            if mark.wrapping_sub(self.first) as i32 <= 0 {
                *mark = self.first;
            }
        }
        Some(block)
    }

    /// A block that was released and can be taken back: nothing has taken its place, and what followed it is
    /// still to follow.
    pub(crate) fn released_block(&self, count: u32) -> Option<&Block> {
        let is_kept =
            count.wrapping_sub(self.kept) as i32 >= 0 && (self.end.wrapping_sub(count) as usize) <= MOST_BLOCKS;
        let is_released = (self.first.wrapping_sub(count) as i32) > 0;
        if is_kept && is_released { Some(self.block(count)) } else { None }
    }

    /// The block of this count, that waits or was released.
    pub(crate) fn any_block(&self, count: u32) -> Option<&Block> {
        if (self.end.wrapping_sub(count) as i32) > 0 { Some(self.block(count)) } else { None }
    }

    /// Makes everything behind a released block wait again. Then [`Self::replan`].
    pub(crate) fn take_back(&mut self, count: u32) {
        self.first = count.wrapping_add(1);
        // A block that is executed again is not shortened any more for a rounded corner.
        self.reserve = 0.0;
    }

    /// Squared speed with which the block in execution should end: the planned entry of the next one.
    pub(crate) fn next_entry_sq(&self) -> f64 {
        self.front().map_or(self.rest_sq, |next| next.entry_sq)
    }

    /// Forgets every block of the queue.
    pub(crate) fn clear(&mut self) {
        self.first = self.end;
        self.kept = self.end;
        self.planned = self.end;
        self.settled = self.end;
    }
}
