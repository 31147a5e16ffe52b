//! State of the core.

use std::collections::BTreeSet;

use super::endpoint::Endpoint;
use super::fifo::{ReceiveFifo, Span, TransmitFifo};
use super::line::Link;
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

    /// Returns the place of a register that is only stored.
    pub(super) fn place_of_kept(offset: u32) -> Option<usize> {
        KEPT.iter().position(|&(kept, _)| kept == offset)
    }

    /// Returns a register that is only stored; 0 for any other.
    pub(super) fn kept(&self, offset: u32) -> u32 {
        Self::place_of_kept(offset).map_or(0, |place| self.kept[place])
    }

    /// Makes the core answer to address DAD from now on.
    pub(super) const fn take_address(&mut self) {
        self.address = ((self.dcfg & dcfg::DAD) >> dcfg::DAD_SHIFT) as u8;
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
