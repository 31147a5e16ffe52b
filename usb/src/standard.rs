//! Refusal of standard requests that `usb-device` would answer for missing interfaces, endpoints or features
//! (USB 2.0 section 9.4).

use usb_device::class_prelude::{ControlIn, ControlOut, UsbBus, UsbClass};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::descriptor_type;

/// Handler that refuses such requests. Must be the first of a device's classes, so that no other sees a
/// refused request.
#[derive(Debug, Default)]
pub struct Standard {
    /// Number of interfaces, numbered from 0.
    interfaces: u8,
    /// Endpoints from the host, beside endpoint 0, one bit each.
    from_host: u16,
    /// Endpoints to the host, beside endpoint 0, one bit each.
    to_host: u16,
    is_configured: bool,
}

/// Returns whether the device is configured behind a SET_CONFIGURATION request; `None` for other requests.
pub fn configures(request: &Request) -> Option<bool> {
    let is_set_configuration = request.request_type == RequestType::Standard
        && request.recipient == Recipient::Device
        && request.request == Request::SET_CONFIGURATION;
    match request.value {
        0 if is_set_configuration => Some(false),
        1 if is_set_configuration => Some(true),
        _ => None,
    }
}

/// Returns the endpoint whose halt a request of the host ends.
pub fn clears_halt(request: &Request) -> Option<u8> {
    let is_clear = request.request_type == RequestType::Standard
        && request.recipient == Recipient::Endpoint
        && request.request == Request::CLEAR_FEATURE
        && request.value == Request::FEATURE_ENDPOINT_HALT;
    is_clear.then_some(request.index as u8)
}

impl Standard {
    /// Adds a function with this number of interfaces, and its endpoints.
    pub const fn add(&mut self, interfaces: u8, from_host: u16, to_host: u16) {
        self.interfaces += interfaces;
        self.from_host |= from_host;
        self.to_host |= to_host;
    }

    fn has_endpoint(&self, index: u16) -> bool {
        let bit = 1 << (index & 0x0F);
        match index & !0x0F {
            0x00 => (self.from_host | 1) & bit != 0,
            0x80 => (self.to_host | 1) & bit != 0,
            _ => false,
        }
    }

    /// Whether the subject of a request exists.
    fn knows(&self, request: &Request) -> bool {
        if request.request_type != RequestType::Standard {
            return true;
        }
        let is_control = request.index & 0x0F == 0;
        match (request.recipient, request.request) {
            (Recipient::Device, Request::GET_DESCRIPTOR) => {
                let (kind, index) = request.descriptor_type_index();
                kind == descriptor_type::STRING || index == 0
            }
            // Remote wake-up and the test modes are not supported.
            (Recipient::Device, Request::SET_FEATURE | Request::CLEAR_FEATURE) => false,
            (Recipient::Interface, _) => self.is_configured && request.index < u16::from(self.interfaces),
            // Halting endpoint 0 is neither required nor useful (section 9.4.5).
            (Recipient::Endpoint, Request::SET_FEATURE) if is_control => false,
            (Recipient::Endpoint, _) => self.has_endpoint(request.index) && (is_control || self.is_configured),
            _ => true,
        }
    }
}

impl<B: UsbBus> UsbClass<B> for Standard {
    fn reset(&mut self) {
        self.is_configured = false;
    }

    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        if !self.knows(transfer.request()) {
            // The transfer waits for an answer, so rejecting cannot fail.
            let _ = transfer.reject();
        }
    }

    fn control_out(&mut self, transfer: ControlOut<'_, '_, '_, B>) {
        if let Some(configured) = configures(transfer.request()) {
            self.is_configured = configured;
        }
        if !self.knows(transfer.request()) {
            // The transfer waits for an answer, so rejecting cannot fail.
            let _ = transfer.reject();
        }
    }
}
