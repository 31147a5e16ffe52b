//! Formatted cards in memory.

use std::io::Cursor;
use std::vec::Vec;

use fatfs::{FatType, FormatVolumeOptions};

use super::checker::{Found, check};
use crate::CardStorage;
use crate::ram::{RamCard, Standing};
use base::ports::Storage as _;

pub type Mounted = CardStorage<'static, RamCard, Standing>;

/// A card as the checker wants it.
pub struct Card(pub RamCard);

impl Card {
    pub fn block(&self, number: u32) -> [u8; 512] {
        self.0.volume_block(number)
    }
}

/// A volume of at least so many clusters, of one block each.
pub fn formatted(kind: FatType, clusters: u32) -> RamCard {
    let blocks = clusters + 40 + 2 * clusters.div_ceil(128) + 32;
    let mut image = Cursor::new(vec![0; blocks as usize * 512]);
    let options = FormatVolumeOptions::new().fat_type(kind).bytes_per_cluster(512).total_sectors(blocks);
    fatfs::format_volume(&mut image, options.volume_label(*b"PRINTS     ")).unwrap();
    RamCard::new(image.into_inner())
}

pub fn fat16() -> RamCard {
    formatted(FatType::Fat16, 4_200)
}

pub fn fat32() -> RamCard {
    formatted(FatType::Fat32, 65_700)
}

pub fn mounted(card: &RamCard) -> Mounted {
    let mut storage = CardStorage::new(card.clone(), Standing, Box::leak(Box::default()));
    storage.mount().unwrap();
    storage
}

/// Returns the content of the card, which must be in order.
#[track_caller]
pub fn read(card: &RamCard) -> Found {
    check(&Card(card.clone())).unwrap()
}

/// Returns the content of the card, which must have nothing left over.
#[track_caller]
pub fn clean(card: &RamCard) -> Found {
    let found = read(card);
    assert!(found.is_clean(), "{found:?}");
    found
}

pub fn content(seed: usize, size: usize) -> Vec<u8> {
    (0..size).map(|at| (seed.wrapping_mul(31) + at * 7 + at / 512) as u8).collect()
}
