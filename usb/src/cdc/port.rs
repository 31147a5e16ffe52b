//! A serial port.
//!
//! Both directions hold their sender back. A packet of the host is only fetched when the line has room for
//! it; until then the endpoint answers NAK and the host waits. A packet for the host is taken from the line
//! when the one before has gone.
//!
//! Somebody is there from the moment a host sets DTR, or, of a host that never does, from its first byte on;
//! until DTR falls, the bus is reset, or it falls silent: an unplugged cable is a silent bus on this board,
//! which has no way to look at the bus voltage. After a silence without a reset (a computer that has slept)
//! whoever was there is there again.
//!
//! Whatever a host was told has arrived reaches the line, as his, when there is room for it, though he has
//! gone by then and others have come and gone behind him (`for line in ...; do echo $line > /dev/ttyACM0`
//! does that): whoever comes is met when all that those before him have left in the controller is fetched.

use usb_device::Result;
use usb_device::bus::{InterfaceNumber, StringIndex};
use usb_device::class_prelude::{
    ControlIn, ControlOut, DescriptorWriter, EndpointIn, EndpointType, UsbBus, UsbBusAllocator, UsbClass,
};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::lang_id::LangID;
use usb_device::device::DEFAULT_ALTERNATE_SETTING;
use usb_device::endpoint::EndpointAddress;
use usbd_serial::CdcAcmClass;

use super::coding::{self, LineCoding};
use super::guard::{NOTIFICATION_INTERVAL, NOTIFICATION_PACKET, Numbers};
use crate::standard;
use crate::{PACKET_BYTES, PACKETS_HELD};

/// What a port is connected to.
pub trait Line {
    /// How many more bytes surely fit.
    fn room(&self) -> usize;

    /// Takes bytes of the host, a packet at most, for which there was room. Those of somebody who has gone
    /// may come when that has been said.
    fn receive(&mut self, bytes: &[u8]);

    /// Fetches bytes for the host; how many there were.
    fn fetch(&mut self, into: &mut [u8]) -> usize;

    /// Somebody has come to the other end, or gone. Bytes for the one who has gone are dropped.
    fn set_open(&mut self, open: bool);

    /// Whoever has gone is there again, and goes on with what he was sending, in the middle of a line
    /// perhaps.
    fn come_back(&mut self);
}

/// Requests (PSTN 1.2, table 13).
const SET_LINE_CODING: u8 = 0x20;
const GET_LINE_CODING: u8 = 0x21;
const SET_CONTROL_LINE_STATE: u8 = 0x22;

/// Notification SERIAL_STATE (PSTN 1.2, section 6.5.4): carrier and data set ready. They are always there; a
/// program that waits for a carrier when it opens a port goes on.
const SERIAL_STATE_BYTES: usize = 10;
const DCD_AND_DSR: u8 = 0b11;

/// Visits that may have ended behind different packets in the controller, or before the first.
const ENDS: usize = PACKETS_HELD + 1;

/// The end of a visit.
#[derive(Clone, Copy)]
struct End {
    /// Packets in the controller that are still his, or of those before him.
    packets: u8,
    /// He has come back since then: whoever is met next is he.
    is_undone: bool,
}

/// A serial port over a line.
pub struct SerialPort<'a, B: UsbBus, L> {
    class: CdcAcmClass<'a, B>,
    /// The interface for its requests.
    control: u8,
    notify: EndpointIn<'a, B>,
    line: L,
    /// What the host has set it to, which the class forgets when the bus is reset.
    coding: LineCoding,
    /// Whoever was there let DTR fall. What comes behind that may still be his: a computer that gives up on
    /// what it has not sent takes it back when it has let DTR fall.
    dtr_fell: bool,
    is_open: bool,
    is_configured: bool,
    is_suspended: bool,
    /// Somebody was there when the bus fell silent.
    may_come_back: bool,
    /// Whoever was there goes, which is seen to in this run.
    goes: bool,
    /// Visits that have ended, and of which packets are still to be fetched, in order.
    ends: heapless::Vec<End, ENDS>,
    /// A packet that the endpoint has not taken yet.
    packet: heapless::Vec<u8, PACKET_BYTES>,
    /// The last packet was full: an empty one says that nothing follows, so that a host does not wait.
    owes_end: bool,
    owes_notification: bool,
}

impl<'a, B: UsbBus, L: Line> SerialPort<'a, B, L> {
    /// A port with these numbers, at a [`crate::Guarded`] bus that has made those before it.
    ///
    /// # Errors
    /// The bus does not have the endpoint for notifications.
    ///
    /// # Panics
    /// It does not have the others.
    pub fn new(bus: &'a UsbBusAllocator<B>, numbers: Numbers, name: &'static str, line: L) -> Result<Self> {
        let (notify, kind) = (Some(numbers.notify.into()), EndpointType::Interrupt);
        Ok(Self {
            class: CdcAcmClass::new_with_interface_names(bus, PACKET_BYTES as u16, Some(name), None),
            control: numbers.control,
            notify: bus.alloc(notify, kind, NOTIFICATION_PACKET.into(), NOTIFICATION_INTERVAL)?,
            line,
            coding: coding::DEFAULT,
            dtr_fell: false,
            is_open: false,
            is_configured: false,
            is_suspended: false,
            may_come_back: false,
            goes: false,
            ends: heapless::Vec::new(),
            packet: heapless::Vec::new(),
            owes_end: false,
            owes_notification: false,
        })
    }

    /// What it is connected to.
    pub const fn line(&mut self) -> &mut L {
        &mut self.line
    }

    /// The endpoint at which packets of the host arrive.
    #[must_use]
    pub fn from_host(&self) -> EndpointAddress {
        self.class.read_ep().address()
    }

    /// Moves what can be moved, a packet each way, so that a run is bounded; all that somebody has left when
    /// he goes. `held`: packets of the host that the controller holds. True when there is room for one more
    /// of them.
    pub fn run(&mut self, held: usize) -> bool {
        if core::mem::take(&mut self.goes) {
            self.end_visit(held);
            self.meet();
        }
        let has_more = self.receive() && held > 1 && self.line.room() >= PACKET_BYTES;
        if self.can_talk() {
            self.send();
            self.tell_state();
        }
        has_more
    }

    const fn can_talk(&self) -> bool {
        self.is_configured && !self.is_suspended
    }

    /// The bus has fallen silent, or is back.
    pub fn set_suspended(&mut self, suspended: bool) {
        if self.is_suspended == suspended {
            return;
        }
        self.is_suspended = suspended;
        if suspended {
            self.may_come_back = self.is_configured && self.has_somebody();
            self.goes |= self.is_configured;
        } else if core::mem::take(&mut self.may_come_back) {
            match self.ends.last_mut() {
                Some(end) => end.is_undone = true,
                None => self.open(true),
            }
        }
    }

    /// Whether somebody is there, met or not.
    fn has_somebody(&self) -> bool {
        match self.ends.last() {
            Some(end) => end.is_undone || self.class.dtr(),
            None => self.is_open,
        }
    }

    fn set_open(&mut self, open: bool) {
        if self.is_open == open {
            return;
        }
        self.is_open = open;
        self.packet.clear();
        self.owes_end = false;
        self.line.set_open(open);
    }

    fn open(&mut self, is_back: bool) {
        if is_back && !self.is_open {
            self.is_open = true;
            self.line.come_back();
        }
        self.set_open(true);
    }

    /// Whoever is there goes. What he has sent is his: it is fetched now as far as there is room, else later.
    fn end_visit(&mut self, held: usize) {
        let mut packets = held as u8;
        if self.ends.is_empty() {
            while packets > 0 && self.line.room() >= PACKET_BYTES && self.receive_packet() {
                packets -= 1;
            }
            if packets > 0 {
                // He may not have been met: nothing of his had been fetched.
                self.set_open(true);
            }
            self.set_open(false);
        }
        match self.ends.last_mut() {
            // He has left nothing.
            Some(end) if end.packets == packets => end.is_undone = false,
            None if packets == 0 => {}
            _ => {
                // There are no more places behind packets than this has.
                let _fits = self.ends.push(End { packets, is_undone: false });
            }
        }
    }

    /// Sees to visits that ended before the next packet.
    fn turn_to_next(&mut self) {
        while let Some(&End { packets: 0, is_undone }) = self.ends.first() {
            self.ends.remove(0);
            self.set_open(false);
            if !self.ends.is_empty() || is_undone && self.can_talk() {
                // One who has come back, or one who is gone as well and has left something.
                self.open(is_undone);
            }
            self.meet();
        }
    }

    /// Meets whoever has come, when all that was left by those before him is fetched.
    fn meet(&mut self) {
        if self.class.dtr() && self.can_talk() && !self.goes && self.ends.is_empty() {
            self.set_open(true);
        }
    }

    /// Fetches a packet, if one is wanted and there is room for it. Whether it has.
    fn receive(&mut self) -> bool {
        let is_wanted = self.can_talk() || !self.ends.is_empty();
        is_wanted && self.line.room() >= PACKET_BYTES && self.receive_packet()
    }

    /// Fetches a packet of the host, if there is one.
    fn receive_packet(&mut self) -> bool {
        let mut packet = [0; PACKET_BYTES];
        let read = self.class.read_packet(&mut packet);
        let bytes = packet.get(..*read.as_ref().unwrap_or(&0)).unwrap_or_default();
        if !bytes.is_empty() {
            if self.ends.is_empty() {
                self.open(self.dtr_fell);
            }
            self.line.receive(bytes);
        }
        // Without a packet there is none of theirs either: the host has halted the endpoint.
        let left = |packets: u8| if read.is_ok() { packets.saturating_sub(1) } else { 0 };
        self.ends.iter_mut().for_each(|end| end.packets = left(end.packets));
        self.turn_to_next();
        read.is_ok()
    }

    fn send(&mut self) {
        if !self.is_open {
            return;
        }
        if !self.ends.is_empty() {
            // For one who has gone.
            while self.line.fetch(&mut [0; PACKET_BYTES]) > 0 {}
            return;
        }
        if self.packet.is_empty() {
            let mut bytes = [0; PACKET_BYTES];
            let count = self.line.fetch(&mut bytes);
            // It has room for all of them.
            let _fits = self.packet.extend_from_slice(bytes.get(..count).unwrap_or_default());
        }
        if (!self.packet.is_empty() || self.owes_end) && self.class.write_packet(&self.packet).is_ok() {
            self.owes_end = self.packet.is_full();
            self.packet.clear();
        }
    }

    fn tell_state(&mut self) {
        if self.owes_notification {
            let state: [u8; SERIAL_STATE_BYTES] = [0xA1, 0x20, 0, 0, self.control, 0, 2, 0, DCD_AND_DSR, 0];
            self.owes_notification = self.notify.write(&state).is_err();
        }
    }

    /// Everything as behind a reset of the bus; what the host has set stays.
    fn begin_anew(&mut self, configured: bool) {
        self.goes |= self.is_configured;
        self.class.reset();
        self.dtr_fell = false;
        self.is_suspended = false;
        self.is_configured = configured;
        self.owes_notification = configured;
    }

    /// DTR has risen or fallen. Not where a host that never sets it sets RTS: that one has not gone.
    fn dtr_changed(&mut self) {
        let dtr = self.class.dtr();
        self.dtr_fell = !dtr;
        // Whoever was there without it is not the one who sets it now.
        self.goes |= !dtr || self.is_open;
        self.meet();
        self.owes_notification |= dtr;
    }

    /// Whether a request is one of a port. The class takes words for a modem too, and codings that are none.
    fn takes(&mut self, request: &Request, data: &[u8]) -> bool {
        match request.request {
            SET_LINE_CODING => {
                let coding = coding::parse(data);
                self.coding = coding.unwrap_or(self.coding);
                coding.is_some()
            }
            SET_CONTROL_LINE_STATE => true,
            _ => false,
        }
    }

    fn is_for_us(&self, request: &Request) -> bool {
        request.request_type == RequestType::Class
            && request.recipient == Recipient::Interface
            && request.index == u16::from(self.control)
    }
}

impl<B: UsbBus, L: Line> UsbClass<B> for SerialPort<'_, B, L> {
    fn get_configuration_descriptors(&self, writer: &mut DescriptorWriter<'_>) -> Result<()> {
        self.class.get_configuration_descriptors(writer)
    }

    fn get_string(&self, index: StringIndex, language: LangID) -> Option<&str> {
        self.class.get_string(index, language)
    }

    fn reset(&mut self) {
        self.begin_anew(false);
    }

    fn set_alt_setting(&mut self, interface: InterfaceNumber, alternative: u8) -> bool {
        let (interface, data) = (u8::from(interface), self.control + 1);
        let is_ours = alternative == DEFAULT_ALTERNATE_SETTING && (interface == self.control || interface == data);
        if is_ours && interface == data {
            self.class.write_ep().unstall();
            self.class.read_ep().unstall();
        }
        is_ours
    }

    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        let request = transfer.request();
        if self.is_for_us(request) && request.request == GET_LINE_CODING {
            // The class has forgotten it at a reset, and answers no host that asks for less or for more. It
            // waits for an answer, and this one fits its buffer.
            let _ = transfer.accept_with(&self.coding);
        } else {
            self.class.control_in(transfer);
        }
    }

    fn control_out(&mut self, transfer: ControlOut<'_, '_, '_, B>) {
        let request = *transfer.request();
        if let Some(configured) = standard::configures(&request) {
            self.begin_anew(configured);
            // USB 2.0 section 9.1.1.5: every endpoint begins anew.
            self.class.write_ep().unstall();
            self.class.read_ep().unstall();
            self.notify.unstall();
        }
        if self.is_for_us(&request) && !self.takes(&request, transfer.data()) {
            // It waits for an answer, so this is one.
            let _ = transfer.reject();
            return;
        }
        let had_dtr = self.class.dtr();
        self.class.control_out(transfer);
        if self.class.dtr() != had_dtr {
            self.dtr_changed();
        }
    }
}
