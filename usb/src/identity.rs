//! Who the device says to be.

use core::fmt::Write;

/// Openmoko, who give out numbers to open hardware.
pub const VENDOR: u16 = 0x1D50;
/// Smoothieboard; Smoothieware v2 has the same.
pub const PRODUCT: u16 = 0x6015;
/// Who made the firmware.
pub const MANUFACTURER: &str = "Velvet";
/// What it is, while the machine runs.
pub const PRODUCT_NAME: &str = "Smoothieboard v2 Prime";
/// What it is, while the boot stage waits for firmware.
pub(crate) const DOWNLOAD_NAME: &str = "Smoothieboard v2 Prime firmware download";
/// Release of the device in binary-coded decimals.
pub(crate) const RELEASE: u16 = 0x0200;
/// What it may draw from the bus: as Smoothieware v2. The 5 V of the socket feed the board's logic through a
/// diode where nothing else does.
pub(crate) const MILLIAMPERES: usize = 100;

/// Hexadecimal digits of three words.
const DIGITS: usize = 24;

/// The serial number: the chip's unique id. A computer gives the same port the same name for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialNumber(heapless::String<{ DIGITS + DOWNLOAD_SUFFIX.len() }>);

/// What sets the boot stage's serial number apart. Windows keeps the driver of a vendor, product and serial
/// number that it has seen; without this it would give the download the driver of the composite device.
const DOWNLOAD_SUFFIX: &str = "-DFU";

impl SerialNumber {
    /// Of the machine.
    #[must_use]
    pub fn new(unique_id: [u32; 3]) -> Self {
        let mut text = heapless::String::new();
        for word in unique_id {
            // Eight digits each: there is room.
            let _fits = write!(text, "{word:08X}");
        }
        Self(text)
    }

    /// Of the boot stage.
    #[must_use]
    pub fn for_download(unique_id: [u32; 3]) -> Self {
        let Self(mut text) = Self::new(unique_id);
        // There is room.
        let _fits = text.push_str(DOWNLOAD_SUFFIX);
        Self(text)
    }

    /// As text.
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
