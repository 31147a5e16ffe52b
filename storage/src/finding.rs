//! Where on the card the volume is: in a partition of a table of either kind, or on the bare card.

use drivers::exfat;
use drivers::fat::{Error, LARGER_THAN_PARTITION, Volume, half, word};
use machine::ports::StorageError;

use crate::Card;
use crate::errors::of_name;
use crate::lens::Device;
use crate::mounted::Mounted;

/// The partition table of old (MBR): four entries of 16 bytes.
const TABLE: usize = 446;
const ENTRIES: usize = 4;
const ENTRY_BYTES: usize = 16;
/// A GUID partition table (UEFI specification 2.10, section 5.3) is behind this one.
const GPT: u8 = 0xEE;
/// "EFI PART".
const GPT_SIGNATURE: &[u8; 8] = b"EFI PART";
/// EBD0A0A2-B9E5-4433-87C0-68B6B72699C7: basic data, which is FAT, exFAT or NTFS.
const BASIC_DATA: [u8; 16] =
    [0xA2, 0xA0, 0xD0, 0xEB, 0xE5, 0xB9, 0x33, 0x44, 0x87, 0xC0, 0x68, 0xB6, 0xB7, 0x26, 0x99, 0xC7];
/// Blocks of the smallest chip that a forgery is made with: 32 MB.
const SMALLEST_CHIP: u32 = 1 << 16;
/// Entries of a GPT that are looked at.
const MOST_ENTRIES: u32 = 128;

/// The first volume that can be used.
pub(crate) fn find_volume<C: Card>(card: &mut C) -> Result<Mounted, StorageError> {
    let found = search(card)?;
    match &found {
        Mounted::Fat(volume) if wraps(card, volume.extent().0)? => Err(StorageError::NotKept),
        _ => Ok(found),
    }
}

/// Whether a card comes round to its beginning where it claims to have more: a forgery, on which what is
/// written there destroys what is here. Looked for at distances that are powers of two, as chips are: there
/// both the card's first block and the volume's are found again.
fn wraps<C: Card>(card: &mut C, volume: u32) -> Result<bool, StorageError> {
    let reason = |error: C::Error| C::reason(&error);
    let blocks = card.blocks().map_err(reason)?;
    let (mut here, mut there) = ([0; 512], [0; 512]);
    let distances = (SMALLEST_CHIP.ilog2()..u32::BITS).map(|bit| 1_u32 << bit);
    for distance in distances.take_while(|distance| *distance < blocks.saturating_sub(volume)) {
        let mut is_same = true;
        for number in [volume, 0] {
            card.read(number, &mut here).map_err(reason)?;
            card.read(number + distance, &mut there).map_err(reason)?;
            is_same &= here == there;
            if !is_same {
                break;
            }
        }
        if is_same {
            return Ok(true);
        }
    }
    Ok(false)
}

fn search<C: Card>(card: &mut C) -> Result<Mounted, StorageError> {
    let reason = |error: C::Error| C::reason(&error);
    let blocks = card.blocks().map_err(reason)?;
    let mut first = [0; 512];
    card.read(0, &mut first).map_err(reason)?;
    let mut search = Search { card, blocks, why: StorageError::NoFileSystem };
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

/// A jump and a signature, where a partition table has code or nothing.
fn is_boot_sector(block: &[u8]) -> bool {
    let jumps = matches!(block, [0xEB, _, 0x90, ..] | [0xE9, ..]);
    jumps && half(block, 510) == 0xAA55
}

struct Search<'a, C> {
    card: &'a mut C,
    /// Of the card.
    blocks: u32,
    /// Why there is none.
    why: StorageError,
}

impl<C: Card> Search<'_, C> {
    /// The volume that begins at this block; `None` when there is none that can be used.
    fn try_open(&mut self, first: u32, blocks: u32) -> Result<Option<Mounted>, StorageError> {
        let mut boot = [0; 512];
        match self.card.read(first, &mut boot) {
            // A table that names blocks which the card does not have.
            Err(error) if C::reason(&error) == StorageError::Device => return Ok(None),
            read => read.map_err(|error| C::reason(&error))?,
        }
        match boot.get(3..11) {
            Some(b"NTFS    ") => self.why = StorageError::Ntfs,
            Some(b"EXFAT   ") => match exfat::Volume::open(&mut Device(self.card), first) {
                Ok(volume) => return Ok(Some(Mounted::Exfat(volume))),
                Err(Error::NotFat(_)) => self.why = StorageError::OddExfat,
                Err(error) => return Err(of_name::<C>(error)),
            },
            _ => match Volume::open(&mut Device(self.card), first, blocks.min(self.blocks.saturating_sub(first))) {
                Ok(mut volume) => {
                    volume.settle(&mut Device(self.card)).map_err(of_name::<C>)?;
                    return Ok(Some(Mounted::Fat(volume)));
                }
                Err(Error::NotFat("FAT12")) => self.why = StorageError::Fat12,
                Err(Error::NotFat(LARGER_THAN_PARTITION)) => self.why = StorageError::LargerThanCard,
                Err(Error::NotFat(_)) => {}
                Err(error) => return Err(of_name::<C>(error)),
            },
        }
        Ok(None)
    }

    fn guid_table(&mut self) -> Result<Option<Mounted>, StorageError> {
        let reason = |error: C::Error| C::reason(&error);
        let mut block = [0; 512];
        self.card.read(1, &mut block).map_err(reason)?;
        if !block.starts_with(GPT_SIGNATURE) {
            return Ok(None);
        }
        // Behind the first 2 TB there is no card.
        let (table, count, bytes) = (word(&block, 72), word(&block, 80).min(MOST_ENTRIES), word(&block, 84));
        if !(bytes.is_power_of_two() && (128..=512).contains(&bytes)) {
            return Ok(None);
        }
        for number in 0..count {
            let offset = (number * bytes) as usize;
            self.card.read(table.saturating_add((offset / 512) as u32), &mut block).map_err(reason)?;
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
