//! A bus for the class of `usbd-serial` 0.2 that numbers its endpoints and mends its descriptors.
//!
//! The class takes whatever numbers it gets, and says that it knows neither line coding nor serial state. It
//! names the interface and not the association. Nothing can be written to its notification endpoint, which
//! takes 8 bytes each 255 ms where SERIAL_STATE has 10: [`super::SerialPort`] has one of its own under the
//! same number. None of this can be set, and `usb-device` lets nobody change a descriptor that another class
//! has written, so bytes are changed on their way to the host.

use core::sync::atomic::{AtomicUsize, Ordering};

use usb_device::control::Request;
use usb_device::descriptor::descriptor_type;
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

/// Numbers of a port. Those of endpoints are as Smoothieware v2 has them.
#[derive(Clone, Copy)]
pub struct Numbers {
    /// The interface for its requests; the one for its bytes is the next.
    pub control: u8,
    /// Bulk, to the host.
    pub to_host: u8,
    /// Bulk, from the host.
    pub from_host: u8,
    /// Interrupt, to the host.
    pub notify: u8,
}

impl Numbers {
    /// Of the first port.
    pub const FIRST: Self = Self { control: 0, to_host: 0x81, from_host: 0x01, notify: 0x82 };
    /// Of the second one.
    pub const SECOND: Self = Self { control: 2, to_host: 0x83, from_host: 0x02, notify: 0x84 };
}

/// A notification endpoint with room for SERIAL_STATE, and how often a host asks for one, ms.
pub const NOTIFICATION_PACKET: u8 = 16;
pub const NOTIFICATION_INTERVAL: u8 = 32;

/// Bytes of a configuration descriptor before the first port, which no other function precedes, and of each.
const HEAD_BYTES: u8 = 9;
const PORT_BYTES: u8 = 66;
/// Strings before a port's name: languages, maker, product, serial number.
const STRINGS: u8 = 4;
/// The port knows line coding, control lines and serial state (PSTN 1.2, table 4); it sends no break.
const CAPABILITIES: u8 = 0x02;
/// No configuration descriptor is on its way.
const NOWHERE: usize = usize::MAX;

/// What a bus knows of its ports.
pub struct Ports {
    /// How many there are.
    count: u8,
    /// The byte of a configuration descriptor that goes next.
    place: AtomicUsize,
}

/// Places in a configuration descriptor, and what a host is to read there, of each port.
const MENDED: [[(u8, u8); 4]; 2] = [mended(0), mended(1)];

const fn mended(port: u8) -> [(u8, u8); 4] {
    let begin = HEAD_BYTES + PORT_BYTES * port;
    [
        // iFunction of the association: what iInterface has.
        (begin + 7, STRINGS + port),
        // bmCapabilities.
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

    /// The number of an endpoint that the class asks for. Its first one is for notifications.
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

    /// A request has come.
    pub fn look_at(&self, request: &[u8]) {
        let is_configuration =
            matches!(request, &[0x80, Request::GET_DESCRIPTOR, _, descriptor_type::CONFIGURATION, ..]);
        self.place.store(if is_configuration { 0 } else { NOWHERE }, Ordering::Relaxed);
    }

    /// Mends what goes to the host from endpoint 0.
    pub fn mend(&self, packet: &mut [u8]) {
        let place = self.place.load(Ordering::Relaxed);
        for (at, value) in MENDED.iter().take(self.count.into()).flatten() {
            if let Some(byte) = usize::from(*at).checked_sub(place).and_then(|at| packet.get_mut(at)) {
                *byte = *value;
            }
        }
    }

    /// So many bytes have gone from there.
    pub fn pass(&self, bytes: usize) {
        let place = self.place.load(Ordering::Relaxed);
        self.place.store(place.saturating_add(bytes), Ordering::Relaxed);
    }
}
