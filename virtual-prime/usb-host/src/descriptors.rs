//! Descriptors of a device, USB 2.0 section 9.6.

use super::request;
use super::transfer::{Direction, Endpoint, Kind};

/// A device descriptor, decoded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceDescriptor {
    /// Release of the USB specification, bcdUSB.
    pub usb: u16,
    /// Class, subclass and protocol (bDeviceClass, bDeviceSubClass, bDeviceProtocol).
    pub class: [u8; 3],
    /// Greatest packet size of endpoint 0, bMaxPacketSize0.
    pub max_packet0: u8,
    /// Vendor identifier of the device, idVendor.
    pub vendor: u16,
    /// Product identifier of the device, idProduct.
    pub product: u16,
    /// Release of the device, bcdDevice.
    pub release: u16,
    /// Indices of the strings for manufacturer, product and serial number; 0 is none.
    pub strings: [u8; 3],
    /// Number of configurations, bNumConfigurations.
    pub configurations: u8,
}

impl DeviceDescriptor {
    /// Decodes the descriptor from its 18 bytes.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let &[length, kind, u0, u1, c0, c1, c2, max_packet0, v0, v1, p0, p1, r0, r1, s0, s1, s2, configurations] =
            bytes
        else {
            return Err(format!("a device descriptor of {} bytes", bytes.len()));
        };
        if (length, kind) != (18, request::DEVICE) {
            return Err(format!("a device descriptor that begins with {length:#04x} {kind:#04x}"));
        }
        Ok(Self {
            usb: u16::from_le_bytes([u0, u1]),
            class: [c0, c1, c2],
            max_packet0,
            vendor: u16::from_le_bytes([v0, v1]),
            product: u16::from_le_bytes([p0, p1]),
            release: u16::from_le_bytes([r0, r1]),
            strings: [s0, s1, s2],
            configurations,
        })
    }
}

/// An interface, or one of its alternate settings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Interface {
    /// Number of the interface, bInterfaceNumber.
    pub number: u8,
    /// Number of the alternate setting, bAlternateSetting.
    pub setting: u8,
    /// Class, subclass and protocol (bInterfaceClass, bInterfaceSubClass, bInterfaceProtocol).
    pub class: [u8; 3],
    /// Index of the string, iInterface.
    pub string: u8,
    /// Endpoints of the interface.
    pub endpoints: Vec<EndpointDescriptor>,
    /// Class-specific descriptors, each whole.
    pub extra: Vec<Vec<u8>>,
}

impl Interface {
    /// Returns the endpoint of this direction and transfer type (bmAttributes).
    #[must_use]
    pub fn endpoint(&self, direction: Direction, kind: u8) -> Option<&EndpointDescriptor> {
        self.endpoints.iter().find(|endpoint| endpoint.direction() == direction && endpoint.attributes & 3 == kind)
    }
}

/// An endpoint descriptor, decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndpointDescriptor {
    /// Endpoint address with direction, bEndpointAddress.
    pub address: u8,
    /// Transfer type from bmAttributes: 2 is bulk, 3 interrupt.
    pub attributes: u8,
    /// Greatest packet size, wMaxPacketSize.
    pub max_packet: u16,
    /// Polling interval in frames, bInterval.
    pub interval: u8,
}

/// Bulk transfer type in bmAttributes.
pub const BULK: u8 = 2;
/// Interrupt transfer type in bmAttributes.
pub const INTERRUPT: u8 = 3;

impl EndpointDescriptor {
    /// Returns the direction of the endpoint's data.
    #[must_use]
    pub const fn direction(&self) -> Direction {
        if self.address & 0x80 == 0 { Direction::Out } else { Direction::In }
    }

    /// Returns the endpoint as the host controller needs it.
    #[must_use]
    pub fn of(&self, device: u8) -> Endpoint {
        let kind = if self.attributes & 3 == INTERRUPT {
            Kind::Interrupt { frames: u16::from(self.interval.max(1)) }
        } else {
            Kind::Bulk
        };
        Endpoint {
            device,
            number: self.address & 0xF,
            direction: self.direction(),
            kind,
            max_packet: self.max_packet & 0x7FF,
        }
    }
}

/// A configuration descriptor with its interfaces.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Configuration {
    /// Number of the configuration, bConfigurationValue.
    pub value: u8,
    /// Attributes of the configuration, bmAttributes.
    pub attributes: u8,
    /// Current drawn from the bus (bMaxPower), in units of 2 mA.
    pub power: u8,
    /// Number of interfaces announced, bNumInterfaces.
    pub announced: u8,
    /// Every interface and setting, in order.
    pub interfaces: Vec<Interface>,
    /// Interface association descriptors, whole.
    pub associations: Vec<Vec<u8>>,
}

/// Descriptor type of an interface association.
const ASSOCIATION: u8 = 11;

impl Configuration {
    /// Decodes the configuration from its wTotalLength bytes.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let &[9, request::CONFIGURATION, t0, t1, announced, value, _, attributes, power, ..] = bytes else {
            return Err(format!("a configuration descriptor that begins with {:02x?}", &bytes[..bytes.len().min(9)]));
        };
        let total = usize::from(u16::from_le_bytes([t0, t1]));
        if total != bytes.len() {
            return Err(format!("wTotalLength is {total}, and {} bytes came", bytes.len()));
        }
        let mut all = Self { value, attributes, power, announced, ..Self::default() };
        let mut rest = &bytes[9..];
        while let Some(&length) = rest.first() {
            let length = usize::from(length);
            if length < 2 || length > rest.len() {
                return Err(format!("a descriptor of {length} bytes where {} are left", rest.len()));
            }
            let (descriptor, after) = rest.split_at(length);
            all.take(descriptor)?;
            rest = after;
        }
        Ok(all)
    }

    fn take(&mut self, descriptor: &[u8]) -> Result<(), String> {
        match *descriptor {
            [9, request::INTERFACE, number, setting, _, c0, c1, c2, string] => {
                let class = [c0, c1, c2];
                self.interfaces.push(Interface { number, setting, class, string, ..Interface::default() });
            }
            [7 | 9, request::ENDPOINT, address, attributes, m0, m1, interval, ..] => {
                let max_packet = u16::from_le_bytes([m0, m1]);
                let endpoint = EndpointDescriptor { address, attributes, max_packet, interval };
                let interface = self.interfaces.last_mut().ok_or("an endpoint before any interface")?;
                interface.endpoints.push(endpoint);
            }
            [8, ASSOCIATION, ..] => self.associations.push(descriptor.to_vec()),
            [_, request::INTERFACE | request::ENDPOINT, ..] => {
                return Err(format!("a descriptor with a wrong length: {descriptor:02x?}"));
            }
            _ => match self.interfaces.last_mut() {
                Some(interface) => interface.extra.push(descriptor.to_vec()),
                None => return Err(format!("before any interface: {descriptor:02x?}")),
            },
        }
        Ok(())
    }

    /// Returns the interface settings of this class and subclass.
    pub fn of_class(&self, class: u8, subclass: u8) -> impl Iterator<Item = &Interface> {
        self.interfaces.iter().filter(move |interface| interface.class[..2] == [class, subclass])
    }

    /// Returns the interface with this number, in its first setting.
    #[must_use]
    pub fn interface(&self, number: u8) -> Option<&Interface> {
        self.interfaces.iter().find(|interface| interface.number == number)
    }
}

/// Decodes a string descriptor's text.
///
/// # Errors
/// What is wrong with it.
pub fn text(bytes: &[u8]) -> Result<String, String> {
    let &[length, request::STRING, ..] = bytes else {
        return Err(format!("a string descriptor that begins with {:02x?}", &bytes[..bytes.len().min(2)]));
    };
    if usize::from(length) != bytes.len() || length % 2 != 0 {
        return Err(format!("a string descriptor of {} bytes says {length}", bytes.len()));
    }
    let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|unit| u16::from_le_bytes([unit[0], unit[1]])).collect();
    String::from_utf16(&units).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SERIAL: &[u8] = &[
        9, 2, 75, 0, 2, 1, 0, 0xC0, 50, // configuration
        8, 11, 0, 2, 2, 2, 1, 0, // association
        9, 4, 0, 0, 1, 2, 2, 1, 0, // communication
        5, 0x24, 0, 0x10, 1, 5, 0x24, 1, 0, 1, 4, 0x24, 2, 2, 5, 0x24, 6, 0, 1, // functional
        7, 5, 0x82, 3, 8, 0, 16, // notifications
        9, 4, 1, 0, 2, 10, 0, 0, 0, // data
        7, 5, 0x01, 2, 64, 0, 0, 7, 5, 0x81, 2, 64, 0, 0,
    ];

    #[test]
    fn a_serial_port_is_taken_apart() {
        let all = Configuration::parse(SERIAL).unwrap();
        assert_eq!((all.value, all.announced, all.interfaces.len(), all.associations.len()), (1, 2, 2, 1));
        assert_eq!(all.interfaces[0].extra.len(), 4);
        let data = all.of_class(10, 0).next().unwrap();
        let endpoint = data.endpoint(Direction::In, BULK).unwrap().of(5);
        assert_eq!((endpoint.device, endpoint.number, endpoint.max_packet), (5, 1, 64));
        let notify = all.interface(0).unwrap().endpoint(Direction::In, INTERRUPT).unwrap();
        assert_eq!(notify.of(1).kind, Kind::Interrupt { frames: 16 });
    }

    #[test]
    fn broken_descriptors_are_said_to_be() {
        let changed = |place: usize, byte: u8| {
            let mut bytes = SERIAL.to_vec();
            bytes[place] = byte;
            Configuration::parse(&bytes)
        };
        assert!(changed(2, 74).is_err(), "wTotalLength");
        assert!(changed(9, 0).is_err(), "a descriptor without a length");
        assert!(changed(9, 66).is_err(), "a descriptor beyond the end");
        assert!(changed(17, 8).is_err(), "an interface of eight bytes");
        assert!(Configuration::parse(&SERIAL[..40]).is_err());
        assert!(DeviceDescriptor::parse(&[18, 1, 0]).is_err());
        assert_eq!(text(&[6, 3, b'a', 0, b'b', 0]), Ok("ab".into()));
        assert!(text(&[5, 3, b'a', 0, b'b']).is_err());
        assert!(text(&[4, 3, 0, 0xD8]).is_err(), "half a surrogate pair");
    }
}
