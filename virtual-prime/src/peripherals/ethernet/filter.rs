//! Packet filtering by addresses, RM0399 section 61.5.3 ("Packet filtering").

use rigless::soc::stm32h743::generated::ethernet_mac::Register;

use super::bits::{address, macpfr};
use super::block::Block;
use super::checksum::frame_check;

const BROADCAST: [u8; 6] = [0xFF; 6];
/// Registers of the further addresses, high and low.
const FURTHER: [(Register, Register); 3] = [
    (Register::Maca1hr, Register::Maca1lr),
    (Register::Maca2hr, Register::Maca2lr),
    (Register::Maca3hr, Register::Maca3lr),
];

/// Outcome for a received frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Filtered {
    /// Whether the frame goes on to the receive queue.
    pub(super) passes: bool,
    pub(super) destination_failed: bool,
    pub(super) source_failed: bool,
    pub(super) by_hash: bool,
}

/// The filter, as the registers set it. The first address counts as of the last write of its low register.
pub(super) struct Filter<'a> {
    pub(super) registers: &'a Block<Register>,
    pub(super) station: [u8; 6],
}

/// Returns the station address in a pair of registers: the first byte on the wire is the lowest.
pub(super) fn address_of(high: u32, low: u32) -> [u8; 6] {
    let [a, b, c, d] = low.to_le_bytes();
    let [e, f, ..] = high.to_le_bytes();
    [a, b, c, d, e, f]
}

impl Filter<'_> {
    fn has(&self, bit: u32) -> bool {
        self.registers.get(Register::Macpfr) & bit != 0
    }

    /// Whether one of the further addresses is this one; MBC leaves bytes out of the comparison.
    fn is_further(&self, sought: [u8; 6], as_source: bool) -> bool {
        FURTHER.iter().any(|&(high, low)| {
            let [high, low] = [high, low].map(|register| self.registers.get(register));
            let own = address_of(high, low);
            // Bit 29 of the register leaves out byte 5 of the address, bit 24 byte 0.
            let equal = |place: usize| high >> (24 + place) & 1 != 0 || own[place] == sought[place];
            high & address::AE != 0 && (high & address::SA != 0) == as_source && (0..6).all(equal)
        })
    }

    /// Whether the hash table has the address: the upper six bits of its checksum, bits in reverse order.
    fn is_in_table(&self, sought: [u8; 6]) -> bool {
        let place = frame_check(&sought).reverse_bits() >> 26;
        let table = if place & 0x20 == 0 { Register::Macht0r } else { Register::Macht1r };
        self.registers.get(table) >> (place & 0x1F) & 1 != 0
    }

    /// Judges a destination. Returns whether it passes, and whether only by the hash table.
    fn destination(&self, sought: [u8; 6]) -> (bool, bool) {
        if sought == BROADCAST {
            return (!self.has(macpfr::DBF), false);
        }
        let is_group = sought[0] & 1 != 0;
        if is_group && self.has(macpfr::PM) {
            return (true, false);
        }
        let exact = (!is_group && sought == self.station || self.is_further(sought, false)) != self.has(macpfr::DAIF);
        if !self.has(if is_group { macpfr::HMC } else { macpfr::HUC }) {
            return (exact, false);
        }
        let hashed = self.is_in_table(sought) != self.has(macpfr::DAIF);
        (hashed || exact && self.has(macpfr::HPF), hashed)
    }

    /// Judges a frame.
    pub(super) fn judge(&self, frame: &[u8]) -> Filtered {
        let address = |at: usize| frame.get(at..at + 6).and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; 6]);
        if self.has(macpfr::PR) {
            return Filtered { passes: true, ..Filtered::default() };
        }
        let (passed, by_hash) = self.destination(address(0));
        let source_failed =
            self.has(macpfr::SAF | macpfr::SAIF) && self.is_further(address(6), true) == self.has(macpfr::SAIF);
        let blocked = !passed || source_failed && self.has(macpfr::SAF);
        Filtered { passes: !blocked || self.has(macpfr::RA), destination_failed: !passed, source_failed, by_hash }
    }
}
