//! From what the linker has made to what is flashed: the boot stage into its place in the ELF file, length
//! and digest into the manifest, and beside it the two files of plain bytes: for `dfu-util`, and for the
//! card.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, elf};
use update::{MANIFEST_BYTES, PRIME, WORD};

/// Value of an erased byte of flash.
const ERASED: u8 = 0xFF;
/// The image's file on a card, as Smoothieware v2 has it.
const CARD_FILE: &str = "flashme.bin";
/// The image whose file for a card lies beside it. Others have it in a folder of their own: it has the same
/// name for each.
const FIRMWARE: &str = "firmware";

/// Seals the application `elf`, whether or not it was sealed before, with the boot stage `boot` in front.
pub fn run(elf: &Path, boot: &Path) -> Result<()> {
    let bytes = fs::read(elf).with_context(|| elf.display().to_string())?;
    let boot = fs::read(boot).with_context(|| boot.display().to_string())?;
    let sealed = seal(bytes, &boot).with_context(|| elf.display().to_string())?;
    write(elf, &sealed.elf)?;
    let mut whole = elf.as_os_str().to_owned();
    whole.push(".bin");
    write(Path::new(&whole), &sealed.flash)?;
    let card = card_file(elf);
    if let Some(folder) = card.parent() {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    write(&card, &sealed.card)?;
    let (boot, image) = (sealed.boot_bytes, sealed.image_bytes);
    println!("sealed: {boot} bytes of boot stage, {image} of {} bytes of image", PRIME.image_bytes());
    Ok(())
}

/// Place of the file for a card.
fn card_file(elf: &Path) -> PathBuf {
    if elf.file_name().is_some_and(|name| name == FIRMWARE) {
        return elf.with_file_name(CARD_FILE);
    }
    let mut folder = elf.as_os_str().to_owned();
    folder.push(".card");
    Path::new(&folder).join(CARD_FILE)
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).with_context(|| path.display().to_string())
}

struct Sealed {
    elf: Vec<u8>,
    /// The flash from its first address on.
    flash: Vec<u8>,
    /// The same with the trailer of Smoothieware v2, which then installs it.
    card: Vec<u8>,
    boot_bytes: usize,
    image_bytes: usize,
}

fn seal(mut bytes: Vec<u8>, boot: &[u8]) -> Result<Sealed> {
    let boot = flash_image(boot).context("the boot stage")?;
    let boot_place = section(&bytes, ".boot")?;
    ensure!(
        boot.len() <= boot_place.len(),
        "the boot stage takes {} bytes, and its sector has {}",
        boot.len(),
        boot_place.len()
    );
    bytes[boot_place.clone()].fill(ERASED);
    bytes[boot_place][..boot.len()].copy_from_slice(&boot);
    let flash = flash_image(&bytes)?;
    let (before, image) = flash.split_at_checked(PRIME.image() as usize).context("there is no image behind it")?;
    let mut image = image.to_vec();
    image.resize(image.len().next_multiple_of(WORD), ERASED);
    ensure!(
        image.len() <= PRIME.image_bytes() as usize,
        "the image takes {} bytes, and {} of flash are for it (docs/updates.md)",
        image.len(),
        PRIME.image_bytes()
    );
    update::seal(&mut image, &PRIME, None).map_err(|flaw| anyhow::anyhow!("{flaw}"))?;
    let manifest_place = section(&bytes, ".manifest")?;
    bytes[manifest_place][..MANIFEST_BYTES].copy_from_slice(&image[..MANIFEST_BYTES]);
    let whole = [before, &image].concat();
    Ok(Sealed {
        card: [whole.as_slice(), &update::trailer(&whole)].concat(),
        flash: whole,
        boot_bytes: boot.len(),
        image_bytes: image.len(),
        elf: bytes,
    })
}

/// Offset of a section in an ELF file.
fn section(bytes: &[u8], name: &str) -> Result<Range<usize>> {
    let file = object::File::parse(bytes).context("not an ELF file")?;
    let section = file.section_by_name(name).with_context(|| format!("no section {name}: is this an image?"))?;
    let (start, length) = section.file_range().with_context(|| format!("section {name} is empty"))?;
    let place = usize::try_from(start)?..usize::try_from(start + length)?;
    ensure!(place.end <= bytes.len(), "section {name} lies outside the file");
    Ok(place)
}

/// The loadable segments of an ELF file as they lie in flash, gaps as erased flash.
pub fn flash_image(bytes: &[u8]) -> Result<Vec<u8>> {
    let file: ElfFile32<Endianness> = ElfFile32::parse(bytes).context("not a 32-bit ELF file")?;
    let endian = file.endian();
    let flash_bytes = (PRIME.log_at() + PRIME.sector_bytes) as usize;
    let mut image = Vec::new();
    for header in file.elf_program_headers() {
        if header.p_type(endian) != elf::PT_LOAD || header.p_filesz(endian) == 0 {
            continue;
        }
        let address = header.p_paddr(endian);
        let data = header.data(endian, bytes).ok().context("a segment lies outside the file")?;
        let from = address.checked_sub(PRIME.address).map(|offset| offset as usize);
        let from = from.filter(|from| from + data.len() <= flash_bytes);
        let from = from.with_context(|| format!("a segment loads at 0x{address:08X}, outside flash"))?;
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
    fn no_image_takes_the_place_of_another_one_for_the_card() {
        assert_eq!(card_file(Path::new("release/firmware")), Path::new("release/flashme.bin"));
        assert_eq!(card_file(Path::new("release/controller")), Path::new("release/controller.card/flashme.bin"));
    }

    #[test]
    fn something_that_is_no_image_is_refused() {
        assert!(flash_image(b"not an elf").is_err());
        assert!(flash_image(&[]).is_err());
    }
}
