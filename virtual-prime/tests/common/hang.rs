//! Copies of the firmware with a fault: other code at the beginning of one function.

use std::fs;
use std::path::PathBuf;

use object::{Object, ObjectSection};
use virtual_prime::image::Symbols;

/// Code of `b .`, the branch to itself (ARM DDI 0403E.b, A7.7.12, encoding T2).
const FOR_EVER: u16 = 0xE7FE;

/// Writes a copy of the firmware that never leaves this function once it is called.
pub fn image_that_hangs_in(function: &str) -> PathBuf {
    image_with(function, &[FOR_EVER], "hangs")
}

/// Writes a copy of the firmware where this function, which returns nothing, only masks all interrupts for
/// twice so many instructions.
pub fn image_that_masks_interrupts_in(function: &str, loops: u16) -> PathBuf {
    // MOVW R0, #loops (A7.7.76, encoding T3): the number is scattered over both halfwords.
    let high = 0xF240 | (loops >> 11 & 1) << 10 | loops >> 12;
    let low = (loops >> 8 & 7) << 12 | loops & 0xFF;
    // CPSID i; MOVW; SUBS R0, #1; BNE to the SUBS; CPSIE i; BX LR.
    image_with(function, &[0xB672, high, low, 0x3801, 0xD1FD, 0xB662, 0x4770], &format!("masks-{loops}"))
}

fn image_with(function: &str, code: &[u16], word: &str) -> PathBuf {
    let original = super::velvet::image();
    let symbols = Symbols::read(&original).expect("an ELF file");
    let address = symbols.function(function).expect("a function of the image").address;
    let mut bytes = fs::read(&original).expect("the image");
    let place = {
        let file = object::File::parse(&*bytes).expect("an ELF file");
        let section = file
            .sections()
            .find(|section| (section.address()..section.address() + section.size()).contains(&address))
            .expect("the function is in a section");
        let (start, _) = section.file_range().expect("code is in the file");
        (start + address - section.address()) as usize
    };
    for (target, halfword) in bytes[place..].chunks_exact_mut(2).zip(code) {
        target.copy_from_slice(&halfword.to_le_bytes());
    }
    super::seal::seal(&mut bytes);
    let copy = std::env::temp_dir().join(format!("velvet-{word}-in-{function}-{}.elf", std::process::id()));
    fs::write(&copy, bytes).expect("a temporary file");
    copy
}
