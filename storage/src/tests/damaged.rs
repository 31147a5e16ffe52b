//! Damaged volumes: whatever is on them, every call ends, with an error if need be.

use std::format;
use std::string::String;
use std::vec::Vec;

use base::ports::{FileHandle, OpenMode, Storage};
use proptest::prelude::*;

use super::card::{Mounted, clean, content, fat16, fat32, mounted};
use super::contents::save;
use crate::ram::{RamCard, Standing};

const PATHS: [&str; 8] = [
    "/sd/config.ini",
    "/sd/benchy_part_one.gcode",
    "/sd/dir/benchy_part_two.gcode",
    "/sd/dir/dir/a",
    "/sd/dir",
    "/sd/dir/dir",
    "/sd/a new name.gcode",
    "/sd/dir/NEW",
];

/// A volume with files and directories, and the blocks of it that say where they are.
fn populated(card: RamCard) -> (RamCard, Vec<u32>) {
    let mut storage = mounted(&card);
    for path in &PATHS[4..6] {
        storage.make_directory(path).unwrap();
    }
    for (seed, path) in PATHS[..4].iter().enumerate() {
        save(&mut storage, path, &content(seed, 700 + seed * 1_300)).unwrap();
    }
    clean(&card);
    let holds_entries = |number: &u32| {
        let block = card.volume_block(*number);
        block
            .chunks(32)
            .any(|slot| matches!(slot[11], 0x10 | 0x20) && slot[13..20] == [0, 0x80, 0x92, 0xB2, 0x52, 0, 0])
    };
    let tables = u32::from(card.volume_block(0)[14]);
    let places = (0..1_200).filter(holds_entries).chain([tables, tables, tables]).collect();
    (card, places)
}

#[derive(Clone, Debug)]
enum Damage {
    Byte(usize, usize, u8),
    Link(usize, u16),
}

fn damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        3 => (0..100_usize, 0..512_usize, any::<u8>()).prop_map(|(which, at, byte)| Damage::Byte(which, at, byte)),
        2 => (0..60_usize, 0..40_u16).prop_map(|(at, link)| Damage::Link(at, link)),
        1 => (0..60_usize, 0xFF00..=0xFFFF_u16).prop_map(|(at, link)| Damage::Link(at, link)),
    ]
}

fn exercise(storage: &mut Mounted, paths: &[(usize, usize, u8)]) {
    let mut open: Vec<FileHandle> = Vec::new();
    for (one, other, what) in paths {
        let (path, second) = (PATHS[one % PATHS.len()], PATHS[other % PATHS.len()]);
        let _may_fail = match what {
            0..3 => {
                let mode = [OpenMode::Read, OpenMode::Write, OpenMode::Append][usize::from(*what)];
                storage.open(path, mode).map(|file| open.push(file))
            }
            3 => storage.remove(path),
            4 => storage.rename(path, second),
            5 => storage.make_directory(path),
            6 => open.pop().map_or(Ok(()), |file| storage.close(file)),
            _ => storage.list(path, other % 3, &mut heapless::Vec::new()),
        };
        for file in &open {
            let mut bytes = [0; 900];
            let _may_fail = storage.read(*file, &mut bytes);
            let _may_fail = storage.write(*file, &bytes);
        }
    }
    for file in open {
        let _may_fail = storage.close(file);
    }
}

fn run(card: RamCard, damage: &[Damage], calls: &[(usize, usize, u8)]) {
    let (card, places) = populated(card);
    for damage in damage {
        let (number, at, bytes) = match *damage {
            Damage::Byte(which, at, byte) => (places[which % places.len()], at, std::vec![byte]),
            Damage::Link(at, link) => (u32::from(card.volume_block(0)[14]), at * 2, link.to_le_bytes().to_vec()),
        };
        let mut block = card.volume_block(number);
        block[at..at + bytes.len()].copy_from_slice(&bytes);
        card.set_volume_block(number, block);
    }
    let card = card.powered_for(None);
    card.expect_no_more_reads_than(2_000_000);
    let mut storage = crate::CardStorage::new(card, Standing, Box::leak(Box::default()));
    if storage.mount().is_ok() {
        exercise(&mut storage, calls);
        let _may_fail = storage.mount();
    }
}

fn calls() -> impl Strategy<Value = Vec<(usize, usize, u8)>> {
    proptest::collection::vec((0..8_usize, 0..8_usize, 0..8_u8), 1..25)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn nothing_hangs_or_panics(damage in proptest::collection::vec(damage(), 1..10), calls in calls()) {
        run(fat16(), &damage, &calls);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn nothing_hangs_or_panics_on_fat32(damage in proptest::collection::vec(damage(), 1..10), calls in calls()) {
        run(fat32(), &damage, &calls);
    }
}

/// The boot sector is believed by nobody.
#[test]
fn a_damaged_boot_sector_ends_in_an_error_or_a_volume() {
    for card in [fat16(), fat32()] {
        for at in (11..64).chain(500..512) {
            for byte in [0, 1, 2, 3, 0x7F, 0x80, 0xFF] {
                let card = card.powered_for(None);
                let mut boot = card.volume_block(0);
                boot[at] = byte;
                card.set_volume_block(0, boot);
                card.expect_no_more_reads_than(2_000_000);
                let mut storage = crate::CardStorage::new(card, Standing, Box::leak(Box::default()));
                let mounted = storage.mount();
                let text: String = format!("{at} {byte} {mounted:?}");
                assert!(mounted.is_err() || storage.list("/sd", 0, &mut heapless::Vec::new()).is_ok(), "{text}");
                let _may_fail = save(&mut storage, "/sd/a file", b"1");
            }
        }
    }
}
