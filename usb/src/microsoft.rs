//! Microsoft OS 2.0 descriptors, by which Windows 8.1 and later chooses the driver WinUSB for the firmware
//! download automatically (Microsoft OS 2.0 Descriptors Specification, April 2018).
//!
//! Version 1.0 is left out: only Windows Vista to 8 need it, and those lack a driver for serial ports anyway.

use usb_device::class_prelude::{ControlIn, UsbBus, UsbClass};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::descriptor_type;

/// Vendor request that reads the descriptors; the number is arbitrary.
const VENDOR_CODE: u8 = 0x20;
/// Index of the descriptor set in that request (section "Microsoft OS 2.0 descriptor requests").
const DESCRIPTOR_INDEX: u16 = 0x07;
/// Windows 8.1, the first version with these descriptors.
const WINDOWS_VERSION: [u8; 4] = [0x00, 0x00, 0x03, 0x06];
/// UUID D8DD60DF-4589-4CC7-9CD2-659D9E648A9F, the platform capability of these descriptors.
const PLATFORM: [u8; 16] =
    [0xDF, 0x60, 0xDD, 0xD8, 0x89, 0x45, 0xC7, 0x4C, 0x9C, 0xD2, 0x65, 0x9D, 0x9E, 0x64, 0x8A, 0x9F];
/// Descriptor type DEVICE CAPABILITY, and the capability's type PLATFORM (USB 3.1 tables 9-6 and 9-14).
const DEVICE_CAPABILITY: u8 = 16;
const CAPABILITY_PLATFORM: u8 = 5;
/// Size of the BOS descriptor with its single capability.
const BOS_BYTES: usize = 5 + CAPABILITY_BYTES;
const CAPABILITY_BYTES: usize = 4 + 16 + 8;

/// GUID by which programs find the interface; libusb accepts any. This GUID is Velvet's own.
const INTERFACE_GUID: &str = "{5C2D8B1E-7A0F-4E63-9B44-D0F1A6C3E972}";
const PROPERTY: &str = "DeviceInterfaceGUIDs";

/// Size of the longest set: for a function of a composite device.
const SET_BYTES: usize = 10 + 8 + 8 + FEATURE_BYTES;
/// Size of the compatible id, and of the property with both texts and their ends, as UTF-16.
const FEATURE_BYTES: usize = 20 + 10 + 2 * (PROPERTY.len() + 1) + 2 * (INTERFACE_GUID.len() + 2);

/// Microsoft's descriptors for an interface of the device.
#[derive(Debug)]
pub struct MicrosoftOs {
    /// Interface number in a composite device; `None` for a device with a single function.
    function: Option<u8>,
}

impl MicrosoftOs {
    /// Selects WinUSB for this interface of a composite device.
    pub const fn for_function(interface: u8) -> Self {
        Self { function: Some(interface) }
    }

    /// Selects WinUSB for a device without other functions.
    pub const fn for_device() -> Self {
        Self { function: None }
    }

    const fn length(&self) -> usize {
        if self.function.is_some() { SET_BYTES } else { 10 + FEATURE_BYTES }
    }

    /// Returns the BOS descriptor, which announces the set (USB 3.1 section 9.6.2). The one from `usb-device`
    /// would also have a "USB 2.0 extension", which is for devices with link power management and would deny
    /// having any: `lsusb` calls that an error.
    fn bos(&self) -> heapless::Vec<u8, BOS_BYTES> {
        let mut bos = Bytes(heapless::Vec::new());
        bos.bytes(&[5, descriptor_type::BOS]).half(BOS_BYTES as u16).bytes(&[1]);
        bos.bytes(&[CAPABILITY_BYTES as u8, DEVICE_CAPABILITY, CAPABILITY_PLATFORM, 0]).bytes(&PLATFORM);
        bos.bytes(&WINDOWS_VERSION).half(self.length() as u16).bytes(&[VENDOR_CODE, 0]);
        bos.0
    }

    fn set(&self) -> heapless::Vec<u8, SET_BYTES> {
        let mut set = Bytes(heapless::Vec::new());
        let total = self.length() as u16;
        // Table 10: the set's header.
        set.half(10).half(0x00).bytes(&WINDOWS_VERSION).half(total);
        if let Some(interface) = self.function {
            // Table 11: the header of a configuration's subset, counted from 0; table 12: of a function's.
            set.half(8).half(0x01).bytes(&[0, 0]).half(total - 10);
            set.half(8).half(0x02).bytes(&[interface, 0]).half(total - 18);
        }
        // Table 13: compatible id.
        set.half(20).half(0x03).bytes(b"WINUSB\0\0").bytes(&[0; 8]);
        // Table 14: registry property, of type REG_MULTI_SZ, which ends with two zeros.
        let (name, data) = (2 * (PROPERTY.len() + 1), 2 * (INTERFACE_GUID.len() + 2));
        set.half((10 + name + data) as u16).half(0x04).half(7);
        set.half(name as u16).text(PROPERTY).half(0);
        set.half(data as u16).text(INTERFACE_GUID).half(0).half(0);
        set.0
    }
}

/// Builder of descriptors, with room for the longest.
struct Bytes<const N: usize>(heapless::Vec<u8, N>);

impl<const N: usize> Bytes<N> {
    fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        // The capacity fits the longest set.
        let _fits = self.0.extend_from_slice(bytes);
        self
    }

    fn half(&mut self, value: u16) -> &mut Self {
        self.bytes(&value.to_le_bytes())
    }

    fn text(&mut self, text: &str) -> &mut Self {
        text.encode_utf16().for_each(|unit| {
            self.half(unit);
        });
        self
    }
}

impl<B: UsbBus> UsbClass<B> for MicrosoftOs {
    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        let request = transfer.request();
        if request.recipient != Recipient::Device {
            return;
        }
        let (kind, number) = request.descriptor_type_index();
        // Both requests wait for an answer, which fits their buffer.
        let _ = match (request.request_type, request.request) {
            (RequestType::Standard, Request::GET_DESCRIPTOR) if (kind, number) == (descriptor_type::BOS, 0) => {
                transfer.accept_with(&self.bos())
            }
            (RequestType::Vendor, VENDOR_CODE) if request.index == DESCRIPTOR_INDEX => {
                transfer.accept_with(&self.set())
            }
            _ => return,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the types of a set's descriptors; every length must lead to the next descriptor.
    fn types(set: &[u8]) -> Vec<u16> {
        let half = |at: usize| u16::from_le_bytes([set[at], set[at + 1]]);
        let (mut at, mut types) = (0, Vec::new());
        while at < set.len() {
            types.push(half(at + 2));
            at += usize::from(half(at));
        }
        assert_eq!(at, set.len());
        types
    }

    #[test]
    fn lengths_lead_from_one_descriptor_to_the_next() {
        let function = MicrosoftOs::for_function(5);
        let set = function.set();
        assert_eq!(set.len(), function.length());
        assert_eq!(types(&set), [0, 1, 2, 3, 4]);
        let total = |at: usize| usize::from(u16::from_le_bytes([set[at], set[at + 1]]));
        assert_eq!((total(8), total(16), total(24)), (set.len(), set.len() - 10, set.len() - 18));
        assert_eq!(set[22], 5, "bFirstInterface");
        let device = MicrosoftOs::for_device();
        assert_eq!(types(&device.set()), [0, 3, 4]);
        assert_eq!(device.set().len(), device.length());
    }
}
