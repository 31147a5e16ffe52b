//! Chips on an SPI bus.

use crate::board::{Board, Spi};
use crate::objects::soft_spi::SoftSpi;
use crate::wire::BLOCK_BYTES;

/// Way to a chip.
pub enum Chip<B: Board> {
    /// A bus of the board.
    OnBus(B::Spi),
    /// Pins of its own.
    AtPins(SoftSpi<B>),
}

impl<B: Board> Spi for Chip<B> {
    fn exchange(&mut self, bytes: &mut [u8]) {
        match self {
            Self::OnBus(chip) => chip.exchange(bytes),
            Self::AtPins(chip) => chip.exchange(bytes),
        }
    }
}

/// A chip. While bytes are exchanged, it is out with the job that does it.
pub struct SpiDevice<B: Board> {
    /// Number of the select pin, and whether it selects by a high level.
    pub select: Option<(u32, bool)>,
    /// The chip, once its bus is set.
    pub chip: Option<Chip<B>>,
    /// The bus is set: it can be once.
    pub is_set: bool,
}

impl<B: Board> SpiDevice<B> {
    /// A chip whose bus is not known yet.
    pub const fn new(select: Option<(u32, bool)>) -> Self {
        Self { select, chip: None, is_set: false }
    }
}

/// Bytes of a message: fewer than a block has.
pub type Bytes = heapless::Vec<u8, BLOCK_BYTES>;

/// Message for a chip at a shutdown.
#[derive(Debug)]
pub struct LastWords {
    /// The chip, by its object.
    pub device: u8,
    /// Bytes of the message.
    pub bytes: Bytes,
}
