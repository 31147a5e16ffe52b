//! Bus wrapper that answers requests which `usb-device` leaves unanswered on endpoint 0, and corrects the
//! serial class.

use core::sync::atomic::{AtomicBool, Ordering};

use heapless::Vec;
use usb_device::bus::{PollResult, UsbBus};
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

use crate::PACKET_BYTES;
use crate::cdc::Ports;

/// Longest data stage from the host that `usb-device` takes, with its feature `control-buffer-256`.
pub const CONTROL_BYTES: u16 = 256;
/// Addresses of endpoint 0, both ways.
const CONTROL_OUT: u8 = 0x00;
const CONTROL_IN: u8 = 0x80;

/// Bus with two refusals added: `usb-device` 0.3 ignores a request whose data stage is longer than its
/// buffer, and data of the host when none is due; the host would wait for its time-out of five seconds. Both
/// are request errors, answered by a stall until the next request (USB 2.0 section 9.2.7).
///
/// The wrapper also numbers the endpoints of serial ports and corrects their descriptors (`cdc/guard.rs`).
pub struct Guarded<B> {
    bus: B,
    /// Whether the next packet of endpoint 0 is a request.
    is_setup: AtomicBool,
    ports: Ports,
}

impl<B> Guarded<B> {
    /// Wraps a bus before its first request.
    pub const fn new(bus: B) -> Self {
        Self { bus, is_setup: AtomicBool::new(false), ports: Ports::new() }
    }

    /// Returns the wrapped bus.
    pub const fn bus(&self) -> &B {
        &self.bus
    }
}

/// Returns the length of the data stage from the host that a request announces.
fn announced(request: &[u8]) -> u16 {
    match *request {
        [kind, _, _, _, _, _, low, high] if kind & UsbDirection::In as u8 == 0 => u16::from_le_bytes([low, high]),
        _ => 0,
    }
}

impl<B: UsbBus> Guarded<B> {
    fn refuse(&self) {
        self.bus.set_stalled(CONTROL_OUT.into(), true);
        self.bus.set_stalled(CONTROL_IN.into(), true);
    }

    /// Sends a packet of endpoint 0. Cold, to keep the path of other packets short.
    #[cold]
    fn answer(&self, packet: &[u8]) -> Result<usize> {
        let mut mended = Vec::<u8, PACKET_BYTES>::from_slice(packet).map_err(|_| UsbError::BufferOverflow)?;
        self.ports.mend(&mut mended);
        let written = self.bus.write(CONTROL_IN.into(), &mended);
        self.ports.pass(*written.as_ref().unwrap_or(&0));
        written
    }
}

impl<B: UsbBus> UsbBus for Guarded<B> {
    const QUIRK_SET_ADDRESS_BEFORE_STATUS: bool = B::QUIRK_SET_ADDRESS_BEFORE_STATUS;

    fn alloc_ep(
        &mut self,
        direction: UsbDirection,
        address: Option<EndpointAddress>,
        kind: EndpointType,
        packet: u16,
        interval: u8,
    ) -> Result<EndpointAddress> {
        let numbered = address.map_or_else(|| self.ports.number(direction, kind), Ok)?;
        if address.is_none() && kind == EndpointType::Interrupt {
            // The port allocates its own notification endpoint.
            return Ok(numbered);
        }
        self.bus.alloc_ep(direction, Some(numbered), kind, packet, interval)
    }

    fn enable(&mut self) {
        self.bus.enable();
    }

    fn reset(&self) {
        self.is_setup.store(false, Ordering::Relaxed);
        self.bus.reset();
    }

    fn set_device_address(&self, address: u8) {
        self.bus.set_device_address(address);
    }

    fn write(&self, endpoint: EndpointAddress, packet: &[u8]) -> Result<usize> {
        if endpoint == EndpointAddress::from(CONTROL_IN) {
            return self.answer(packet);
        }
        self.bus.write(endpoint, packet)
    }

    fn read(&self, endpoint: EndpointAddress, into: &mut [u8]) -> Result<usize> {
        let read = self.bus.read(endpoint, into);
        if endpoint != EndpointAddress::from(CONTROL_OUT) {
            return read;
        }
        let was_setup = self.is_setup.swap(false, Ordering::Relaxed);
        let is_wrong = match read {
            Ok(count) if was_setup => {
                let request = into.get(..count).unwrap_or_default();
                self.ports.look_at(request);
                announced(request) > CONTROL_BYTES
            }
            Ok(_) => false,
            Err(error) => error == UsbError::BufferOverflow,
        };
        if !is_wrong {
            return read;
        }
        self.refuse();
        // For `usb-device`, nothing has arrived.
        Err(UsbError::WouldBlock)
    }

    fn set_stalled(&self, endpoint: EndpointAddress, stalled: bool) {
        self.bus.set_stalled(endpoint, stalled);
    }

    fn is_stalled(&self, endpoint: EndpointAddress) -> bool {
        self.bus.is_stalled(endpoint)
    }

    fn suspend(&self) {
        self.bus.suspend();
    }

    fn resume(&self) {
        self.bus.resume();
    }

    fn poll(&self) -> PollResult {
        let result = self.bus.poll();
        if let PollResult::Data { ep_setup, .. } = result
            && ep_setup & 1 != 0
        {
            self.is_setup.store(true, Ordering::Relaxed);
        }
        result
    }

    fn force_reset(&self) -> Result<()> {
        self.bus.force_reset()
    }
}

#[cfg(test)]
mod tests {
    use super::announced;

    #[test]
    fn a_request_announces_what_the_host_will_send() {
        assert_eq!(announced(&[0x21, 0x20, 0, 0, 0, 0, 0x34, 0x12]), 0x1234);
        assert_eq!(announced(&[0xA1, 0x21, 0, 0, 0, 0, 0x34, 0x12]), 0, "that comes from the device");
        assert_eq!(announced(&[0x21, 0x20]), 0);
    }
}
