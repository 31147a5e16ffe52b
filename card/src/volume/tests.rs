//! Tests with cards that have tables of both kinds, none, or unusable contents.

use fatfs::{FatType, FileSystem, FormatVolumeOptions, FsOptions};
use std::io::{Cursor, Write};

use super::{FileReader, NoVolume, Volume, find, find_file};
use crate::fat::{Block, Blocks};

const BLOCK: usize = 512;
/// First block of the partitions of these cards.
const FIRST: u32 = 64;

/// Card in memory that allows no writes.
#[derive(Clone)]
struct ReadOnlyCard(Vec<u8>);

impl Blocks for ReadOnlyCard {
    type Error = u32;

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), u32> {
        let at = number as usize * BLOCK;
        *block = self.0.get(at..at + BLOCK).ok_or(number)?.try_into().unwrap();
        Ok(())
    }

    fn write(&mut self, number: u32, _: &Block) -> Result<(), u32> {
        panic!("block {number} is written")
    }
}

impl ReadOnlyCard {
    /// Makes a card with so many blocks before a FAT16 volume with one file.
    fn with_volume_at(first: u32) -> Self {
        let mut image = Cursor::new(vec![0; 4_300 * BLOCK]);
        let options = FormatVolumeOptions::new().fat_type(FatType::Fat16).bytes_per_cluster(512);
        fatfs::format_volume(&mut image, options).unwrap();
        let system = FileSystem::new(&mut image, FsOptions::new()).unwrap();
        system.root_dir().create_file("flashme.bin").unwrap().write_all(&content()).unwrap();
        system.unmount().unwrap();
        let mut card = vec![0; first as usize * BLOCK];
        card.extend(image.into_inner());
        Self(card)
    }

    fn blocks(&self) -> u32 {
        (self.0.len() / BLOCK) as u32
    }

    fn entry(mut self, place: usize, kind: u8, first: u32, blocks: u32) -> Self {
        let at = 446 + 16 * place;
        self.0[at + 4] = kind;
        self.0[at + 8..at + 12].copy_from_slice(&first.to_le_bytes());
        self.0[at + 12..at + 16].copy_from_slice(&blocks.to_le_bytes());
        self.0[510..512].copy_from_slice(&[0x55, 0xAA]);
        self
    }

    fn whole_file(&mut self) -> Vec<u8> {
        let blocks = self.blocks();
        let mut volume = find(self, blocks).expect("a volume");
        let (mut reader, _) = find_file(&mut volume, self, "FLASHME.BIN").expect("a file");
        assert!(matches!((reader, &volume), (FileReader::Fat(_), Volume::Fat(_))));
        let mut bytes = Vec::new();
        let mut chunk = [0; 300];
        loop {
            match reader.read(&mut volume, self, bytes.len() as u32, &mut chunk).expect("readable") {
                0 => return bytes,
                count => bytes.extend_from_slice(&chunk[..count]),
            }
        }
    }

    fn why_not(&mut self) -> NoVolume<u32> {
        let blocks = self.blocks();
        find(self, blocks).map(|_| ()).expect_err("no volume")
    }
}

fn content() -> Vec<u8> {
    (0..3_000_u32).map(|at| (at % 251) as u8).collect()
}

#[test]
fn a_bare_card_has_its_volume_at_its_beginning() {
    assert_eq!(ReadOnlyCard::with_volume_at(0).whole_file(), content());
}

#[test]
fn any_partition_of_a_table_will_do() {
    let blocks = ReadOnlyCard::with_volume_at(FIRST).blocks() - FIRST;
    for place in 0..4 {
        let mut card = ReadOnlyCard::with_volume_at(FIRST).entry(place, 0x0E, FIRST, blocks);
        assert_eq!(card.whole_file(), content(), "place {place}");
    }
    // An entry that lies behind the card's end is passed over.
    let mut card = ReadOnlyCard::with_volume_at(FIRST).entry(0, 0x0C, 1 << 20, 1 << 10).entry(1, 0x0E, FIRST, blocks);
    assert_eq!(card.whole_file(), content());
}

fn guid_table(entry_bytes: u32, first: u64, last: u64) -> ReadOnlyCard {
    let mut card = ReadOnlyCard::with_volume_at(FIRST).entry(0, 0xEE, 1, u32::MAX);
    let mut header = [0; BLOCK];
    header[..8].copy_from_slice(b"EFI PART");
    header[72..80].copy_from_slice(&2_u64.to_le_bytes());
    header[80..84].copy_from_slice(&8_u32.to_le_bytes());
    header[84..88].copy_from_slice(&entry_bytes.to_le_bytes());
    card.0[BLOCK..2 * BLOCK].copy_from_slice(&header);
    // The second of the table's partitions; the first is something else.
    let at = 2 * BLOCK + entry_bytes as usize;
    card.0[2 * BLOCK..][..16].fill(0x11);
    card.0[at..][..16].copy_from_slice(&super::search::BASIC_DATA);
    card.0[at + 32..][..8].copy_from_slice(&first.to_le_bytes());
    card.0[at + 40..][..8].copy_from_slice(&last.to_le_bytes());
    card
}

#[test]
fn a_guid_table_is_read() {
    for entry_bytes in [128, 256, 512] {
        let last = u64::from(ReadOnlyCard::with_volume_at(FIRST).blocks() - 1);
        assert_eq!(guid_table(entry_bytes, u64::from(FIRST), last).whole_file(), content(), "{entry_bytes}");
    }
    assert_eq!(guid_table(96, u64::from(FIRST), 4_000).why_not(), NoVolume::Unknown);
    assert_eq!(guid_table(128, 1 << 40, 1 << 41).why_not(), NoVolume::Unknown);
}

#[test]
fn what_cannot_be_used_has_its_name() {
    assert_eq!(ReadOnlyCard(vec![0; 100 * BLOCK]).why_not(), NoVolume::Unknown);
    assert_eq!(ReadOnlyCard(vec![0; 0]).why_not(), NoVolume::Device(0));
    let partition = |name: &[u8; 8]| {
        let mut card = ReadOnlyCard(vec![0; 100 * BLOCK]).entry(0, 7, FIRST, 30);
        card.0[FIRST as usize * BLOCK + 3..][..8].copy_from_slice(name);
        card
    };
    assert_eq!(partition(b"NTFS    ").why_not(), NoVolume::Ntfs);
    // Both of its boot regions are torn.
    assert_eq!(partition(b"EXFAT   ").why_not(), NoVolume::Damaged);
    let mut small = ReadOnlyCard::with_volume_at(0);
    small.0[13] = 64;
    assert_eq!(small.why_not(), NoVolume::Fat12);
}
