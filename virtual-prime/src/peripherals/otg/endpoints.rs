//! Firmware's side of the endpoints: their registers and FIFOs.

use super::core::Core;
use super::fifo::{Entry, RAM_WORDS, ReceiveFifo, Span, words};
use super::registers::*;
use usb_host::wire::Toggle;

/// Least depth of a FIFO, by OTG_GRXFSIZ and OTG_DIEPTXFx, words.
const LEAST_WORDS: u32 = 16;

/// Splits the offset of an endpoint's register: whether IN, the endpoint, the register within it.
const fn place(offset: u32) -> (bool, usize, u32) {
    let is_in = offset < OUT;
    let base = if is_in { IN } else { OUT };
    (is_in, ((offset - base) / STRIDE) as usize, offset % STRIDE)
}

impl Core {
    pub(super) fn peek_endpoint(&self, offset: u32) -> u32 {
        let (is_in, number, register) = place(offset);
        let endpoints = if is_in { &self.ins } else { &self.outs };
        let Some(endpoint) = endpoints.get(number) else { return 0 };
        match register {
            // The packet size of endpoint 0 is set for both directions in OTG_DIEPCTL0.
            CTL if !is_in && number == 0 => endpoint.control(0) & !0b11 | self.ins[0].control(0) & 0b11,
            CTL => endpoint.control(number),
            INT if is_in => self.in_causes(number),
            INT => endpoint.causes,
            TSIZ => endpoint.transfer(),
            DMA => endpoint.dma,
            DTXFSTS if is_in => self.fifo_room(number),
            _ => 0,
        }
    }

    pub(super) fn write_endpoint(&mut self, offset: u32, value: u32) {
        let (is_in, number, register) = place(offset);
        if number >= ENDPOINTS {
            self.find("block", "no register at this offset, RM0399 section 60.14");
            return;
        }
        let packets0 = if is_in { tsiz::PKTCNT0 } else { 1 };
        let endpoint = if is_in { &mut self.ins[number] } else { &mut self.outs[number] };
        match register {
            CTL if is_in => self.write_in_control(number, value),
            CTL => self.write_out_control(number, value),
            INT => endpoint.clear(value),
            TSIZ => endpoint.write_transfer(number, value, packets0),
            DMA => endpoint.dma = value,
            _ => {}
        }
    }

    fn write_in_control(&mut self, number: usize, value: u32) {
        let endpoint = &mut self.ins[number];
        endpoint.write_control(number, value);
        if value & epctl::SNAK != 0 {
            endpoint.raise(epint::INEPNE);
        } else if value & epctl::CNAK != 0 {
            endpoint.clear(epint::INEPNE);
        }
        if value & epctl::EPDIS != 0 && endpoint.enabled {
            endpoint.enabled = false;
            endpoint.raise(epint::EPDISD);
        } else if value & epctl::EPENA != 0 {
            endpoint.enabled = true;
            self.mind_isochronous(true, number);
            self.mind_transmit_fifo(number);
        }
    }

    fn write_out_control(&mut self, number: usize, value: u32) {
        let endpoint = &mut self.outs[number];
        endpoint.write_control(number, value);
        // The core disables an OUT endpoint under the global OUT NAK alone, and never endpoint 0 (section
        // 60.15, "Disabling an OUT endpoint"; OTG_DOEPCTL0).
        if value & epctl::EPDIS != 0 && endpoint.enabled && self.out_nak_effective && number != 0 {
            endpoint.enabled = false;
            endpoint.raise(epint::EPDISD);
        } else if value & epctl::EPENA != 0 {
            endpoint.enabled = true;
            // Firmware may still have to pop the end of the last transfer, which is not the end of the new
            // one.
            self.ending[number] = false;
            self.mind_isochronous(false, number);
            if self.grxfsiz > RAM_WORDS {
                self.find("GRXFSIZ", "the receive FIFO is larger than the core's 4 KB of RAM");
            }
        }
    }

    fn mind_isochronous(&mut self, is_in: bool, number: usize) {
        let endpoints = if is_in { &self.ins } else { &self.outs };
        if number != 0 && endpoints[number].is_isochronous() {
            let register = if is_in { "DIEPCTLx" } else { "DOEPCTLx" };
            self.find(register, "isochronous endpoints have no model");
        }
    }

    /// Checks that the FIFO of an IN endpoint that begins to send is a part of the RAM with no other user.
    fn mind_transmit_fifo(&mut self, number: usize) {
        let fifo = self.ins[number].fifo();
        if number == 0 && fifo != 0 {
            self.find("DIEPCTL0", "RM0399 OTG_DIEPCTL0: endpoint 0 uses FIFO 0");
        }
        let Some(span) = self.span(fifo) else {
            self.find("DIEPCTLx", "TXFNUM names a FIFO that is not there");
            return;
        };
        if !span.fits() {
            self.find("DIEPTXFx", "the FIFO ends beyond the core's 4 KB of RAM");
        }
        if span.depth < LEAST_WORDS {
            self.find("DIEPTXFx", "RM0399 OTG_DIEPTXFx: a FIFO has at least 16 words");
        }
        let others = (0..ENDPOINTS)
            .filter(|&other| other != number && self.ins[other].is_active(other))
            .map(|other| self.ins[other].fifo())
            .filter(|&other| other != fifo)
            .filter_map(|other| self.span(other));
        let receive = Span { start: 0, depth: self.grxfsiz };
        if others.chain([receive]).any(|other| span.overlaps(other)) {
            self.find("DIEPTXFx", "the FIFO shares RAM with another one in use");
        }
    }

    /// Returns OTG_DTXFSTSx: free words of the endpoint's FIFO.
    fn fifo_room(&self, number: usize) -> u32 {
        let fifo = self.ins[number].fifo();
        match (self.span(fifo), self.tx.get(fifo)) {
            (Some(span), Some(held)) => span.depth.saturating_sub(held.held()),
            _ => 0,
        }
    }

    /// Checks an access to an endpoint's registers while a packet is half written to a transmit FIFO: the
    /// next word of the packet would be corrupted.
    pub(super) fn mind_fifo_writes(&mut self, offset: u32) {
        if (IN..0xC20).contains(&offset) && self.tx.iter().any(super::fifo::TransmitFifo::is_midway) {
            self.find(
                "FIFO",
                "erratum: an endpoint's register was accessed between two words of a packet for a transmit FIFO, \
                 which corrupts the next word (ES0445, OTG_HS)",
            );
        }
    }

    /// Writes a word into the FIFO of an IN endpoint.
    pub(super) fn write_fifo(&mut self, number: usize, word: u32) {
        let endpoint = &self.ins[number];
        let (fifo, length) = (endpoint.fifo(), endpoint.max_packet(number).min(endpoint.size as usize));
        let Some(depth) = self.span(fifo).map(|span| span.depth) else { return };
        let Some(packets) = self.tx.get_mut(fifo) else { return };
        if length == 0 && !packets.is_midway() {
            self.find("FIFO", "RM0399 section 60.15: data for a transmit FIFO before OTG_DIEPTSIZx asks for any");
            return;
        }
        if packets.held() >= depth {
            self.find("FIFO", "more words for a transmit FIFO than it has room for");
            return;
        }
        // XFRSIZ falls as packets enter the FIFO (OTG_DIEPTSIZx).
        if let Some(bytes) = packets.write(word, length) {
            self.ins[number].size -= bytes as u32;
            self.stirred = true;
        }
    }

    /// Encodes an entry for OTG_GRXSTSP and OTG_GRXSTSR.
    pub(super) fn status_word(entry: &Entry) -> u32 {
        u32::from(entry.endpoint)
            | (entry.data.len() as u32) << rxsts::BCNT_SHIFT
            | entry.pid << rxsts::DPID_SHIFT
            | entry.status << rxsts::PKTSTS_SHIFT
            | u32::from(entry.frame & 0xF) << rxsts::FRMNUM_SHIFT
    }

    /// Pops an entry by OTG_GRXSTSP, with all effects of that.
    pub(super) fn pop_status(&mut self) -> u32 {
        let Some((entry, left)) = self.rx.pop() else { return 0 };
        if left {
            self.find("GRXSTSP", "RM0399 section 60.15: popped before the data of the last packet were read");
        }
        let number = usize::from(entry.endpoint);
        match entry.status {
            rxsts::GLOBAL_OUT_NAK => self.out_nak_effective = true,
            rxsts::OUT_DATA => {
                let endpoint = &mut self.outs[number];
                endpoint.size = endpoint.size.saturating_sub(entry.data.len() as u32);
            }
            rxsts::OUT_DONE => self.end_out(number, epint::XFRC),
            rxsts::SETUP_DONE => self.end_out(number, epint::STUP),
            _ => {}
        }
        self.stirred = true;
        Self::status_word(&entry)
    }

    /// Ends an OUT transfer: the endpoint is disabled before the cause is raised, unless firmware has enabled
    /// it again already.
    fn end_out(&mut self, number: usize, cause: u32) {
        if std::mem::take(&mut self.ending[number]) {
            self.outs[number].enabled = false;
        }
        self.outs[number].raise(cause);
    }

    /// Reads a word of the packet that was popped. Any FIFO address reads the receive FIFO.
    pub(super) fn read_fifo(&mut self) -> u32 {
        self.stirred = true;
        self.rx.word().unwrap_or_else(|| {
            self.find("FIFO", "read beyond the data of the packet that was popped");
            0
        })
    }

    /// Whether an OUT packet of this size can be received.
    pub(super) fn can_receive(&mut self, bytes: usize) -> bool {
        let active = (0..ENDPOINTS).filter(|&number| self.outs[number].is_active(number)).count() as u32;
        if self.grxfsiz < 1 + words(bytes) + ReceiveFifo::reserved(active) {
            self.find("GRXFSIZ", "RM0399 section 60.11.3: the receive FIFO is too small for a packet that came");
        }
        self.rx.has_room(bytes, self.grxfsiz, active)
    }

    /// Puts an entry into the receive FIFO.
    pub(super) fn receive(&mut self, status: u32, number: usize, toggle: Toggle, data: &[u8]) {
        let pid = if toggle == Toggle::Data1 { rxsts::DATA1 } else { 0 };
        let entry = Entry { status, endpoint: number as u8, pid, frame: self.link.frame(), data: data.to_vec() };
        self.rx.push(entry);
    }
}
