//! Identity of the device: vendor, product and serial numbers, and names.

use core::fmt::Write;

/// Vendor id of Openmoko, which gives out product ids to open hardware.
pub const VENDOR: u16 = 0x1D50;
/// Product id of the Smoothieboard, as in Smoothieware v2.
pub const PRODUCT: u16 = 0x6015;
/// Maker of the firmware.
pub const MANUFACTURER: &str = "Velvet";
/// Product name while the machine runs.
pub const PRODUCT_NAME: &str = "Smoothieboard v2 Prime";
/// Product name while the boot stage waits for firmware.
pub(crate) const DOWNLOAD_NAME: &str = "Smoothieboard v2 Prime firmware download";
/// Release of the device in binary-coded decimals.
pub(crate) const RELEASE: u16 = 0x0200;
/// Greatest current from the bus, mA, as in Smoothieware v2. The 5 V of the socket feed the board's logic
/// through a diode if no other supply does.
pub(crate) const MILLIAMPERES: usize = 100;

/// Hexadecimal digits of three words.
const DIGITS: usize = 24;

/// Serial number from the chip's unique id. Computers name the ports of a board by it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialNumber(heapless::String<{ DIGITS + DOWNLOAD_SUFFIX.len() }>);

/// Suffix of the boot stage's serial number. Windows remembers drivers by vendor, product and serial number,
/// so without a suffix the download would get the driver of the composite device.
const DOWNLOAD_SUFFIX: &str = "-DFU";

impl SerialNumber {
    /// Returns the machine's serial number.
    #[must_use]
    pub fn new(unique_id: [u32; 3]) -> Self {
        let mut text = heapless::String::new();
        for word in unique_id {
            // Each word has eight digits, so there is room.
            let _fits = write!(text, "{word:08X}");
        }
        Self(text)
    }

    /// Returns the boot stage's serial number.
    #[must_use]
    pub fn for_download(unique_id: [u32; 3]) -> Self {
        let Self(mut text) = Self::new(unique_id);
        // The capacity includes the suffix.
        let _fits = text.push_str(DOWNLOAD_SUFFIX);
        Self(text)
    }

    /// Returns the serial number as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_digit_of_the_id_is_in_the_serial_number() {
        assert_eq!(SerialNumber::new([0x1, 0xABCD_EF01, 0]).as_str(), "00000001ABCDEF0100000000");
        assert_eq!(SerialNumber::for_download([1, 2, 3]).as_str(), "000000010000000200000003-DFU");
    }
}
