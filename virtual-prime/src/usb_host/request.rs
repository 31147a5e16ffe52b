//! Control requests by name: USB 2.0 chapter 9.

/// The eight bytes of a SETUP packet, by field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// bmRequestType.
    pub kind: u8,
    /// bRequest.
    pub request: u8,
    /// wValue.
    pub value: u16,
    /// wIndex.
    pub index: u16,
    /// wLength.
    pub length: u16,
}

impl Setup {
    /// As it goes over the wire.
    #[must_use]
    pub const fn bytes(self) -> [u8; 8] {
        let ([v0, v1], [i0, i1], [l0, l1]) =
            (self.value.to_le_bytes(), self.index.to_le_bytes(), self.length.to_le_bytes());
        [self.kind, self.request, v0, v1, i0, i1, l0, l1]
    }

    /// From the wire.
    #[must_use]
    pub const fn parse(bytes: [u8; 8]) -> Self {
        let [kind, request, v0, v1, i0, i1, l0, l1] = bytes;
        Self {
            kind,
            request,
            value: u16::from_le_bytes([v0, v1]),
            index: u16::from_le_bytes([i0, i1]),
            length: u16::from_le_bytes([l0, l1]),
        }
    }

    /// Data go to the host.
    #[must_use]
    pub const fn reads(self) -> bool {
        self.kind & 0x80 != 0
    }
}

/// bmRequestType: to the device, the host asks.
pub const DEVICE_OUT: u8 = 0x00;
/// The same, the device answers.
pub const DEVICE_IN: u8 = 0x80;
/// To an interface.
pub const INTERFACE_OUT: u8 = 0x01;
/// From an interface.
pub const INTERFACE_IN: u8 = 0x81;
/// To an endpoint.
pub const ENDPOINT_OUT: u8 = 0x02;
/// From an endpoint.
pub const ENDPOINT_IN: u8 = 0x82;
/// A class's request to an interface.
pub const CLASS_OUT: u8 = 0x21;
/// A class's question to an interface.
pub const CLASS_IN: u8 = 0xA1;
/// A vendor's question to the device.
pub const VENDOR_IN: u8 = 0xC0;

/// bRequest.
pub const GET_STATUS: u8 = 0;
/// bRequest.
pub const CLEAR_FEATURE: u8 = 1;
/// bRequest.
pub const SET_FEATURE: u8 = 3;
/// bRequest.
pub const SET_ADDRESS: u8 = 5;
/// bRequest.
pub const GET_DESCRIPTOR: u8 = 6;
/// bRequest.
pub const SET_DESCRIPTOR: u8 = 7;
/// bRequest.
pub const GET_CONFIGURATION: u8 = 8;
/// bRequest.
pub const SET_CONFIGURATION: u8 = 9;
/// bRequest.
pub const GET_INTERFACE: u8 = 10;
/// bRequest.
pub const SET_INTERFACE: u8 = 11;
/// bRequest.
pub const SYNCH_FRAME: u8 = 12;

/// Feature of an endpoint.
pub const ENDPOINT_HALT: u16 = 0;
/// Feature of a device.
pub const REMOTE_WAKEUP: u16 = 1;

/// Descriptor type.
pub const DEVICE: u8 = 1;
/// Descriptor type.
pub const CONFIGURATION: u8 = 2;
/// Descriptor type.
pub const STRING: u8 = 3;
/// Descriptor type.
pub const INTERFACE: u8 = 4;
/// Descriptor type.
pub const ENDPOINT: u8 = 5;
