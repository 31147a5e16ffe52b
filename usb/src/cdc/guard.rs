//! Bus wrapper for the class of `usbd-serial` 0.2, which numbers the class's endpoints and corrects its
//! descriptors.
//!
//! The class accepts any endpoint numbers, and declares support for neither line coding nor serial state. The
//! descriptors name the interface instead of the association. The notification endpoint cannot be written,
//! and takes 8 bytes each 255 ms although SERIAL_STATE has 10: [`super::SerialPort`] has its own endpoint
//! under the same number. None of this is configurable, and `usb-device` does not permit changing a
//! descriptor of another class, so bytes are changed on their way to the host.

use core::sync::atomic::{AtomicUsize, Ordering};

use usb_device::control::Request;
use usb_device::descriptor::descriptor_type;
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

/// Interface and endpoint numbers of a port. Endpoint numbers are those of Smoothieware v2.
#[derive(Clone, Copy)]
pub struct Numbers {
    /// Interface for control requests; the data interface is the next number.
    pub control: u8,
    /// Bulk endpoint to the host.
    pub to_host: u8,
    /// Bulk endpoint from the host.
    pub from_host: u8,
    /// Interrupt endpoint to the host.
    pub notify: u8,
}

impl Numbers {
    /// Numbers of the first port.
    pub const FIRST: Self = Self { control: 0, to_host: 0x81, from_host: 0x01, notify: 0x82 };
    /// Numbers of the second port.
    pub const SECOND: Self = Self { control: 2, to_host: 0x83, from_host: 0x02, notify: 0x84 };
}

/// Notification endpoint: packet size with room for SERIAL_STATE, and polling interval, ms.
pub const NOTIFICATION_PACKET: u8 = 16;
pub const NOTIFICATION_INTERVAL: u8 = 32;

/// Bytes of a configuration descriptor before the first port, which no other function precedes, and of each
/// port.
const HEAD_BYTES: u8 = 9;
const PORT_BYTES: u8 = 66;
/// Strings before a port's name: languages, maker, product, serial number.
const STRINGS: u8 = 4;
/// Capabilities of the port: line coding, control lines and serial state (PSTN 1.2, table 4), but no break.
const CAPABILITIES: u8 = 0x02;
/// No configuration descriptor is being sent.
const NOWHERE: usize = usize::MAX;

/// Ports of a bus, and the progress of a configuration descriptor.
pub struct Ports {
    /// Number of ports allocated so far.
    count: u8,
    /// Offset of the configuration descriptor's next byte.
    place: AtomicUsize,
}

/// Offsets in a configuration descriptor, and the corrected bytes, of each port.
const MENDED: [[(u8, u8); 4]; 2] = [mended(0), mended(1)];

const fn mended(port: u8) -> [(u8, u8); 4] {
    let begin = HEAD_BYTES + PORT_BYTES * port;
    [
        // iFunction of the association gets the class's iInterface string.
        (begin + 7, STRINGS + port),
        // bmCapabilities of the port's functional descriptor.
        (begin + 25, CAPABILITIES),
        // wMaxPacketSize and bInterval of the notification endpoint.
        (begin + 40, NOTIFICATION_PACKET),
        (begin + 42, NOTIFICATION_INTERVAL),
    ]
}

impl Ports {
    pub const fn new() -> Self {
        Self { count: 0, place: AtomicUsize::new(NOWHERE) }
    }

    /// Returns the number for the next endpoint that the class allocates. The first of a port is for
    /// notifications.
    pub fn number(&mut self, direction: UsbDirection, kind: EndpointType) -> Result<EndpointAddress> {
        self.count += u8::from(kind == EndpointType::Interrupt);
        let numbers = match self.count {
            1 => Numbers::FIRST,
            2 => Numbers::SECOND,
            _ => return Err(UsbError::EndpointOverflow),
        };
        let number = match (kind, direction) {
            (EndpointType::Interrupt, _) => numbers.notify,
            (_, UsbDirection::In) => numbers.to_host,
            (_, UsbDirection::Out) => numbers.from_host,
        };
        Ok(number.into())
    }

    /// Notes a request, to detect one for the configuration descriptor.
    pub fn look_at(&self, request: &[u8]) {
        let is_configuration =
            matches!(request, &[0x80, Request::GET_DESCRIPTOR, _, descriptor_type::CONFIGURATION, ..]);
        self.place.store(if is_configuration { 0 } else { NOWHERE }, Ordering::Relaxed);
    }

    /// Corrects a packet of endpoint 0 to the host.
    pub fn mend(&self, packet: &mut [u8]) {
        let place = self.place.load(Ordering::Relaxed);
        for (at, value) in MENDED.iter().take(self.count.into()).flatten() {
            if let Some(byte) = usize::from(*at).checked_sub(place).and_then(|at| packet.get_mut(at)) {
                *byte = *value;
            }
        }
    }

    /// Notes that this number of bytes has been sent.
    pub fn pass(&self, bytes: usize) {
        let place = self.place.load(Ordering::Relaxed);
        self.place.store(place.saturating_add(bytes), Ordering::Relaxed);
    }
}
