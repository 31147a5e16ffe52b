//! State of the core, and its registers.

use std::collections::BTreeSet;

use super::endpoint::Endpoint;
use super::fifo::{ReceiveFifo, Span, TransmitFifo};
use super::link::Link;
use super::registers::*;

/// Conditions outside of the core's own registers that it depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Surroundings {
    /// The kernel clock that RCC_D2CCIP2R.USBSEL selects; it has to be 48 MHz.
    pub kernel_hz: u64,
    /// PA11 (DM) and PA12 (DP) are connected to the core: alternate function 10.
    pub pins: bool,
    /// PWR_CR3.USB33DEN: the detector has found the supply of the transceiver.
    pub supply: bool,
    /// RCC_AHB1ENR.USB2OTGHSULPIEN: the core waits for the clock of an external transceiver.
    pub ulpi: bool,
    /// RCC_AHB1LPENR.USB2OTGHSULPILPEN: the core waits for that clock while the processor sleeps.
    pub ulpi_asleep: bool,
}

/// Use of the core by an image that the manual does not allow, or that the model lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// Register that the finding is about.
    pub register: &'static str,
    /// Reason of the finding, with the place in the manual.
    pub reason: &'static str,
}

/// The core as a device controller.
#[derive(Debug)]
pub struct Core {
    pub(super) around: Surroundings,
    pub(super) now_ns: u64,
    pub(super) gotgctl: u32,
    pub(super) gotgint: u32,
    pub(super) gahbcfg: u32,
    pub(super) gusbcfg: u32,
    /// TXFNUM, and CSRST while the reset waits for the transceiver's clock.
    pub(super) grstctl: u32,
    /// Causes of OTG_GINTSTS that stay until they are cleared.
    pub(super) latched: u32,
    pub(super) gintmsk: u32,
    pub(super) grxfsiz: u32,
    /// Registers OTG_DIEPTXF0 to OTG_DIEPTXF8.
    pub(super) dieptxf: [u32; ENDPOINTS],
    pub(super) gccfg: u32,
    pub(super) cid: u32,
    pub(super) dcfg: u32,
    /// Device address that the core answers to.
    pub(super) address: u8,
    /// OTG_DCTL's stored bits: RWUSIG, SDIS, the test mode and POPRGDNE.
    pub(super) dctl: u32,
    pub(super) global_in_nak: bool,
    pub(super) global_out_nak: bool,
    /// GONAKEFF: the entry of the global OUT NAK was popped.
    pub(super) out_nak_effective: bool,
    pub(super) diepmsk: u32,
    pub(super) doepmsk: u32,
    pub(super) daintmsk: u32,
    pub(super) diepempmsk: u32,
    pub(super) deachintmsk: u32,
    pub(super) pcgcctl: u32,
    /// Registers that are only stored: GLPMCFG, HPTXFSIZ, DVBUSDIS, DVBUSPULSE, DTHRCTL, DIEPEACHMSK1 and
    /// DOEPEACHMSK1.
    pub(super) kept: [u32; KEPT.len()],
    pub(super) rx: ReceiveFifo,
    pub(super) tx: [TransmitFifo; ENDPOINTS],
    pub(super) ins: [Endpoint; ENDPOINTS],
    pub(super) outs: [Endpoint; ENDPOINTS],
    /// Transfers of OUT endpoints that have ended, and whose end was not popped yet.
    pub(super) ending: [bool; ENDPOINTS],
    pub(super) control: Control,
    pub(super) link: Link,
    pub(super) stirred: bool,
    found: BTreeSet<Finding>,
    untold: Vec<Finding>,
}

/// State of the control transfer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Control {
    /// Whether a SETUP has come, and the status stage is not over.
    pub open: bool,
    /// SETUP packets in a row, whose stage is not over.
    pub setups: u32,
    /// Whether the transfer's data go to the host.
    pub reads: bool,
    /// Whether data have come from the host.
    pub written: bool,
}

/// Registers that are only stored, with their reset values.
const KEPT: [(u32, u32); 7] = [
    (GLPMCFG, 0),
    (HPTXFSIZ, 0x0200_0400),
    (DVBUSDIS, 0x17D7),
    (DVBUSPULSE, 0x05B8),
    (DTHRCTL, 0),
    (DIEPEACHMSK1, 0),
    (DOEPEACHMSK1, 0),
];
/// Value of OTG_CID in the STM32H7, section 60.14.
const PRODUCT_ID: u32 = 0x2300;

impl Core {
    /// Creates a core out of reset.
    #[must_use]
    pub fn new() -> Self {
        Self {
            around: Surroundings::default(),
            now_ns: 0,
            // Device mode: the ID line, which the board leaves open, is pulled up.
            gotgctl: gotgctl::CIDSTS,
            gotgint: 0,
            gahbcfg: 0,
            gusbcfg: 0x1400,
            grstctl: 0,
            // The erratum of a false CIDSCHG after a reset: ES0392, 2.25.6, and the register's reset value.
            latched: gint::CIDSCHG,
            gintmsk: 0,
            grxfsiz: 0x200,
            dieptxf: std::array::from_fn(|number| 0x0200_0200 + 0x200 * number as u32),
            gccfg: 0,
            cid: PRODUCT_ID,
            dcfg: 0x0220_0000,
            address: 0,
            dctl: dctl::SDIS,
            global_in_nak: false,
            global_out_nak: false,
            out_nak_effective: false,
            diepmsk: 0,
            doepmsk: 0,
            daintmsk: 0,
            diepempmsk: 0,
            deachintmsk: 0,
            pcgcctl: 0,
            kept: KEPT.map(|(_, value)| value),
            rx: ReceiveFifo::default(),
            tx: Default::default(),
            ins: Default::default(),
            outs: Default::default(),
            ending: [false; ENDPOINTS],
            control: Control::default(),
            link: Link::default(),
            stirred: true,
            found: BTreeSet::new(),
            untold: Vec::new(),
        }
    }

    /// Resets the block by RCC, or with the whole part. The host's port, at the other end of the cable,
    /// notices only that the pull-up goes.
    pub fn reset(&mut self) {
        let fresh = Self::new();
        *self = Self {
            around: self.around,
            now_ns: self.now_ns,
            link: self.link.reset(),
            found: std::mem::take(&mut self.found),
            untold: std::mem::take(&mut self.untold),
            ..fresh
        };
    }

    /// Sets the core's surroundings.
    pub fn look_around(&mut self, around: Surroundings) {
        if self.around != around {
            self.around = around;
            self.settle();
        }
    }

    /// Sets the rate of the kernel clock.
    pub fn set_clock(&mut self, hz: u64) {
        self.look_around(Surroundings { kernel_hz: hz, ..self.around });
    }

    pub(super) fn find(&mut self, register: &'static str, reason: &'static str) {
        let finding = Finding { register, reason };
        if self.found.insert(finding) {
            self.untold.push(finding);
        }
    }

    /// Takes the findings since the last call, each of them once.
    pub fn take_findings(&mut self) -> Vec<Finding> {
        std::mem::take(&mut self.untold)
    }

    /// Carries out a read by firmware at this instant.
    pub fn read(&mut self, now_ns: u64, offset: u32) -> u32 {
        self.advance(now_ns);
        self.mind_fifo_writes(offset);
        match offset {
            GRXSTSP => self.pop_status(),
            FIFO..FIFO_END => self.read_fifo(),
            _ => {
                if !Self::exists(offset) {
                    self.find("block", "no register at this offset, RM0399 section 60.14");
                }
                self.peek(offset)
            }
        }
    }

    /// Returns a register's value and changes nothing.
    #[must_use]
    pub fn peek(&self, offset: u32) -> u32 {
        match offset {
            GOTGCTL => self.gotgctl & !gotgctl::BSVLD | if self.b_valid() { gotgctl::BSVLD } else { 0 },
            GOTGINT => self.gotgint,
            GAHBCFG => self.gahbcfg,
            GUSBCFG => self.gusbcfg,
            GRSTCTL => self.grstctl | grstctl::AHBIDL,
            GINTSTS => self.core_interrupts(),
            GINTMSK => self.gintmsk,
            GRXSTSR | GRXSTSP => self.rx.front().map_or(0, Self::status_word),
            GRXFSIZ => self.grxfsiz,
            HNPTXFSIZ => self.dieptxf[0],
            // Value for an empty request queue of the host.
            HNPTXSTS => 0x0008_0000 | self.dieptxf[0] >> 16,
            GCCFG => self.gccfg,
            CID => self.cid,
            DIEPTXF1..=0x120 => self.dieptxf[1 + ((offset - DIEPTXF1) / 4) as usize],
            DCFG => self.dcfg,
            DCTL => self.device_control(),
            DSTS => self.device_status(),
            DIEPMSK => self.diepmsk,
            DOEPMSK => self.doepmsk,
            DAINT => self.endpoint_interrupts(),
            DAINTMSK => self.daintmsk,
            DIEPEMPMSK => self.diepempmsk,
            DEACHINT => self.each_interrupt(),
            DEACHINTMSK => self.deachintmsk,
            IN..0xC20 => self.peek_endpoint(offset),
            PCGCCTL => self.pcgcctl | if self.link.is_suspended() { pcgcctl::PHYSUSP } else { 0 },
            _ => Self::kept(offset).map_or(0, |place| self.kept[place]),
        }
    }

    fn kept(offset: u32) -> Option<usize> {
        KEPT.iter().position(|&(kept, _)| kept == offset)
    }

    /// Whether the block has a register at this offset, in either mode.
    fn exists(offset: u32) -> bool {
        let in_endpoint = matches!(offset % STRIDE, CTL | INT | TSIZ | DMA | DTXFSTS);
        match offset {
            0x000..=0x02C | 0x038 | 0x03C | 0x054 | 0x100..=0x120 => true,
            HOST..DCFG => true,
            DCFG | DCTL | DSTS | 0x810..=0x81C | 0x828..=0x83C | DIEPEACHMSK1 | DOEPEACHMSK1 => true,
            IN..0xA20 => in_endpoint,
            OUT..0xC20 => in_endpoint && offset % STRIDE != DTXFSTS,
            PCGCCTL | 0xE04 => true,
            _ => false,
        }
    }

    /// Carries out a write by firmware at this instant.
    pub fn write(&mut self, now_ns: u64, offset: u32, value: u32) {
        self.advance(now_ns);
        self.mind_fifo_writes(offset);
        match offset {
            GOTGCTL => self.write_session(value),
            GOTGINT => self.gotgint &= !value,
            GAHBCFG => self.write_bus_configuration(value),
            GUSBCFG => self.write_configuration(value),
            GRSTCTL => self.write_reset(value),
            GINTSTS => self.latched &= !(value & gint::LATCHED),
            GINTMSK => self.gintmsk = value,
            GRXFSIZ => self.grxfsiz = value & 0xFFFF,
            HNPTXFSIZ => self.dieptxf[0] = value,
            GCCFG => self.gccfg = value & !gccfg::READ_ONLY,
            CID => self.cid = value,
            DIEPTXF1..=0x120 => self.dieptxf[1 + ((offset - DIEPTXF1) / 4) as usize] = value,
            DCFG => self.write_device_configuration(value),
            DCTL => self.write_device_control(value),
            DIEPMSK => self.diepmsk = value,
            DOEPMSK => self.doepmsk = value,
            DAINTMSK => self.daintmsk = value,
            DIEPEMPMSK => self.diepempmsk = value & 0xFFFF,
            DEACHINTMSK => self.deachintmsk = value,
            IN..0xC20 => self.write_endpoint(offset, value),
            PCGCCTL => self.pcgcctl = value & pcgcctl::WRITABLE,
            FIFO..FIFO_END => self.write_fifo(((offset - FIFO) / FIFO_STRIDE) as usize, value),
            HOST..DCFG => self.find("host registers", "host mode has no model: the board's socket is a device's"),
            _ => match Self::kept(offset) {
                Some(place) => self.kept[place] = value,
                None if Self::exists(offset) => {}
                None => self.find("block", "no register at this offset, RM0399 section 60.14"),
            },
        }
        // A write to a register of this list may let the core answer the host differently. The FIFOs set
        // `stirred` themselves.
        self.stirred |= match offset {
            GOTGCTL | GUSBCFG | GRSTCTL | GRXFSIZ | GCCFG | DCFG | DCTL | PCGCCTL => true,
            IN..0xC20 => matches!(offset % STRIDE, CTL | TSIZ),
            _ => false,
        };
        self.settle();
    }

    fn write_session(&mut self, value: u32) {
        let before = self.b_valid();
        self.gotgctl = value & !gotgctl::READ_ONLY | gotgctl::CIDSTS;
        match (before, self.b_valid()) {
            (false, true) => self.latched |= gint::SRQINT,
            (true, false) => self.gotgint |= gotgint::SEDET,
            _ => {}
        }
    }

    fn write_bus_configuration(&mut self, value: u32) {
        self.gahbcfg = value;
        if value & gahbcfg::DMAEN != 0 {
            self.find("GAHBCFG", "the core's DMA has no model: no endpoint moves data");
        }
    }

    fn write_configuration(&mut self, value: u32) {
        self.gusbcfg = value;
        if value & gusbcfg::FHMOD != 0 {
            self.find("GUSBCFG", "host mode has no model: the board's socket is a device's");
        }
    }

    fn write_device_configuration(&mut self, value: u32) {
        self.dcfg = value;
        // With SET_ADDRESS the new address is written before the status stage, which is still for the old one
        // (section 60.15, "Endpoint initialization on SetAddress command").
        if !self.control.open {
            self.take_address();
        }
        if value & dcfg::DSPD != dcfg::FULL_SPEED {
            self.find("DCFG", "RM0399 OTG_DCFG: the internal transceiver knows full speed alone, DSPD = 11");
        }
    }

    /// Makes the core answer to address DAD from now on.
    pub(super) const fn take_address(&mut self) {
        self.address = ((self.dcfg & dcfg::DAD) >> dcfg::DAD_SHIFT) as u8;
    }

    fn write_reset(&mut self, value: u32) {
        self.grstctl = value & grstctl::TXFNUM | self.grstctl & grstctl::CSRST;
        if value & grstctl::CSRST != 0 {
            self.grstctl |= grstctl::CSRST;
        }
        if value & grstctl::RXFFLSH != 0 {
            self.rx.flush();
        }
        if value & grstctl::TXFFLSH != 0 {
            let number = (value & grstctl::TXFNUM) >> grstctl::TXFNUM_SHIFT;
            match self.tx.get_mut(number as usize) {
                Some(fifo) => fifo.flush(),
                None if number == grstctl::ALL => self.tx.iter_mut().for_each(TransmitFifo::flush),
                None => self.find("GRSTCTL", "RM0399 OTG_GRSTCTL: TXFNUM names no FIFO"),
            }
        }
    }

    /// Carries out the core soft reset: all registers but STPPCLK and GATEHCLK, DSPD, SDIS and OTG_GCCFG, all
    /// FIFOs and all transfers (OTG_GRSTCTL, CSRST). The selection of the transceiver in OTG_GUSBCFG stays as
    /// well, or it could never be followed by this reset, which it needs.
    pub(super) fn soft_reset(&mut self) {
        let fresh = Self::new();
        *self = Self {
            around: self.around,
            now_ns: self.now_ns,
            gusbcfg: fresh.gusbcfg & !gusbcfg::KEPT | self.gusbcfg & gusbcfg::KEPT,
            gccfg: self.gccfg,
            cid: self.cid,
            dcfg: fresh.dcfg & !dcfg::DSPD | self.dcfg & dcfg::DSPD,
            dctl: self.dctl & dctl::SDIS,
            pcgcctl: self.pcgcctl,
            link: self.link.reset(),
            found: std::mem::take(&mut self.found),
            untold: std::mem::take(&mut self.untold),
            ..fresh
        };
    }

    /// Returns the part of the RAM that a transmit FIFO has.
    pub(super) fn span(&self, fifo: usize) -> Option<Span> {
        self.dieptxf.get(fifo).map(|&register| Span::of(register))
    }
}

impl Default for Core {
    fn default() -> Self {
        Self::new()
    }
}
