//! The USB host in tests: a person at a desk who plugs the board in, enumerates, and waits for transfers, in
//! virtual time. [`cdc`], [`bulk_only`], [`scsi`] and [`dfu`] speak the classes.
//!
//! ```no_run
//! # use virtual_prime::usb_desk::UsbHost;
//! # fn shown(vm: &mut virtual_prime::vm::Vm) -> Result<(), virtual_prime::usb_desk::UsbError> {
//! let mut host = UsbHost::new();
//! let mut desk = host.at(vm);
//! desk.plug();
//! let device = desk.enumerate()?;
//! assert_eq!(device.descriptor.vendor, 0x1D50);
//! # Ok(()) }
//! ```

pub mod bulk_only;
pub mod cdc;
pub mod dfu;
pub mod scsi;

use std::collections::HashMap;
use std::fmt;

use rigless::time::VirtualNanos;

use crate::peripherals::otg::core::Core;
use crate::vm::{Span, Vm};
use usb_host::controller::{Controller, Port, PortEvent, Tally};
use usb_host::descriptors::{Configuration, DeviceDescriptor, text};
use usb_host::request::{self, Setup};
use usb_host::transfer::{Completion, Direction, Endpoint, Kind, Outcome, Request, TransferId};
use usb_host::wire::Toggle;

const MS: u64 = 1_000_000;
/// Slices of time in which a wait runs the board.
const SLICE_NS: u64 = 200_000;
/// Greatest duration of a transfer unless set otherwise: a control transfer's 5 s, USB 2.0 section 9.2.6.1.
const PATIENCE_MS: u64 = 5_000;
/// Time of debouncing after a connection, section 7.1.7.3.
const DEBOUNCE_MS: u64 = 100;
/// Duration of a bus reset, and recovery time after it, section 7.1.7.5.
const RESET_MS: u64 = 10;
const RECOVERY_MS: u64 = 10;
/// Recovery time after SET_ADDRESS, section 9.2.6.3.
const ADDRESS_MS: u64 = 2;
/// Language identifier of US English.
const LANGUAGE: u16 = 0x0409;
/// Greatest length of a string descriptor.
const STRING_BYTES: u16 = 255;

/// Reason why an operation failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UsbError {
    /// The transfer ended otherwise than asked, with this much data moved.
    Ended(Outcome, Vec<u8>),
    /// The transfer has not ended in time.
    Late,
    /// The device did something that it should not.
    Wrong(String),
    /// The image has ended its run.
    Over(Span),
}

impl UsbError {
    /// Whether the device answered STALL.
    #[must_use]
    pub const fn is_stall(&self) -> bool {
        matches!(self, Self::Ended(Outcome::Stalled, _))
    }
}

impl fmt::Display for UsbError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ended(outcome, data) => write!(f, "the transfer ended {outcome:?} after {} bytes", data.len()),
            Self::Late => f.write_str("no answer in time"),
            Self::Wrong(what) => f.write_str(what),
            Self::Over(span) => write!(f, "the image ended: {span:?}"),
        }
    }
}

impl std::error::Error for UsbError {}

impl From<String> for UsbError {
    fn from(what: String) -> Self {
        Self::Wrong(what)
    }
}

/// Result of an enumeration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// Address of the device.
    pub address: u8,
    /// The device's own descriptor.
    pub descriptor: DeviceDescriptor,
    /// The first configuration descriptor.
    pub configuration: Configuration,
    /// The first configuration descriptor, byte by byte.
    pub configuration_bytes: Vec<u8>,
    /// Manufacturer, product and serial number, as far as they have an index.
    pub strings: [Option<String>; 3],
}

/// State of the host from one visit to the desk to the next.
#[derive(Debug)]
pub struct UsbHost {
    address: u8,
    max_packet0: u16,
    ended: HashMap<TransferId, Completion>,
    events: Vec<PortEvent>,
    /// Greatest duration of a transfer, milliseconds.
    pub patience_ms: u64,
}

impl Default for UsbHost {
    fn default() -> Self {
        Self { address: 0, max_packet0: 64, ended: HashMap::new(), events: Vec::new(), patience_ms: PATIENCE_MS }
    }
}

impl UsbHost {
    /// Creates a host with an empty port.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the desk, with the board running.
    pub const fn at<'a>(&'a mut self, vm: &'a mut Vm) -> Desk<'a> {
        Desk { host: self, vm }
    }
}

/// The host at a running board.
pub struct Desk<'a> {
    host: &'a mut UsbHost,
    /// The emulated board's machine.
    pub vm: &'a mut Vm,
}

impl Desk<'_> {
    /// Runs `work` on the controller, at this instant; does nothing once the image has ended.
    pub fn controller<R: Send + 'static>(
        &mut self,
        work: impl FnOnce(&mut Controller, &mut Core, u64) -> R + Send + 'static,
    ) -> Option<R> {
        self.vm.with(|stopped| {
            let at = stopped.stop.at;
            stopped.session.board_mut().mcu.usb(VirtualNanos(at.0), work)
        })
    }

    /// Runs the board for so many nanoseconds, and takes note of ended transfers.
    ///
    /// # Errors
    /// The image has ended.
    pub fn pass(&mut self, nanoseconds: u64) -> Result<(), UsbError> {
        let span = self.vm.run_for(nanoseconds);
        self.look();
        if span == Span::Reached { Ok(()) } else { Err(UsbError::Over(span)) }
    }

    /// Runs the board for so many milliseconds.
    ///
    /// # Errors
    /// The image has ended.
    pub fn pass_ms(&mut self, ms: u64) -> Result<(), UsbError> {
        self.pass(ms * MS)
    }

    fn look(&mut self) {
        let seen = self.controller(|host, _, _| (host.take_completions(), host.take_events()));
        let Some((ended, events)) = seen else { return };
        self.host.ended.extend(ended.into_iter().map(|one| (one.id, one)));
        self.host.events.extend(events);
    }

    /// Plugs the cable in.
    pub fn plug(&mut self) {
        self.controller(|host, device, now| host.plug(now, device));
    }

    /// Pulls the cable out.
    pub fn unplug(&mut self) {
        self.controller(|host, device, now| host.unplug(now, device));
        self.look();
    }

    /// Returns the state of the port.
    pub fn port(&mut self) -> Port {
        self.controller(|host, _, _| host.port()).unwrap_or(Port::Unplugged)
    }

    /// Takes the events that the host has not caused since the last call.
    pub fn take_events(&mut self) -> Vec<PortEvent> {
        self.look();
        std::mem::take(&mut self.host.events)
    }

    /// Returns the counts of traffic over the bus.
    pub fn tally(&mut self) -> Tally {
        self.controller(|host, _, _| host.tally).unwrap_or_default()
    }

    /// Waits until the port's state satisfies `is`.
    ///
    /// # Errors
    /// It is not in time, or the image has ended.
    pub fn wait_for_port(&mut self, is: impl Fn(Port) -> bool, patience_ms: u64) -> Result<(), UsbError> {
        let end = self.vm.now_ns() + patience_ms * MS;
        while !is(self.port()) {
            if self.vm.now_ns() >= end {
                return Err(UsbError::Late);
            }
            self.pass(SLICE_NS)?;
        }
        Ok(())
    }

    /// Resets the bus; the device has address 0 then.
    ///
    /// # Errors
    /// Nobody is there, or the image has ended.
    pub fn reset(&mut self) -> Result<(), UsbError> {
        self.controller(|host, device, now| host.reset(now, RESET_MS * MS, device));
        self.host.address = 0;
        self.host.max_packet0 = 64;
        self.wait_for_port(|port| port == Port::Enabled, RESET_MS + 1)?;
        self.pass_ms(RECOVERY_MS)
    }

    /// Stops sending frames (suspend).
    pub fn suspend(&mut self) {
        self.controller(|host, device, now| host.suspend(now, device));
    }

    /// Drives a resume, and waits for its end and the recovery time after it.
    ///
    /// # Errors
    /// The image has ended.
    pub fn resume(&mut self) -> Result<(), UsbError> {
        self.controller(|host, device, now| host.resume(now, device));
        self.wait_for_port(|port| port == Port::Enabled, 50)?;
        self.pass_ms(RECOVERY_MS)
    }

    /// Returns endpoint 0 of the device.
    #[must_use]
    pub const fn control_endpoint(&self) -> Endpoint {
        Endpoint {
            device: self.host.address,
            number: 0,
            direction: Direction::Out,
            kind: Kind::Control,
            max_packet: self.host.max_packet0,
        }
    }

    /// Submits a transfer; none once the image has ended.
    pub fn submit(&mut self, endpoint: Endpoint, request: Request) -> Option<TransferId> {
        self.controller(move |host, _, now| host.submit(now, endpoint, request))
    }

    /// Cancels a submitted transfer.
    pub fn cancel(&mut self, id: TransferId) {
        self.controller(move |host, _, now| host.cancel(now, id));
        self.look();
    }

    /// Takes the completion of a transfer, if it has ended.
    pub fn ended(&mut self, id: TransferId) -> Option<Completion> {
        self.look();
        self.host.ended.remove(&id)
    }

    /// Waits for the end of a transfer. A transfer that takes too long is given up.
    ///
    /// # Errors
    /// It ended otherwise than it should, or not in time.
    pub fn wait(&mut self, id: Option<TransferId>) -> Result<Completion, UsbError> {
        let Some(id) = id else { return Err(UsbError::Late) };
        let end = self.vm.now_ns() + self.host.patience_ms * MS;
        loop {
            if let Some(ended) = self.ended(id) {
                return match ended.outcome {
                    Outcome::Done => Ok(ended),
                    outcome => Err(UsbError::Ended(outcome, ended.data)),
                };
            }
            if self.vm.now_ns() >= end {
                self.cancel(id);
                self.host.ended.remove(&id);
                return Err(UsbError::Late);
            }
            self.pass(SLICE_NS)?;
        }
    }

    /// Carries out a control transfer with any eight bytes. Returns the received data.
    ///
    /// # Errors
    /// It ended otherwise than it should, or not in time.
    pub fn control(&mut self, setup: [u8; 8], data: &[u8]) -> Result<Vec<u8>, UsbError> {
        let request = Request::Control { setup, data: data.to_vec() };
        let id = self.submit(self.control_endpoint(), request);
        self.wait(id).map(|ended| ended.data)
    }

    /// Sends a request that the device answers with data.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn ask(&mut self, kind: u8, request: u8, value: u16, index: u16, length: u16) -> Result<Vec<u8>, UsbError> {
        self.control(Setup { kind, request, value, index, length }.bytes(), &[])
    }

    /// Sends a request with data for the device.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn tell(&mut self, kind: u8, request: u8, value: u16, index: u16, data: &[u8]) -> Result<(), UsbError> {
        let length = data.len() as u16;
        self.control(Setup { kind, request, value, index, length }.bytes(), data).map(drop)
    }

    /// Reads up to so many bytes, or until a short packet.
    ///
    /// # Errors
    /// As [`Self::wait`].
    pub fn read(&mut self, endpoint: Endpoint, length: usize) -> Result<Vec<u8>, UsbError> {
        let id = self.submit(endpoint, Request::In(length));
        self.wait(id).map(|ended| ended.data)
    }

    /// Writes these bytes to an endpoint.
    ///
    /// # Errors
    /// As [`Self::wait`].
    pub fn write(&mut self, endpoint: Endpoint, data: &[u8]) -> Result<(), UsbError> {
        let id = self.submit(endpoint, Request::Out { data: data.to_vec(), zero: false });
        self.wait(id).map(drop)
    }

    /// Forgets an endpoint's toggle on the host's side, as with CLEAR_FEATURE(ENDPOINT_HALT).
    pub fn restart_toggle(&mut self, endpoint: Endpoint) {
        self.controller(move |host, _, _| host.set_toggle(endpoint, Toggle::Data0));
    }

    /// Clears an endpoint's halt on both sides.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn clear_halt(&mut self, endpoint: Endpoint) -> Result<(), UsbError> {
        let index = u16::from(Controller::endpoint_address(endpoint));
        self.tell(request::ENDPOINT_OUT, request::CLEAR_FEATURE, request::ENDPOINT_HALT, index, &[])?;
        self.restart_toggle(endpoint);
        Ok(())
    }

    /// Reads a descriptor, up to `length` bytes of it.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn descriptor(&mut self, kind: u8, index: u8, length: u16) -> Result<Vec<u8>, UsbError> {
        let value = u16::from_be_bytes([kind, index]);
        let language = if kind == request::STRING && index != 0 { LANGUAGE } else { 0 };
        self.ask(request::DEVICE_IN, request::GET_DESCRIPTOR, value, language, length)
    }

    /// Reads a string descriptor by its index.
    ///
    /// # Errors
    /// As [`Self::control`], or it is no string.
    pub fn string(&mut self, index: u8) -> Result<String, UsbError> {
        let bytes = self.descriptor(request::STRING, index, STRING_BYTES)?;
        Ok(text(&bytes)?)
    }

    /// Gives the device an address.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn set_address(&mut self, address: u8) -> Result<(), UsbError> {
        self.tell(request::DEVICE_OUT, request::SET_ADDRESS, u16::from(address), 0, &[])?;
        self.host.address = address;
        self.pass_ms(ADDRESS_MS)
    }

    /// Selects a configuration; 0 is none.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn set_configuration(&mut self, value: u8) -> Result<(), UsbError> {
        self.tell(request::DEVICE_OUT, request::SET_CONFIGURATION, u16::from(value), 0, &[])?;
        self.controller(|host, _, _| host.clear_toggles());
        Ok(())
    }

    /// Enumerates a device that has just been plugged in, as a computer does: waits for the connection,
    /// resets, reads the device descriptor, gives it address 1, reads all descriptors and selects the first
    /// configuration.
    ///
    /// # Errors
    /// Any of that did not work.
    pub fn enumerate(&mut self) -> Result<Device, UsbError> {
        self.wait_for_port(|port| !matches!(port, Port::Unplugged | Port::Empty), self.host.patience_ms)?;
        self.pass_ms(DEBOUNCE_MS)?;
        self.reset()?;
        // The first eight bytes end with the packet size of endpoint 0.
        let begin = self.descriptor(request::DEVICE, 0, 8)?;
        self.host.max_packet0 = u16::from(*begin.get(7).ok_or("a device descriptor of less than 8 bytes".to_owned())?);
        self.set_address(1)?;
        let descriptor = DeviceDescriptor::parse(&self.descriptor(request::DEVICE, 0, 18)?)?;
        let head = self.descriptor(request::CONFIGURATION, 0, 9)?;
        let &[_, _, t0, t1, ..] = head.as_slice() else {
            return Err(UsbError::Wrong(format!("a configuration descriptor of {} bytes", head.len())));
        };
        let configuration_bytes = self.descriptor(request::CONFIGURATION, 0, u16::from_le_bytes([t0, t1]))?;
        let configuration = Configuration::parse(&configuration_bytes)?;
        let mut strings = [None, None, None];
        for (text, index) in strings.iter_mut().zip(descriptor.strings) {
            if index != 0 {
                *text = Some(self.string(index)?);
            }
        }
        self.set_configuration(configuration.value)?;
        Ok(Device { address: self.host.address, descriptor, configuration, configuration_bytes, strings })
    }
}
