//! The card's registers as bits.

use super::{BLOCK, Make, Traits};

/// Card identification (section 5.2): an invented maker.
pub(super) const CID: [u32; 4] = [0x7656_4C56, 0x454C_5654, 0x1000_0001, 0x0101_8A01];

/// CSD (section 5.3): 512-byte blocks, 25 MHz, or 50 MHz once high speed is set; command class 10 (CMD6)
/// where it is known. Version 2 states sizes in units of 512 KiB, version 1 here in units of 256 KiB.
pub(super) fn csd(traits: &Traits, bytes: usize, is_fast_now: bool) -> [u32; 4] {
    let protect = u32::from(traits.is_protected) << 12;
    let speed = if is_fast_now { 0x5A } else { 0x32 };
    let classes = if traits.is_fast { 0x5B5 } else { 0x1B5 };
    match traits.make {
        Make::Standard => {
            // READ_BL_LEN 9, C_SIZE_MULT 7.
            let size = (bytes / (512 * BLOCK)).clamp(1, 4096) as u32 - 1;
            [
                0x002E_0000 | speed,
                classes << 20 | 9 << 16 | size >> 2,
                (size & 3) << 30 | 7 << 15,
                0x0A40_0001 | protect,
            ]
        }
        Make::High | Make::Mmc => {
            let size = (bytes / (1024 * BLOCK)) as u32 - 1;
            [
                0x400E_0000 | speed,
                classes << 20 | 9 << 16 | size >> 16,
                (size & 0xFFFF) << 16 | 0x7F80,
                0x0A40_0001 | protect,
            ]
        }
    }
}

/// SCR (section 5.6): version 3.0x, or 1.01, which knows no CMD6; 1 and 4 bit bus, no CMD23.
pub(super) fn scr(traits: &Traits) -> Vec<u8> {
    vec![if traits.is_fast { 0x02 } else { 0x00 }, 0x35, if traits.is_fast { 0x80 } else { 0 }, 0, 0, 0, 0, 0]
}

/// The status that CMD6 answers with (section 4.3.10.4): group 1 has default and high speed.
pub(super) fn switch_status(selected: u8) -> Vec<u8> {
    let mut bytes = vec![0; 64];
    bytes[1] = 100; // 100 mA at most
    bytes[3..14].copy_from_slice(&[0x01, 0x80, 0x01, 0x80, 0x01, 0x80, 0x01, 0x80, 0x01, 0x80, 0x03]);
    bytes[2] = 0x80;
    bytes[16] = selected;
    bytes
}
