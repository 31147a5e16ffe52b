//! Contents of the system memory that ST writes into every chip at the factory.

use std::path::Path;

use rigless::image::{Error, Image};

/// Unique id (RM0399 section 64.1): place on the wafer, the wafer's number, and its lot in ASCII.
pub const UNIQUE_ID: [u32; 3] = [0x0029_003B, 0x3233_510B, 0x3833_3337];

/// Address of the unique id, the first of these words.
const BEGIN: u64 = 0x1FF1_E800;
/// Offset and value of the flash size, KiB (section 64.2).
const FLASH_SIZE: (usize, u16) = (0x80, 2048);
/// Calibration values: readings of ADC3 at 3.3 V with 16 bits (DS12923, "Temperature sensor calibration
/// values" and "Internal reference voltage calibration values"): the temperature sensor at 30 degrees, 0.62
/// V, and at 110, 2 mV a degree more; VREFINT, 1.216 V.
const CALIBRATION_MV: [(usize, u32); 3] = [(0x20, 620), (0x40, 780), (0x60, 1216)];
const REFERENCE_MV: u32 = 3300;

/// Returns these words as an image that is loaded beside the firmware.
///
/// # Errors
/// When the emulator takes them for something else.
pub fn image() -> Result<Image, Error> {
    let mut bytes = vec![0; FLASH_SIZE.0 + 2];
    for (word, place) in UNIQUE_ID.iter().zip(bytes.chunks_exact_mut(4)) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    let calibration =
        CALIBRATION_MV.map(|(offset, millivolts)| (offset, (millivolts * u32::from(u16::MAX) / REFERENCE_MV) as u16));
    for (offset, word) in calibration.into_iter().chain([FLASH_SIZE]) {
        if let Some(place) = bytes.get_mut(offset..offset + 2) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }
    Image::new(Path::new("factory words"), bytes, Some(BEGIN))
}
