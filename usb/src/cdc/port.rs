//! Serial port of the device.
//!
//! Both directions have flow control. A packet of the host is only fetched when the line has room for it;
//! until then the endpoint answers NAK and the host waits. A packet for the host is taken from the line when
//! the previous packet has been sent.
//!
//! A visit is the time of one program at the host's end. Visits begin when the host sets DTR or, for a host
//! that never does, with its first byte, and end when DTR falls, the bus is reset, or the bus falls silent:
//! this board cannot measure the bus voltage, so an unplugged cable is a silent bus. After a silence without
//! a reset (a computer that has slept) the same visit goes on.
//!
//! All bytes that a host was told have arrived reach the line as part of their visit, once there is room,
//! even if that visit has ended and others have followed (`for line in ...; do echo $line > /dev/ttyACM0`
//! causes this). So a visit begins only after all earlier visits' packets have been fetched from the
//! controller.

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

/// Other end of a port, at the machine's side.
pub trait Line {
    /// Returns a number of bytes that certainly fit.
    fn room(&self) -> usize;

    /// Takes bytes of the host, at most a packet, for which there was room. Bytes of a finished visit may
    /// still come after `set_open(false)`.
    fn receive(&mut self, bytes: &[u8]);

    /// Fetches bytes for the host and returns their number.
    fn fetch(&mut self, into: &mut [u8]) -> usize;

    /// Begins or ends a visit. Bytes for a finished visit are dropped.
    fn set_open(&mut self, open: bool);

    /// Resumes the previous visit, perhaps in the middle of a line that was being sent.
    fn come_back(&mut self);
}

/// Requests of the class (PSTN 1.2, table 13).
const SET_LINE_CODING: u8 = 0x20;
const GET_LINE_CODING: u8 = 0x21;
const SET_CONTROL_LINE_STATE: u8 = 0x22;

/// Notification SERIAL_STATE (PSTN 1.2, section 6.5.4): carrier and data set ready. Both are always on, so
/// that a program that waits for a carrier when opening a port can go on.
const SERIAL_STATE_BYTES: usize = 10;
const DCD_AND_DSR: u8 = 0b11;

/// Greatest number of ended visits behind different packets in the controller, or before the first.
const ENDS: usize = PACKETS_HELD + 1;

/// End of a visit.
#[derive(Clone, Copy)]
struct End {
    /// Packets in the controller that belong to this visit or earlier ones.
    packets: u8,
    /// Whether the visit was resumed since then, so that the next visit is its continuation.
    is_undone: bool,
}

/// Serial port that connects the bus to a line.
pub struct SerialPort<'a, B: UsbBus, L> {
    class: CdcAcmClass<'a, B>,
    /// Interface for control requests.
    control: u8,
    notify: EndpointIn<'a, B>,
    line: L,
    /// Line coding set by the host, kept here because the class forgets it at a reset of the bus.
    coding: LineCoding,
    /// Whether DTR fell. Later bytes may still belong to the visit: a computer that gives up unsent data
    /// takes the data back only after DTR has fallen.
    dtr_fell: bool,
    is_open: bool,
    is_configured: bool,
    is_suspended: bool,
    /// Whether a visit was in progress when the bus fell silent.
    may_come_back: bool,
    /// Whether the visit ends, which the next run handles.
    goes: bool,
    /// Ended visits with packets still to be fetched, in order.
    ends: heapless::Vec<End, ENDS>,
    /// Packet that the endpoint has not taken yet.
    packet: heapless::Vec<u8, PACKET_BYTES>,
    /// Whether an empty packet must follow a full one, so that a host does not wait for more.
    owes_end: bool,
    owes_notification: bool,
}

impl<'a, B: UsbBus, L: Line> SerialPort<'a, B, L> {
    /// Creates a port with these numbers, at a [`crate::Guarded`] bus that already has the earlier ports.
    ///
    /// # Errors
    /// When the bus lacks the endpoint for notifications.
    ///
    /// # Panics
    /// When the bus lacks the other endpoints.
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

    /// Returns the line at the machine's side.
    pub const fn line(&mut self) -> &mut L {
        &mut self.line
    }

    /// Returns the endpoint at which packets of the host arrive.
    #[must_use]
    pub fn from_host(&self) -> EndpointAddress {
        self.class.read_ep().address()
    }

    /// Moves a packet each way, if possible, so that a run is bounded; at the end of a visit moves all its
    /// packets. `held`: packets of the host that the controller holds. Returns true when there is room for
    /// another of them.
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

    /// Notes that the bus has fallen silent, or is active again.
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

    /// Whether a visit is in progress, begun at the line or not.
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

    /// Ends the visit. The visit's packets are fetched now as far as there is room, the rest later.
    fn end_visit(&mut self, held: usize) {
        let mut packets = held as u8;
        if self.ends.is_empty() {
            while packets > 0 && self.line.room() >= PACKET_BYTES && self.receive_packet() {
                packets -= 1;
            }
            if packets > 0 {
                // The visit may not have begun at the line, if none of its packets had been fetched.
                self.set_open(true);
            }
            self.set_open(false);
        }
        match self.ends.last_mut() {
            // The visit has left no packets.
            Some(end) if end.packets == packets => end.is_undone = false,
            None if packets == 0 => {}
            _ => {
                // The list has a place for each number of packets, so there is room.
                let _fits = self.ends.push(End { packets, is_undone: false });
            }
        }
    }

    /// Ends visits at the line whose packets have all been fetched.
    fn turn_to_next(&mut self) {
        while let Some(&End { packets: 0, is_undone }) = self.ends.first() {
            self.ends.remove(0);
            self.set_open(false);
            if !self.ends.is_empty() || is_undone && self.can_talk() {
                // The next visit is a resumed one, or one that has ended but left packets.
                self.open(is_undone);
            }
            self.meet();
        }
    }

    /// Begins the visit at the line, once all packets of earlier visits have been fetched.
    fn meet(&mut self) {
        if self.class.dtr() && self.can_talk() && !self.goes && self.ends.is_empty() {
            self.set_open(true);
        }
    }

    /// Fetches a packet, if one is wanted and there is room. Returns whether a packet was fetched.
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
        // Without a packet, earlier visits have no packets left either: the host has halted the endpoint.
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
            // Bytes for a visit that has ended are dropped.
            while self.line.fetch(&mut [0; PACKET_BYTES]) > 0 {}
            return;
        }
        if self.packet.is_empty() {
            let mut bytes = [0; PACKET_BYTES];
            let count = self.line.fetch(&mut bytes);
            // The packet has room for all bytes.
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

    /// Resets everything as after a reset of the bus, except settings made by the host.
    fn begin_anew(&mut self, configured: bool) {
        self.goes |= self.is_configured;
        self.class.reset();
        self.dtr_fell = false;
        self.is_suspended = false;
        self.is_configured = configured;
        self.owes_notification = configured;
    }

    /// Handles a change of DTR. RTS alone, from a host that never sets DTR, does not end a visit.
    fn dtr_changed(&mut self) {
        let dtr = self.class.dtr();
        self.dtr_fell = !dtr;
        // A visit that began without DTR is not the one that sets DTR now.
        self.goes |= !dtr || self.is_open;
        self.meet();
        self.owes_notification |= dtr;
    }

    /// Whether a port supports the request. The class would also accept modem commands and invalid line
    /// codings.
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
            // The class forgets the coding at a reset, and ignores hosts that ask for another length. The
            // transfer waits for an answer, and the coding fits its buffer.
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
            // The transfer waits for an answer, so rejecting cannot fail.
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
