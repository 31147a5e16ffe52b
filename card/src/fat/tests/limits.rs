//! Tests of volumes that are full, too small, or no FAT at all.

use std::collections::BTreeSet;
use std::format;
use std::vec::Vec;

use fatfs::FatType;

use super::card::{Card, FIRST_BLOCK, Format};
use super::checker::check;
use super::operations::{NOW, fill};
use crate::fat::{BLOCK_BYTES, Error, Kind, Name, Volume};

#[test]
fn a_full_root_of_fat16_says_so_and_stays_whole() {
    let mut card = Card::new(Format::FAT16);
    let mut volume = card.mount();
    volume.make_directory(&mut card, "roomy", NOW).unwrap();
    let mut made = 0;
    let refused = loop {
        match volume.create(&mut card, &format!("a long name that takes four slots {made:02}"), NOW) {
            Ok(_) => made += 1,
            Err(error) => break error,
        }
    };
    assert_eq!((made, refused), ((128 - 2) / 4, Error::DirectoryFull), "the label and a directory take one slot each");
    let first = volume.find(&mut card, "a long name that takes four slots 00").unwrap();
    assert_eq!(volume.make_directory(&mut card, "one more.directory", NOW).unwrap_err(), Error::DirectoryFull);
    volume.create(&mut card, "SHORT1", NOW).unwrap();
    volume.create(&mut card, "SHORT2", NOW).unwrap();
    assert_eq!(
        volume.rename(&mut card, &first, "roomy/moved").unwrap_err(),
        Error::DirectoryFull,
        "no room for the note"
    );
    volume.create(&mut card, "roomy/another long name of some length", NOW).unwrap();
    let found = check(&card).unwrap();
    assert!(found.is_clean(), "{found:?}");
    assert_eq!(found.tree.len(), 1 + made + 3);
    volume.remove(&mut card, &first).unwrap();
    let entry = volume.find(&mut card, "SHORT1").unwrap();
    volume.rename(&mut card, &entry, "roomy/moved").unwrap();
    assert!(check(&card).unwrap().is_clean());
}

#[test]
fn directories_grow_and_keep_everything() {
    for format in [Format::FAT16, Format::FAT32] {
        let mut card = Card::new(format);
        let mut volume = card.mount();
        volume.make_directory(&mut card, "d", NOW).unwrap();
        let name = |number: usize| format!("d/{}{number:04}.gcode", "part of a print ".repeat(number % 14));
        for number in 0..150 {
            volume.create(&mut card, &name(number), NOW).unwrap();
        }
        let found = check(&card).unwrap();
        assert!(found.is_clean() && found.tree.len() == 151);
        for number in (0..150).step_by(2) {
            let entry = volume.find(&mut card, &name(number)).unwrap();
            volume.remove(&mut card, &entry).unwrap();
        }
        let (mut listing, mut listed) = (volume.list(&mut card, "d").unwrap(), Name::new());
        let mut count = 0;
        while listing.next(&mut volume, &mut card, &mut listed).unwrap().is_some() {
            count += 1;
        }
        assert_eq!(count, 75);
        let directory = volume.find(&mut card, "d").unwrap();
        assert_eq!(volume.remove(&mut card, &directory), Err(Error::NotEmpty));
        for number in (1..150).step_by(2) {
            let entry = volume.find(&mut card, &name(number)).unwrap();
            volume.remove(&mut card, &entry).unwrap();
        }
        volume.remove(&mut card, &directory).unwrap();
        assert_eq!(check(&card).unwrap(), super::checker::Found::default(), "every cluster is back");
    }
}

/// Creates far more names with one beginning than there are tails.
#[test]
fn short_names_stay_different() {
    let mut card = Card::new(Format::FAT32);
    let mut volume = card.mount();
    let mut seen = BTreeSet::new();
    for number in 0..300 {
        let entry = volume.create(&mut card, &format!("benchy_part_{number}.gcode"), NOW).unwrap();
        assert!(seen.insert(entry.short_name()), "{number}");
    }
    assert!(seen.iter().any(|name| name.starts_with(b"BENCHY~9")));
    assert!(check(&card).unwrap().is_clean());
}

#[test]
fn a_full_card_says_so_and_stays_whole() {
    let mut card = Card::new(Format::FAT16);
    let mut volume = card.mount();
    volume.make_directory(&mut card, "d", NOW).unwrap();
    let free = card.free_clusters() as usize;
    for (name, size) in [("large", (free - 3) * 512), ("d/small", 1)] {
        volume.create(&mut card, name, NOW).unwrap();
        fill(&mut card, name, size);
    }
    assert!(volume.has_free(&mut card, 2).unwrap() && !volume.has_free(&mut card, 3).unwrap());
    let mut made = 0;
    let refused = loop {
        match volume.create(&mut card, &format!("d/{}{made}", "many slots ".repeat(20)), NOW) {
            Ok(_) => made += 1,
            Err(error) => break error,
        }
    };
    assert_eq!(refused, Error::Full);
    assert_eq!(volume.make_directory(&mut card, "e", NOW).unwrap_err(), Error::Full);
    let found = check(&card).unwrap();
    assert!(found.is_clean() && made > 0, "{made} {found:?}");
    let large = volume.find(&mut card, "large").unwrap();
    volume.remove(&mut card, &large).unwrap();
    volume.make_directory(&mut card, "e", NOW).unwrap();
    assert!(check(&card).unwrap().is_clean());
}

#[test]
fn a_file_is_trimmed_to_its_size() {
    let mut card = Card::new(Format::FAT32);
    let mut volume = card.mount();
    for (size, left) in [(2_000_u32, 900_u32), (2_000, 1_024), (2_000, 0), (512, 512), (0, 0)] {
        let entry = volume.create(&mut card, "file", NOW).unwrap();
        fill(&mut card, "file", size as usize);
        // The state if the end of the file had never been noted.
        let place = entry.place();
        let mut block = card.block(place.block - FIRST_BLOCK);
        block[place.offset_bytes() as usize + 28..][..4].copy_from_slice(&left.to_le_bytes());
        card.set_block(place.block - FIRST_BLOCK, block);
        assert_eq!(check(&card).is_err(), left.div_ceil(512) != size.div_ceil(512));
        volume.trim(&mut card, place).unwrap();
        let found = check(&card).unwrap();
        assert!(found.is_clean() && found.tree["file"].content.as_ref().unwrap().len() == left as usize);
        let entry = volume.find(&mut card, "file").unwrap();
        assert_eq!(volume.check(&mut card, &entry), Ok(()));
        volume.remove(&mut card, &entry).unwrap();
    }
}

/// Slots behind the end of a directory are not always zero. A slot that appears when the end moves is
/// nobody's file.
#[test]
fn what_lies_behind_the_end_of_a_directory_stays_there() {
    let mut card = Card::new(Format::FAT16);
    let mut volume = card.mount();
    let place = volume.create(&mut card, "first", NOW).unwrap().place();
    let mut block = card.block(place.block - FIRST_BLOCK);
    for slot in place.slot + 2..16 {
        let at = usize::from(slot) * 32;
        block[at..at + 32].copy_from_slice(b"GHOST   TXT\x20\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x09\0\x10\0\0\0");
    }
    card.set_block(place.block - FIRST_BLOCK, block);
    for name in ["SECOND", "a name of two slots", "THIRD"] {
        volume.create(&mut card, name, NOW).unwrap();
        let names = check(&card).unwrap().tree;
        assert!(names.keys().all(|name| name != "GHOST.TXT"), "{names:?}");
    }
    assert_eq!(check(&card).unwrap().tree.len(), 4);
}

#[test]
fn a_read_only_file_stays() {
    let mut card = Card::new(Format::FAT16);
    let mut volume = card.mount();
    let place = volume.create(&mut card, "kept", NOW).unwrap().place();
    let mut block = card.block(place.block - FIRST_BLOCK);
    block[place.offset_bytes() as usize + 11] |= 1;
    card.set_block(place.block - FIRST_BLOCK, block);
    let entry = volume.find(&mut card, "kept").unwrap();
    assert_eq!(volume.remove(&mut card, &entry), Err(Error::ReadOnly));
    assert_eq!(volume.empty(&mut card, &entry, NOW), Err(Error::ReadOnly));
    volume.rename(&mut card, &entry, "renamed and kept").unwrap();
}

/// FSINFO, the block behind the boot sector.
#[test]
fn the_count_of_free_clusters_is_no_lie() {
    let count = |card: &Card| u32::from_le_bytes(card.block(1)[488..492].try_into().unwrap());
    let counted = || {
        let mut card = Card::new(Format::FAT32);
        let mut info = card.block(1);
        info[488..492].copy_from_slice(&65_000_u32.to_le_bytes());
        card.set_block(1, info);
        card
    };
    let mut card = counted();
    let mut volume = card.mount();
    let _ = volume.create(&mut card, "file", NOW).unwrap();
    assert_eq!(count(&card), 65_000, "no cluster was taken");
    volume.make_directory(&mut card, "d", NOW).unwrap();
    assert_eq!(count(&card), u32::MAX);
    let mut again = counted();
    let mut volume = again.mount();
    volume.forget_free_count(&mut again).unwrap();
    assert_eq!((count(&again), again.writes), (u32::MAX, 1));
    volume.forget_free_count(&mut again).unwrap();
    assert_eq!((again.writes, again.reads), (1, 2), "once");
}

#[test]
fn what_is_no_volume_is_refused_with_the_reason() {
    let good = Card::new(Format::FAT32);
    let refused = |change: &dyn Fn(&mut [u8; BLOCK_BYTES])| {
        let mut card = good.clone();
        let mut boot = card.block(0);
        change(&mut boot);
        card.set_block(0, boot);
        let blocks = card.blocks();
        match Volume::open(&mut card, FIRST_BLOCK, blocks) {
            Err(Error::NotFat(why)) => why,
            other => panic!("{other:?}"),
        }
    };
    let put =
        |at: usize, bytes: &'static [u8]| move |boot: &mut [u8; 512]| boot[at..at + bytes.len()].copy_from_slice(bytes);
    assert!(refused(&put(510, &[0, 0])).contains("no FAT boot sector"));
    assert!(refused(&put(11, &[0, 16])).contains("512"), "4 KiB blocks");
    assert!(refused(&put(13, &[0])).contains("no FAT boot sector"), "no blocks in a cluster");
    assert!(refused(&put(13, &[3])).contains("no FAT boot sector"));
    assert!(refused(&put(16, &[3])).contains("allocation tables"));
    assert!(refused(&put(32, &[0xFF; 4])).contains("larger than its partition"));
    assert!(refused(&put(32, &[9, 0, 0, 0])).contains("smaller than its tables"));
    assert!(refused(&put(36, &[1, 0, 0, 0])).contains("table is too short"));
    assert!(refused(&put(40, &[0x81, 0])).contains("second allocation table"));
    assert!(refused(&put(42, &[1, 0])).contains("version"));
    assert!(refused(&put(44, &[0, 0, 0, 0])).contains("root directory"));
    assert!(refused(&put(44, &[0xFF, 0xFF, 0xFF, 0xFF])).contains("root directory"));
    assert!(refused(&put(13, &[64])).contains("FAT12"));
    assert!(refused(&put(13, &[2])).contains("too few clusters"), "FAT32's parameters with FAT16's count");
    let mut small = good;
    assert!(matches!(Volume::open(&mut small, FIRST_BLOCK, 1_000), Err(Error::NotFat(_))));
}

#[test]
fn both_kinds_are_told_apart_and_their_tables_end_where_they_end() {
    for (format, kind) in [(Format::FAT16, Kind::Fat16), (Format::FAT32, Kind::Fat32)] {
        let mut card = Card::new(format);
        let volume = card.mount();
        assert_eq!((volume.kind(), volume.cluster_bytes()), (kind, 512));
        let entry_bytes = if format.kind == FatType::Fat16 { 2 } else { 4 };
        let used = (card.clusters() + 2) * entry_bytes;
        let unused: Vec<_> = (0..FIRST_BLOCK + 1_200)
            .filter_map(|block| Some((block, volume.unused_table_bytes_from(block)?)))
            .collect();
        assert_eq!(unused.len() % 2, 0, "both tables");
        assert_eq!(unused[0].1, (used % 512) as usize);
        assert!(unused[1..unused.len() / 2].iter().all(|(_, from)| *from == 0));
    }
}
