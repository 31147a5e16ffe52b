//! Differences between cards, and the faults of a card.

/// Kind of a card (PL 6.00 section 3.3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Make {
    /// Standard capacity: byte addresses, CSD version 1.
    Standard,
    /// High or extended capacity, which its size tells: block addresses, CSD version 2.
    High,
    /// A MultiMediaCard, which knows none of the commands that tell SD cards apart.
    Mmc,
}

/// Behaviour of a card that claims more memory than it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fake {
    /// A block beyond the memory is one from the beginning again.
    Wraps,
    /// Data written beyond the memory is lost, and reads as zeros.
    Loses,
}

/// Traits by which a card differs from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traits {
    /// Programming time after a block was written.
    pub programming_ns: u64,
    /// Access time: from a read command to its first block. At most 100 ms (section 4.6.2.1). A card of
    /// application performance class A1 reads 1,500 times 4 KiB a second at random, one of class A2 4,000
    /// times (section 4.16.2): 667 and 250 us, the transfer included.
    pub access_ns: u64,
    /// Access time between the blocks of a read.
    pub next_ns: u64,
    /// TMP_WRITE_PROTECT of the CSD is set: the card takes no writes.
    pub is_protected: bool,
    /// Kind of the card.
    pub make: Make,
    /// Whether the card knows high speed (CMD6): cards of version 1.10 and later may.
    pub is_fast: bool,
    /// The fastest bus at which nothing arrives damaged: contacts and traces are part of a card.
    pub clean_hz: u64,
    /// Whether the card is locked with a password (section 4.3.7).
    pub is_locked: bool,
    /// Factor by which the card claims more memory than it has, and its behaviour beyond.
    pub claims: Option<(u32, Fake)>,
}

impl Default for Traits {
    fn default() -> Self {
        Self {
            // Cards differ; 300 us is usual for a block.
            programming_ns: 300_000,
            access_ns: 200_000,
            next_ns: 5_000,
            is_protected: false,
            make: Make::High,
            is_fast: true,
            clean_hz: 50_000_000,
            is_locked: false,
            claims: None,
        }
    }
}

/// Troubles to come, each with its number of times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trouble {
    /// Number of blocks that arrive damaged at the host.
    pub damaged_reads: u32,
    /// Number of blocks that arrive damaged at the card, which says so.
    pub damaged_writes: u32,
    /// Number of answers that arrive damaged.
    pub damaged_answers: u32,
    /// Blocks that the card's own error correction has given up (CARD_ECC_FAILED).
    pub unreadable: Vec<u32>,
    /// Additional time of slow reads, nanoseconds, and their number.
    pub slow_reads: (u64, u32),
    /// Additional time of slow writes, nanoseconds, and their number.
    pub slow_writes: (u64, u32),
    /// Whether the card never gets ready again after the next write.
    pub stays_busy: bool,
}

impl Trouble {
    /// Counts down by one; returns whether any were left.
    pub(super) const fn take(times: &mut u32) -> bool {
        let is_due = *times > 0;
        *times = times.saturating_sub(1);
        is_due
    }

    /// Returns the additional time of an access, nanoseconds, and counts it.
    pub(super) const fn delay(slow: &mut (u64, u32)) -> u64 {
        if Self::take(&mut slow.1) { slow.0 } else { 0 }
    }
}
