//! The MAC management counters and the MAC's own interrupts, RM0399 sections 61.5.8 ("MAC management
//! counters") and 61.11.4 (ETH_MMC_CONTROL, ETH_MACISR).

use rigless::soc::stm32h743::generated::ethernet_mac::Register;

use super::state::Ethernet;
use super::wire::{Coming, SHORTEST};

/// Bits of MMC_CONTROL.
const CNTRST: u32 = 1;
const CNTSTOPRO: u32 = 1 << 1;
const RSTONRD: u32 = 1 << 2;
const CNTFREEZ: u32 = 1 << 3;
const CNTPRST: u32 = 1 << 4;
const CNTPRSTLVL: u32 = 1 << 5;
/// Counters and their bits in the two interrupt registers: sent, received.
const SENT: (Register, u32) = (Register::TxPacketCountGood, 1 << 21);
const CRC_ERRORS: (Register, u32) = (Register::RxCrcErrorPackets, 1 << 5);
const UNICASTS: (Register, u32) = (Register::RxUnicastPacketsGood, 1 << 17);
const COUNTERS: [Register; 6] = [
    Register::TxSingleCollisionGoodPackets,
    Register::TxMultipleCollisionGoodPackets,
    Register::TxPacketCountGood,
    Register::RxCrcErrorPackets,
    Register::RxAlignmentErrorPackets,
    Register::RxUnicastPacketsGood,
];
/// Values at which a counter sets its bit: half full, and full.
const HALF: u32 = 0x8000_0000;
/// Bits of MACISR: of the MMC, of its receive and of its transmit part. MACIER has none for them: the masks
/// are the MMC's.
const MMCIS: u32 = 1 << 8;
const MMCRXIS: u32 = 1 << 9;
const MMCTXIS: u32 = 1 << 10;

impl Ethernet {
    /// Returns ETH_MACISR: of its causes the MMC alone is modelled.
    pub(super) fn mac_interrupts(&self) -> u32 {
        let pending = |causes, mask| self.mac.get(causes) & !self.mac.get(mask) != 0;
        let received = pending(Register::MmcRxInterrupt, Register::MmcRxInterruptMask);
        let sent = pending(Register::MmcTxInterrupt, Register::MmcTxInterruptMask);
        let flags = [(received || sent, MMCIS), (received, MMCRXIS), (sent, MMCTXIS)];
        flags.into_iter().filter(|&(set, _)| set).fold(0, |word, (_, bit)| word | bit)
    }

    /// Whether a register is a counter, which a read may clear.
    pub(super) fn is_counter(register: Register) -> bool {
        COUNTERS.contains(&register)
    }

    /// Returns what a read of a register answers. The flags of the MMC are cleared by reading the counter.
    pub(super) fn read_mac(&mut self, register: Register) -> u32 {
        let value = self.peek_mac(register);
        let causes = |each: &(Register, u32)| each.0 == register;
        if [CRC_ERRORS, UNICASTS].iter().any(causes) {
            let (_, bit) = if register == CRC_ERRORS.0 { CRC_ERRORS } else { UNICASTS };
            self.mac.clear_bits(Register::MmcRxInterrupt, bit);
        } else if causes(&SENT) {
            self.mac.clear_bits(Register::MmcTxInterrupt, SENT.1);
        }
        if Self::is_counter(register) && self.mac.get(Register::MmcControl) & RSTONRD != 0 {
            self.mac.set(register, 0);
        }
        value
    }

    /// Returns the present value of a register, and changes nothing.
    pub(super) fn peek_mac(&self, register: Register) -> u32 {
        match register {
            Register::Macisr => self.mac_interrupts(),
            other => self.mac.get(other),
        }
    }

    /// Follows a write of MMC_CONTROL.
    pub(super) fn control_counters(&mut self, value: u32) {
        let preset = if value & CNTPRSTLVL == 0 { HALF - 16 } else { u32::MAX - 15 };
        if value & CNTRST != 0 {
            COUNTERS.into_iter().for_each(|counter| self.mac.set(counter, 0));
        } else if value & CNTPRST != 0 {
            COUNTERS.into_iter().for_each(|counter| self.mac.set(counter, preset));
        }
        self.mac.clear_bits(Register::MmcControl, CNTRST | CNTPRST);
    }

    fn count(&mut self, (counter, bit): (Register, u32), causes: Register) {
        let control = self.mac.get(Register::MmcControl);
        let old = self.mac.get(counter);
        if control & CNTFREEZ != 0 || old == u32::MAX && control & CNTSTOPRO != 0 {
            return;
        }
        let new = old.wrapping_add(1);
        self.mac.set(counter, new);
        if new == HALF || new == u32::MAX {
            self.mac.set_bits(causes, bit);
        }
    }

    pub(super) fn count_sent(&mut self) {
        self.count(SENT, Register::MmcTxInterrupt);
    }

    /// Counts a received frame, whatever the address filter says of it.
    pub(super) fn count_received(&mut self, frame: &Coming) {
        if !frame.is_intact {
            self.count(CRC_ERRORS, Register::MmcRxInterrupt);
        } else if frame.bytes.len() >= SHORTEST && frame.bytes.first().is_some_and(|first| first & 1 == 0) {
            self.count(UNICASTS, Register::MmcRxInterrupt);
        }
    }
}
