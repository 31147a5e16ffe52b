//! The internal DMA, RM0399 section 58.5.6: a single buffer, or two by turns.

use std::ops::Range;

use rigless::device::RegisterFile;
use rigless::soc::stm32h743::generated::sdmmc1::Register;

use super::state::Sdmmc;
use crate::peripherals::sdmmc_flags as flag;

/// Fields of register IDMACTRLR.
const IDMAEN: u64 = 1;
const IDMABMODE: u64 = 1 << 1;
const IDMABACT: u64 = 1 << 2;
/// Memories that the internal DMA of SDMMC1 reaches, RM0399 table 3: the flash, AXI SRAM and the external
/// memories, but neither the TCMs nor the second domain's SRAM.
const REACH: [Range<u64>; 3] = [0x0800_0000..0x0820_0000, 0x2400_0000..0x2408_0000, 0x6000_0000..0xA000_0000];
/// Tokens of the accesses the DMA makes.
pub(super) const FETCH: u64 = 1;
pub(super) const STORE: u64 = 2;

/// Returns the size of a buffer in double-buffer mode.
pub(super) fn buffer_bytes(file: &RegisterFile) -> u64 {
    (file.get(Register::Idmabsizer) >> 5 & 0xFF) * 32
}

impl Sdmmc {
    pub(super) fn dma(file: &RegisterFile) -> bool {
        file.get(Register::Idmactrlr) & IDMAEN != 0
    }

    /// Returns the DMA's next address; in double-buffer mode it changes buffers and raises the flag. `None`
    /// when the DMA does not reach the address.
    pub(super) fn next_dma_address(&mut self, file: &mut RegisterFile) -> Option<u64> {
        let control = file.get(Register::Idmactrlr);
        if control & IDMABMODE != 0 && self.dma_room == 0 {
            let second = control & IDMABACT == 0;
            file.set(Register::Idmactrlr, control ^ IDMABACT);
            self.keep(file);
            self.dma_address = file.get(if second { Register::Idmabase1r } else { Register::Idmabase0r });
            self.dma_room = buffer_bytes(file);
            self.status |= flag::IDMABTC;
        }
        let address = self.dma_address;
        if !REACH.iter().any(|range| range.contains(&address)) {
            return None;
        }
        self.dma_address += 4;
        self.dma_room = self.dma_room.saturating_sub(4);
        Some(address)
    }
}
