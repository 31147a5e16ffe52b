//! SPI by three pins, for chips that are on no bus of the board.

use crate::board::{Board, Input, Output};

/// A chip at pins of its own.
pub struct SoftSpi<B: Board> {
    /// Select line, and whether it selects by a high level.
    pub select: Option<(B::Output, bool)>,
    /// Clock of the bits.
    pub clock: B::Output,
    /// Data to the chip (MOSI).
    pub to_chip: B::Output,
    /// Data from the chip (MISO).
    pub from_chip: B::Input,
    /// SPI mode, 0 to 3.
    pub mode: u8,
    /// Length of half a period of the clock, ticks.
    pub pulse_ticks: u32,
}

impl<B: Board> SoftSpi<B> {
    fn select(&mut self, is_selected: bool) {
        if let Some((pin, active_high)) = &mut self.select {
            pin.set(is_selected == *active_high);
        }
    }

    /// Selects the chip, exchanges the bytes in place, highest bits first, and deselects it.
    pub fn exchange(&mut self, bytes: &mut [u8]) {
        self.select(true);
        for byte in bytes {
            for _ in 0..8 {
                let bit = self.exchange_bit(*byte & 0x80 != 0);
                *byte = *byte << 1 | u8::from(bit);
            }
        }
        self.select(false);
    }

    fn exchange_bit(&mut self, bit: bool) -> bool {
        let (idles_high, second_edge) = (self.mode & 2 != 0, self.mode & 1 != 0);
        if second_edge {
            self.clock.set(!idles_high);
        }
        self.to_chip.set(bit);
        B::pause(self.pulse_ticks);
        self.clock.set(idles_high == second_edge);
        let read = self.from_chip.is_high();
        B::pause(self.pulse_ticks);
        if !second_edge {
            self.clock.set(idles_high);
        }
        read
    }
}
