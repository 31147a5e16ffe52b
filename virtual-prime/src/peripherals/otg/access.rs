//! The core's registers, as firmware reads and writes them.

use super::core::Core;
use super::fifo::TransmitFifo;
use super::registers::*;

impl Core {
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
            _ => self.kept(offset),
        }
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
            _ => match Self::place_of_kept(offset) {
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
}
