//! Sealing of images that a test has changed: the boot stage starts none whose digest is wrong.

use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection};
use update::{MANIFEST_BYTES, PRIME, WORD};

/// Computes the digest of the ELF file's present contents into its manifest.
pub fn seal(elf: &mut [u8]) {
    let mut image = image(elf);
    update::seal(&mut image, &PRIME, None).expect("an image");
    let place = {
        let file = object::File::parse(&*elf).expect("an ELF file");
        file.section_by_name(".manifest").and_then(|section| section.file_range()).expect("a manifest").0 as usize
    };
    elf[place..place + MANIFEST_BYTES].copy_from_slice(&image[..MANIFEST_BYTES]);
}

/// Returns the image as it lies in flash, from its manifest on.
fn image(elf: &[u8]) -> Vec<u8> {
    let file: ElfFile32<Endianness> = ElfFile32::parse(elf).expect("an ELF file");
    let mut image = Vec::new();
    for segment in file.elf_program_headers() {
        let address = segment.p_paddr(file.endian());
        let data = segment.data(file.endian(), elf).expect("within the file");
        if address < PRIME.image_address() || data.is_empty() {
            continue;
        }
        let from = (address - PRIME.image_address()) as usize;
        image.resize(image.len().max(from + data.len()), 0xff);
        image[from..from + data.len()].copy_from_slice(data);
    }
    image.resize(image.len().next_multiple_of(WORD), 0xff);
    image
}
