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

use core::cell::RefCell;
use core::error::Error as CoreError;
use core::fmt;

use base::ports::StorageError;
use card::fat::{Block as FatBlock, Entry, Error, Kind, Place, Volume};
use card::volume::Volume as Mounted;
use embedded_sdmmc::{Block, BlockCount, BlockDevice, BlockIdx};

use crate::device::{AtHand, Card, Device};

/// Files open at once: those of the machine, and two that are uploaded over the network.
pub const MAX_FILES: usize = 7;

/// Offset of the case bits in an entry.
const CASE_BITS: u32 = 12;
/// Place of the count in the block of free clusters.
const FREE_COUNT: core::ops::Range<usize> = 488..492;

/// Blocks have numbers that are so much higher here than on the card: the first one is a partition table,
/// made up, with the one volume. So a card whose partitions are many, described by a GPT, or none looks like
/// any other.
pub(crate) const SHIFT: u32 = 1;

/// Error in reading or writing a block.
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

impl<E: CoreError> CoreError for Fault<E> {}

/// The card, its volume, and the entries of open files.
pub(crate) struct SdmmcDevice<C> {
    /// The card in a cell, as `embedded-sdmmc` reads and writes through a shared reference.
    card: RefCell<C>,
    pub(crate) volume: Option<Mounted>,
    /// Error to report while no volume is mounted.
    pub(crate) absent: StorageError,
    /// Entries of open files with their case bits.
    kept: [Option<(Place, u8)>; MAX_FILES],
}

impl<C> SdmmcDevice<C> {
    pub(crate) const fn new(card: C) -> Self {
        Self { card: RefCell::new(card), volume: None, absent: StorageError::NoCard, kept: [None; MAX_FILES] }
    }

    /// Returns the card itself.
    pub(crate) fn card(&mut self) -> &mut C {
        self.card.get_mut()
    }

    /// The volume, and the device that [`card::fat`] changes it on.
    ///
    /// # Errors
    /// Before there is one, and when it is of the kind that is only read.
    pub(crate) fn names(&mut self) -> Result<(&mut Volume, Device<'_, C>), StorageError> {
        match self.volume.as_mut().ok_or(self.absent)? {
            Mounted::Fat(volume) => Ok((volume, Device(self.card.get_mut()))),
            Mounted::Exfat(_) => Err(StorageError::Exfat),
        }
    }

    /// The volume of either kind, to read from.
    pub(crate) fn reading(&mut self) -> Result<(&mut Mounted, Device<'_, C>), StorageError> {
        Ok((self.volume.as_mut().ok_or(self.absent)?, Device(self.card.get_mut())))
    }

    /// Reads the volume again after writes were lost, and completes half-done changes.
    pub(crate) fn mend(&mut self) -> Result<(), Error<C::Error>>
    where
        C: Card,
    {
        let Ok((volume, mut device)) = self.names() else { return Ok(()) };
        *volume = volume.again(&mut device)?;
        volume.settle(&mut device)
    }

    /// Runs `action` with a device that does not wait, and returns its result.
    pub(crate) fn at_hand<R>(
        &mut self,
        action: impl FnOnce(&mut Mounted, &mut AtHand<'_, C>) -> Option<R>,
    ) -> Option<R> {
        let (volume, mut device) = self.names_at_hand()?;
        action(volume, &mut device)
    }

    /// The volume, and a device that does not wait.
    pub(crate) fn names_at_hand(&mut self) -> Option<(&mut Mounted, AtHand<'_, C>)> {
        Some((self.volume.as_mut()?, AtHand(self.card.get_mut())))
    }

    /// Keeps the case bits of an entry from now on.
    pub(crate) fn keep(&mut self, entry: &Entry) {
        if let Some(free) = self.kept.iter_mut().find(|kept| kept.is_none()) {
            *free = Some((entry.place(), entry.case_bits()));
        }
    }

    /// Forgets the case bits of an entry whose file is closed.
    pub(crate) fn release(&mut self, place: Place) {
        self.kept.iter_mut().filter(|kept| kept.is_some_and(|(kept, _)| kept == place)).for_each(|kept| *kept = None);
    }

    fn fat(&self) -> Option<&Volume> {
        match &self.volume {
            Some(Mounted::Fat(volume)) => Some(volume),
            _ => None,
        }
    }

    fn is_inside(&self, number: u32) -> bool {
        self.fat().is_some_and(|volume| volume.contains_block(number))
    }
}

impl<C: Card> BlockDevice for SdmmcDevice<C> {
    type Error = Fault<C::Error>;

    fn read(&self, blocks: &mut [Block], start: BlockIdx) -> Result<(), Self::Error> {
        let volume = self.fat().ok_or(Fault::Outside)?;
        for (number, block) in (start.0..).zip(blocks) {
            let Some(number) = number.checked_sub(SHIFT) else {
                block.contents = table(volume);
                continue;
            };
            if !volume.contains_block(number) {
                return Err(Fault::Outside);
            }
            self.card.borrow_mut().read(number, &mut block.contents).map_err(Fault::Card)?;
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
            let Some(number) = number.checked_sub(SHIFT).filter(|number| self.is_inside(*number)) else {
                return Err(Fault::Outside);
            };
            let mut block = block.clone();
            for (place, case_bits) in self.kept.iter().flatten().filter(|(place, _)| place.block == number) {
                let at = (place.offset_bytes() + CASE_BITS) as usize;
                block.contents.iter_mut().skip(at).take(1).for_each(|byte| *byte = *case_bits);
            }
            self.card.borrow_mut().write(number, &block.contents).map_err(Fault::Card)?;
        }
        Ok(())
    }

    fn num_blocks(&self) -> Result<BlockCount, Self::Error> {
        self.card.borrow_mut().blocks().map(|blocks| BlockCount(blocks.saturating_add(SHIFT))).map_err(Fault::Card)
    }
}

/// A partition table with this volume.
fn table(volume: &Volume) -> FatBlock {
    let mut block = [0; 512];
    // FAT16 and FAT32, both with block addresses.
    let kind = if volume.kind() == Kind::Fat16 { 0x0E } else { 0x0C };
    let (first, blocks) = volume.extent();
    let ([a, b, c, d], [e, f, g, h]) = (first.saturating_add(SHIFT).to_le_bytes(), blocks.to_le_bytes());
    let entry = [0, 0, 0, 0, kind, 0, 0, 0, a, b, c, d, e, f, g, h];
    block.iter_mut().skip(446).zip(entry).for_each(|(to, from)| *to = from);
    block.iter_mut().skip(510).zip([0x55, 0xAA]).for_each(|(to, from)| *to = from);
    block
}
