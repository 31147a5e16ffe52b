//! The SD card on SDMMC1 (4 bits, PC8 to PC12 and PD2): identification, and blocks by the controller's own
//! DMA.
//!
//! Cards of the standard (byte-addressed, up to 2 GB) and high-capacity kinds. Every command and transfer has
//! a bound and ends in an error rather than a hang. While the hardware works the core sleeps: the interrupt
//! only clears the controller's mask, its wake-up is the message, so whoever reads a file (the dispatcher in
//! idle) neither spins nor holds anything up. Transfers go through a buffer in the DMA arena, the only memory
//! both sides reach without cache care; a sequential reader gets [`WINDOW_BLOCKS`] blocks per command.

use core::fmt;

mod card;
mod controller;
mod window;

pub use card::{CardInfo, CardKind};
pub use controller::on_interrupt;
pub use window::{SdCard, WINDOW_BLOCKS};

/// What can go wrong with the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdError {
    /// No card answers to identification.
    NoCard,
    /// The card (or the controller) stopped answering; carries the command.
    NotResponding(u8),
    /// A response or a block arrived damaged; carries the command.
    Damaged(u8),
    /// The card refused a command; carries the command and the error bits of its status.
    Refused(u8, u32),
    /// The card works at a voltage or by rules we do not offer.
    Unsupported,
    /// The controller could not reach the transfer buffer in time.
    Transfer,
    /// A block beyond the card's end.
    OutOfRange,
    /// Not identified yet: call [`SdCard::identify`].
    NotIdentified,
}

impl fmt::Display for SdError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCard => f.write_str("no SD card answers"),
            Self::NotResponding(command) => write!(f, "the SD card did not answer command {command}"),
            Self::Damaged(command) => write!(f, "the answer to SD command {command} arrived damaged"),
            Self::Refused(command, bits) => write!(f, "the SD card refused command {command} with status {bits:#010x}"),
            Self::Unsupported => f.write_str("the SD card works by rules this board does not offer"),
            Self::Transfer => f.write_str("the SD controller lost data"),
            Self::OutOfRange => f.write_str("a block beyond the end of the SD card was asked for"),
            Self::NotIdentified => f.write_str("the SD card is not identified yet"),
        }
    }
}

impl core::error::Error for SdError {}
