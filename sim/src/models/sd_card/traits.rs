//! How cards differ, and what goes wrong with one.

/// What kind of card it is (PL 6.00 section 3.3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Make {
    /// Standard capacity: byte addresses, CSD version 1.
    Standard,
    /// High or extended capacity, which its size tells: block addresses, CSD version 2.
    High,
    /// A MultiMediaCard, which knows none of the commands that SD cards are told apart by.
    Mmc,
}

/// What a card does that claims more than it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fake {
    /// A block beyond its memory is one from the beginning again.
    Wraps,
    /// What is written beyond its memory is lost, and reads as zeros.
    Loses,
}

/// How a card differs from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traits {
    /// Time it programs after a block was written.
    pub programming_ns: u64,
    /// Access time: from a read command to its first block. At most 100 ms (section 4.6.2.1). A card of
    /// application performance class A1 reads 1,500 times 4 KiB a second at random, one of class A2 4,000
    /// times (section 4.16.2): 667 and 250 us, the transfer included.
    pub access_ns: u64,
    /// The same between the blocks of one read.
    pub next_ns: u64,
    /// TMP_WRITE_PROTECT of the CSD is set: it takes no writes.
    pub is_protected: bool,
    /// What kind it is.
    pub make: Make,
    /// It knows high speed (CMD6): cards of version 1.10 and later may.
    pub is_fast: bool,
    /// The fastest bus at which nothing arrives damaged: contacts and traces are part of a card.
    pub clean_hz: u64,
    /// It is locked with a password (section 4.3.7).
    pub is_locked: bool,
    /// It claims so many times what it has.
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

/// What goes wrong from now on, and how often.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trouble {
    /// Blocks that arrive damaged at the host.
    pub damaged_reads: u32,
    /// Blocks that arrive damaged at the card, which says so.
    pub damaged_writes: u32,
    /// Answers that arrive damaged.
    pub damaged_answers: u32,
    /// Blocks that its own error correction has given up (CARD_ECC_FAILED).
    pub unreadable: Vec<u32>,
    /// Reads that take so much longer, nanoseconds, and how many of them.
    pub slow_reads: (u64, u32),
    /// The same for writes.
    pub slow_writes: (u64, u32),
    /// It never gets ready again after the next write.
    pub stays_busy: bool,
}

impl Trouble {
    /// One time less; whether there was one.
    pub(super) const fn take(times: &mut u32) -> bool {
        let is_due = *times > 0;
        *times = times.saturating_sub(1);
        is_due
    }

    pub(super) const fn delay(slow: &mut (u64, u32)) -> u64 {
        if Self::take(&mut slow.1) { slow.0 } else { 0 }
    }
}
