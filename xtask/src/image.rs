//! The flash image as raw bytes, the form that `dfu-util -s 0x08000000` writes.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, elf};

/// Where flash begins and how much the part has (RM0399 section 4.3, table 16).
const FLASH: std::ops::Range<u64> = 0x0800_0000..0x0820_0000;
/// What erased flash reads as.
const ERASED: u8 = 0xFF;

/// Writes the loadable segments of `elf` at their load addresses into `bin`, gaps filled as erased flash.
pub fn write(elf: &Path, bin: &Path) -> Result<()> {
    let bytes = fs::read(elf).with_context(|| elf.display().to_string())?;
    let image = flash_image(&bytes)?;
    fs::write(bin, &image).with_context(|| bin.display().to_string())?;
    println!("{}: {} bytes for 0x{:08X}", bin.display(), image.len(), FLASH.start);
    Ok(())
}

fn flash_image(bytes: &[u8]) -> Result<Vec<u8>> {
    let file: ElfFile32<Endianness> = ElfFile32::parse(bytes).context("not a 32-bit ELF file")?;
    let endian = file.endian();
    let mut image = Vec::new();
    for header in file.elf_program_headers() {
        if header.p_type(endian) != elf::PT_LOAD || header.p_filesz(endian) == 0 {
            continue;
        }
        let address = u64::from(header.p_paddr(endian));
        let data = header.data(endian, bytes).ok().context("a segment lies outside the file")?;
        let end = address + data.len() as u64;
        ensure!(FLASH.contains(&address) && end <= FLASH.end, "a segment loads at 0x{address:08X}, outside flash");
        let from = usize::try_from(address - FLASH.start)?;
        let to = from + data.len();
        if image.len() < to {
            image.resize(to, ERASED);
        }
        image[from..to].copy_from_slice(data);
    }
    ensure!(!image.is_empty(), "nothing to flash in this file");
    Ok(image)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn something_that_is_no_image_is_refused() {
        assert!(flash_image(b"not an elf").is_err());
        assert!(flash_image(&[]).is_err());
    }
}
