//! An image that hangs: the firmware with an endless loop put at the beginning of one function.

use std::fs;
use std::path::PathBuf;

use object::{Object, ObjectSection};
use virtual_prime::image::Symbols;

/// `b .`, the branch to itself (ARM DDI 0403E.b, A7.7.12, encoding T2).
const FOR_EVER: [u8; 2] = 0xE7FE_u16.to_le_bytes();

/// A copy of the firmware that never leaves this function once it is called.
pub fn image_that_hangs_in(function: &str) -> PathBuf {
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
    bytes[place..place + 2].copy_from_slice(&FOR_EVER);
    let copy = std::env::temp_dir().join(format!("velvet-hangs-in-{function}-{}.elf", std::process::id()));
    fs::write(&copy, bytes).expect("a temporary file");
    copy
}
