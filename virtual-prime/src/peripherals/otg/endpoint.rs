//! Registers of an endpoint, RM0399 section 60.14: OTG_DIEPCTLx, OTG_DOEPCTLx and those beside them.

use super::registers::{epctl, epint, tsiz};
use usb_host::wire::Toggle;

/// State of an endpoint, in either direction.
#[derive(Clone, Debug, Default)]
pub struct Endpoint {
    /// The fields of the control register that are stored: MPSIZ, USBAEP, EPTYP, STALL, TXFNUM.
    stored: u32,
    /// Whether the endpoint is enabled, EPENA.
    pub enabled: bool,
    /// Whether the endpoint answers NAK, NAKSTS.
    pub nak: bool,
    /// Data PID that is sent or expected next.
    pub toggle: Toggle,
    /// Interrupt causes that have come and were not cleared.
    pub causes: u32,
    /// Packets left of the transfer, PKTCNT.
    pub packets: u32,
    /// Bytes left of the transfer, XFRSIZ.
    pub size: u32,
    /// Top field of the transfer size register: STUPCNT, or MCNT, which is not used here.
    pub count: u32,
    /// DMA address, which is only kept.
    pub dma: u32,
}

/// Fields of a control register that are stored as they are written.
const STORED: u32 = epctl::MPSIZ | epctl::USBAEP | epctl::EPTYP | epctl::STALL | epctl::TXFNUM;
/// Stored fields of endpoint 0, which is always active and a control endpoint.
const STORED_0: u32 = 0b11 | epctl::TXFNUM;

impl Endpoint {
    /// Returns the control register's value.
    pub const fn control(&self, number: usize) -> u32 {
        let toggle = if matches!(self.toggle, Toggle::Data1) && number != 0 { epctl::DPID } else { 0 };
        let nak = if self.nak { epctl::NAKSTS } else { 0 };
        let enabled = if self.enabled { epctl::EPENA } else { 0 };
        let active = if number == 0 { epctl::USBAEP } else { 0 };
        self.stored | toggle | nak | enabled | active
    }

    /// Writes the control register: stores its fields and carries out its action bits, but for EPENA and
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

    /// Returns the transfer size register's value.
    pub const fn transfer(&self) -> u32 {
        self.count << tsiz::STUPCNT_SHIFT | self.packets << tsiz::PKTCNT_SHIFT | self.size
    }

    /// Writes the transfer size register. For endpoint 0, `packets0` is the mask of PKTCNT.
    pub const fn write_transfer(&mut self, number: usize, value: u32, packets0: u32) {
        let (packets, size) = if number == 0 { (packets0, tsiz::XFRSIZ0) } else { (tsiz::PKTCNT, tsiz::XFRSIZ) };
        self.count = value >> tsiz::STUPCNT_SHIFT & 0b11;
        self.packets = value >> tsiz::PKTCNT_SHIFT & packets;
        self.size = value & size;
    }

    /// Whether the endpoint is part of the configuration in force, USBAEP.
    pub const fn is_active(&self, number: usize) -> bool {
        number == 0 || self.stored & epctl::USBAEP != 0
    }

    /// Takes the endpoint out of the configuration, as a bus reset does with all but endpoint 0.
    pub const fn deactivate(&mut self) {
        self.stored &= !epctl::USBAEP;
    }

    /// Returns whether the endpoint answers STALL.
    pub const fn is_stalled(&self) -> bool {
        self.stored & epctl::STALL != 0
    }

    /// Starts a control transfer at a SETUP packet: NAK in both directions until firmware has dealt with it,
    /// and no STALL any more.
    pub const fn begin_control(&mut self) {
        self.stored &= !epctl::STALL;
        self.nak = true;
        self.toggle = Toggle::Data1;
    }

    /// Returns whether the endpoint is set up as an isochronous one.
    pub const fn is_isochronous(&self) -> bool {
        (self.stored & epctl::EPTYP) >> epctl::EPTYP_SHIFT == epctl::ISOCHRONOUS
    }

    /// Returns the greatest packet size, bytes.
    pub const fn max_packet(&self, number: usize) -> usize {
        if number == 0 { 64 >> (self.stored & 0b11) } else { (self.stored & epctl::MPSIZ) as usize }
    }

    /// Returns the FIFO's number, TXFNUM.
    pub const fn fifo(&self) -> usize {
        ((self.stored & epctl::TXFNUM) >> epctl::TXFNUM_SHIFT) as usize
    }

    /// Sets causes of the endpoint interrupt.
    pub const fn raise(&mut self, cause: u32) {
        self.causes |= cause;
    }

    /// Clears the causes whose bits are written as 1; TXFE follows the FIFO.
    pub const fn clear(&mut self, causes: u32) {
        self.causes &= !(causes & !epint::TXFE);
    }
}
