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
    ControlIn, ControlOut, DescriptorWriter, EndpointIn, EndpointOut, EndpointType, UsbBus, UsbBusAllocator, UsbClass,
};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::lang_id::LangID;
use usb_device::device::DEFAULT_ALTERNATE_SETTING;
use usb_device::endpoint::EndpointAddress;

use super::coding::{CODING_BYTES, LineCoding};
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

const CLASS_COMMUNICATIONS: u8 = 0x02;
const CLASS_DATA: u8 = 0x0A;
const SUBCLASS_ABSTRACT_CONTROL: u8 = 0x02;
/// None: with 1, the commands of a modem, Linux's ModemManager would try to dial.
const PROTOCOL_NONE: u8 = 0x00;

/// Class-specific descriptor of an interface (CDC 1.2, table 12), and its kinds (table 13).
const CS_INTERFACE: u8 = 0x24;
const HEADER: u8 = 0x00;
const CALL_MANAGEMENT: u8 = 0x01;
const ABSTRACT_CONTROL: u8 = 0x02;
const UNION: u8 = 0x06;
/// The port knows line coding, control lines and serial state (PSTN 1.2, table 4); it sends no break.
const CAPABILITIES: u8 = 0x02;

/// Requests (PSTN 1.2, table 13).
const SET_LINE_CODING: u8 = 0x20;
const GET_LINE_CODING: u8 = 0x21;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
/// A host that wants to hear: a terminal is ready (PSTN 1.2, table 18).
const DTR: u16 = 1;

/// Notification SERIAL_STATE (PSTN 1.2, section 6.5.4): carrier and data set ready. They are always there; a
/// program that waits for a carrier when it opens a port goes on.
const SERIAL_STATE_BYTES: usize = 10;
const DCD_AND_DSR: u8 = 0b11;
/// An interrupt endpoint with room for it.
const NOTIFICATION_PACKET: u16 = 16;
/// How often a host asks for one, ms.
const NOTIFICATION_INTERVAL: u8 = 32;

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

/// Numbers of a port's endpoints, as Smoothieware v2 has them.
#[derive(Clone, Copy)]
pub struct Endpoints {
    /// Bulk, to the host.
    pub to_host: u8,
    /// Bulk, from the host.
    pub from_host: u8,
    /// Interrupt, to the host.
    pub notify: u8,
}

impl Endpoints {
    /// Of the first port.
    pub const FIRST: Self = Self { to_host: 0x81, from_host: 0x01, notify: 0x82 };
    /// Of the second one.
    pub const SECOND: Self = Self { to_host: 0x83, from_host: 0x02, notify: 0x84 };
}

/// A serial port over a line.
pub struct SerialPort<'a, B: UsbBus, L> {
    control: InterfaceNumber,
    data: InterfaceNumber,
    name: (StringIndex, &'static str),
    notify: EndpointIn<'a, B>,
    to_host: EndpointIn<'a, B>,
    from_host: EndpointOut<'a, B>,
    line: L,
    coding: LineCoding,
    has_dtr: bool,
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
    /// A port with these endpoints.
    ///
    /// # Errors
    /// The bus does not have them.
    pub fn new(bus: &'a UsbBusAllocator<B>, endpoints: Endpoints, name: &'static str, line: L) -> Result<Self> {
        let packet = PACKET_BYTES as u16;
        let address = |number: u8| Some(EndpointAddress::from(number));
        Ok(Self {
            control: bus.interface(),
            data: bus.interface(),
            name: (bus.string(), name),
            to_host: bus.alloc(address(endpoints.to_host), EndpointType::Bulk, packet, 0)?,
            from_host: bus.alloc(address(endpoints.from_host), EndpointType::Bulk, packet, 0)?,
            notify: bus.alloc(
                address(endpoints.notify),
                EndpointType::Interrupt,
                NOTIFICATION_PACKET,
                NOTIFICATION_INTERVAL,
            )?,
            line,
            coding: LineCoding::default(),
            has_dtr: false,
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

    /// What the host has set it to.
    #[must_use]
    pub const fn coding(&self) -> LineCoding {
        self.coding
    }

    /// What it is connected to.
    pub const fn line(&mut self) -> &mut L {
        &mut self.line
    }

    /// The endpoint at which packets of the host arrive.
    #[must_use]
    pub fn from_host(&self) -> EndpointAddress {
        self.from_host.address()
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
            Some(end) => end.is_undone || self.has_dtr,
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
        if self.has_dtr && self.can_talk() && !self.goes && self.ends.is_empty() {
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
        let read = self.from_host.read(&mut packet);
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
        if (!self.packet.is_empty() || self.owes_end) && self.to_host.write(&self.packet).is_ok() {
            self.owes_end = self.packet.is_full();
            self.packet.clear();
        }
    }

    fn tell_state(&mut self) {
        if self.owes_notification {
            let control = u8::from(self.control);
            let state: [u8; SERIAL_STATE_BYTES] = [0xA1, 0x20, 0, 0, control, 0, 2, 0, DCD_AND_DSR, 0];
            self.owes_notification = self.notify.write(&state).is_err();
        }
    }

    /// Everything as behind a reset of the bus; what the host has set stays.
    fn begin_anew(&mut self, configured: bool) {
        self.goes |= self.is_configured;
        (self.has_dtr, self.dtr_fell) = (false, false);
        self.is_suspended = false;
        self.is_configured = configured;
        self.owes_notification = configured;
    }

    fn set_dtr(&mut self, dtr: bool) {
        // A host that never sets it, but sets RTS, has not gone.
        if self.has_dtr != dtr {
            self.has_dtr = dtr;
            self.dtr_fell = !dtr;
            // Whoever was there without it is not the one who sets it now.
            self.goes |= !dtr || self.is_open;
            self.meet();
            self.owes_notification |= dtr;
        }
    }

    fn is_for_us(&self, request: &Request) -> bool {
        request.request_type == RequestType::Class
            && request.recipient == Recipient::Interface
            && request.index == u16::from(u8::from(self.control))
    }
}

impl<B: UsbBus, L: Line> UsbClass<B> for SerialPort<'_, B, L> {
    fn get_configuration_descriptors(&self, writer: &mut DescriptorWriter<'_>) -> Result<()> {
        let (control, data) = (self.control, self.data);
        let (class, subclass) = (CLASS_COMMUNICATIONS, SUBCLASS_ABSTRACT_CONTROL);
        let name = Some(self.name.0);
        writer.iad(control, 2, class, subclass, PROTOCOL_NONE, name)?;
        writer.interface_alt(control, DEFAULT_ALTERNATE_SETTING, class, subclass, PROTOCOL_NONE, name)?;
        // CDC 1.20.
        writer.write(CS_INTERFACE, &[HEADER, 0x20, 0x01])?;
        writer.write(CS_INTERFACE, &[CALL_MANAGEMENT, 0, data.into()])?;
        writer.write(CS_INTERFACE, &[ABSTRACT_CONTROL, CAPABILITIES])?;
        writer.write(CS_INTERFACE, &[UNION, control.into(), data.into()])?;
        writer.endpoint(&self.notify)?;
        writer.interface(data, CLASS_DATA, 0, 0)?;
        writer.endpoint(&self.to_host)?;
        writer.endpoint(&self.from_host)
    }

    fn get_string(&self, index: StringIndex, _: LangID) -> Option<&str> {
        (index == self.name.0).then_some(self.name.1)
    }

    fn reset(&mut self) {
        self.begin_anew(false);
    }

    fn set_alt_setting(&mut self, interface: InterfaceNumber, alternative: u8) -> bool {
        let is_ours = alternative == DEFAULT_ALTERNATE_SETTING && (interface == self.control || interface == self.data);
        if is_ours && interface == self.data {
            self.to_host.unstall();
            self.from_host.unstall();
        }
        is_ours
    }

    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        let request = transfer.request();
        if self.is_for_us(request) {
            // It waits for an answer, and this one fits its buffer.
            let _ = match request.request {
                GET_LINE_CODING => transfer.accept_with(&self.coding.bytes()),
                _ => transfer.reject(),
            };
        }
    }

    fn control_out(&mut self, transfer: ControlOut<'_, '_, '_, B>) {
        let request = *transfer.request();
        if let Some(configured) = standard::configures(&request) {
            self.begin_anew(configured);
            // USB 2.0 section 9.1.1.5: every endpoint begins anew.
            self.to_host.unstall();
            self.from_host.unstall();
            self.notify.unstall();
        }
        if !self.is_for_us(&request) {
            return;
        }
        let accepted = match request.request {
            SET_LINE_CODING => {
                let coding = transfer.data().get(..CODING_BYTES).and_then(LineCoding::parse);
                self.coding = coding.unwrap_or(self.coding);
                coding.is_some()
            }
            SET_CONTROL_LINE_STATE => {
                self.set_dtr(request.value & DTR != 0);
                true
            }
            _ => false,
        };
        // It waits for an answer, so this is one.
        let _ = if accepted { transfer.accept() } else { transfer.reject() };
    }
}
