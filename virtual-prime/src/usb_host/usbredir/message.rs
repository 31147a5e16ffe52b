//! The messages of the USB network redirection protocol 0.7.1, as QEMU speaks it: little-endian and packed
//! (description: <https://gitlab.freedesktop.org/spice/usbredir>, `docs/usb-redirection-protocol.md`).

/// Which additions to version 0.3 a side knows: a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities(pub u32);

impl Capabilities {
    /// device_connect says bcdDevice.
    pub const DEVICE_VERSION: Self = Self(1 << 1);
    /// The peer may say which devices it wants.
    pub const FILTER: Self = Self(1 << 2);
    /// device_disconnect is acknowledged.
    pub const DISCONNECT_ACK: Self = Self(1 << 3);
    /// ep_info says wMaxPacketSize.
    pub const MAX_PACKET: Self = Self(1 << 4);
    /// Identifiers of 64 bits.
    pub const WIDE_IDS: Self = Self(1 << 5);
    /// Lengths of bulk packets of 32 bits.
    pub const LONG_BULK: Self = Self(1 << 6);
    /// What this side knows: all but bulk streams, which full speed does not have, and buffered bulk input,
    /// which is for devices that lose what is not fetched.
    pub const OURS: Self = Self(
        Self::DEVICE_VERSION.0
            | Self::FILTER.0
            | Self::DISCONNECT_ACK.0
            | Self::MAX_PACKET.0
            | Self::WIDE_IDS.0
            | Self::LONG_BULK.0,
    );

    /// Whether this is among them.
    #[must_use]
    pub const fn has(self, one: Self) -> bool {
        self.0 & one.0 != 0
    }

    /// What both sides know.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// How a request ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// As it should.
    Success = 0,
    /// Whoever asked did not want it any more, or the device has gone.
    Cancelled = 1,
    /// It makes no sense for this device.
    Invalid = 2,
    /// The device did not answer properly.
    IoError = 3,
    /// The device answered STALL.
    Stall = 4,
    /// Not in time.
    Timeout = 5,
    /// The device sent more than was asked for.
    Babble = 6,
}

impl Status {
    /// From its byte; one that is not known is an error of the device.
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

/// Places for endpoints: OUT n has n, IN n has 16 + n.
pub const PLACES: usize = 32;
/// Type of an endpoint that is not there. The others are those of bmAttributes.
pub const NO_ENDPOINT: u8 = 255;
/// usb_redir_speed_full.
pub const FULL_SPEED: u8 = 1;

/// Where an endpoint stands in ep_info.
#[must_use]
pub const fn place(address: u8) -> usize {
    (address & 0xF) as usize + if address & 0x80 != 0 { 16 } else { 0 }
}

/// An endpoint in ep_info.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndpointInfo {
    /// bmAttributes, or [`NO_ENDPOINT`].
    pub kind: u8,
    /// bInterval. QEMU refuses a device with 0 at an interrupt endpoint.
    pub interval: u8,
    /// Its interface.
    pub interface: u8,
    /// wMaxPacketSize.
    pub max_packet: u16,
}

impl EndpointInfo {
    /// None.
    pub const NONE: Self = Self { kind: NO_ENDPOINT, interval: 0, interface: 0, max_packet: 0 };
}

/// An interface in interface_info: its number, class, subclass and protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterfaceInfo {
    /// bInterfaceNumber.
    pub number: u8,
    /// bInterfaceClass, bInterfaceSubClass, bInterfaceProtocol.
    pub class: [u8; 3],
}

/// The head of device_connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// As in [`FULL_SPEED`].
    pub speed: u8,
    /// bDeviceClass, bDeviceSubClass, bDeviceProtocol.
    pub class: [u8; 3],
    /// idVendor.
    pub vendor: u16,
    /// idProduct.
    pub product: u16,
    /// bcdDevice.
    pub release: u16,
}

/// The head of a control packet; the answer repeats the question's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlHead {
    /// 0x80 for a question that the device answers with data, else 0.
    pub endpoint: u8,
    /// bRequest.
    pub request: u8,
    /// bmRequestType.
    pub kind: u8,
    /// Of the answer; garbage in a request.
    pub status: u8,
    /// wValue.
    pub value: u16,
    /// wIndex.
    pub index: u16,
    /// wLength, and in the answer the bytes that went or came.
    pub length: u16,
}

/// The head of a bulk packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BulkHead {
    /// Its address, bit 7 for IN.
    pub endpoint: u8,
    /// Of the answer; garbage in a request.
    pub status: u8,
    /// Bytes that are wanted or sent, and in the answer those that came or went.
    pub length: u32,
    /// Always 0 at full speed.
    pub stream: u32,
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the fields are the protocol's, by the same names")]
pub enum Message {
    /// The first of each side: a name, and what it knows.
    Hello(String, Capabilities),
    /// A device is there.
    DeviceConnect(DeviceInfo),
    /// It has gone.
    DeviceDisconnect,
    /// Reset the bus; there is no answer.
    Reset,
    /// The interfaces of the configuration.
    InterfaceInfo(Vec<InterfaceInfo>),
    /// Its endpoints, by [`place`].
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
    /// Keep asking an interrupt endpoint, and send what comes.
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
    /// The request with this message's identifier is not wanted any more.
    CancelDataPacket,
    /// The peer does not want this device.
    FilterReject,
    /// What it would want.
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
    /// A message of a kind that was not agreed on: its number.
    Other(u32),
}

/// Numbers of messages.
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
    /// The number of its kind.
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
