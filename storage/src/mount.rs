//! The volume of a card, looked for by [`card::volume`]: it is to be written to as well, so what a power
//! cut has interrupted is completed, and a card that claims more than it has is refused.

use base::ports::StorageError;
use card::fat::Volume as FatVolume;
use card::volume::{NoVolume, Volume, find};

use crate::device::{Card, Device};
use crate::errors::of_name;

/// Blocks of the smallest chip that a forgery is made with: 32 MB.
const SMALLEST_CHIP: u32 = 1 << 16;

/// The first volume that can be used.
pub(crate) fn find_volume<C: Card>(card: &mut C) -> Result<Volume, StorageError> {
    let blocks = card.blocks().map_err(|error| C::reason(&error))?;
    let mut found = find(&mut Device(card), blocks).map_err(why::<C>)?;
    if let Volume::Fat(volume) = &mut found {
        complete(card, volume)?;
    }
    Ok(found)
}

fn complete<C: Card>(card: &mut C, volume: &mut FatVolume) -> Result<(), StorageError> {
    volume.settle(&mut Device(card)).map_err(of_name::<C>)?;
    if wraps(card, volume.extent().0)? { Err(StorageError::NotKept) } else { Ok(()) }
}

fn why<C: Card>(error: NoVolume<C::Error>) -> StorageError {
    match error {
        NoVolume::Device(error) => C::reason(&error),
        NoVolume::Damaged => StorageError::Damaged,
        NoVolume::Unknown => StorageError::NoFileSystem,
        NoVolume::Fat12 => StorageError::Fat12,
        NoVolume::Ntfs => StorageError::Ntfs,
        NoVolume::OddExfat => StorageError::OddExfat,
        NoVolume::LargerThanDevice => StorageError::LargerThanCard,
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
