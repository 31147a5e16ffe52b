//! The MAC's registers, its receiver, and what leaves it, RM0399 sections 61.5.2 ("MAC transmission"), 61.5.3
//! ("MAC reception") and 61.11.4 ("Ethernet MAC and MMC registers").

use rigless::device::DeviceContext;
use rigless::soc::stm32h743::generated::ethernet_dma::Register as DmaRegister;
use rigless::soc::stm32h743::generated::ethernet_mac::Register;
use rigless::soc::stm32h743::generated::ethernet_mtl::Register as MtlRegister;

use super::bits::{maccr, queue, status};
use super::channels::Packet;
use super::checksum::{Payload, Verdict, check, frame_check};
use super::descriptor::receive;
use super::filter::{Filter, Filtered, address_of};
use super::state::Ethernet;
use super::wire::{CHECK, Coming, SHORTEST};

/// Types of Ethernet frames.
const ARP: u16 = 0x0806;
const VLAN: u16 = 0x8100;
const CONTROL: u16 = 0x8808;
/// Smallest value of the length and type field that is a type.
const FIRST_TYPE: u16 = 0x600;
/// Longest packets with their check sequence: before the watchdog cuts them, and before they are giants.
const WATCHDOG: usize = 2_048;
const JUMBO_WATCHDOG: usize = 10_240;
const GIANT: usize = 1_518;

const WRONG_SPEED: &str = "RM0399 ETH_MACCR.FES is not the speed of the PHY: no frame passes between them";
const WRONG_DUPLEX: &str = "RM0399 ETH_MACCR.DM is not the duplex of the link: collisions on silicon";

const SLOW_PINS: &str =
    "DS12923, I/O AC characteristics: outputs at low speed (OSPEEDR = 0) carry 12 MHz, and RMII has data for 50 MHz";

impl Ethernet {
    fn configuration(&self, bit: u32) -> bool {
        self.mac.get(Register::Maccr) & bit != 0
    }

    fn queue_option(&self, bit: u32) -> bool {
        self.mtl.get(MtlRegister::Mtlrxqomr) & bit != 0
    }

    /// Follows a write of a register of the MAC.
    pub(super) fn write_mac(&mut self, register: Register, value: u32, context: &mut DeviceContext<'_>) {
        if matches!(register, Register::Macmdioar | Register::Macmdiodr) {
            let busy = self.frame_over.is_some();
            if !busy {
                self.mac.write(register, value);
            }
            self.write_management(register, value, context);
            return;
        }
        self.mac.write(register, value);
        match register {
            Register::Maca0lr => {
                self.station = address_of(self.mac.get(Register::Maca0hr), self.mac.get(Register::Maca0lr));
            }
            Register::MmcControl => self.control_counters(value),
            _ => {}
        }
    }

    /// Whether MAC and PHY run at the same speed. Frames are lost otherwise, and the first of them is told.
    fn fits_the_link(&mut self, context: &mut DeviceContext<'_>) -> bool {
        if self.configuration(maccr::FES) != self.phy.is_fast() {
            self.complain("MACCR", WRONG_SPEED, context);
            self.wire.counters.at_wrong_speed += 1;
            return false;
        }
        if self.phy.link().is_some_and(|link| link.is_full != self.configuration(maccr::DM)) {
            self.complain("MACCR", WRONG_DUPLEX, context);
        }
        true
    }

    /// Takes a frame that has left the transmitter.
    pub(super) fn leave(&mut self, bytes: Vec<u8>, is_sound: bool, context: &mut DeviceContext<'_>) {
        self.count_sent();
        if self.configuration(maccr::LM) || self.phy.loops_back() {
            self.arrived(&Coming { bytes, is_intact: is_sound }, context);
            return;
        }
        if self.phy.link().is_none() || !self.phy.passes() || !self.around.speaks {
            self.wire.counters.without_link += 1;
        } else if self.fits_the_link(context) {
            if !self.around.speaks_fast {
                self.complain("MACCR", SLOW_PINS, context);
            }
            if is_sound && bytes.len() >= SHORTEST {
                self.wire.hear(context.now().0, bytes);
            } else {
                self.wire.counters.malformed += 1;
            }
        }
    }

    /// Takes a frame from the line.
    pub(super) fn take_from_line(&mut self, frame: &Coming, context: &mut DeviceContext<'_>) {
        if !self.phy.passes() || !self.around.hears {
            self.wire.counters.without_link += 1;
        } else if !self.configuration(maccr::LM) && self.is_receiving() && self.fits_the_link(context) {
            self.arrived(frame, context);
        }
    }

    fn is_receiving(&mut self) -> bool {
        let is_on = self.configuration(maccr::RE) && self.is_clocked();
        self.wire.counters.unheard += u64::from(!is_on);
        is_on
    }

    /// Judges a frame, and passes it on to the receive queue.
    fn arrived(&mut self, frame: &Coming, context: &mut DeviceContext<'_>) {
        self.count_received(frame);
        let watchdog = if self.configuration(maccr::JE) { JUMBO_WATCHDOG } else { WATCHDOG };
        let is_cut = !self.configuration(maccr::WD) && frame.bytes.len() + CHECK as usize > watchdog;
        if is_cut {
            self.dma.set_bits(DmaRegister::Dmacsr, status::RWT);
        }
        let is_wrong = is_cut || !frame.is_intact;
        let is_short = frame.bytes.len() < SHORTEST;
        if is_wrong && !self.queue_option(queue::FEP) || is_short && !self.queue_option(queue::FUP) {
            self.wire.counters.damaged += 1;
            return;
        }
        let filtered = Filter { registers: &self.mac, station: self.station }.judge(&frame.bytes);
        if !filtered.passes {
            self.wire.counters.filtered += 1;
            return;
        }
        let checked = self.configuration(maccr::IPC).then(|| check(&frame.bytes));
        let fails = checked.is_some_and(|verdict| verdict.header_is_wrong || verdict.payload_is_wrong);
        if fails && !self.queue_option(queue::DIS_TCP_EF) && !self.queue_option(queue::FEP) {
            self.wire.counters.damaged += 1;
            if !self.queue_option(queue::RSF) {
                self.complain("MTLRxQOMR", "RM0399 ETH_MTLRXQOMR: checksum errors are dropped with RSF alone", context);
            }
            return;
        }
        let mut packet = self.strip(frame);
        packet.bytes.truncate(if is_cut { watchdog } else { usize::MAX });
        packet.des1 = checked.map_or(0, words_of_verdict);
        packet.des2 = words_of_filter(filtered);
        packet.des3 |= receive::RS1V | if frame.is_intact { 0 } else { receive::CE | receive::ES };
        packet.des3 |= if is_cut { receive::RWT | receive::ES } else { 0 };
        self.queue_packet(packet, context);
    }

    /// Strips padding and check sequence as ACS and CST say. Returns the packet with its kind.
    fn strip(&self, frame: &Coming) -> Packet {
        let mut bytes = frame.bytes.clone();
        let check = frame_check(&bytes) ^ if frame.is_intact { 0 } else { u32::MAX };
        let whole = bytes.len() + CHECK as usize;
        let kind = frame.bytes.get(12..14).map_or(0, |kind| u16::from_be_bytes([kind[0], kind[1]]));
        let is_type = kind >= FIRST_TYPE;
        if is_type && !self.configuration(maccr::CST) || !is_type && !self.configuration(maccr::ACS) {
            bytes.extend(check.to_le_bytes());
        } else if !is_type && usize::from(kind) < SHORTEST - 14 {
            bytes.truncate(14 + usize::from(kind));
        }
        let kind = match kind {
            ARP => receive::LT_ARP,
            VLAN => receive::LT_VLAN,
            CONTROL => receive::LT_CONTROL,
            _ if is_type => receive::LT_TYPE,
            _ => receive::LT_LENGTH,
        };
        let giant = if whole > GIANT + usize::from(kind == receive::LT_VLAN) * 4 { receive::GP } else { 0 };
        Packet { bytes, des3: kind << receive::LT | giant, ..Packet::default() }
    }
}

/// Returns DES1 of a packet: what the checksum engine found.
fn words_of_verdict(verdict: Verdict) -> u32 {
    let kind = match verdict.payload {
        Some(Payload::Udp) => 1,
        Some(Payload::Tcp) => 2,
        Some(Payload::Icmp) => 3,
        None => 0,
    };
    let flags = [
        (verdict.payload_is_wrong, receive::IPCE),
        (verdict.bypassed, receive::IPCB),
        (verdict.is_ipv6, receive::IPV6),
        (verdict.is_ipv4, receive::IPV4),
        (verdict.header_is_wrong, receive::IPHE),
    ];
    flags.into_iter().filter(|&(set, _)| set).fold(kind, |word, (_, bit)| word | bit)
}

/// Returns DES2 of a packet: what the address filter found.
fn words_of_filter(filtered: Filtered) -> u32 {
    let flags = [
        (filtered.destination_failed, receive::DAF),
        (filtered.source_failed, receive::SAF),
        (filtered.by_hash, receive::HF),
    ];
    flags.into_iter().filter(|&(set, _)| set).fold(0, |word, (_, bit)| word | bit)
}
