//! Tests with a volume made here by the specification; `fsck.exfat` of exfatprogs finds nothing wrong with
//! it.

use proptest::prelude::*;

use super::Volume;
use crate::fat::{Blocks, Error, Name};

mod maker;

use maker::{FAT, FAT_BLOCKS, FIRST, content};

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

fn volume() -> Card {
    Card(maker::volume(&[]))
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
    // The fields that change in use are outside the checksum.
    card.0[12 * 512 + 106] ^= 2;
    assert!(Volume::open(&mut card, FIRST).is_ok());
    card.0[12 * 512 + 90] ^= 1;
    assert_eq!(Volume::open(&mut card, FIRST), Err(Error::Damaged));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    /// After any change of bytes, reading ends without a panic.
    #[test]
    fn damage_ends_in_an_error_or_in_something(changes in proptest::collection::vec((any::<u32>(), any::<u8>()), 1..40)) {
        let mut card = volume();
        let length = card.0.len() as u32;
        for (at, byte) in changes {
            // Half of the changes hit where it hurts: boot sector aside, the FAT and the directories.
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
