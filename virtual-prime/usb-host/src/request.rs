//! Control requests by name: USB 2.0 chapter 9.

/// A SETUP packet's eight bytes, by field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Type and direction, bmRequestType.
    pub kind: u8,
    /// Code of the request, bRequest.
    pub request: u8,
    /// Parameter wValue of the request.
    pub value: u16,
    /// Parameter wIndex of the request.
    pub index: u16,
    /// Bytes of the data stage, wLength.
    pub length: u16,
}

impl Setup {
    /// Encodes the packet as on the wire.
    #[must_use]
    pub const fn bytes(self) -> [u8; 8] {
        let ([v0, v1], [i0, i1], [l0, l1]) =
            (self.value.to_le_bytes(), self.index.to_le_bytes(), self.length.to_le_bytes());
        [self.kind, self.request, v0, v1, i0, i1, l0, l1]
    }

    /// Decodes the packet from the wire.
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

    /// Whether the data go to the host.
    #[must_use]
    pub const fn reads(self) -> bool {
        self.kind & 0x80 != 0
    }
}

/// bmRequestType of a standard request to the device, without an answer.
pub const DEVICE_OUT: u8 = 0x00;
/// bmRequestType of a standard request to the device that it answers with data.
pub const DEVICE_IN: u8 = 0x80;
/// bmRequestType of a standard request to an interface.
pub const INTERFACE_OUT: u8 = 0x01;
/// bmRequestType of a standard request that an interface answers.
pub const INTERFACE_IN: u8 = 0x81;
/// bmRequestType of a standard request to an endpoint.
pub const ENDPOINT_OUT: u8 = 0x02;
/// bmRequestType of a standard request that an endpoint answers.
pub const ENDPOINT_IN: u8 = 0x82;
/// bmRequestType of a class's request to an interface.
pub const CLASS_OUT: u8 = 0x21;
/// bmRequestType of a class's request that an interface answers.
pub const CLASS_IN: u8 = 0xA1;
/// bmRequestType of a vendor's request that the device answers.
pub const VENDOR_IN: u8 = 0xC0;

/// bRequest of GET_STATUS, section 9.4.5.
pub const GET_STATUS: u8 = 0;
/// bRequest of CLEAR_FEATURE, section 9.4.1.
pub const CLEAR_FEATURE: u8 = 1;
/// bRequest of SET_FEATURE, section 9.4.9.
pub const SET_FEATURE: u8 = 3;
/// bRequest of SET_ADDRESS, section 9.4.6.
pub const SET_ADDRESS: u8 = 5;
/// bRequest of GET_DESCRIPTOR, section 9.4.3.
pub const GET_DESCRIPTOR: u8 = 6;
/// bRequest of SET_DESCRIPTOR, section 9.4.8.
pub const SET_DESCRIPTOR: u8 = 7;
/// bRequest of GET_CONFIGURATION, section 9.4.2.
pub const GET_CONFIGURATION: u8 = 8;
/// bRequest of SET_CONFIGURATION, section 9.4.7.
pub const SET_CONFIGURATION: u8 = 9;
/// bRequest of GET_INTERFACE, section 9.4.4.
pub const GET_INTERFACE: u8 = 10;
/// bRequest of SET_INTERFACE, section 9.4.10.
pub const SET_INTERFACE: u8 = 11;
/// Feature selector of an endpoint's halt.
pub const ENDPOINT_HALT: u16 = 0;
/// Type of a device descriptor.
pub const DEVICE: u8 = 1;
/// Type of a configuration descriptor.
pub const CONFIGURATION: u8 = 2;
/// Type of a string descriptor.
pub const STRING: u8 = 3;
/// Type of an interface descriptor.
pub const INTERFACE: u8 = 4;
/// Type of an endpoint descriptor.
pub const ENDPOINT: u8 = 5;
