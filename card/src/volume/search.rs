//! Search for the volume on the card: in a partition of a table of either kind, or on the bare card.

use super::Volume;
use crate::exfat;
use crate::fat::{self, Blocks, Error, LARGER_THAN_PARTITION, half, word};

/// Offset of the MBR's partition table: four entries of 16 bytes.
const TABLE: usize = 446;
const ENTRIES: usize = 4;
const ENTRY_BYTES: usize = 16;
/// Partition type of the entry that announces a GUID partition table (UEFI specification 2.10, section 5.3).
const GPT: u8 = 0xEE;
/// Signature "EFI PART" of a GPT header.
const GPT_SIGNATURE: &[u8; 8] = b"EFI PART";
/// Type EBD0A0A2-B9E5-4433-87C0-68B6B72699C7: basic data, that is FAT, exFAT or NTFS.
pub(super) const BASIC_DATA: [u8; 16] =
    [0xA2, 0xA0, 0xD0, 0xEB, 0xE5, 0xB9, 0x33, 0x44, 0x87, 0xC0, 0x68, 0xB6, 0xB7, 0x26, 0x99, 0xC7];
/// Most entries of a GPT that are read.
const MOST_ENTRIES: u32 = 128;

/// Reason why no volume can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoVolume<E> {
    /// The device's own error.
    Device(E),
    /// A volume is there, but contradicts itself.
    Damaged,
    /// No volume of a known kind is there.
    Unknown,
    /// FAT12, as cards of a few megabytes have it.
    Fat12,
    /// NTFS, which is not supported.
    Ntfs,
    /// exFAT in a form that cannot be read here.
    OddExfat,
    /// The volume goes beyond the device, or its partition.
    LargerThanDevice,
}

/// Finds the first usable volume on a device of so many blocks. Nothing is written: [`fat::Volume::settle`]
/// completes the operations that a power cut has left half done on a FAT volume.
///
/// # Errors
/// Why there is none.
pub fn find<B: Blocks>(device: &mut B, blocks: u32) -> Result<Volume, NoVolume<B::Error>> {
    let mut first = [0; 512];
    device.read(0, &mut first).map_err(NoVolume::Device)?;
    let mut search = Search { device, blocks, why: NoVolume::Unknown };
    if is_boot_sector(&first)
        && let Some(volume) = search.try_open(0, blocks)?
    {
        return Ok(volume);
    }
    if half(&first, 510) != 0xAA55 {
        return Err(search.why);
    }
    for entry in first.get(TABLE..).unwrap_or(&[]).chunks_exact(ENTRY_BYTES).take(ENTRIES) {
        let (kind, at, length) = (entry.get(4).copied().unwrap_or(0), word(entry, 8), word(entry, 12));
        let found = match kind {
            0 => None,
            GPT => search.guid_table()?,
            _ => search.try_open(at, length)?,
        };
        if let Some(volume) = found {
            return Ok(volume);
        }
    }
    Err(search.why)
}

/// Returns whether the block has a jump and a signature, where a partition table has code or nothing.
fn is_boot_sector(block: &[u8]) -> bool {
    let jumps = matches!(block, [0xEB, _, 0x90, ..] | [0xE9, ..]);
    jumps && half(block, 510) == 0xAA55
}

struct Search<'a, B: Blocks> {
    device: &'a mut B,
    blocks: u32,
    /// Reason for the failure so far.
    why: NoVolume<B::Error>,
}

impl<B: Blocks> Search<'_, B> {
    /// Opens the volume that begins at this block; `None` if there is none that can be used.
    fn try_open(&mut self, first: u32, blocks: u32) -> Result<Option<Volume>, NoVolume<B::Error>> {
        if first >= self.blocks {
            // The table names blocks which the card does not have.
            return Ok(None);
        }
        let mut boot = [0; 512];
        self.device.read(first, &mut boot).map_err(NoVolume::Device)?;
        match boot.get(3..11) {
            Some(b"NTFS    ") => self.why = NoVolume::Ntfs,
            Some(b"EXFAT   ") => match exfat::Volume::open(self.device, first) {
                Ok(volume) => return Ok(Some(Volume::Exfat(volume))),
                Err(Error::NotFat(_)) => self.why = NoVolume::OddExfat,
                Err(error) => return Err(other(error)),
            },
            _ => match fat::Volume::open(self.device, first, blocks.min(self.blocks.saturating_sub(first))) {
                Ok(volume) => return Ok(Some(Volume::Fat(volume))),
                Err(Error::NotFat("FAT12")) => self.why = NoVolume::Fat12,
                Err(Error::NotFat(LARGER_THAN_PARTITION)) => self.why = NoVolume::LargerThanDevice,
                Err(Error::NotFat(_)) => {}
                Err(error) => return Err(other(error)),
            },
        }
        Ok(None)
    }

    fn guid_table(&mut self) -> Result<Option<Volume>, NoVolume<B::Error>> {
        let mut block = [0; 512];
        self.device.read(1, &mut block).map_err(NoVolume::Device)?;
        if !block.starts_with(GPT_SIGNATURE) {
            return Ok(None);
        }
        // No partition begins behind the first 2 TB, as no card is larger.
        let (table, count, bytes) = (word(&block, 72), word(&block, 80).min(MOST_ENTRIES), word(&block, 84));
        if !(bytes.is_power_of_two() && (128..=512).contains(&bytes)) {
            return Ok(None);
        }
        for number in 0..count {
            let offset = (number * bytes) as usize;
            let at = table.saturating_add((offset / 512) as u32);
            self.device.read(at, &mut block).map_err(NoVolume::Device)?;
            let entry = block.get(offset % 512..).unwrap_or(&[]);
            if !entry.starts_with(&BASIC_DATA) || word(entry, 36) != 0 || word(entry, 44) != 0 {
                continue;
            }
            let (first, last) = (word(entry, 32), word(entry, 40));
            let blocks = last.saturating_sub(first).saturating_add(1);
            if let Some(volume) = self.try_open(first, blocks)? {
                return Ok(Some(volume));
            }
        }
        Ok(None)
    }
}

/// Converts errors that do not depend on the kind of volume.
fn other<E>(error: Error<E>) -> NoVolume<E> {
    match error {
        Error::Device(error) => NoVolume::Device(error),
        _ => NoVolume::Damaged,
    }
}
