//! Words that every chip has from the factory: its id, the size of its flash, calibration values.

/// The words that are read here: from the unique id (RM0399 section 64.1) to the size of the flash (section
/// 64.2), and between them the calibration values (DS12923, "Temperature sensor calibration values").
const WORDS: core::ops::Range<u32> = 0x1FF1_E800..0x1FF1_E884;

/// Reads 1, 2 or 4 bytes at an address that is a multiple of their number. `None` for any other number, and
/// any address outside the words from the factory.
#[must_use]
pub fn read(bytes: u8, address: u32) -> Option<u32> {
    let end = address.checked_add(u32::from(bytes))?;
    if address < WORDS.start || end > WORDS.end {
        return None;
    }
    if !matches!(bytes, 1 | 2 | 4) || !address.is_multiple_of(u32::from(bytes)) {
        return None;
    }
    // SAFETY: read-only memory that every chip of the family has; the address is within and aligned.
    unsafe {
        Some(match bytes {
            1 => u32::from((address as *const u8).read_volatile()),
            2 => u32::from((address as *const u16).read_volatile()),
            _ => (address as *const u32).read_volatile(),
        })
    }
}
