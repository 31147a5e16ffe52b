//! The machine's storage port ([`base::ports::Storage`]) on a card with a FAT16 or FAT32 volume.
//!
//! Names are the business of [`card::fat`]: finding, listing, making, removing, renaming. The content of a
//! file is the business of `embedded-sdmmc`, which opens the file by the short name found here. The two never
//! change the same thing: while a file is open its entry stays where it is, and blocks are only changed
//! between calls of the other, which then forgets what it had read.
//!
//! Generic over the card, so that the desk tests what the board runs.
#![cfg_attr(not(any(test, feature = "ram")), no_std)]

mod device;
mod errors;
mod files;
mod mount;
#[cfg(any(test, feature = "ram"))]
pub mod ram;
mod read_ahead;
mod readers;
mod sdmmc_device;
mod write_buffer;

#[cfg(test)]
mod tests;

pub use device::Card;
pub use files::{CardStorage, Memory};
pub use readers::MAX_BESIDE;
pub use sdmmc_device::MAX_FILES;
