//! Encoding and decoding of usbredir messages as bytes.

use std::fmt;

use super::message::{
    BulkHead, Capabilities, ControlHead, DeviceInfo, EndpointInfo, InterfaceInfo, Message, PLACES, number,
};

/// Length of the name in HELLO.
const NAME_BYTES: usize = 64;

/// Bytes that are no valid message, with the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Malformed(pub String);

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The rest of a message's body.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (head, rest) = self.0.split_first_chunk().ok_or_else(|| Malformed("it is too short".into()))?;
        self.0 = rest;
        Ok(*head)
    }

    fn u8(&mut self) -> Result<u8, Malformed> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    fn text(self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).unwrap_or(self.0.len());
        String::from_utf8_lossy(&self.0[..end]).into_owned()
    }
}

impl Message {
    /// Decodes the body of a message of kind `kind`, under the capabilities that both sides have.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(kind: u32, body: &[u8], agreed: Capabilities) -> Result<Self, Malformed> {
        let mut rest = Rest(body);
        Ok(match kind {
            number::HELLO => {
                let name = Rest(&rest.array::<NAME_BYTES>()?).text();
                let known = if rest.0.is_empty() { 0 } else { rest.u32()? };
                Self::Hello(name, Capabilities(known))
            }
            number::DEVICE_CONNECT => Self::DeviceConnect(device(&mut rest, agreed)?),
            number::DEVICE_DISCONNECT => Self::DeviceDisconnect,
            number::RESET => Self::Reset,
            number::INTERFACE_INFO => Self::InterfaceInfo(interfaces(&mut rest)?),
            number::EP_INFO => Self::EpInfo(endpoints(&mut rest, agreed)?),
            number::SET_CONFIGURATION => Self::SetConfiguration { configuration: rest.u8()? },
            number::GET_CONFIGURATION => Self::GetConfiguration,
            number::CONFIGURATION_STATUS => Self::ConfigurationStatus { status: rest.u8()?, configuration: rest.u8()? },
            number::SET_ALT_SETTING => Self::SetAltSetting { interface: rest.u8()?, alt: rest.u8()? },
            number::GET_ALT_SETTING => Self::GetAltSetting { interface: rest.u8()? },
            number::ALT_SETTING_STATUS => {
                Self::AltSettingStatus { status: rest.u8()?, interface: rest.u8()?, alt: rest.u8()? }
            }
            number::START_ISO_STREAM => Self::StartIsoStream { endpoint: rest.u8()? },
            number::STOP_ISO_STREAM => Self::StopIsoStream { endpoint: rest.u8()? },
            number::ISO_STREAM_STATUS => Self::IsoStreamStatus { status: rest.u8()?, endpoint: rest.u8()? },
            number::START_INTERRUPT_RECEIVING => Self::StartInterruptReceiving { endpoint: rest.u8()? },
            number::STOP_INTERRUPT_RECEIVING => Self::StopInterruptReceiving { endpoint: rest.u8()? },
            number::INTERRUPT_RECEIVING_STATUS => {
                Self::InterruptReceivingStatus { status: rest.u8()?, endpoint: rest.u8()? }
            }
            number::CANCEL_DATA_PACKET => Self::CancelDataPacket,
            number::FILTER_REJECT => Self::FilterReject,
            number::FILTER_FILTER => Self::FilterFilter(rest.text()),
            number::DEVICE_DISCONNECT_ACK => Self::DeviceDisconnectAck,
            number::CONTROL_PACKET => Self::ControlPacket(control_head(&mut rest)?, rest.0.to_vec()),
            number::BULK_PACKET => Self::BulkPacket(bulk_head(&mut rest, agreed)?, rest.0.to_vec()),
            number::INTERRUPT_PACKET => Self::InterruptPacket {
                endpoint: rest.u8()?,
                status: rest.u8()?,
                length: rest.u16()?,
                data: rest.0.to_vec(),
            },
            other => Self::Other(other),
        })
    }

    /// Encodes the body of the message, for a peer with these agreed capabilities.
    #[must_use]
    pub fn body(&self, agreed: Capabilities) -> Vec<u8> {
        let mut body = Vec::new();
        match self {
            Self::Hello(name, known) => {
                body.extend(name.bytes().take(NAME_BYTES - 1));
                body.resize(NAME_BYTES, 0);
                body.extend(known.0.to_le_bytes());
            }
            Self::DeviceConnect(device) => put_device(&mut body, device, agreed),
            Self::InterfaceInfo(interfaces) => put_interfaces(&mut body, interfaces),
            Self::EpInfo(endpoints) => put_endpoints(&mut body, endpoints, agreed),
            Self::SetConfiguration { configuration } => body.push(*configuration),
            Self::ConfigurationStatus { status, configuration } => body.extend([*status, *configuration]),
            Self::SetAltSetting { interface, alt } => body.extend([*interface, *alt]),
            Self::GetAltSetting { interface } => body.push(*interface),
            Self::AltSettingStatus { status, interface, alt } => body.extend([*status, *interface, *alt]),
            Self::StartIsoStream { endpoint } | Self::StopIsoStream { endpoint } => body.push(*endpoint),
            Self::StartInterruptReceiving { endpoint } | Self::StopInterruptReceiving { endpoint } => {
                body.push(*endpoint);
            }
            Self::IsoStreamStatus { status, endpoint } | Self::InterruptReceivingStatus { status, endpoint } => {
                body.extend([*status, *endpoint]);
            }
            Self::FilterFilter(rules) => {
                body.extend(rules.bytes());
                body.push(0);
            }
            Self::ControlPacket(head, data) => {
                body.extend([head.endpoint, head.request, head.kind, head.status]);
                body.extend([head.value, head.index, head.length].map(u16::to_le_bytes).concat());
                body.extend(data);
            }
            Self::BulkPacket(head, data) => {
                put_bulk_head(&mut body, head, agreed);
                body.extend(data);
            }
            Self::InterruptPacket { endpoint, status, length, data } => {
                body.extend([*endpoint, *status]);
                body.extend(length.to_le_bytes());
                body.extend(data);
            }
            Self::DeviceDisconnect
            | Self::Reset
            | Self::GetConfiguration
            | Self::CancelDataPacket
            | Self::FilterReject
            | Self::DeviceDisconnectAck
            | Self::Other(_) => {}
        }
        body
    }
}

fn device(rest: &mut Rest<'_>, agreed: Capabilities) -> Result<DeviceInfo, Malformed> {
    Ok(DeviceInfo {
        speed: rest.u8()?,
        class: rest.array()?,
        vendor: rest.u16()?,
        product: rest.u16()?,
        release: if agreed.has(Capabilities::DEVICE_VERSION) { rest.u16()? } else { 0 },
    })
}

fn put_device(body: &mut Vec<u8>, device: &DeviceInfo, agreed: Capabilities) {
    body.push(device.speed);
    body.extend(device.class);
    body.extend([device.vendor, device.product].map(u16::to_le_bytes).concat());
    if agreed.has(Capabilities::DEVICE_VERSION) {
        body.extend(device.release.to_le_bytes());
    }
}

fn control_head(rest: &mut Rest<'_>) -> Result<ControlHead, Malformed> {
    Ok(ControlHead {
        endpoint: rest.u8()?,
        request: rest.u8()?,
        kind: rest.u8()?,
        status: rest.u8()?,
        value: rest.u16()?,
        index: rest.u16()?,
        length: rest.u16()?,
    })
}

fn bulk_head(rest: &mut Rest<'_>, agreed: Capabilities) -> Result<BulkHead, Malformed> {
    let (endpoint, status, low, stream) = (rest.u8()?, rest.u8()?, rest.u16()?, rest.u32()?);
    let high = if agreed.has(Capabilities::LONG_BULK) { rest.u16()? } else { 0 };
    Ok(BulkHead { endpoint, status, length: u32::from(high) << 16 | u32::from(low), stream })
}

fn put_bulk_head(body: &mut Vec<u8>, head: &BulkHead, agreed: Capabilities) {
    body.extend([head.endpoint, head.status]);
    body.extend((head.length as u16).to_le_bytes());
    body.extend(head.stream.to_le_bytes());
    if agreed.has(Capabilities::LONG_BULK) {
        body.extend(((head.length >> 16) as u16).to_le_bytes());
    }
}

fn interfaces(rest: &mut Rest<'_>) -> Result<Vec<InterfaceInfo>, Malformed> {
    let count = rest.u32()? as usize;
    let numbers: [u8; PLACES] = rest.array()?;
    let classes: [[u8; PLACES]; 3] = [rest.array()?, rest.array()?, rest.array()?];
    let of = |index: usize| InterfaceInfo { number: numbers[index], class: classes.map(|all| all[index]) };
    Ok((0..count.min(PLACES)).map(of).collect())
}

fn put_interfaces(body: &mut Vec<u8>, interfaces: &[InterfaceInfo]) {
    let mut columns = [[0; PLACES]; 4];
    let shown = &interfaces[..interfaces.len().min(PLACES)];
    for (index, interface) in shown.iter().enumerate() {
        let [c0, c1, c2] = interface.class;
        for (column, byte) in columns.iter_mut().zip([interface.number, c0, c1, c2]) {
            column[index] = byte;
        }
    }
    body.extend((shown.len() as u32).to_le_bytes());
    body.extend(columns.concat());
}

fn endpoints(rest: &mut Rest<'_>, agreed: Capabilities) -> Result<Box<[EndpointInfo; PLACES]>, Malformed> {
    let [kinds, intervals, interfaces]: [[u8; PLACES]; 3] = [rest.array()?, rest.array()?, rest.array()?];
    let mut all = Box::new([EndpointInfo::NONE; PLACES]);
    for (index, endpoint) in all.iter_mut().enumerate() {
        let max_packet = if agreed.has(Capabilities::MAX_PACKET) { rest.u16()? } else { 0 };
        let (kind, interval, interface) = (kinds[index], intervals[index], interfaces[index]);
        *endpoint = EndpointInfo { kind, interval, interface, max_packet };
    }
    Ok(all)
}

fn put_endpoints(body: &mut Vec<u8>, endpoints: &[EndpointInfo; PLACES], agreed: Capabilities) {
    body.extend(endpoints.map(|endpoint| endpoint.kind));
    body.extend(endpoints.map(|endpoint| endpoint.interval));
    body.extend(endpoints.map(|endpoint| endpoint.interface));
    if agreed.has(Capabilities::MAX_PACKET) {
        body.extend(endpoints.map(|endpoint| endpoint.max_packet.to_le_bytes()).concat());
    }
}
