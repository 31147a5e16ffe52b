//! The messages of the USB network redirection protocol 0.7.1, as QEMU speaks it: little-endian and packed
//! (description: <https://gitlab.freedesktop.org/spice/usbredir>, `docs/usb-redirection-protocol.md`).

/// Capabilities that a side has beyond version 0.3 of the protocol, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities(pub u32);

impl Capabilities {
    /// device_connect carries bcdDevice (usb_redir_cap_connect_device_version).
    pub const DEVICE_VERSION: Self = Self(1 << 1);
    /// The peer may send filters for the devices that it wants.
    pub const FILTER: Self = Self(1 << 2);
    /// device_disconnect is acknowledged by the peer.
    pub const DISCONNECT_ACK: Self = Self(1 << 3);
    /// ep_info carries wMaxPacketSize of each endpoint.
    pub const MAX_PACKET: Self = Self(1 << 4);
    /// Identifiers have 64 bits.
    pub const WIDE_IDS: Self = Self(1 << 5);
    /// Lengths of bulk packets have 32 bits.
    pub const LONG_BULK: Self = Self(1 << 6);
    /// Capabilities of this server: all but bulk streams, which full speed does not have, and buffered bulk
    /// input, which is for devices that lose data when nobody fetches them.
    pub const OURS: Self = Self(
        Self::DEVICE_VERSION.0
            | Self::FILTER.0
            | Self::DISCONNECT_ACK.0
            | Self::MAX_PACKET.0
            | Self::WIDE_IDS.0
            | Self::LONG_BULK.0,
    );

    /// Whether the capability `one` is in the set.
    #[must_use]
    pub const fn has(self, one: Self) -> bool {
        self.0 & one.0 != 0
    }

    /// Capabilities that both sides have.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// Result of a request, as a status byte of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// The request was carried out.
    Success = 0,
    /// The peer cancelled the request, or the device has gone.
    Cancelled = 1,
    /// The request makes no sense for this device.
    Invalid = 2,
    /// The device did not answer properly.
    IoError = 3,
    /// The device answered STALL.
    Stall = 4,
    /// The request did not end in time.
    Timeout = 5,
    /// The device sent more than was asked for.
    Babble = 6,
}

impl Status {
    /// Returns the status of a byte; an unknown byte counts as an I/O error of the device.
    #[must_use]
    pub const fn of(byte: u8) -> Self {
        match byte {
            0 => Self::Success,
            1 => Self::Cancelled,
            2 => Self::Invalid,
            4 => Self::Stall,
            5 => Self::Timeout,
            6 => Self::Babble,
            _ => Self::IoError,
        }
    }
}

/// Number of places for endpoints: OUT n has place n, IN n has 16 + n.
pub const PLACES: usize = 32;
/// Type of an endpoint that does not exist. All other types are those of bmAttributes.
pub const NO_ENDPOINT: u8 = 255;
/// Code of full speed, usb_redir_speed_full.
pub const FULL_SPEED: u8 = 1;

/// Returns the index of an endpoint address in ep_info.
#[must_use]
pub const fn place(address: u8) -> usize {
    (address & 0xF) as usize + if address & 0x80 != 0 { 16 } else { 0 }
}

/// An endpoint in ep_info.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndpointInfo {
    /// Transfer type from bmAttributes, or [`NO_ENDPOINT`].
    pub kind: u8,
    /// Polling interval, bInterval. QEMU refuses a device with 0 at an interrupt endpoint.
    pub interval: u8,
    /// Number of the endpoint's interface.
    pub interface: u8,
    /// Greatest packet size, wMaxPacketSize.
    pub max_packet: u16,
}

impl EndpointInfo {
    /// Entry of an endpoint that does not exist.
    pub const NONE: Self = Self { kind: NO_ENDPOINT, interval: 0, interface: 0, max_packet: 0 };
}

/// An interface in interface_info: its number, class, subclass and protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterfaceInfo {
    /// Number of the interface, bInterfaceNumber.
    pub number: u8,
    /// Class, subclass and protocol (bInterfaceClass, bInterfaceSubClass, bInterfaceProtocol).
    pub class: [u8; 3],
}

/// The head of device_connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Speed of the device, as in [`FULL_SPEED`].
    pub speed: u8,
    /// Class, subclass and protocol (bDeviceClass, bDeviceSubClass, bDeviceProtocol).
    pub class: [u8; 3],
    /// Vendor identifier of the device, idVendor.
    pub vendor: u16,
    /// Product identifier of the device, idProduct.
    pub product: u16,
    /// Release of the device, bcdDevice.
    pub release: u16,
}

/// The head of a control packet; the answer repeats the question's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlHead {
    /// Endpoint: 0x80 for a request that the device answers with data, else 0.
    pub endpoint: u8,
    /// Request code of the SETUP packet, bRequest.
    pub request: u8,
    /// Request type of the SETUP packet, bmRequestType.
    pub kind: u8,
    /// Status of the answer; garbage in a request.
    pub status: u8,
    /// Parameter wValue of the SETUP packet.
    pub value: u16,
    /// Parameter wIndex of the SETUP packet.
    pub index: u16,
    /// Length of the data (wLength); in the answer, bytes sent or received.
    pub length: u16,
}

/// The head of a bulk packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BulkHead {
    /// Endpoint address, bit 7 set for IN.
    pub endpoint: u8,
    /// Status of the answer; garbage in a request.
    pub status: u8,
    /// Bytes wanted or sent; in the answer, bytes received or sent.
    pub length: u32,
    /// Bulk stream, always 0 at full speed.
    pub stream: u32,
}

/// A message of either side.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the fields are the protocol's, by the same names")]
pub enum Message {
    /// First message of each side: a name and the side's capabilities.
    Hello(String, Capabilities),
    /// A device has connected.
    DeviceConnect(DeviceInfo),
    /// The device has gone.
    DeviceDisconnect,
    /// Resets the bus; there is no answer.
    Reset,
    /// The interfaces of the configuration.
    InterfaceInfo(Vec<InterfaceInfo>),
    /// The endpoints of all interfaces, by [`place`].
    EpInfo(Box<[EndpointInfo; PLACES]>),
    SetConfiguration {
        configuration: u8,
    },
    GetConfiguration,
    ConfigurationStatus {
        status: u8,
        configuration: u8,
    },
    SetAltSetting {
        interface: u8,
        alt: u8,
    },
    GetAltSetting {
        interface: u8,
    },
    AltSettingStatus {
        status: u8,
        interface: u8,
        alt: u8,
    },
    StartIsoStream {
        endpoint: u8,
    },
    StopIsoStream {
        endpoint: u8,
    },
    IsoStreamStatus {
        status: u8,
        endpoint: u8,
    },
    /// Starts continuous polling of an interrupt endpoint, with its packets sent to the peer.
    StartInterruptReceiving {
        endpoint: u8,
    },
    StopInterruptReceiving {
        endpoint: u8,
    },
    InterruptReceivingStatus {
        status: u8,
        endpoint: u8,
    },
    /// Cancels the request with the message's identifier.
    CancelDataPacket,
    /// The peer refuses this device.
    FilterReject,
    /// Filter rule for the devices that the peer would accept.
    FilterFilter(String),
    DeviceDisconnectAck,
    ControlPacket(ControlHead, Vec<u8>),
    BulkPacket(BulkHead, Vec<u8>),
    InterruptPacket {
        endpoint: u8,
        status: u8,
        length: u16,
        data: Vec<u8>,
    },
    /// A message of a kind that was not agreed on, with the kind's number.
    Other(u32),
}

/// Numbers of the kinds of messages.
pub(super) mod number {
    pub const HELLO: u32 = 0;
    pub const DEVICE_CONNECT: u32 = 1;
    pub const DEVICE_DISCONNECT: u32 = 2;
    pub const RESET: u32 = 3;
    pub const INTERFACE_INFO: u32 = 4;
    pub const EP_INFO: u32 = 5;
    pub const SET_CONFIGURATION: u32 = 6;
    pub const GET_CONFIGURATION: u32 = 7;
    pub const CONFIGURATION_STATUS: u32 = 8;
    pub const SET_ALT_SETTING: u32 = 9;
    pub const GET_ALT_SETTING: u32 = 10;
    pub const ALT_SETTING_STATUS: u32 = 11;
    pub const START_ISO_STREAM: u32 = 12;
    pub const STOP_ISO_STREAM: u32 = 13;
    pub const ISO_STREAM_STATUS: u32 = 14;
    pub const START_INTERRUPT_RECEIVING: u32 = 15;
    pub const STOP_INTERRUPT_RECEIVING: u32 = 16;
    pub const INTERRUPT_RECEIVING_STATUS: u32 = 17;
    pub const CANCEL_DATA_PACKET: u32 = 21;
    pub const FILTER_REJECT: u32 = 22;
    pub const FILTER_FILTER: u32 = 23;
    pub const DEVICE_DISCONNECT_ACK: u32 = 24;
    pub const CONTROL_PACKET: u32 = 100;
    pub const BULK_PACKET: u32 = 101;
    pub const INTERRUPT_PACKET: u32 = 103;
}

impl Message {
    /// Returns the number of the message's kind.
    #[must_use]
    pub const fn kind(&self) -> u32 {
        match self {
            Self::Hello(..) => number::HELLO,
            Self::DeviceConnect(_) => number::DEVICE_CONNECT,
            Self::DeviceDisconnect => number::DEVICE_DISCONNECT,
            Self::Reset => number::RESET,
            Self::InterfaceInfo(_) => number::INTERFACE_INFO,
            Self::EpInfo(_) => number::EP_INFO,
            Self::SetConfiguration { .. } => number::SET_CONFIGURATION,
            Self::GetConfiguration => number::GET_CONFIGURATION,
            Self::ConfigurationStatus { .. } => number::CONFIGURATION_STATUS,
            Self::SetAltSetting { .. } => number::SET_ALT_SETTING,
            Self::GetAltSetting { .. } => number::GET_ALT_SETTING,
            Self::AltSettingStatus { .. } => number::ALT_SETTING_STATUS,
            Self::StartIsoStream { .. } => number::START_ISO_STREAM,
            Self::StopIsoStream { .. } => number::STOP_ISO_STREAM,
            Self::IsoStreamStatus { .. } => number::ISO_STREAM_STATUS,
            Self::StartInterruptReceiving { .. } => number::START_INTERRUPT_RECEIVING,
            Self::StopInterruptReceiving { .. } => number::STOP_INTERRUPT_RECEIVING,
            Self::InterruptReceivingStatus { .. } => number::INTERRUPT_RECEIVING_STATUS,
            Self::CancelDataPacket => number::CANCEL_DATA_PACKET,
            Self::FilterReject => number::FILTER_REJECT,
            Self::FilterFilter(_) => number::FILTER_FILTER,
            Self::DeviceDisconnectAck => number::DEVICE_DISCONNECT_ACK,
            Self::ControlPacket(..) => number::CONTROL_PACKET,
            Self::BulkPacket(..) => number::BULK_PACKET,
            Self::InterruptPacket { .. } => number::INTERRUPT_PACKET,
            Self::Other(kind) => *kind,
        }
    }
}
