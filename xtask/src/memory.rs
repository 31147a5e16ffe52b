//! Bytes of each memory that an image takes, by the addresses of its sections.

use std::fs;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, SectionFlags, elf};

/// The memories of the part (RM0399 section 2.3, table 7).
pub const REGIONS: &[(&str, Range<u64>)] = &[
    ("itcm", 0x0000_0000..0x0001_0000),
    ("flash", 0x0800_0000..0x0820_0000),
    ("dtcm", 0x2000_0000..0x2002_0000),
    ("axi_sram", 0x2400_0000..0x2408_0000),
    // SRAM1 and SRAM2, which lie next to each other.
    ("sram1_2", 0x3000_0000..0x3004_0000),
    ("sram3", 0x3004_0000..0x3004_8000),
    ("sram4", 0x3800_0000..0x3801_0000),
];

/// The firmware's room for the boot stage, which is no part of the image.
const BOOT_STAGE: &str = ".boot";

/// Bytes taken in each of [`REGIONS`]. Flash counts what is stored there, load images of other regions
/// included, the boot stage not.
pub fn used(elf_bytes: &[u8]) -> Result<Vec<(&'static str, u64)>> {
    let file = object::File::parse(elf_bytes).context("not an ELF file")?;
    let mut used: Vec<(&str, u64)> = REGIONS.iter().map(|(name, _)| (*name, 0)).collect();
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 || section.name() == Ok(BOOT_STAGE) {
            continue;
        }
        for (slot, (name, range)) in used.iter_mut().zip(REGIONS) {
            let lies_here = range.contains(&section.address());
            // Initialised data and ITCM code lie in flash too: `file_range` is what the flash image stores.
            let stored = *name == "flash" && section.file_range().is_some();
            if lies_here || stored {
                slot.1 += section.size();
            }
        }
    }
    Ok(used)
}

/// Prints a row for each memory.
pub fn report(elf: &Path) -> Result<()> {
    let bytes = fs::read(elf).with_context(|| elf.display().to_string())?;
    for ((name, taken), (_, range)) in used(&bytes)?.into_iter().zip(REGIONS) {
        let size = if name == "flash" { u64::from(update::PRIME.image_bytes()) } else { range.end - range.start };
        println!("{name:>9} {taken:>8} of {size:>8} bytes  {:>5.1} %", taken as f64 * 100.0 / size as f64);
    }
    Ok(())
}
