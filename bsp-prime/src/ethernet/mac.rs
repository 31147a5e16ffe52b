//! The controller's registers: clocks and pins, the software reset, set-up, start and stop (RM0399 chapter
//! 61, "Programming guide" and "Ethernet registers").

use drivers::lan8720::{self, Duplex, Link};
use stm32h7xx_hal::pac;

use super::rings::{BUFFER_BYTES, RECEIVE, ReceiveRing, SEND, SendRing};
use crate::clocks;
use crate::pins::{self, Mode, PinName, Pull, Speed};

/// The pins of RMII, all of function 11: what is sent at 50 MHz (TX_EN, TXD1, TXD0), and inputs and the slow
/// management lines (REF_CLK, CRS_DV, RXD0, RXD1; MDIO, MDC).
const FAST_PINS: [(char, u8); 3] = [('G', 11), ('G', 12), ('G', 13)];
const OTHER_PINS: [(char, u8); 6] = [('A', 1), ('A', 7), ('C', 4), ('C', 5), ('A', 2), ('C', 1)];

/// SYSCFG_PMCR.EPIS: RMII.
const RMII: u8 = 0b100;

/// Bits of ETH_MACCR.
mod control {
    pub const RECEIVE: u32 = 1 << 0;
    pub const SEND: u32 = 1 << 1;
    /// DCRS and DO, which count in half duplex: RMII has no carrier sense of what is sent, and what is sent
    /// is not to be received.
    pub const NO_CARRIER_SENSE: u32 = 1 << 9;
    pub const NO_RECEIVE_OWN: u32 = 1 << 10;
    pub const LOOP_BACK: u32 = 1 << 12;
    pub const FULL_DUPLEX: u32 = 1 << 13;
    pub const HUNDRED: u32 = 1 << 14;
    /// ACS and CST: padding and check sequence are taken off.
    pub const STRIP: u32 = 1 << 20 | 1 << 21;
    /// IPC: checksums of IP, TCP, UDP and ICMP are verified.
    pub const VERIFY: u32 = 1 << 27;
    pub const ALWAYS: u32 = NO_CARRIER_SENSE | NO_RECEIVE_OWN | STRIP | VERIFY;
}

/// Bits of ETH_DMACSR and ETH_DMACIER.
mod flag {
    pub const SENT: u32 = 1 << 0;
    pub const RECEIVED: u32 = 1 << 6;
    pub const BUS_ERROR: u32 = 1 << 12;
    /// Summaries of what is abnormal (AIS, AIE) and of what is normal (NIS, NIE).
    pub const ABNORMAL: u32 = 1 << 14;
    pub const NORMAL: u32 = 1 << 15;
}
pub(super) use flag::{BUS_ERROR, RECEIVED, SENT};

/// Interrupts of the counters, all masked: they would come after days of traffic, with nobody to clear them.
/// Bit 27 is one of them although the device crate calls it read-only.
const MMC_RECEIVE: u32 = 1 << 5 | 1 << 6 | 1 << 17 | 1 << 26 | 1 << 27;
const MMC_SEND: u32 = 1 << 14 | 1 << 15 | 1 << 21 | 1 << 26 | 1 << 27;

/// Words of a burst of the DMA: ETH_DMACTxCR.TXPBL and ETH_DMACRxCR.RXPBL.
const BURST: u32 = 32 << 16;
/// Bit 0 of ETH_DMACTxCR and ETH_DMACRxCR: the channel runs.
const RUN: u32 = 1;

/// The groups whose frames are received: mDNS (224.0.0.251), and all hosts (224.0.0.1), to which routers send
/// their queries for groups.
const GROUPS: [[u8; 6]; 2] = [[0x01, 0x00, 0x5E, 0x00, 0x00, 0xFB], [0x01, 0x00, 0x5E, 0x00, 0x00, 0x01]];

/// Check sequence of Ethernet over an address.
const fn crc32(bytes: [u8; 6]) -> u32 {
    let mut crc = u32::MAX;
    let mut bit = 0;
    while bit < 48 {
        let input = bytes[bit / 8] as u32 >> (bit % 8) & 1;
        crc = if (crc ^ input) & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
        bit += 1;
    }
    !crc
}

/// Returns an address' bit in the hash table of 64: the upper six bits of its reversed check sequence
/// (ETH_MACHT0R).
const fn hash_bit(address: [u8; 6]) -> u64 {
    1 << (crc32(address).reverse_bits() >> 26)
}

const HASH_TABLE: u64 = hash_bit(GROUPS[0]) | hash_bit(GROUPS[1]);
// The example of the manual: the bit of 1F:52:41:9C:B6:AF is that of hash 2C, and of A0:0A:98:00:00:45 that
// of 07 (ETH_MACHT0R).
const _: () = assert!(hash_bit([0x1F, 0x52, 0x41, 0x9C, 0xB6, 0xAF]) == 1 << 0x2C);
const _: () = assert!(hash_bit([0xA0, 0x0A, 0x98, 0x00, 0x00, 0x45]) == 1 << 0x07);

/// The three blocks of the controller.
pub(super) struct Registers {
    pub mac: pac::ETHERNET_MAC,
    pub mtl: pac::ETHERNET_MTL,
    pub dma: pac::ETHERNET_DMA,
}

impl Registers {
    /// Connects pins and clocks, and has the software reset begin. False if the chip does not take RMII.
    pub(super) fn begin(&self) -> bool {
        for (group, speed) in [(&FAST_PINS[..], Speed::VeryHigh), (&OTHER_PINS[..], Speed::Low)] {
            for &(port, number) in group {
                pins::configure(PinName::new(port, number), Mode::Alternate(11, speed), Pull::Floating, false);
            }
        }
        // SAFETY: RCC and SYSCFG have no owner behind start-up; these fields are the controller's alone, and
        // only the executor changes others of these registers, which is also who calls this.
        let (rcc, syscfg) = unsafe { (&*pac::RCC::ptr(), &*pac::SYSCFG::ptr()) };
        // RM0399 section 13.3.1, SYSCFG_PMCR: to be set while the MAC is in reset and has no clock. The read
        // back makes sure that it has been.
        rcc.ahb1rstr.modify(|_, w| w.eth1macrst().set_bit());
        // SAFETY: a value of the field.
        syscfg.pmcr.modify(|_, w| unsafe { w.epis().bits(RMII) });
        let is_rmii = syscfg.pmcr.read().epis().bits() == RMII;
        rcc.ahb1enr.modify(|_, w| w.eth1macen().enabled().eth1txen().enabled().eth1rxen().enabled());
        // RM0399 section 3.2: two cycles after the write before the first access; the read back is longer.
        let _settled = rcc.ahb1enr.read().bits();
        rcc.ahb1rstr.modify(|_, w| w.eth1macrst().clear_bit());
        let _settled = rcc.ahb1rstr.read().bits();
        self.reset();
        is_rmii
    }

    /// Has the software reset begin (ETH_DMAMR: SWR). It ends by itself if the PHY's clock is there.
    pub(super) fn reset(&self) {
        self.dma.dmamr.write(|w| w.swr().set_bit());
    }

    pub(super) fn is_resetting(&self) -> bool {
        self.dma.dmamr.read().swr().bit_is_set()
    }

    /// Sets everything up but speed and duplex, after a reset. The rings are the DMA's already.
    pub(super) fn set_up(&self, address: [u8; 6]) {
        let Self { mac, mtl, .. } = self;
        let [a, b, c, d, e, f] = address;
        // SAFETY: patterns of these registers' fields; the controller is stopped.
        unsafe {
            // ETH_MAC1USTCR: a microsecond in periods of HCLK.
            mac.mac1ustcr.write(|w| w.bits(clocks::HCLK_HZ / 1_000_000 - 1));
            // ETH_MACA0HR, ETH_MACA0LR: the write of the second takes both over.
            mac.maca0hr.write(|w| w.bits(u32::from_le_bytes([e, f, 0, 0])));
            mac.maca0lr.write(|w| w.bits(u32::from_le_bytes([a, b, c, d])));
            // ETH_MACHT0R, ETH_MACHT1R and ETH_MACPFR.HMC: our address, broadcast, and these groups.
            mac.macht0r.write(|w| w.bits(HASH_TABLE as u32));
            mac.macht1r.write(|w| w.bits((HASH_TABLE >> 32) as u32));
            mac.macpfr.write(|w| w.hmc().set_bit());
            // ETH_MMC_RX_INTERRUPT_MASK, ETH_MMC_TX_INTERRUPT_MASK.
            mac.mmc_rx_interrupt_mask.modify(|r, w| w.bits(r.bits() | MMC_RECEIVE));
            mac.mmc_tx_interrupt_mask.modify(|r, w| w.bits(r.bits() | MMC_SEND));
            mac.maccr.write(|w| w.bits(control::ALWAYS));
        }
        // ETH_MTLTxQOMR: TSF, without which no checksum can be inserted. ETH_MTLRxQOMR: RSF, without which
        // none can be verified; frames with a wrong one are dropped (DIS_TCP_EF, FEP and FUP clear), at 10
        // Mbit/s by `rings.rs`.
        mtl.mtltx_qomr.modify(|_, w| w.tsf().set_bit());
        mtl.mtlrx_qomr.modify(|_, w| w.rsf().set_bit().dis_tcp_ef().clear_bit().fep().clear_bit().fup().clear_bit());
        self.set_up_dma();
    }

    /// Sets the DMA up and starts its receiver, to which the MAC brings nothing yet.
    fn set_up_dma(&self) {
        let dma = &self.dma;
        // ETH_DMASBMR: FB and AAL, bursts of fixed length from aligned addresses.
        dma.dmasbmr.write(|w| w.fb().set_bit().aal().set_bit());
        // SAFETY: patterns of these registers' fields, addresses of the rings and their lengths less one; all
        // before the channels run.
        unsafe {
            // ETH_DMACCR: descriptors without a gap.
            dma.dmaccr.write(|w| w.bits(0));
            dma.dmactx_cr.write(|w| w.bits(BURST));
            dma.dmacrx_cr.write(|w| w.bits(BURST | (BUFFER_BYTES as u32) << 1));
            dma.dmactx_rlr.write(|w| w.bits(SEND as u32 - 1));
            dma.dmacrx_dlar.write(|w| w.bits(ReceiveRing::address()));
            dma.dmacrx_rlr.write(|w| w.bits(RECEIVE as u32 - 1));
            dma.dmacrx_dtpr.write(|w| w.bits(ReceiveRing::tail()));
            dma.dmacrx_cr.modify(|r, w| w.bits(r.bits() | RUN));
        }
        self.listen(flag::RECEIVED);
    }

    /// Clears a flag: from now on it says that something has happened since (ETH_DMACSR).
    pub(super) fn forget(&self, flag: u32) {
        // SAFETY: a 1 clears a flag and its summary.
        self.dma.dmacsr.write(|w| unsafe { w.bits(flag | flag::NORMAL) });
    }

    /// Lets the controller interrupt for a flag, and for errors of the DMA.
    pub(super) fn listen(&self, flag: u32) {
        let flags = flag::ABNORMAL | flag::NORMAL | flag::BUS_ERROR | flag;
        // SAFETY: any set of flags may interrupt (ETH_DMACIER).
        self.dma.dmacier.write(|w| unsafe { w.bits(flags) });
    }

    /// Starts to send and receive over this link, or with the sender connected to the receiver. The ring to
    /// send is empty.
    pub(super) fn start(&self, link: Link, loops: bool) {
        let speed = if link.speed == lan8720::Speed::Hundred { control::HUNDRED } else { 0 };
        let duplex = if link.duplex == Duplex::Full { control::FULL_DUPLEX } else { 0 };
        // ETH_MTLRxQOMR: FEP, for the frames whose errors are none (`rings.rs`).
        self.mtl.mtlrx_qomr.modify(|_, w| w.fep().bit(link.speed == lan8720::Speed::Ten));
        let settings = control::ALWAYS | speed | duplex | if loops { control::LOOP_BACK } else { 0 };
        // SAFETY: patterns of these registers' fields; the transmitter is stopped, as a change of speed, of
        // duplex and of the list's address asks for.
        unsafe {
            self.mac.maccr.write(|w| w.bits(settings));
            // The settings are in force before anything moves.
            let _settled = self.mac.maccr.read().bits();
            self.mac.maccr.write(|w| w.bits(settings | control::SEND | control::RECEIVE));
            self.dma.dmactx_dlar.write(|w| w.bits(SendRing::address()));
            self.dma.dmactx_cr.write(|w| w.bits(BURST | RUN));
        }
    }

    /// Stops the DMA to send, behind its present frame, and the receiver (chapter 61, "Stopping and starting
    /// transmission").
    pub(super) fn stop(&self) {
        // SAFETY: as in `start`.
        unsafe {
            self.dma.dmactx_cr.write(|w| w.bits(BURST));
            self.mac.maccr.modify(|r, w| w.bits(r.bits() & !control::RECEIVE));
        }
    }

    /// Whether the DMA to send stands still (ETH_DMADSR: TPS0, 0 stopped, 6 suspended).
    pub(super) fn has_stopped(&self) -> bool {
        matches!(self.dma.dmadsr.read().bits() >> 12 & 0xF, 0 | 6)
    }

    /// Throws away what was not sent, and stops the transmitter (ETH_MTLTxQOMR: FTQ).
    pub(super) fn flush(&self) {
        self.mtl.mtltx_qomr.modify(|_, w| w.ftq().set_bit());
    }

    pub(super) fn is_flushing(&self) -> bool {
        self.mtl.mtltx_qomr.read().ftq().bit_is_set()
    }

    /// Stops the transmitter, behind a flush, which needs it.
    pub(super) fn rest(&self) {
        // SAFETY: clears one bit.
        self.mac.maccr.modify(|r, w| unsafe { w.bits(r.bits() & !control::SEND) });
    }

    /// Returns the number of frames lost since the last call: those that found the queue full because no
    /// descriptor was free (ETH_MTLRxQMPOCR: OVFPKTCNT), and those that an error of the DMA cost
    /// (ETH_DMACMFCR: MFC). Both clear when read; a bit says that they have overflowed.
    pub(super) fn take_missed(&self) -> u32 {
        const COUNT: u32 = 0x7FF;
        let overflowed = self.mtl.mtlrx_qmpocr.read().bits();
        let dropped = self.dma.dmacmfcr.read().bits();
        (overflowed & COUNT) + (overflowed >> 11 & 1) * COUNT + (dropped & COUNT) + (dropped >> 15 & 1) * COUNT
    }

    /// Returns the number of frames with a wrong check sequence since the reset.
    pub(super) fn check_errors(&self) -> u32 {
        self.mac.rx_crc_error_packets.read().bits()
    }
}

/// Masks the interrupts and clears their flags, which it returns.
pub(super) fn silence() -> u32 {
    // SAFETY: both registers are written as whole words. The mask is set again by the owner, when it has
    // found no more work; flags that it has not seen yet are of frames that it will find in the rings.
    let dma = unsafe { &*pac::ETHERNET_DMA::ptr() };
    // SAFETY: as above; a 1 clears a flag (ETH_DMACSR).
    unsafe {
        dma.dmacier.write(|w| w.bits(0));
        let flags = dma.dmacsr.read().bits();
        dma.dmacsr.write(|w| w.bits(flags));
        flags
    }
}
