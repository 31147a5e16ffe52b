//! The card as `embedded-sdmmc` sees it.
//!
//! Version 0.10 of that crate does four things that would harm a volume, and has no way to be told; here they
//! have no effect:
//!
//! - it counts free clusters from what it read when the volume was opened, although others take and give
//!   clusters as well. So it reads that the count is not known, and then leaves it alone;
//! - it takes entries of the allocation table that belong to no cluster, behind the last one, for free. So
//!   they read as taken;
//! - it writes to clusters that the volume does not have, on a damaged one. So nothing outside the volume is
//!   read or written;
//! - it sets the case of a short name to capitals when it writes an entry. So the case bits of open files are
//!   put back.

use core::error::Error;
use core::fmt;

use drivers::fat::{Block as FatBlock, Blocks, Entry, Place, Volume};
use embedded_sdmmc::{Block, BlockCount, BlockDevice, BlockIdx};

use crate::MAX_FILES;

/// Where an entry has its case bits.
const CASE_BITS: u32 = 12;
/// Where the block of free clusters has its count.
const FREE_COUNT: core::ops::Range<usize> = 488..492;

/// What goes wrong with a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault<E> {
    /// The card's own error.
    Card(E),
    /// The block is not part of the volume.
    Outside,
}

impl<E: fmt::Display> fmt::Display for Fault<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Card(error) => error.fmt(f),
            Self::Outside => f.write_str("a block outside the volume"),
        }
    }
}

impl<E: Error> Error for Fault<E> {}

/// The card, its volume, and the entries of open files.
pub(crate) struct Lens<C> {
    card: C,
    pub(crate) volume: Option<Volume>,
    /// Entries of open files with their case bits.
    kept: [Option<(Place, u8)>; MAX_FILES],
}

impl<C> Lens<C> {
    pub(crate) const fn new(card: C) -> Self {
        Self { card, volume: None, kept: [None; MAX_FILES] }
    }

    /// The card itself.
    pub(crate) const fn card(&mut self) -> &mut C {
        &mut self.card
    }

    /// The volume, and the device that [`drivers::fat`] changes it on. `None` before there is one.
    pub(crate) fn names(&mut self) -> Option<(&mut Volume, Device<'_, C>)> {
        Some((self.volume.as_mut()?, Device(&mut self.card)))
    }

    /// Keeps the case bits of an entry from now on.
    pub(crate) fn keep(&mut self, entry: &Entry) {
        if let Some(free) = self.kept.iter_mut().find(|kept| kept.is_none()) {
            *free = Some((entry.place(), entry.case_bits()));
        }
    }

    /// The file of this entry is closed.
    pub(crate) fn release(&mut self, place: Place) {
        self.kept.iter_mut().filter(|kept| kept.is_some_and(|(kept, _)| kept == place)).for_each(|kept| *kept = None);
    }

    fn is_inside(&self, number: u32) -> bool {
        self.volume.as_ref().is_some_and(|volume| volume.contains_block(number))
    }
}

impl<C: BlockDevice> BlockDevice for Lens<C> {
    type Error = Fault<C::Error>;

    fn read(&self, blocks: &mut [Block], start: BlockIdx) -> Result<(), Self::Error> {
        let volume = self.volume.as_ref().ok_or(Fault::Outside)?;
        for (number, block) in (start.0..).zip(blocks) {
            // The first block is the partition table.
            if number > 0 && !volume.contains_block(number) {
                return Err(Fault::Outside);
            }
            self.card.read(core::slice::from_mut(block), BlockIdx(number)).map_err(Fault::Card)?;
            let hidden = match volume.unused_table_bytes_from(number) {
                Some(from) => from..Block::LEN,
                None if volume.info_block() == Some(number) => FREE_COUNT,
                None => 0..0,
            };
            block.contents.iter_mut().take(hidden.end).skip(hidden.start).for_each(|byte| *byte = 0xFF);
        }
        Ok(())
    }

    fn write(&self, blocks: &[Block], start: BlockIdx) -> Result<(), Self::Error> {
        for (number, block) in (start.0..).zip(blocks) {
            if !self.is_inside(number) {
                return Err(Fault::Outside);
            }
            let mut block = block.clone();
            for (place, case_bits) in self.kept.iter().flatten().filter(|(place, _)| place.block == number) {
                let at = (place.offset_bytes() + CASE_BITS) as usize;
                block.contents.iter_mut().skip(at).take(1).for_each(|byte| *byte = *case_bits);
            }
            self.card.write(core::slice::from_ref(&block), BlockIdx(number)).map_err(Fault::Card)?;
        }
        Ok(())
    }

    fn num_blocks(&self) -> Result<BlockCount, Self::Error> {
        self.card.num_blocks().map_err(Fault::Card)
    }
}

/// The card as [`drivers::fat`] sees it.
pub(crate) struct Device<'a, C>(pub &'a mut C);

impl<C: BlockDevice> Blocks for Device<'_, C> {
    type Error = C::Error;

    fn read(&mut self, number: u32, block: &mut FatBlock) -> Result<(), C::Error> {
        let mut read = [Block::new()];
        self.0.read(&mut read, BlockIdx(number))?;
        *block = read[0].contents;
        Ok(())
    }

    fn write(&mut self, number: u32, block: &FatBlock) -> Result<(), C::Error> {
        self.0.write(&[Block { contents: *block }], BlockIdx(number))
    }
}
