//! Blocks between the host and the card's memory.

use super::{BLOCK, BlockWrite, Fake, SdCard, State, Stream, Trouble};

/// Busy time of a card that never gets ready again: longer than anybody waits.
const FOR_EVER_NS: u64 = 3_600_000_000_000;

impl SdCard {
    /// Returns the fastest clock permitted in the card's present state, Hz.
    #[must_use]
    pub const fn highest_hz(&self) -> u64 {
        match self.state {
            State::Idle | State::Ready | State::Identification => 400_000,
            _ if self.high_speed => 50_000_000,
            _ => 25_000_000,
        }
    }

    /// Returns whether data over a bus with this clock arrives as sent.
    #[must_use]
    pub const fn is_clean_at(&self, hz: u64) -> bool {
        hz <= self.highest_hz() && hz <= self.traits.clean_hz
    }

    /// Returns the time from a command to the first block that the card sends, nanoseconds.
    pub const fn access_ns(&mut self) -> u64 {
        self.traits.access_ns + Trouble::delay(&mut self.trouble.slow_reads)
    }

    /// Returns the time between the blocks of a read, nanoseconds.
    #[must_use]
    pub const fn next_ns(&self) -> u64 {
        self.traits.next_ns
    }

    /// Returns whether the block that is sent now arrives damaged.
    pub const fn damages_block(&mut self) -> bool {
        Trouble::take(&mut self.trouble.damaged_reads)
    }

    /// Returns the number of bytes that the card claims to have.
    pub(super) fn claimed(&self) -> usize {
        self.content.len() * self.traits.claims.map_or(1, |(times, _)| times as usize)
    }

    /// Returns the place of a block in the card's memory, and whether the card has that.
    fn place(&self, block: u32) -> (usize, bool) {
        let (start, size) = (block as usize * BLOCK, self.content.len());
        match self.traits.claims {
            Some((_, Fake::Wraps)) => (start % size, true),
            _ => (start, start < size),
        }
    }

    /// Returns the next block of a transfer to the host, `length` bytes. `None` when the card has nothing
    /// to send.
    pub fn read(&mut self, length: usize) -> Option<Vec<u8>> {
        if self.state != State::Data {
            return None;
        }
        match &self.stream {
            Stream::Idle => None,
            Stream::Register(bytes) => {
                let mut bytes = bytes.clone();
                bytes.resize(length, 0);
                Some(bytes)
            }
            Stream::Memory { block, .. } => {
                let block = *block;
                if self.trouble.unreadable.contains(&block) {
                    self.has_failed = true;
                    return None;
                }
                let (start, has_it) = self.place(block);
                if !has_it && self.traits.claims.is_some() {
                    return Some(vec![0; length]);
                }
                Some(self.content.get(start..start + length)?.to_vec())
            }
        }
    }

    /// Notes that the block of [`Self::read`] is on the bus with its checksum. Until then the card is in
    /// its data state, and a transfer can be stopped.
    pub fn block_sent(&mut self) {
        if self.state != State::Data {
            return;
        }
        if let Stream::Memory { block, endless: true } = &mut self.stream {
            *block += 1;
        } else {
            self.stream = Stream::Idle;
            self.state = State::Transfer;
        }
    }

    /// Takes the next block from the host. False when the card expects none, it would not fit, or it has
    /// arrived damaged.
    pub fn write(&mut self, now_ns: u64, bytes: &[u8]) -> bool {
        let Stream::Memory { block: number, endless } = self.stream else { return false };
        if self.state != State::Receive || Trouble::take(&mut self.trouble.damaged_writes) {
            return false;
        }
        let (start, has_it) = self.place(number);
        if self.traits.is_protected {
            // Section 4.3.4: a protected card takes the data and drops them.
            self.has_refused = true;
        } else if let Some(place) = self.content.get_mut(start..start + bytes.len()).filter(|_| has_it) {
            place.copy_from_slice(bytes);
            if let Some(log) = &mut self.log {
                log.push(BlockWrite { at_ns: now_ns, block: number, bytes: bytes.to_vec() });
            }
        } else if self.traits.claims.is_none() {
            return false;
        }
        self.stream = Stream::Memory { block: number + 1, endless };
        let busy_ns = self.traits.programming_ns + Trouble::delay(&mut self.trouble.slow_writes);
        self.busy_until_ns = now_ns + if self.trouble.stays_busy { FOR_EVER_NS } else { busy_ns };
        if !endless {
            self.stream = Stream::Idle;
            self.state = State::Program;
        }
        true
    }
}
