//! Work on buses, which is done without the controller's lock: bytes take their time there, and timers go on
//! meanwhile.

use crate::board::{Board, Spi};
use crate::objects::spi::Bytes;

/// Bytes for a chip.
pub struct Job<B: Board> {
    pub(super) oid: u8,
    pub(super) chip: B::Spi,
    pub(super) bytes: Bytes,
    pub(super) answers: bool,
}

impl<B: Board> Job<B> {
    /// Exchanges the bytes with the chip.
    pub fn run(&mut self) {
        self.chip.exchange(&mut self.bytes);
    }
}
