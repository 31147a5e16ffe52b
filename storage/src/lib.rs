//! The machine's storage port ([`machine::ports::Storage`]) on a card with a FAT16 or FAT32 volume.
//!
//! Names are the business of [`drivers::fat`]: finding, listing, making, removing, renaming. What is in a
//! file is that of `embedded-sdmmc`, which opens it by the short name found here. The two never change the
//! same thing: while a file is open its entry stays where it is, and blocks are only changed between calls of
//! the other, which then forgets what it had read.
//!
//! Generic over the card, so that the desk tests what the board runs.
#![cfg_attr(not(any(test, feature = "ram")), no_std)]

mod beside;
mod errors;
mod files;
mod lens;
mod listing;
#[cfg(any(test, feature = "ram"))]
pub mod ram;

#[cfg(test)]
mod tests;

pub use beside::MAX_BESIDE;
pub use files::{CardStorage, MAX_FILES};
use lens::Fault;

use embedded_sdmmc::BlockDevice;
use machine::ports::StorageError;

/// A card, or what stands in for one. Its first block is a partition table.
pub trait Card: BlockDevice {
    /// Finds the card; again after a change of cards.
    ///
    /// # Errors
    /// The card's own.
    fn identify(&mut self) -> Result<(), Self::Error>;

    /// What the machine is told of an error.
    fn reason(error: &Self::Error) -> StorageError;
}
