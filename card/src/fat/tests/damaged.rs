//! Tests with damaged volumes: after any damage, every call ends, with an error if need be, and touches
//! nothing outside the volume.

use std::string::String;
use std::vec::Vec;

use proptest::prelude::*;

use super::card::{Card, FIRST_BLOCK, Format};
use super::checker::check;
use super::operations::{NOW, Operation, apply, operation};
use crate::fat::{BLOCK_BYTES, Entry, Error, Name, Volume};

/// Returns a volume with files, directories and long names, and its blocks with structure.
fn populated(format: Format) -> (Card, Vec<u32>) {
    let mut card = Card::new(format);
    let mut volume = card.mount();
    for directory in ["dir", "Long Directory", "dir/dir"] {
        volume.make_directory(&mut card, directory, NOW).unwrap();
    }
    let files =
        ["config.ini", "benchy_part_one.gcode", "dir/benchy_part_two.gcode", "Long Directory/größe.g", "dir/dir/a"];
    let operations = files.iter().enumerate().flat_map(|(number, path)| {
        [Operation::Create((*path).into()), Operation::Fill((*path).into(), number * 1_700)]
    });
    for operation in operations {
        apply(&mut card, &mut volume, &operation).unwrap();
    }
    assert!(check(&card).unwrap().is_clean());
    let place =
        |volume: &mut Volume, card: &mut Card, path| volume.find(card, path).unwrap().place().block - FIRST_BLOCK;
    let mut blocks: Vec<_> = files.map(|path| place(&mut volume, &mut card, path)).into();
    let reserved = u32::from(card.block(0)[14]);
    blocks.extend([reserved, reserved, reserved, reserved + 1]);
    (card, blocks)
}

fn visit(volume: &mut Volume, card: &mut Card, path: &str, depth: u32) {
    let Ok(mut listing) = volume.list(card, path) else { return };
    let mut name = Name::new();
    let mut seen: Vec<(String, Entry)> = Vec::new();
    // A damaged directory may be very long; what matters is that reading it ends.
    while let Ok(Some(entry)) = listing.next(volume, card, &mut name) {
        if seen.len() < 40 {
            seen.push((std::format!("{path}/{}", name.chars().collect::<String>()), entry));
        }
    }
    for (path, entry) in seen {
        let _may_fail = volume.check(card, &entry);
        let _may_fail = volume.find(card, &path);
        if entry.is_directory() && depth < 4 {
            visit(volume, card, &path, depth + 1);
        }
    }
}

#[derive(Clone, Debug)]
enum Damage {
    Byte(usize, usize, u8),
    Link(usize, u16),
    Boot(usize, u8),
}

fn damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        6 => (any::<proptest::sample::Index>(), 0..BLOCK_BYTES, any::<u8>())
            .prop_map(|(block, at, byte)| Damage::Byte(block.index(1_000), at, byte)),
        4 => (0..256_usize, 0..40_u16).prop_map(|(at, link)| Damage::Link(at, link)),
        1 => (0..64_usize, any::<u8>()).prop_map(|(at, byte)| Damage::Boot(at, byte)),
    ]
}

fn run(format: Format, damage: &[Damage], operations: &[Operation]) {
    let (mut card, places) = populated(format);
    for damage in damage {
        let (number, at, bytes) = match *damage {
            Damage::Byte(which, at, byte) => (places[which % places.len()], at, std::vec![byte]),
            Damage::Link(at, link) => (u32::from(card.block(0)[14]), at * 2, link.to_le_bytes().to_vec()),
            Damage::Boot(at, byte) => (0, at, std::vec![byte]),
        };
        let mut block = card.block(number);
        block[at..at + bytes.len()].copy_from_slice(&bytes);
        card.set_block(number, block);
    }
    card.read_limit = 3_000_000;
    let blocks = card.blocks();
    let Ok(mut volume) = Volume::open(&mut card, FIRST_BLOCK, blocks) else { return };
    let _may_fail = volume.settle(&mut card);
    visit(&mut volume, &mut card, "", 0);
    for operation in operations {
        // Filling uses the other tool, which is not made for damaged volumes.
        if !matches!(operation, Operation::Fill(..)) {
            let _may_fail = apply(&mut card, &mut volume, operation);
        }
    }
    visit(&mut volume, &mut card, "", 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn nothing_hangs_or_panics(
        damage in proptest::collection::vec(damage(), 1..12),
        operations in proptest::collection::vec(operation(), 1..12),
    ) {
        run(Format::FAT16, &damage, &operations);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn nothing_hangs_or_panics_on_fat32(
        damage in proptest::collection::vec(damage(), 1..12),
        operations in proptest::collection::vec(operation(), 1..12),
    ) {
        run(Format::FAT32, &damage, &operations);
    }
}

/// Sets the link of a cluster.
fn link(card: &mut Card, cluster: u32, next: u16) {
    let mut block = card.block(u32::from(card.block(0)[14]));
    block[cluster as usize * 2..][..2].copy_from_slice(&next.to_le_bytes());
    card.set_block(u32::from(card.block(0)[14]), block);
}

#[test]
fn a_chain_that_loops_or_leaves_the_volume_is_an_error() {
    let (card, _) = populated(Format::FAT16);
    let path = "dir/benchy_part_two.gcode";
    let first = card.clone().mount().find(&mut card.clone(), path).unwrap().cluster();
    for (place, next) in
        [(first, first as u16), (first + 2, first as u16), (first + 1, 0xFFF7), (first, 0), (first, 1), (first, 5_000)]
    {
        let mut card = card.clone();
        let mut volume = card.mount();
        link(&mut card, place, next);
        card.read_limit = card.reads + 1_000;
        let file = volume.find(&mut card, path).unwrap();
        assert_eq!(volume.check(&mut card, &file), Err(Error::Damaged), "{next:x}");
        // The file can still be removed, and nothing else goes with it.
        volume.remove(&mut card, &file).unwrap();
        let found = check(&card).unwrap();
        assert_eq!(found.tree.len(), 7);
    }
}

#[test]
fn a_directory_that_loops_is_an_error() {
    let (mut card, _) = populated(Format::FAT16);
    let mut volume = card.mount();
    let cluster = volume.find(&mut card, "dir").unwrap().cluster();
    for number in 0..20 {
        volume.create(&mut card, &std::format!("dir/another file number {number}"), NOW).unwrap();
    }
    link(&mut card, cluster, cluster as u16);
    card.read_limit = card.reads + 10_000;
    assert_eq!(volume.find(&mut card, "dir/nosuch").unwrap_err(), Error::Damaged);
    assert_eq!(volume.create(&mut card, "dir/nosuch", NOW).unwrap_err(), Error::Damaged);
    assert!(volume.find(&mut card, "config.ini").is_ok(), "the rest can be used");
}
