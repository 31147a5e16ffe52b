//! Other blocks in front of those that wait: the ring is opened before them, takes new ones, and is closed.

use super::{block::Block, ring::Planner};
use crate::config::MOST_BLOCKS;

/// New blocks in front of those that wait, at most.
pub(crate) const MOST_OF_DETOUR: usize = 6;

/// Blocks that wait behind the gap in an opened ring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Behind {
    /// Count of the first.
    pub first: u32,
    end: u32,
    rest_sq: f64,
    reserve: f64,
    complete: bool,
}

impl Behind {
    /// Whether no blocks wait behind.
    pub const fn is_empty(&self) -> bool {
        self.first == self.end
    }
}

impl Planner {
    /// Whether [`MOST_OF_DETOUR`] blocks fit in front of those that wait.
    pub(crate) const fn has_room_before(&self) -> bool {
        self.len() + MOST_OF_DETOUR <= MOST_BLOCKS
    }

    /// Drops the first so many blocks that wait, and opens the ring before the others: it looks empty, and
    /// takes [`MOST_OF_DETOUR`] blocks if it [`has_room_before`](Self::has_room_before).
    pub(crate) fn open(&mut self, dropped: usize) -> Behind {
        let Self { rest_sq, reserve, complete, .. } = *self;
        let first = self.first.wrapping_add(dropped as u32);
        let behind = Behind { first, end: self.end, rest_sq, reserve, complete };
        self.end = first.wrapping_sub(MOST_OF_DETOUR as u32);
        self.clear();
        behind
    }

    /// Closes the ring behind what was pushed. The blocks that wait behind are entered from rest, at this
    /// speed squared. Then [`Self::replan`].
    pub(crate) fn close(&mut self, behind: &Behind, rest_sq: f64) {
        let gap = behind.first.wrapping_sub(self.end);
        let mut count = self.end;
        while count != self.first {
            count = count.wrapping_sub(1);
            *self.block_mut(count.wrapping_add(gap)) = *self.block(count);
        }
        self.first = self.first.wrapping_add(gap);
        self.kept = self.first;
        self.end = behind.first;
        if behind.is_empty() {
            return;
        }
        let Self { rest_sq: rest, reserve, complete, .. } = self;
        (*rest, *reserve, *complete) = (behind.rest_sq, behind.reserve, behind.complete);
        self.end = behind.end;
        let entered = self.block_mut(behind.first);
        *entered = Block { corner_sq: rest_sq, is_tangent: false, entry_sq: 0.0, ..*entered };
    }
}
