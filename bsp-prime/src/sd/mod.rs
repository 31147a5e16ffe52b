//! The SD card on SDMMC1 (4 bits, PC8 to PC12 and PD2).
//!
//! The commands to the card come from [`card::sd`]; here is the host controller that carries them out
//! ([`Controller`]), moved on by its interrupt: nothing spins, and the core sleeps while the hardware works.
//! Data move by the controller's own DMA between the card and the DMA arena, the only memory that both sides
//! reach without cache care.
//!
//! There are two faces:
//!
//! - [`CardService`], for images with tasks: a resource shared between the controller's interrupt
//!   ([`on_interrupt`] and `advance`) and its users, each of which locks it for microseconds. The file
//!   system's way to it is `firmware/src/storage.rs`.
//! - [`SdCard`], for a boot stage and for tests: calls that wait.
//!
//! # Mass storage over USB
//!
//! ```text
//! card.lock(|card| card.lend())           Ok(true): all is written, and the card is this user's
//! card.lock(|card| card.begin(direction, Run { first, count }, address))
//!                                         `address` in the DMA arena: `dma_buffer!`, or `lent_buffer()`
//! card.lock(|card| card.lent())           Lent::Busy until Lent::Done or Lent::Failed(why), told once
//! card.lock(|card| card.take_back())
//! ```
//!
//! `begin` is carried out by the next `advance`: call that under the same lock. The end of a transfer comes
//! with the controller's interrupt: the task of SDMMC1 wakes the user behind `advance`. A card that is pulled
//! out ends the transfer with an error; `state()` says when there is one again. While the card is lent, the
//! service's own blocks are free: [`lent_buffer`] has 73 KB. The file system gives its volume back first
//! (`CardStorage::unmount`, which refuses while files are open) and finds it again with `mount`.

use card::sd::{BLOCK_BYTES, SLOTS, Service};

mod blocking;
mod controller;

use crate::dma_buffer;
pub use blocking::SdCard;
pub use controller::{Controller, on_interrupt};

/// Service that shares the card among its users.
pub type CardService = Service<Controller>;

/// Words of a block.
const WORDS: usize = BLOCK_BYTES / 4;

dma_buffer! {
    static BLOCKS: [u32; WORDS * SLOTS]
}

/// Address and size in bytes of the service's blocks in the DMA arena, for the user who has the card lent,
/// and no longer; [`read_lent`] and [`write_lent`] are the processor's access.
#[must_use]
pub fn lent_buffer() -> Option<(u32, usize)> {
    // The last block stays reserved for registers of a card that is put in meanwhile.
    BLOCKS.address().map(|address| (address, (SLOTS - 1) * BLOCK_BYTES))
}

/// Reads whole words of [`lent_buffer`], from this byte on; false beyond its end.
pub fn read_lent(offset: usize, bytes: &mut [u8]) -> bool {
    BLOCKS.load(offset / 4, bytes)
}

/// Writes whole words of [`lent_buffer`], from this byte on; false beyond its end.
pub fn write_lent(offset: usize, bytes: &[u8]) -> bool {
    BLOCKS.store(offset / 4, bytes)
}
