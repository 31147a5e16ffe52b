//! An endpoint's registers, RM0399 section 60.14: OTG_DIEPCTLx, OTG_DOEPCTLx and those beside them.

use super::registers::{epctl, epint, tsiz};
use crate::usb_host::wire::Toggle;

/// What an endpoint has in both directions.
#[derive(Clone, Debug, Default)]
pub struct Endpoint {
    /// The fields of the control register that are stored: MPSIZ, USBAEP, EPTYP, STALL, TXFNUM.
    stored: u32,
    /// EPENA.
    pub enabled: bool,
    /// NAKSTS.
    pub nak: bool,
    /// The data PID that is sent or expected next.
    pub toggle: Toggle,
    /// Causes of an interrupt that have come and were not cleared.
    pub causes: u32,
    /// PKTCNT.
    pub packets: u32,
    /// XFRSIZ.
    pub size: u32,
    /// The top field of the transfer size register: STUPCNT, or MCNT, which means nothing here.
    pub count: u32,
    /// The DMA address, which is only kept.
    pub dma: u32,
}

/// Fields of a control register that are stored as they are written.
const STORED: u32 = epctl::MPSIZ | epctl::USBAEP | epctl::EPTYP | epctl::STALL | epctl::TXFNUM;
/// The same of endpoint 0, which is always active and a control endpoint.
const STORED_0: u32 = 0b11 | epctl::TXFNUM;

impl Endpoint {
    /// The control register.
    pub const fn control(&self, number: usize) -> u32 {
        let toggle = if matches!(self.toggle, Toggle::Data1) && number != 0 { epctl::DPID } else { 0 };
        let nak = if self.nak { epctl::NAKSTS } else { 0 };
        let enabled = if self.enabled { epctl::EPENA } else { 0 };
        let active = if number == 0 { epctl::USBAEP } else { 0 };
        self.stored | toggle | nak | enabled | active
    }

    /// Stores what a write of the control register leaves, and does what its bits ask for, but for EPENA and
    /// EPDIS.
    pub const fn write_control(&mut self, number: usize, value: u32) {
        if number == 0 {
            // The core alone clears STALL of a control endpoint, when a SETUP comes.
            self.stored = value & STORED_0 | (self.stored | value) & epctl::STALL;
        } else {
            self.stored = value & STORED;
            if value & epctl::SD0PID != 0 {
                self.toggle = Toggle::Data0;
            } else if value & epctl::SD1PID != 0 {
                self.toggle = Toggle::Data1;
            }
        }
        if value & epctl::SNAK != 0 {
            self.nak = true;
        } else if value & epctl::CNAK != 0 {
            self.nak = false;
        }
    }

    /// The transfer size register.
    pub const fn transfer(&self) -> u32 {
        self.count << tsiz::STUPCNT_SHIFT | self.packets << tsiz::PKTCNT_SHIFT | self.size
    }

    /// Of an endpoint 0, `packets` says how many bits PKTCNT has.
    pub const fn write_transfer(&mut self, number: usize, value: u32, packets0: u32) {
        let (packets, size) = if number == 0 { (packets0, tsiz::XFRSIZ0) } else { (tsiz::PKTCNT, tsiz::XFRSIZ) };
        self.count = value >> tsiz::STUPCNT_SHIFT & 0b11;
        self.packets = value >> tsiz::PKTCNT_SHIFT & packets;
        self.size = value & size;
    }

    /// USBAEP: part of the configuration in force.
    pub const fn is_active(&self, number: usize) -> bool {
        number == 0 || self.stored & epctl::USBAEP != 0
    }

    /// A bus reset takes every endpoint but endpoint 0 out of the configuration.
    pub const fn deactivate(&mut self) {
        self.stored &= !epctl::USBAEP;
    }

    pub const fn is_stalled(&self) -> bool {
        self.stored & epctl::STALL != 0
    }

    /// A SETUP packet: NAK in both directions until firmware has dealt with it, and no stall any more.
    pub const fn begin_control(&mut self) {
        self.stored &= !epctl::STALL;
        self.nak = true;
        self.toggle = Toggle::Data1;
    }

    pub const fn is_isochronous(&self) -> bool {
        (self.stored & epctl::EPTYP) >> epctl::EPTYP_SHIFT == epctl::ISOCHRONOUS
    }

    /// Most bytes of a packet.
    pub const fn max_packet(&self, number: usize) -> usize {
        if number == 0 { 64 >> (self.stored & 0b11) } else { (self.stored & epctl::MPSIZ) as usize }
    }

    /// TXFNUM.
    pub const fn fifo(&self) -> usize {
        ((self.stored & epctl::TXFNUM) >> epctl::TXFNUM_SHIFT) as usize
    }

    pub const fn raise(&mut self, cause: u32) {
        self.causes |= cause;
    }

    /// Writing one clears a cause; TXFE follows the FIFO.
    pub const fn clear(&mut self, causes: u32) {
        self.causes &= !(causes & !epint::TXFE);
    }
}
