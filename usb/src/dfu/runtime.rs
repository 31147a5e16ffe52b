//! Entry from the running machine into the firmware download.

use usb_device::Result;
use usb_device::bus::{InterfaceNumber, StringIndex};
use usb_device::class_prelude::{ControlIn, ControlOut, DescriptorWriter, UsbBus, UsbBusAllocator, UsbClass};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::lang_id::LangID;
use usb_device::device::DEFAULT_ALTERNATE_SETTING;

use super::protocol::{CLASS, FUNCTIONAL, PROTOCOL_RUNTIME, SUBCLASS, State, functional, request, status};

/// Handler that decides whether the machine may enter the download.
pub trait Detach {
    /// Asks the machine to stop and to start the download. Returns false when the machine moves or heats, and
    /// goes on.
    fn detach(&mut self) -> bool;
}

/// Interface by which a host requests the download.
pub struct DfuRuntime<D> {
    interface: InterfaceNumber,
    name: (StringIndex, &'static str),
    machine: D,
    state: State,
}

impl<D: Detach> DfuRuntime<D> {
    /// Creates the interface for this machine.
    pub fn new<B: UsbBus>(bus: &UsbBusAllocator<B>, name: &'static str, machine: D) -> Self {
        Self { interface: bus.interface(), name: (bus.string(), name), machine, state: State::AppIdle }
    }

    /// Returns the interface number.
    pub fn interface(&self) -> u8 {
        self.interface.into()
    }

    fn is_for_us(&self, request: &Request) -> bool {
        request.request_type == RequestType::Class
            && request.recipient == Recipient::Interface
            && request.index == u16::from(self.interface())
    }
}

impl<B: UsbBus, D: Detach> UsbClass<B> for DfuRuntime<D> {
    fn get_configuration_descriptors(&self, writer: &mut DescriptorWriter<'_>) -> Result<()> {
        let (interface, name) = (self.interface, Some(self.name.0));
        writer.interface_alt(interface, DEFAULT_ALTERNATE_SETTING, CLASS, SUBCLASS, PROTOCOL_RUNTIME, name)?;
        writer.write(FUNCTIONAL, &functional())
    }

    fn get_string(&self, index: StringIndex, _: LangID) -> Option<&str> {
        (index == self.name.0).then_some(self.name.1)
    }

    fn reset(&mut self) {
        self.state = State::AppIdle;
    }

    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        let request = transfer.request();
        if !self.is_for_us(request) {
            return;
        }
        // The transfer waits for an answer, and these fit its buffer.
        let _ = match request.request {
            request::GETSTATUS => transfer.accept_with(&status(None, 0, self.state, 0)),
            request::GETSTATE => transfer.accept_with(&[self.state as u8]),
            _ => transfer.reject(),
        };
    }

    fn control_out(&mut self, transfer: ControlOut<'_, '_, '_, B>) {
        let request = transfer.request();
        if !self.is_for_us(request) {
            return;
        }
        let accepted = request.request == request::DETACH && self.machine.detach();
        if accepted {
            self.state = State::AppDetach;
        }
        // The transfer waits for an answer, so answering cannot fail.
        let _ = if accepted { transfer.accept() } else { transfer.reject() };
    }
}
