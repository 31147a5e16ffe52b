//! Chips on an SPI bus.

use crate::wire::BLOCK_BYTES;

/// A chip. While bytes are exchanged, it is out with the job that does it.
#[derive(Debug)]
pub struct SpiDevice<S> {
    /// Number of the select pin, and whether it selects by a high level.
    pub select: Option<(u32, bool)>,
    /// The chip, once its bus is set.
    pub chip: Option<S>,
    /// The bus is set: it can be once.
    pub is_set: bool,
}

impl<S> SpiDevice<S> {
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
