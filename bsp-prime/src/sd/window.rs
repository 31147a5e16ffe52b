//! Blocks for the file system: a window of consecutive blocks in the DMA arena, read ahead when the reader is
//! sequential.

use core::cell::RefCell;

use embedded_sdmmc::{Block, BlockCount, BlockDevice, BlockIdx};
use stm32h7xx_hal::pac;

use super::SdError;
use super::card::{self, CardInfo};
use super::controller::{Controller, Transfer};
use crate::dma_buffer;

/// Blocks fetched at once for a sequential reader: 4 KiB.
pub const WINDOW_BLOCKS: u32 = 8;
const WORDS_PER_BLOCK: usize = 128;
/// A damaged block is read or written again this often; more is a bad card or a bad socket.
const ATTEMPTS: u32 = 3;

dma_buffer! {
    static WINDOW: [u32; WORDS_PER_BLOCK * WINDOW_BLOCKS as usize]
}

/// The card as a block device. One owner; the interior cell is only for the file system's shared reference.
pub struct SdCard(RefCell<State>);

struct State {
    bus: Controller,
    card: Option<CardInfo>,
    /// First block in the window, and how many are valid.
    window: (u32, u32),
    /// The block a sequential reader would ask for next.
    expected: u32,
    /// A card formatted without a partition table; see [`Bare`].
    bare: Option<Bare>,
}

/// The volume of a card that has no partition table, its boot sector being the card's first block.
///
/// The file system crate knows partitions only. So such a card is shown to it one block longer: a table made
/// up for it first, then the card.
#[derive(Clone, Copy)]
struct Bare {
    /// FAT32 with LBA (0x0C) or FAT16 with LBA (0x0E).
    partition_type: u8,
    /// Length of the volume in blocks.
    blocks: u32,
}

impl Bare {
    /// Recognises a boot sector (FAT specification 1.03, section 3.1) where a partition table is expected.
    fn of(block: &Block) -> Option<Self> {
        let byte = |at: usize| u32::from(block.contents.get(at).copied().unwrap_or(0));
        let half = |at| byte(at) | byte(at + 1) << 8;
        let jump = byte(0) == 0xEB && byte(2) == 0x90 || byte(0) == 0xE9;
        let parameters = half(11) == 512 && byte(13).is_power_of_two() && half(14) != 0 && matches!(byte(16), 1 | 2);
        if !(jump && parameters && half(510) == 0xAA55) {
            return None;
        }
        let blocks = if half(19) != 0 { half(19) } else { half(32) | half(34) << 16 };
        Some(Self { partition_type: if half(22) == 0 { 0x0C } else { 0x0E }, blocks })
    }

    /// The made-up table: one partition, from block 1 on.
    fn table(self, block: &mut Block) {
        block.contents.fill(0);
        let [a, b, c, d] = self.blocks.to_le_bytes();
        let entry = [0, 0, 0, 0, self.partition_type, 0, 0, 0, 1, 0, 0, 0, a, b, c, d];
        block.contents.iter_mut().skip(446).zip(entry).for_each(|(to, from)| *to = from);
        block.contents.iter_mut().skip(510).zip([0x55, 0xAA]).for_each(|(to, from)| *to = from);
    }
}

impl SdCard {
    pub(crate) fn new(registers: pac::SDMMC1) -> Self {
        let bus = Controller::new(registers);
        Self(RefCell::new(State { bus, card: None, window: (0, 0), expected: u32::MAX, bare: None }))
    }

    /// Finds the card; again after a change of cards. Takes up to a second and a half without one that
    /// answers.
    ///
    /// # Errors
    /// [`SdError`].
    pub fn identify(&self) -> Result<CardInfo, SdError> {
        let mut state = self.0.try_borrow_mut().map_err(|_| SdError::Transfer)?;
        state.card = None;
        state.window = (0, 0);
        state.bare = None;
        let card = card::identify(&mut state.bus)?;
        state.card = Some(card);
        let mut first = Block::default();
        state.read(0, &mut first)?;
        state.bare = Bare::of(&first);
        Ok(card)
    }
}

impl BlockDevice for SdCard {
    type Error = SdError;

    fn read(&self, blocks: &mut [Block], start: BlockIdx) -> Result<(), SdError> {
        let mut state = self.0.try_borrow_mut().map_err(|_| SdError::Transfer)?;
        for (number, block) in (start.0..).zip(blocks) {
            match (state.bare, number) {
                (None, _) => state.read(number, block)?,
                (Some(bare), 0) => bare.table(block),
                (Some(_), _) => state.read(number - 1, block)?,
            }
        }
        Ok(())
    }

    fn write(&self, blocks: &[Block], start: BlockIdx) -> Result<(), SdError> {
        let mut state = self.0.try_borrow_mut().map_err(|_| SdError::Transfer)?;
        for (number, block) in (start.0..).zip(blocks) {
            match (state.bare, number) {
                (None, _) => state.write(number, block)?,
                (Some(_), 0) => return Err(SdError::OutOfRange),
                (Some(_), _) => state.write(number - 1, block)?,
            }
        }
        Ok(())
    }

    fn num_blocks(&self) -> Result<BlockCount, SdError> {
        let state = self.0.try_borrow().map_err(|_| SdError::Transfer)?;
        state.card.map(|card| BlockCount(card.blocks + u32::from(state.bare.is_some()))).ok_or(SdError::NotIdentified)
    }
}

impl State {
    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), SdError> {
        let (first, count) = self.window;
        if number < first || number - first >= count {
            self.fetch(number)?;
        }
        let offset = (number - self.window.0) as usize * WORDS_PER_BLOCK;
        for (index, bytes) in block.contents.chunks_exact_mut(4).enumerate() {
            let word = WINDOW.read(offset + index).unwrap_or(0);
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        self.expected = number + 1;
        Ok(())
    }

    /// Fills the window from `number` on: one block, or as many as fit when the reader is sequential.
    fn fetch(&mut self, number: u32) -> Result<(), SdError> {
        let card = self.card.ok_or(SdError::NotIdentified)?;
        if number >= card.blocks {
            return Err(SdError::OutOfRange);
        }
        let count = if number == self.expected { WINDOW_BLOCKS.min(card.blocks - number) } else { 1 };
        self.window = (number, 0);
        self.repeat(|state| state.move_blocks(card, number, count, Transfer::FromCard))?;
        self.window = (number, count);
        Ok(())
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), SdError> {
        let card = self.card.ok_or(SdError::NotIdentified)?;
        if number >= card.blocks {
            return Err(SdError::OutOfRange);
        }
        self.window = (number, 0);
        for (index, bytes) in block.contents.chunks_exact(4).enumerate() {
            let word = bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
            WINDOW.write(index, word);
        }
        self.repeat(|state| state.move_blocks(card, number, 1, Transfer::ToCard))?;
        self.window = (number, 1);
        Ok(())
    }

    fn repeat(&mut self, mut action: impl FnMut(&mut Self) -> Result<(), SdError>) -> Result<(), SdError> {
        let mut result = Ok(());
        for _ in 0..ATTEMPTS {
            result = action(self);
            if result.is_ok() {
                return Ok(());
            }
            // Whatever was under way on the card ends here; that there was nothing is no error.
            let _nothing_to_stop = self.bus.stop_transmission();
        }
        result
    }

    fn move_blocks(&mut self, card: CardInfo, number: u32, count: u32, way: Transfer) -> Result<(), SdError> {
        let window = WINDOW.address().ok_or(SdError::Transfer)?;
        let index = match (way, count) {
            (Transfer::FromCard, 1) => 17,
            (Transfer::FromCard, _) => 18,
            (Transfer::ToCard, 1) => 24,
            (Transfer::ToCard, _) => 25,
        };
        // What the core wrote to the window must be in memory before the controller reads it.
        cortex_m::asm::dsb();
        self.bus.transfer(index, card.address_of(number), way, window, count * 512)?;
        if count > 1 {
            self.bus.stop_transmission()?;
        }
        self.bus.wait_while_busy(index)?;
        if way == Transfer::ToCard {
            // The status of a write is known only afterwards.
            card::checked(&mut self.bus, 13, card.relative_address)?;
        }
        Ok(())
    }
}
