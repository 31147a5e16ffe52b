//! Blocks on their way to the card, in the order in which they were written.

use super::{QUEUE_BLOCKS, QUEUE_SLOT};

/// Ring of block numbers; the blocks' contents lie in slots of the same places.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    numbers: [u32; QUEUE_BLOCKS],
    /// Place of the oldest block.
    first: usize,
    count: usize,
    /// Number of the oldest blocks that are on the bus.
    sending: usize,
}

const fn slot(place: usize) -> usize {
    QUEUE_SLOT + place % QUEUE_BLOCKS
}

impl Queue {
    /// Creates an empty queue.
    pub const fn new() -> Self {
        Self { numbers: [0; QUEUE_BLOCKS], first: 0, count: 0, sending: 0 }
    }

    /// Whether no block waits or is being sent.
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the number of blocks that still fit.
    pub const fn room(&self) -> usize {
        QUEUE_BLOCKS - self.count
    }

    fn number(&self, nth: usize) -> u32 {
        self.numbers.get((self.first + nth) % QUEUE_BLOCKS).copied().unwrap_or(0)
    }

    /// Returns the slot to write a block into, which is queued with that; `None` while there is no room. If
    /// the block is the last one already, it is replaced.
    pub fn push(&mut self, number: u32) -> Option<usize> {
        if self.count > self.sending && self.number(self.count - 1) == number {
            return Some(slot(self.first + self.count - 1));
        }
        if self.count == QUEUE_BLOCKS {
            return None;
        }
        let place = (self.first + self.count) % QUEUE_BLOCKS;
        if let Some(free) = self.numbers.get_mut(place) {
            *free = number;
        }
        self.count += 1;
        Some(slot(place))
    }

    /// Returns the slot of a waiting block, as written last.
    pub fn find(&self, number: u32) -> Option<usize> {
        (0..self.count).rev().find(|nth| self.number(*nth) == number).map(|nth| slot(self.first + nth))
    }

    /// Marks the oldest blocks, of consecutive numbers and in consecutive slots, at most so many, as on the
    /// bus from now on. Returns the number of the first, its slot, and the count.
    pub fn begin(&mut self, most: usize) -> Option<(u32, usize, usize)> {
        if self.count == 0 {
            return None;
        }
        let number = self.number(0);
        let most = most.min(self.count).min(QUEUE_BLOCKS - self.first);
        let count = (1..most).take_while(|nth| number.checked_add(*nth as u32) == Some(self.number(*nth))).count() + 1;
        self.sending = count;
        Some((number, slot(self.first), count))
    }

    /// Removes the blocks on the bus, which have arrived. Returns the last block's number and slot, whose
    /// contents stay there until the queue has come round.
    pub fn finish(&mut self) -> (u32, usize) {
        let last = self.sending.saturating_sub(1);
        let arrived = (self.number(last), slot(self.first + last));
        self.first = (self.first + self.sending) % QUEUE_BLOCKS;
        self.count -= self.sending;
        self.sending = 0;
        arrived
    }

    /// Drops all waiting blocks.
    pub const fn clear(&mut self) {
        (self.count, self.sending) = (0, 0);
    }

    /// Gives each block within `first..first + count`, oldest first: its distance from `first`, and its slot.
    pub fn each_within(&self, first: u32, count: u32, mut take: impl FnMut(u32, usize)) {
        for nth in 0..self.count {
            if let Some(offset) = self.number(nth).checked_sub(first).filter(|offset| *offset < count) {
                take(offset, slot(self.first + nth));
            }
        }
    }
}
