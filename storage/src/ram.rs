//! A card in memory that can lose its power. For tests.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::rc::Rc;
use std::vec::Vec;

use base::ports::StorageError;
use card::fat::Block;

use crate::device::Card;

/// First block of the volume on the card.
const FIRST_BLOCK: u32 = 8;

/// Error with which [`RamCard`] refuses a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RamError {
    /// The power is gone.
    Off,
    /// The card has no such block.
    Outside,
}

impl fmt::Display for RamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "the power is gone",
            Self::Outside => "the card has no such block",
        })
    }
}

impl core::error::Error for RamError {}

/// Counts of the card's work since its power came on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Number of blocks read.
    pub reads: u32,
    /// Number of blocks written.
    pub writes: u32,
}

#[derive(Default)]
struct State {
    written: BTreeMap<u32, [u8; 512]>,
    counts: Counts,
    writes_left: Option<u32>,
    /// Number of reads beyond which the code counts as hanging.
    most_reads: Option<u32>,
}

/// A card with one partition. Clones are the same card. A block is written whole or not at all, as cards
/// promise.
#[derive(Clone)]
pub struct RamCard {
    formatted: Rc<Vec<u8>>,
    state: Rc<RefCell<State>>,
}

impl RamCard {
    /// A card with this volume.
    #[must_use]
    pub fn new(volume: Vec<u8>) -> Self {
        Self { formatted: Rc::new(volume), state: Rc::default() }
    }

    /// Another card with the same content, and power for so many writes.
    #[must_use]
    pub fn powered_for(&self, writes: Option<u32>) -> Self {
        let written = self.state.borrow().written.clone();
        let state = State { written, counts: Counts::default(), writes_left: writes, most_reads: None };
        Self { formatted: self.formatted.clone(), state: Rc::new(RefCell::new(state)) }
    }

    /// Returns the card's counts so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.state.borrow().counts
    }

    /// Panics at the next read beyond so many: whoever reads for ever is found.
    pub fn expect_no_more_reads_than(&self, reads: u32) {
        self.state.borrow_mut().most_reads = Some(reads);
    }

    /// Blocks of the volume.
    #[must_use]
    pub fn volume_blocks(&self) -> u32 {
        (self.formatted.len() / 512) as u32
    }

    /// A block of the volume.
    #[must_use]
    pub fn volume_block(&self, number: u32) -> [u8; 512] {
        let mut block = [0; 512];
        if let Some(written) = self.state.borrow().written.get(&number) {
            return *written;
        }
        block.iter_mut().zip(self.formatted.iter().skip(number as usize * 512)).for_each(|(to, from)| *to = *from);
        block
    }

    /// Changes a block of the volume behind everybody's back.
    pub fn set_volume_block(&self, number: u32, block: [u8; 512]) {
        self.state.borrow_mut().written.insert(number, block);
    }

    /// The volume, as other tools want it.
    #[must_use]
    pub fn volume(&self) -> Vec<u8> {
        (0..self.volume_blocks()).flat_map(|number| self.volume_block(number)).collect()
    }

    fn partition_table(&self) -> [u8; 512] {
        let mut table = [0; 512];
        table[446 + 4] = 0x0C;
        table[446 + 8..446 + 12].copy_from_slice(&FIRST_BLOCK.to_le_bytes());
        table[446 + 12..446 + 16].copy_from_slice(&self.volume_blocks().to_le_bytes());
        table[510..].copy_from_slice(&[0x55, 0xAA]);
        table
    }

    fn inside(&self, number: u32) -> Result<u32, RamError> {
        number.checked_sub(FIRST_BLOCK).filter(|number| *number < self.volume_blocks()).ok_or(RamError::Outside)
    }
}

impl Card for RamCard {
    type Error = RamError;

    fn identify(&mut self) -> Result<(), RamError> {
        Ok(())
    }

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), RamError> {
        *block = if number == 0 { self.partition_table() } else { self.volume_block(self.inside(number)?) };
        let state = &mut *self.state.borrow_mut();
        state.counts.reads += 1;
        assert!(state.most_reads.is_none_or(|most| state.counts.reads <= most), "it reads for ever");
        Ok(())
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), RamError> {
        let number = self.inside(number)?;
        let state = &mut *self.state.borrow_mut();
        if state.writes_left == Some(0) {
            return Err(RamError::Off);
        }
        state.writes_left = state.writes_left.map(|left| left - 1);
        state.counts.writes += 1;
        state.written.insert(number, *block);
        Ok(())
    }

    fn blocks(&mut self) -> Result<u32, RamError> {
        Ok(FIRST_BLOCK + self.volume_blocks())
    }

    fn reason(error: &RamError) -> StorageError {
        match error {
            RamError::Off => StorageError::NotResponding,
            RamError::Outside => StorageError::Device,
        }
    }
}

/// A clock that stands still.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standing;

impl embedded_sdmmc::TimeSource for Standing {
    fn get_timestamp(&self) -> embedded_sdmmc::Timestamp {
        embedded_sdmmc::Timestamp {
            year_since_1970: 51,
            zero_indexed_month: 4,
            zero_indexed_day: 17,
            hours: 18,
            minutes: 20,
            seconds: 0,
        }
    }
}
