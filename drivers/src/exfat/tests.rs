//! A volume that is made here by the specification; `fsck.exfat` of exfatprogs finds nothing wrong with it.

use proptest::prelude::*;

use super::{ENTRY_BYTES, Volume};
use crate::fat::{Blocks, Error, Name};

const FIRST: u32 = 64;
const FAT: u32 = 24;
const FAT_BLOCKS: u32 = 8;
const HEAP: u32 = 40;
const CLUSTERS: u32 = 400;
/// Blocks of a cluster.
const PER_CLUSTER: u32 = 2;

#[derive(Clone)]
struct Card(Vec<u8>);

impl Blocks for Card {
    type Error = u32;

    fn read(&mut self, number: u32, block: &mut [u8; 512]) -> Result<(), u32> {
        let at = number.checked_sub(FIRST).ok_or(number)? as usize * 512;
        *block = self.0.get(at..at + 512).ok_or(number)?.try_into().unwrap();
        Ok(())
    }

    fn write(&mut self, number: u32, _: &[u8; 512]) -> Result<(), u32> {
        panic!("block {number} is written");
    }
}

/// A volume while it is made.
struct Maker {
    bytes: Vec<u8>,
    next: u32,
}

struct File {
    first: u32,
    size: u32,
    valid: u32,
    is_contiguous: bool,
    is_directory: bool,
}

impl Maker {
    fn new() -> Self {
        Self { bytes: vec![0; ((HEAP + CLUSTERS * PER_CLUSTER) * 512) as usize], next: 2 }
    }

    fn put(&mut self, at: u32, bytes: &[u8]) {
        self.bytes[at as usize..at as usize + bytes.len()].copy_from_slice(bytes);
    }

    fn link(&mut self, cluster: u32, next: u32) {
        self.put(FAT * 512 + cluster * 4, &next.to_le_bytes());
    }

    /// Content in clusters that are `apart` from each other: 1 is side by side.
    fn store(&mut self, content: &[u8], apart: u32) -> u32 {
        let (first, bytes) = (self.next, (PER_CLUSTER * 512) as usize);
        let pieces: Vec<&[u8]> = content.chunks(bytes).collect();
        for (number, piece) in pieces.iter().enumerate() {
            let cluster = first + number as u32 * apart;
            self.put((HEAP + (cluster - 2) * PER_CLUSTER) * 512, piece);
            let next = if number + 1 == pieces.len() { u32::MAX } else { cluster + apart };
            self.link(cluster, next);
        }
        self.next = first + pieces.len() as u32 * apart;
        first
    }

    fn file(&mut self, content: &[u8], apart: u32) -> File {
        let first = self.store(content, apart);
        let size = content.len() as u32;
        File { first, size, valid: size, is_contiguous: false, is_directory: false }
    }
}

fn sum(bytes: &[u8], skips: &[usize]) -> u16 {
    let counts = bytes.iter().enumerate().filter(|(at, _)| !skips.contains(at));
    counts.fold(0, |sum: u16, (_, byte)| sum.rotate_right(1).wrapping_add(u16::from(*byte)))
}

fn entries(name: &str, file: &File) -> Vec<u8> {
    let units: Vec<u16> = name.encode_utf16().collect();
    let names = units.len().div_ceil(15);
    let mut set = vec![0; ENTRY_BYTES * (2 + names)];
    set[0] = 0x85;
    set[1] = 1 + names as u8;
    set[4] = if file.is_directory { 0x10 } else { 0x20 };
    // 2026-05-17 18:20: the date is the upper half.
    set[12..16].copy_from_slice(&(((46_u32 << 9 | 5 << 5 | 17) << 16) | 18 << 11 | 20 << 5).to_le_bytes());
    set[8..12].copy_from_slice(&((46_u32 << 9 | 5 << 5 | 17) << 16).to_le_bytes());
    set[16..20].copy_from_slice(&((46_u32 << 9 | 5 << 5 | 17) << 16).to_le_bytes());
    set[32] = 0xC0;
    set[33] = 1 | u8::from(file.is_contiguous) << 1;
    set[35] = units.len() as u8;
    let upper: Vec<u8> = name.to_ascii_uppercase().encode_utf16().flat_map(u16::to_le_bytes).collect();
    set[36..38].copy_from_slice(&sum(&upper, &[]).to_le_bytes());
    set[40..44].copy_from_slice(&file.valid.to_le_bytes());
    set[52..56].copy_from_slice(&file.first.to_le_bytes());
    set[56..60].copy_from_slice(&file.size.to_le_bytes());
    for (number, piece) in units.chunks(15).enumerate() {
        let at = 64 + number * ENTRY_BYTES;
        set[at] = 0xC1;
        piece.iter().enumerate().for_each(|(place, unit)| {
            set[at + 2 + place * 2..at + 4 + place * 2].copy_from_slice(&unit.to_le_bytes());
        });
    }
    let checksum = sum(&set, &[2, 3]);
    set[2..4].copy_from_slice(&checksum.to_le_bytes());
    set
}

fn content(size: usize) -> Vec<u8> {
    (0..size).map(|at| (at * 7 + at / 512) as u8).collect()
}

/// Files side by side, scattered, with a part that was never written, in a directory, and with a long name.
fn volume() -> Card {
    let mut maker = Maker::new();
    let bitmap = maker.store(&vec![0; CLUSTERS.div_ceil(8) as usize], 1);
    let upcase: Vec<u8> = (0..128_u16)
        .map(|unit| if (97..=122).contains(&unit) { unit - 32 } else { unit })
        .flat_map(u16::to_le_bytes)
        .collect();
    let table = maker.store(&upcase, 1);
    let scattered = maker.file(&content(9_000), 3);
    let mut together = maker.file(&content(20_000), 1);
    together.is_contiguous = true;
    // The FAT of a contiguous file says nothing.
    (together.first..maker.next).for_each(|cluster| maker.link(cluster, 0));
    let mut sparse = maker.file(&content(3_000), 1);
    sparse.valid = 700;
    let inner = maker.file(b"G28\n", 1);
    let mut folder = maker.file(&[&entries("inner.g", &inner)[..], &[0; 900]].concat(), 1);
    (folder.is_directory, folder.size, folder.valid) = (true, 1_024, 1_024);
    let mut root = vec![0x83, 4];
    root.extend("CARD".encode_utf16().flat_map(u16::to_le_bytes));
    root.resize(ENTRY_BYTES, 0);
    let system = |kind: u8, sum: u32, first: u32, size: u32| {
        let mut entry = vec![0; ENTRY_BYTES];
        entry[0] = kind;
        entry[4..8].copy_from_slice(&sum.to_le_bytes());
        entry[20..24].copy_from_slice(&first.to_le_bytes());
        entry[24..28].copy_from_slice(&size.to_le_bytes());
        entry
    };
    let check = upcase.iter().fold(0_u32, |sum, byte| sum.rotate_right(1).wrapping_add(u32::from(*byte)));
    root.extend(system(0x81, 0, bitmap, CLUSTERS.div_ceil(8)));
    root.extend(system(0x82, check, table, upcase.len() as u32));
    root.extend(entries("scattered.g", &scattered));
    // A file that was removed.
    let mut removed = entries("gone.g", &scattered);
    removed.chunks_mut(ENTRY_BYTES).for_each(|entry| entry[0] &= 0x7F);
    root.extend(removed);
    root.extend(entries("together.g", &together));
    root.extend(entries("Ein langer Name über mehr als fünfzehn Zeichen.gcode", &sparse));
    root.extend(entries("folder", &folder));
    for number in 0..20 {
        let tiny = maker.file(format!("{number}").as_bytes(), 1);
        root.extend(entries(&format!("tiny {number}.g"), &tiny));
    }
    let root = maker.store(&root, 1);
    // What is taken.
    for cluster in 2..maker.next {
        let at = (HEAP + (bitmap - 2) * PER_CLUSTER) * 512 + (cluster - 2) / 8;
        maker.bytes[at as usize] |= 1 << ((cluster - 2) % 8);
    }
    // The gaps of the scattered file are free.
    for cluster in scattered.first..together.first {
        if (cluster - scattered.first) % 3 != 0 {
            let at = (HEAP + (bitmap - 2) * PER_CLUSTER) * 512 + (cluster - 2) / 8;
            maker.bytes[at as usize] &= !(1 << ((cluster - 2) % 8));
        }
    }
    maker.link(0, 0xFFFF_FFF8);
    maker.link(1, u32::MAX);
    boot_regions(&mut maker, root);
    Card(maker.bytes)
}

fn boot_regions(maker: &mut Maker, root: u32) {
    let mut boot = vec![0; 12 * 512];
    boot[..11].copy_from_slice(b"\xEB\x76\x90EXFAT   ");
    boot[64..72].copy_from_slice(&u64::from(FIRST).to_le_bytes());
    boot[72..80].copy_from_slice(&u64::from(HEAP + CLUSTERS * PER_CLUSTER).to_le_bytes());
    for (at, value) in [(80, FAT), (84, FAT_BLOCKS), (88, HEAP), (92, CLUSTERS), (96, root), (100, 0x1234_5678)] {
        boot[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    boot[104..106].copy_from_slice(&0x0100_u16.to_le_bytes());
    (boot[108], boot[109], boot[110], boot[111], boot[112]) = (9, 1, 1, 0x80, 0xFF);
    boot[510..512].copy_from_slice(&[0x55, 0xAA]);
    for block in 1..9 {
        boot[block * 512 + 510..block * 512 + 512].copy_from_slice(&[0x55, 0xAA]);
    }
    let sum = boot[..11 * 512].iter().enumerate().filter(|(at, _)| !matches!(at, 106 | 107 | 112));
    let sum = sum.fold(0_u32, |sum, (_, byte)| sum.rotate_right(1).wrapping_add(u32::from(*byte)));
    boot[11 * 512..].chunks_mut(4).for_each(|word| word.copy_from_slice(&sum.to_le_bytes()));
    maker.put(0, &boot);
    maker.put(12 * 512, &boot);
}

fn names(volume: &Volume, card: &mut Card, path: &str) -> Result<Vec<String>, Error<u32>> {
    let (mut listing, mut name, mut names) = (volume.list(card, path)?, Name::new(), Vec::new());
    while listing.next(volume, card, &mut name)?.is_some() {
        names.push(name.chars().collect());
    }
    assert!(listing.next(volume, card, &mut name)?.is_none(), "it goes on behind its end");
    Ok(names)
}

fn whole(volume: &Volume, card: &mut Card, path: &str, at_a_time: usize) -> Result<Vec<u8>, Error<u32>> {
    let mut reader = volume.find(card, path)?.reader();
    let (mut bytes, mut chunk) = (Vec::new(), vec![0; at_a_time]);
    loop {
        match reader.read(volume, card, bytes.len() as u32, &mut chunk)? {
            0 => return Ok(bytes),
            count => bytes.extend_from_slice(&chunk[..count]),
        }
    }
}

#[test]
fn files_are_listed_and_read_wherever_they_lie() {
    let mut card = volume();
    if let Some(path) = std::env::var_os("EXFAT_IMAGE") {
        std::fs::write(path, &card.0).unwrap();
    }
    let volume = Volume::open(&mut card, FIRST).unwrap();
    let listed = names(&volume, &mut card, "").unwrap();
    assert_eq!(
        listed[..4],
        ["scattered.g", "together.g", "Ein langer Name über mehr als fünfzehn Zeichen.gcode", "folder"]
    );
    assert_eq!(listed.len(), 24);
    for at_a_time in [100, 512, 4_096] {
        assert_eq!(whole(&volume, &mut card, "scattered.g", at_a_time), Ok(content(9_000)));
        assert_eq!(whole(&volume, &mut card, "TOGETHER.G", at_a_time), Ok(content(20_000)));
    }
    let mut sparse = content(3_000);
    sparse[700..].fill(0);
    assert_eq!(whole(&volume, &mut card, "EIN LANGER NAME ÜBER MEHR ALS FÜNFZEHN ZEICHEN.GCODE", 512), Ok(sparse));
    assert_eq!(whole(&volume, &mut card, "folder/inner.g", 512), Ok(b"G28\n".to_vec()));
    assert_eq!(names(&volume, &mut card, "folder"), Ok(vec!["inner.g".to_owned()]));
    let entry = volume.find(&mut card, "tiny 19.g").unwrap();
    assert_eq!((entry.written().year(), entry.written().month(), entry.written().day()), (2026, 5, 17));
    assert_eq!((entry.written().hour(), entry.written().minute(), entry.size_bytes()), (18, 20, 2));
}

#[test]
fn what_is_not_there_is_said_by_name() {
    let mut card = volume();
    let volume = Volume::open(&mut card, FIRST).unwrap();
    assert_eq!(volume.find(&mut card, "gone.g").map(drop), Err(Error::NotFound));
    assert_eq!(volume.find(&mut card, "scattered.g/x").map(drop), Err(Error::IsFile));
    assert_eq!(volume.find(&mut card, "/").map(drop), Err(Error::BadName));
    assert_eq!(volume.list(&mut card, "together.g").map(drop), Err(Error::IsFile));
}

#[test]
fn stretches_lead_along_the_file_as_reading_does() {
    let mut card = volume();
    let volume = Volume::open(&mut card, FIRST).unwrap();
    for path in ["scattered.g", "together.g"] {
        let entry = volume.find(&mut card, path).unwrap();
        let (mut ahead, mut offset, mut blocks) = (entry.reader(), 0, Vec::new());
        while let Some((first, count)) = ahead.stretch(&volume, &mut card, offset).unwrap() {
            blocks.extend(first..first + count);
            offset += count * 512;
        }
        let expected = content(entry.size_bytes() as usize);
        assert_eq!(blocks.len(), expected.len().div_ceil(512));
        for (block, piece) in blocks.iter().zip(expected.chunks(512)) {
            let mut bytes = [0; 512];
            card.read(*block, &mut bytes).unwrap();
            assert_eq!(&bytes[..piece.len()], piece);
        }
    }
}

#[test]
fn a_damaged_boot_region_is_made_up_for_by_its_backup() {
    let mut card = volume();
    card.0[90] ^= 1;
    assert!(Volume::open(&mut card, FIRST).is_ok());
    // What changes by itself does not count.
    card.0[12 * 512 + 106] ^= 2;
    assert!(Volume::open(&mut card, FIRST).is_ok());
    card.0[12 * 512 + 90] ^= 1;
    assert_eq!(Volume::open(&mut card, FIRST), Err(Error::Damaged));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    /// Whatever is changed, reading it ends, and nothing panics.
    #[test]
    fn damage_ends_in_an_error_or_in_something(changes in proptest::collection::vec((any::<u32>(), any::<u8>()), 1..40)) {
        let mut card = volume();
        let length = card.0.len() as u32;
        for (at, byte) in changes {
            // Half of them where it hurts: boot sector aside, the FAT and the directories.
            let at = if at % 2 == 0 { FAT * 512 + at % (FAT_BLOCKS * 512) } else { (FAT * 512).max(at % length) };
            card.0[at as usize] = byte;
        }
        let Ok(volume) = Volume::open(&mut card, FIRST) else { return Ok(()) };
        let Ok(mut listing) = volume.list(&mut card, "") else { return Ok(()) };
        let (mut name, mut seen) = (Name::new(), 0);
        while let Ok(Some(entry)) = listing.next(&volume, &mut card, &mut name) {
            seen += 1;
            prop_assert!(seen < 10_000, "a directory without an end");
            let (mut reader, mut offset, mut chunk) = (entry.reader(), 0_u32, [0; 512]);
            while let Ok(count) = reader.read(&volume, &mut card, offset, &mut chunk) {
                offset += count as u32;
                if count == 0 || offset > 100_000 {
                    break;
                }
            }
        }
    }
}
