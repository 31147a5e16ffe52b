//! Bulk-only transport: command, data, status, and the handling of hosts that disagree about the data (BOT
//! section 6.7, the thirteen cases).

use usb_device::Result;
use usb_device::bus::{InterfaceNumber, StringIndex};
use usb_device::class_prelude::{
    ControlIn, ControlOut, DescriptorWriter, EndpointIn, EndpointOut, EndpointType, UsbBus, UsbBusAllocator, UsbClass,
};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::lang_id::LangID;
use usb_device::device::DEFAULT_ALTERNATE_SETTING;
use usb_device::endpoint::EndpointAddress;

use super::medium::{Fault, Medium, State};
use super::reply::Reply;
use super::scsi::{self, Asked, Unit};
use super::sense::Sense;
use super::transfer::{Transfer, Way};
use super::wrapper::{Outcome, Wrapper, status};
use crate::identity::SerialNumber;
use crate::{PACKET_BYTES, PACKETS_HELD, standard};

const CLASS_MASS_STORAGE: u8 = 0x08;
const SUBCLASS_SCSI: u8 = 0x06;
const PROTOCOL_BULK_ONLY: u8 = 0x50;
/// Codes of class requests (BOT section 3).
const RESET: u8 = 0xFF;
const GET_MAX_UNIT: u8 = 0xFE;
/// Endpoint numbers, behind those of the serial ports.
const TO_HOST: u8 = 0x85;
const FROM_HOST: u8 = 0x03;
/// Steps of one run, so that a run is bounded. A step moves a packet at most.
const STEPS_A_RUN: usize = 4;

/// Stage of the command in progress.
enum Stage {
    /// Waits for a command.
    Command,
    /// Received an invalid command: both pipes are halted until the host has reset the transport (BOT section
    /// 6.6.1).
    Invalid,
    /// Sends an answer, from this offset on.
    Answer(Reply, usize),
    /// Moves blocks between bus and medium.
    Blocks(Transfer),
    /// Ends the data stage. A halt ends data that the host expects beyond the data moved.
    End,
    /// Sends the command's status.
    Status,
    /// Waits for the status to be sent.
    Sent,
}

/// Command in progress, from its wrapper.
#[derive(Clone, Copy)]
struct Current {
    tag: u32,
    /// Bytes that the host expects to move, and the direction.
    expected: u32,
    is_to_host: bool,
    /// Bytes moved so far.
    moved: u32,
    outcome: Outcome,
}

/// Mass storage function, the disk.
pub struct MassStorage<'a, B: UsbBus, M> {
    interface: InterfaceNumber,
    name: (StringIndex, &'static str),
    serial: SerialNumber,
    to_host: EndpointIn<'a, B>,
    from_host: EndpointOut<'a, B>,
    medium: M,
    stage: Stage,
    current: Current,
    /// Whether a packet for the host has not been sent yet.
    is_sending: bool,
    /// Whether the pipe to the host is halted.
    is_halted: bool,
    /// Whether the medium still carries out an operation of an aborted command.
    is_draining: bool,
    is_configured: bool,
    sense: Sense,
    attention: Option<Sense>,
    is_removal_prevented: bool,
    seen: State,
}

impl<'a, B: UsbBus, M: Medium> MassStorage<'a, B, M> {
    /// Creates a disk with this medium.
    ///
    /// # Errors
    /// When the bus lacks the endpoints.
    pub fn new(bus: &'a UsbBusAllocator<B>, name: &'static str, serial: SerialNumber, medium: M) -> Result<Self> {
        let packet = PACKET_BYTES as u16;
        let address = |number: u8| Some(EndpointAddress::from(number));
        Ok(Self {
            interface: bus.interface(),
            name: (bus.string(), name),
            serial,
            to_host: bus.alloc(address(TO_HOST), EndpointType::Bulk, packet, 0)?,
            from_host: bus.alloc(address(FROM_HOST), EndpointType::Bulk, packet, 0)?,
            medium,
            stage: Stage::Command,
            current: Current { tag: 0, expected: 0, is_to_host: false, moved: 0, outcome: Outcome::Passed },
            is_sending: false,
            is_halted: false,
            is_draining: false,
            is_configured: false,
            sense: Sense::NONE,
            attention: None,
            is_removal_prevented: false,
            seen: State::Absent,
        })
    }

    /// Returns the medium of the disk.
    pub const fn medium(&mut self) -> &mut M {
        &mut self.medium
    }

    /// Moves a few packets at most. Returns whether there is more to do at once.
    pub fn run(&mut self) -> bool {
        (0..STEPS_A_RUN).all(|_| self.is_configured && self.step())
    }

    /// Does one step; returns false when nothing can be done before an event.
    fn step(&mut self) -> bool {
        match &mut self.stage {
            Stage::Invalid => false,
            Stage::Command => self.await_command(),
            Stage::Answer(..) => self.answer(),
            Stage::Blocks(_) => self.move_blocks(),
            Stage::End => self.end(),
            Stage::Status => self.send_status(),
            Stage::Sent if self.is_sending => false,
            Stage::Sent => {
                self.stage = Stage::Command;
                true
            }
        }
    }

    const fn can_send(&self) -> bool {
        !self.is_sending && !self.is_halted
    }

    fn await_command(&mut self) -> bool {
        if self.is_draining {
            let is_busy = self.medium.progress() == super::Progress::Busy;
            self.is_draining = is_busy;
            return !is_busy;
        }
        let mut packet = [0; PACKET_BYTES];
        let Ok(count) = self.from_host.read(&mut packet) else { return false };
        match Wrapper::parse(packet.get(..count).unwrap_or_default()) {
            Some(wrapper) => self.begin(&wrapper),
            None => {
                self.stage = Stage::Invalid;
                self.halt_both();
            }
        }
        true
    }

    /// Drops received packets, and makes the endpoint ready again.
    fn forget_received(&mut self) {
        for _ in 0..PACKETS_HELD {
            let _nobodys = self.from_host.read(&mut [0; PACKET_BYTES]);
        }
        self.from_host.unstall();
    }

    fn halt_both(&mut self) {
        self.is_halted = true;
        self.to_host.stall();
        self.from_host.stall();
    }

    fn begin(&mut self, wrapper: &Wrapper) {
        let Wrapper { tag, bytes, is_to_host, .. } = *wrapper;
        self.current = Current { tag, expected: bytes, is_to_host, moved: 0, outcome: Outcome::Passed };
        self.look_at_medium();
        let asked = self.interpret(wrapper);
        self.sense = asked.as_ref().err().copied().unwrap_or(Sense::NONE);
        self.stage = match asked {
            Ok(asked) => self.carry_out(asked),
            Err(_) => {
                self.current.outcome = Outcome::Failed;
                Stage::End
            }
        };
    }

    /// Notes a change of the medium.
    fn look_at_medium(&mut self) {
        let now = self.medium.state();
        if now == self.seen {
            return;
        }
        self.seen = now;
        self.is_removal_prevented = false;
        self.attention = matches!(now, State::Ready { .. }).then_some(Sense::MEDIUM_CHANGED);
    }

    fn interpret(&mut self, wrapper: &Wrapper) -> core::result::Result<Asked, Sense> {
        if wrapper.unit != 0 {
            return Err(Sense::NO_SUCH_UNIT);
        }
        if !scsi::comes_before_attention(&wrapper.command)
            && let Some(attention) = self.attention.take()
        {
            return Err(attention);
        }
        let unit = Unit {
            medium: self.seen,
            sense: self.sense,
            is_removal_prevented: self.is_removal_prevented,
            serial: self.serial.as_str(),
        };
        scsi::interpret(&wrapper.command, &unit)
    }

    /// Returns the next stage. If host and command disagree about the data, nothing is done (BOT section 6.7,
    /// cases 2, 3, 7, 8, 10, 13).
    fn carry_out(&mut self, asked: Asked) -> Stage {
        let Current { expected, is_to_host, .. } = self.current;
        let (bytes, way) = match &asked {
            Asked::Answer(reply) => (reply.bytes().len() as u32, true),
            Asked::Read(blocks) => (blocks.bytes(), true),
            Asked::Write(blocks) => (blocks.bytes(), false),
            _ => (0, is_to_host),
        };
        if bytes > expected || bytes > 0 && way != is_to_host {
            self.current.outcome = Outcome::PhaseError;
            return Stage::End;
        }
        match asked {
            Asked::Answer(reply) => Stage::Answer(reply, 0),
            Asked::Read(blocks) => Stage::Blocks(Transfer::new(Way::ToHost, blocks)),
            Asked::Write(blocks) => Stage::Blocks(Transfer::new(Way::FromHost, blocks)),
            Asked::Verify(blocks) => Stage::Blocks(Transfer::new(Way::Nowhere, blocks)),
            Asked::Nothing => Stage::End,
            Asked::PreventRemoval(is_prevented) => {
                self.is_removal_prevented = is_prevented;
                Stage::End
            }
            Asked::Eject => {
                self.medium.eject();
                self.look_at_medium();
                Stage::End
            }
        }
    }

    fn answer(&mut self) -> bool {
        if !self.can_send() {
            return false;
        }
        let Stage::Answer(reply, at) = &mut self.stage else { return false };
        let rest = reply.bytes().get(*at..).unwrap_or_default();
        let packet = rest.get(..rest.len().min(PACKET_BYTES)).unwrap_or_default();
        if packet.is_empty() {
            self.stage = Stage::End;
            return true;
        }
        self.is_sending = self.to_host.write(packet).is_ok();
        if self.is_sending {
            *at += packet.len();
            self.current.moved += packet.len() as u32;
        }
        self.is_sending
    }

    fn move_blocks(&mut self) -> bool {
        let can_send = self.can_send();
        if self.medium.state() != self.seen {
            // The medium's buffers may have another owner by now.
            self.fail(Fault::Gone);
            return true;
        }
        let Stage::Blocks(transfer) = &mut self.stage else { return false };
        if let Err(fault) = transfer.advance(&mut self.medium) {
            self.fail(fault);
            return true;
        }
        if transfer.is_over() {
            // The last packet has to be sent before the pipe may be halted.
            self.stage = Stage::End;
            return true;
        }
        let mut packet = [0; PACKET_BYTES];
        match transfer.way() {
            Way::Nowhere => false,
            Way::ToHost => {
                let bytes = if can_send { transfer.fetch(&self.medium, &mut packet) } else { None };
                let Some(bytes) = bytes else { return false };
                self.is_sending = self.to_host.write(bytes).is_ok();
                if self.is_sending {
                    let count = bytes.len();
                    transfer.taken(count);
                    self.current.moved += count as u32;
                }
                self.is_sending
            }
            Way::FromHost => {
                if transfer.room::<M>() == 0 {
                    return false;
                }
                let Ok(count) = self.from_host.read(&mut packet) else { return false };
                let bytes = packet.get(..count).unwrap_or_default();
                self.current.moved += count as u32;
                // A block is a whole number of packets, so a short packet means that the host has given up.
                if count == PACKET_BYTES {
                    transfer.store(&mut self.medium, bytes);
                } else {
                    self.break_off(Outcome::PhaseError);
                }
                true
            }
        }
    }

    fn fail(&mut self, fault: Fault) {
        self.sense = fault.into();
        self.break_off(Outcome::Failed);
    }

    /// Ends the command; an operation of the medium runs to its end.
    fn break_off(&mut self, outcome: Outcome) {
        if let Stage::Blocks(transfer) = &self.stage {
            self.is_draining = transfer.is_at_medium();
        }
        self.current.outcome = outcome;
        self.stage = Stage::End;
    }

    /// Halts the pipe when data that the host expects or still has will not be moved (cases 4, 5, 9, 11, and
    /// all that end early).
    fn end(&mut self) -> bool {
        let Current { expected, moved, is_to_host, .. } = self.current;
        if moved < expected && is_to_host {
            if self.is_sending {
                return false;
            }
            self.is_halted = true;
            self.to_host.stall();
        } else if moved < expected {
            self.from_host.stall();
        }
        self.stage = Stage::Status;
        true
    }

    fn send_status(&mut self) -> bool {
        if !self.can_send() {
            return false;
        }
        let Current { tag, expected, moved, outcome, .. } = self.current;
        self.is_sending = self.to_host.write(&status(tag, expected.saturating_sub(moved), outcome)).is_ok();
        if self.is_sending {
            self.stage = Stage::Sent;
        }
        self.is_sending
    }

    /// Drops the command in progress. Halted pipes stay halted until the host ends the halt.
    fn reset_transport(&mut self) {
        if let Stage::Blocks(transfer) = &self.stage {
            self.is_draining = transfer.is_at_medium();
        }
        self.stage = Stage::Command;
    }

    fn begin_anew(&mut self, configured: bool) {
        self.reset_transport();
        self.is_configured = configured;
        self.is_sending = false;
        self.is_halted = false;
        self.is_removal_prevented = false;
    }

    fn is_for_us(&self, request: &Request) -> bool {
        request.request_type == RequestType::Class
            && request.recipient == Recipient::Interface
            && request.index == u16::from(u8::from(self.interface))
            && request.value == 0
    }

    /// Returns whether the host may end this halt now, and follows the change.
    fn halt_ends(&mut self, endpoint: u8) -> bool {
        let is_ours = matches!(endpoint, TO_HOST | FROM_HOST);
        if is_ours && matches!(self.stage, Stage::Invalid) {
            return false;
        }
        if endpoint == TO_HOST {
            self.is_halted = false;
            self.is_sending = false;
        }
        true
    }
}

impl<B: UsbBus, M: Medium> UsbClass<B> for MassStorage<'_, B, M> {
    fn get_configuration_descriptors(&self, writer: &mut DescriptorWriter<'_>) -> Result<()> {
        let (interface, name) = (self.interface, Some(self.name.0));
        let alternative = DEFAULT_ALTERNATE_SETTING;
        writer.interface_alt(interface, alternative, CLASS_MASS_STORAGE, SUBCLASS_SCSI, PROTOCOL_BULK_ONLY, name)?;
        writer.endpoint(&self.to_host)?;
        writer.endpoint(&self.from_host)
    }

    fn get_string(&self, index: StringIndex, _: LangID) -> Option<&str> {
        (index == self.name.0).then_some(self.name.1)
    }

    fn reset(&mut self) {
        // Packets in the controller belong to a command that has been given up.
        self.forget_received();
        self.begin_anew(false);
    }

    fn endpoint_in_complete(&mut self, endpoint: EndpointAddress) {
        if endpoint == self.to_host.address() {
            self.is_sending = false;
        }
    }

    fn set_alt_setting(&mut self, interface: InterfaceNumber, alternative: u8) -> bool {
        let is_ours = interface == self.interface && alternative == DEFAULT_ALTERNATE_SETTING;
        if is_ours {
            self.to_host.unstall();
            self.forget_received();
            self.begin_anew(true);
        }
        is_ours
    }

    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        let request = transfer.request();
        if self.is_for_us(request) && request.request == GET_MAX_UNIT && request.length == 1 {
            // The transfer waits for an answer, and the highest unit's number fits its buffer.
            let _ = transfer.accept_with(&[0]);
        }
    }

    fn control_out(&mut self, transfer: ControlOut<'_, '_, '_, B>) {
        let request = *transfer.request();
        if let Some(configured) = standard::configures(&request) {
            self.to_host.unstall();
            self.forget_received();
            self.begin_anew(configured);
        }
        if let Some(endpoint) = standard::clears_halt(&request)
            && !self.halt_ends(endpoint)
        {
            // The transfer waits for an answer, so accepting cannot fail; the halt goes on.
            let _ = transfer.accept();
            return;
        }
        if self.is_for_us(&request) && request.request == RESET && request.length == 0 {
            self.reset_transport();
            // The transfer waits for an answer, so accepting cannot fail.
            let _ = transfer.accept();
        }
    }
}
