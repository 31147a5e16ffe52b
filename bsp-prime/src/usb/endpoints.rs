//! Endpoints of the USB core: packets both ways, and the core's events (RM0399 chapter 60, "OTG_HS
//! programming model").

use usb_device::bus::PollResult;
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

use super::registers::endpoint::{CNAK, EPDIS, EPDISD, EPENA, SD0PID, SNAK, STALL, STUP, USBAEP, XFRC};
use super::registers::event::{ENUMDNE, IEPINT, OEPINT, RXFLVL, USBRST, USBSUSP, WKUPINT};
use super::registers::{self, control, modify, read, write};
use crate::wait;

/// Endpoints each way, 0 among them (RM0399 chapter 60, OTG implementation).
pub(super) const ENDPOINTS: usize = 9;
/// The longest packet of bulk and control endpoints at full speed.
const PACKET_BYTES: usize = 64;
const PACKET_WORDS: usize = PACKET_BYTES / 4;
/// Packets of the host that an endpoint buffers until they are fetched.
const BUFFERS: usize = 2;

/// Words of the core's FIFO memory, 4 KiB.
const FIFO_WORDS: u32 = 1024;
/// The common receive FIFO. The least is 10 words for requests, one packet and its status, and one word an
/// endpoint and one besides: 10 + 17 + 5. Every endpoint may have a packet in it, and two requests with
/// theirs.
const RECEIVE_WORDS: u32 = 256;
/// FIFO words of endpoint 0, which sends one packet at a time.
const CONTROL_WORDS: u32 = 32;
/// FIFO words of a bulk endpoint: four packets, of which one is there at a time.
const BULK_WORDS: u32 = 64;
/// The least that the manual allows; the longest packet of an interrupt endpoint has 16 bytes.
const INTERRUPT_WORDS: u32 = 16;
const _: () = assert!(RECEIVE_WORDS + CONTROL_WORDS + 8 * BULK_WORDS <= FIFO_WORDS, "whatever the endpoints are");

/// Bits of the register GRSTCTL.
const RXFFLSH: u32 = 1 << 4;
const TXFFLSH: u32 = 1 << 5;
const ALL_FIFOS: u32 = 0x10 << 6;
/// Limit of a flush within the interrupt, where flushing takes some ten bus clocks.
const FLUSH_LIMIT_US: u32 = 5;

/// Most entries of the receive FIFO handled in one poll: a packet has two.
const ENTRIES_A_POLL: usize = 6;
/// More than the FIFO ever holds: a packet at each of four endpoints, three requests in a row, and their
/// ends.
const ENTRIES_AT_MOST: usize = 16;
/// Kinds of FIFO entries (GRXSTSP, PKTSTS in device mode).
const OUT_RECEIVED: u32 = 0b0010;
const SETUP_RECEIVED: u32 = 0b0110;

/// Packets of the host at one endpoint, oldest first.
struct Waiting {
    packets: [[u32; PACKET_WORDS]; BUFFERS],
    lengths: [u8; BUFFERS],
    first: u8,
    count: u8,
    /// The endpoint takes a packet.
    is_armed: bool,
    is_halted: bool,
}

impl Waiting {
    const fn new() -> Self {
        Self {
            packets: [[0; PACKET_WORDS]; BUFFERS],
            lengths: [0; BUFFERS],
            first: 0,
            count: 0,
            is_armed: false,
            is_halted: false,
        }
    }
}

/// State of the endpoints.
pub(super) struct State {
    /// Types of the endpoints to the host, as in their control registers; `None` for an endpoint that does
    /// not exist.
    to_host: [Option<u8>; ENDPOINTS],
    from_host: [Option<u8>; ENDPOINTS],
    /// Packets of endpoints 0 to 3 from the host. There are no others.
    waiting: [Waiting; 4],
    /// Last request, whether the core has yet to report its end, and whether it is to be fetched.
    setup: [u32; 2],
    is_setup_new: bool,
    has_setup: bool,
    /// Endpoints whose packet has gone, one bit each.
    complete: u16,
    /// The bus is silent. Packets that wait already are no sign of life, or `usb-device` would take the host
    /// to be back.
    is_silent: bool,
}

/// Returns the number of an endpoint's type in its control register (EPTYP).
fn kind(kind: EndpointType) -> u8 {
    kind.to_bm_attributes() & 0b11
}

/// Empties a transmit FIFO, or all of them (GRSTCTL). The core does it at once; a time-out is a core without
/// a clock.
fn flush_transmit(fifo: u32) {
    write(registers::GRSTCTL, TXFFLSH | fifo);
    let _flushed = wait::until(FLUSH_LIMIT_US, || read(registers::GRSTCTL) & TXFFLSH == 0);
}

/// Takes back what an endpoint was to send (RM0399 chapter 60, "IN endpoint disable").
fn take_back(number: usize) {
    if read(registers::diepctl(number)) & EPENA != 0 {
        control(registers::diepctl(number), 0, SNAK | EPDIS);
        let is_off = || read(registers::diepint(number)) & EPDISD != 0;
        let _disabled = wait::until(FLUSH_LIMIT_US, is_off);
        write(registers::diepint(number), EPDISD);
    }
    flush_transmit((number as u32) << 6);
}

impl State {
    pub(super) const fn new() -> Self {
        Self {
            to_host: [None; ENDPOINTS],
            from_host: [None; ENDPOINTS],
            waiting: [const { Waiting::new() }; 4],
            setup: [0; 2],
            is_setup_new: false,
            has_setup: false,
            complete: 0,
            is_silent: false,
        }
    }

    /// Configures another endpoint and returns its address.
    pub(super) fn add(
        &mut self,
        direction: UsbDirection,
        address: EndpointAddress,
        type_of: EndpointType,
        packet: u16,
    ) -> Result<()> {
        let number = address.index();
        let endpoints = if direction == UsbDirection::In { &mut self.to_host } else { &mut self.from_host };
        let place = endpoints.get_mut(number).ok_or(UsbError::EndpointOverflow)?;
        let has_buffer = direction == UsbDirection::In || number < self.waiting.len();
        if place.is_some() || !has_buffer || usize::from(packet) > PACKET_BYTES {
            return Err(UsbError::InvalidEndpoint);
        }
        *place = Some(kind(type_of));
        Ok(())
    }

    fn waiting_at(&mut self, number: usize) -> Option<&mut Waiting> {
        self.from_host.get(number).copied().flatten()?;
        self.waiting.get_mut(number)
    }

    /// Lets an endpoint take a packet, if there is a buffer for it.
    fn arm(&mut self, number: usize) {
        let Some(waiting) = self.waiting_at(number) else { return };
        if waiting.is_armed || usize::from(waiting.count) >= BUFFERS {
            return;
        }
        waiting.is_armed = true;
        // DOEPTSIZx: one packet of the longest; of endpoint 0 also three requests in a row (STUPCNT).
        let requests = if number == 0 { 0b11 << 29 } else { 0 };
        write(registers::doeptsiz(number), requests | 1 << 19 | PACKET_BYTES as u32);
        control(registers::doepctl(number), 0, CNAK | EPENA);
    }

    /// Sets every endpoint up as behind a reset of the bus (RM0399 chapter 60, "Endpoint initialization on
    /// USB reset", "Endpoint activation"). Packets that the host was told have arrived wait on for their
    /// function, but those of endpoint 0.
    pub(super) fn configure(&mut self) {
        (self.is_setup_new, self.has_setup, self.complete) = (false, false, 0);
        write(registers::DAINTMSK, 0);
        self.share_fifos();
        let mut mask = 0;
        for number in 0..ENDPOINTS {
            if let Some(kind) = self.to_host[number] {
                let active = if number == 0 { 0 } else { USBAEP | SD0PID | PACKET_BYTES as u32 };
                let fifo = (number as u32) << 22;
                write(registers::diepint(number), u32::MAX);
                control(registers::diepctl(number), STALL, active | u32::from(kind) << 18 | fifo);
                mask |= 1 << number;
            }
            if let Some(kind) = self.from_host[number] {
                if let Some(waiting) = self.waiting.get_mut(number) {
                    (waiting.is_armed, waiting.is_halted) = (false, false);
                    if number == 0 {
                        waiting.count = 0;
                    }
                }
                let active = if number == 0 { 0 } else { USBAEP | SD0PID | PACKET_BYTES as u32 };
                write(registers::doepint(number), u32::MAX);
                control(registers::doepctl(number), STALL, active | u32::from(kind) << 18);
                mask |= 1 << (16 + number);
                self.arm(number);
            }
        }
        write(registers::DAINTMSK, mask);
    }

    /// Divides the FIFO memory (RM0399 chapter 60, "FIFO RAM allocation").
    fn share_fifos(&self) {
        write(registers::GRXFSIZ, RECEIVE_WORDS);
        write(registers::DIEPTXF0, CONTROL_WORDS << 16 | RECEIVE_WORDS);
        let mut place = RECEIVE_WORDS + CONTROL_WORDS;
        for (number, kind) in self.to_host.iter().enumerate().skip(1) {
            let words = match kind {
                Some(0b11) => INTERRUPT_WORDS,
                Some(_) => BULK_WORDS,
                None => continue,
            };
            write(registers::dieptxf(number), words << 16 | place);
            place += words;
        }
        flush_transmit(ALL_FIFOS);
        write(registers::GRSTCTL, RXFFLSH);
        let _flushed = wait::until(FLUSH_LIMIT_US, || read(registers::GRSTCTL) & RXFFLSH == 0);
    }

    /// Stops all endpoints, as the bus is reset.
    fn stop(&mut self) {
        for number in 0..ENDPOINTS {
            if self.to_host[number].is_some() {
                control(registers::diepctl(number), STALL, 0);
                take_back(number);
            }
            if self.from_host[number].is_some() {
                control(registers::doepctl(number), STALL, SNAK);
            }
        }
        // DCFG: DAD, the address.
        modify(registers::DCFG, 0x7F << 4, 0);
    }

    /// Fetches entries that the core has received, so many at most.
    fn receive(&mut self, entries: usize) {
        for _ in 0..entries {
            if read(registers::GINTSTS) & RXFLVL == 0 {
                return;
            }
            // GRXSTSP: EPNUM, BCNT, PKTSTS.
            let entry = read(registers::GRXSTSP);
            let (number, bytes, what) = (entry as usize & 0xF, (entry >> 4) & 0x7FF, (entry >> 17) & 0xF);
            match what {
                SETUP_RECEIVED => {
                    self.setup = [registers::receive(), registers::receive()];
                    (self.is_setup_new, self.has_setup) = (true, false);
                    // Data of the previous request, still to send or received, are of no use any more.
                    if read(registers::diepctl(0)) & EPENA != 0 {
                        take_back(0);
                    }
                    self.complete &= !1;
                    self.waiting[0].count = 0;
                }
                OUT_RECEIVED => self.take_packet(number, bytes as usize),
                // End of a transfer or request, which also comes as an event of the endpoint.
                _ => {}
            }
        }
    }

    fn take_packet(&mut self, number: usize, bytes: usize) {
        let words = bytes.div_ceil(4);
        let place = self
            .waiting_at(number)
            .filter(|waiting| bytes <= PACKET_BYTES && usize::from(waiting.count) < BUFFERS && !waiting.is_halted);
        let Some(waiting) = place else {
            // Packet for no endpoint; taken all the same, so that the entries behind it are reached.
            (0..words).for_each(|_| {
                registers::receive();
            });
            return;
        };
        let index = (usize::from(waiting.first) + usize::from(waiting.count)) % BUFFERS;
        for word in waiting.packets[index].iter_mut().take(words) {
            *word = registers::receive();
        }
        waiting.lengths[index] = bytes as u8;
        waiting.count += 1;
    }

    /// Handles the events of the endpoints.
    fn serve_endpoints(&mut self) {
        let events = read(registers::DAINT) & read(registers::DAINTMSK);
        for number in 0..ENDPOINTS {
            if events & (1 << number) != 0 && read(registers::diepint(number)) & XFRC != 0 {
                write(registers::diepint(number), XFRC);
                self.complete |= 1 << number;
            }
            if events & (1 << (16 + number)) != 0 {
                let what = read(registers::doepint(number));
                write(registers::doepint(number), what);
                if what & (XFRC | STUP) != 0 {
                    if let Some(waiting) = self.waiting_at(number) {
                        waiting.is_armed = false;
                    }
                    self.arm(number);
                }
                // Of several requests in a row the last one counts, once.
                self.has_setup |= what & STUP != 0 && core::mem::take(&mut self.is_setup_new);
            }
        }
    }

    pub(super) fn poll(&mut self) -> PollResult {
        let events = read(registers::GINTSTS);
        if events & USBRST != 0 {
            write(registers::GINTSTS, USBRST | ENUMDNE | USBSUSP | WKUPINT);
            self.is_silent = false;
            self.receive(ENTRIES_AT_MOST);
            self.stop();
            return PollResult::Reset;
        }
        if events & ENUMDNE != 0 {
            write(registers::GINTSTS, ENUMDNE);
            // DCTL bit CGINAK: clears the global NAK for IN endpoints.
            modify(registers::DCTL, 0, 1 << 8);
        }
        if events & WKUPINT != 0 {
            write(registers::GINTSTS, WKUPINT);
            self.is_silent = false;
            return PollResult::Resume;
        }
        if events & USBSUSP != 0 {
            write(registers::GINTSTS, USBSUSP);
            self.receive(ENTRIES_AT_MOST);
            self.serve_endpoints();
            self.is_silent = true;
            return PollResult::Suspend;
        }
        // Packets from before the silence have been taken: anything new is a sign of life.
        self.is_silent &= events & (RXFLVL | IEPINT | OEPINT) == 0;
        self.receive(ENTRIES_A_POLL);
        self.serve_endpoints();
        if self.is_silent {
            return PollResult::None;
        }
        let mut from_host = 0;
        for (number, waiting) in self.waiting.iter().enumerate() {
            from_host |= u16::from(waiting.count > 0) << number;
        }
        let (ep_setup, ep_in_complete) = (u16::from(self.has_setup), core::mem::take(&mut self.complete));
        if from_host | ep_setup | ep_in_complete == 0 {
            return PollResult::None;
        }
        PollResult::Data { ep_out: from_host, ep_in_complete, ep_setup }
    }

    // Inlined like its caller.
    #[inline]
    pub(super) fn send(&mut self, number: usize, packet: &[u8]) -> Result<usize> {
        self.to_host.get(number).copied().flatten().ok_or(UsbError::InvalidEndpoint)?;
        let at = registers::diepctl(number);
        if packet.len() > PACKET_BYTES {
            return Err(UsbError::BufferOverflow);
        }
        let words = packet.len().div_ceil(4) as u32;
        if read(at) & (EPENA | STALL) != 0 || read(registers::dtxfsts(number)) & 0xFFFF < words {
            return Err(UsbError::WouldBlock);
        }
        // DIEPTSIZx: one packet of this length.
        write(registers::dieptsiz(number), 1 << 19 | packet.len() as u32);
        control(at, 0, CNAK | EPENA);
        for bytes in packet.chunks(4) {
            let mut word = [0; 4];
            word.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
            registers::transmit(number, u32::from_le_bytes(word));
        }
        Ok(packet.len())
    }

    pub(super) fn fetch(&mut self, number: usize, into: &mut [u8]) -> Result<usize> {
        if number == 0 && core::mem::take(&mut self.has_setup) {
            return copy(&self.setup, 8, into);
        }
        let waiting = self.waiting_at(number).ok_or(UsbError::InvalidEndpoint)?;
        if waiting.count == 0 {
            return Err(UsbError::WouldBlock);
        }
        let index = usize::from(waiting.first) % BUFFERS;
        let result = copy(&waiting.packets[index], waiting.lengths[index].into(), into);
        waiting.first = (index as u8 + 1) % BUFFERS as u8;
        waiting.count -= 1;
        self.arm(number);
        result
    }

    /// Packets that wait at an endpoint to be fetched.
    pub(super) fn held(&self, number: usize) -> usize {
        self.waiting.get(number).map_or(0, |waiting| waiting.count.into())
    }

    pub(super) fn halt(&mut self, address: EndpointAddress, halted: bool) {
        let number = address.index();
        if address.is_in() {
            if self.to_host.get(number).copied().flatten().is_none() {
                return;
            }
            let at = registers::diepctl(number);
            match (halted, number) {
                // The core ends it with the next request.
                (false, 0) => {}
                (true, 0) => control(at, 0, STALL),
                (true, _) => {
                    take_back(number);
                    control(at, 0, STALL);
                }
                (false, _) => {
                    take_back(number);
                    self.complete &= !(1 << number);
                    control(at, STALL, SD0PID);
                }
            }
            return;
        }
        let Some(waiting) = self.waiting_at(number) else { return };
        let at = registers::doepctl(number);
        if number > 0 {
            waiting.is_halted = halted;
            // The end of a halt sets the toggle back, and takes nothing from what has arrived.
            if halted {
                waiting.count = 0;
            }
        }
        match (halted, number) {
            (false, 0) => {}
            (true, _) => control(at, 0, STALL),
            (false, _) => {
                control(at, STALL, SD0PID);
                self.arm(number);
            }
        }
    }
}

/// Copies so many bytes of a packet.
fn copy(words: &[u32], length: usize, into: &mut [u8]) -> Result<usize> {
    let place = into.get_mut(..length).ok_or(UsbError::BufferOverflow)?;
    for (bytes, word) in place.chunks_mut(4).zip(words) {
        bytes.iter_mut().zip(word.to_le_bytes()).for_each(|(place, byte)| *place = byte);
    }
    Ok(length)
}
