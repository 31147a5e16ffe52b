//! Files and directories after opening, writing and closing, and the requests that are refused.

use std::string::{String, ToString};
use std::vec::Vec;
use std::{format, vec};

use base::ports::{FileTime, OpenMode, Storage, StorageError};

use super::card::{Mounted, clean, content, fat16, fat32, mounted, read};
use crate::ram::RamCard;

pub fn save(storage: &mut Mounted, path: &str, bytes: &[u8]) -> Result<(), StorageError> {
    let file = storage.open(path, OpenMode::Write)?;
    let written = bytes.chunks(300).try_for_each(|piece| storage.write(file, piece));
    let closed = storage.close(file);
    written.and(closed)
}

pub fn load(storage: &mut Mounted, path: &str) -> Result<Vec<u8>, StorageError> {
    let file = storage.open(path, OpenMode::Read)?;
    let mut bytes = vec![0; storage.size(file)? as usize];
    let count = storage.read(file, &mut bytes)?;
    storage.close(file)?;
    bytes.truncate(count);
    Ok(bytes)
}

/// Changes a byte of the slot that begins with this short name.
fn set_slot_byte(card: &RamCard, short_name: &[u8; 11], at: usize, byte: u8) {
    for number in 0..200 {
        let mut block = card.volume_block(number);
        if let Some(slot) = block.chunks(32).position(|slot| slot.starts_with(short_name)) {
            block[slot * 32 + at] = byte;
            return card.set_volume_block(number, block);
        }
    }
    panic!("no such slot");
}

#[test]
fn no_name_falls_on_another_file() {
    let card = fat32();
    let mut storage = mounted(&card);
    let names = [
        "config.ini",
        "benchy_part_one.gcode",
        "benchy_part_two.gcode",
        "config.initial",
        "config.inia",
        "config-override",
    ];
    for (seed, name) in names.iter().enumerate() {
        save(&mut storage, &format!("/sd/{name}"), &content(seed, 1_000 + seed)).unwrap();
    }
    storage.remove("/sd/config.inia").unwrap();
    assert_eq!(storage.remove("/sd/config.inib"), Err(StorageError::NotFound));
    for (seed, name) in names.iter().enumerate().filter(|(_, name)| **name != "config.inia") {
        assert_eq!(load(&mut storage, &format!("/sd/{}", name.to_uppercase())), Ok(content(seed, 1_000 + seed)));
    }
    let mut found: Vec<_> = clean(&card).tree.into_keys().collect();
    found.sort();
    assert_eq!(
        found,
        ["benchy_part_one.gcode", "benchy_part_two.gcode", "config-override", "config.ini", "config.initial"]
    );
}

/// A file in small letters keeps its name, although `embedded-sdmmc` writes capitals when it closes the file.
#[test]
fn a_name_in_small_letters_stays_so() {
    let card = fat16();
    let mut storage = mounted(&card);
    for round in 0..3 {
        save(&mut storage, "/sd/config.ini", &content(round, 2_000)).unwrap();
        save(&mut storage, "/sd/CONFIG.INI", &content(round, 700)).unwrap();
        save(&mut storage, "/sd/README", &content(round, 700)).unwrap();
        assert_eq!(clean(&card).tree.keys().map(String::as_str).collect::<Vec<_>>(), ["README", "config.ini"]);
    }
}

#[test]
fn a_listing_is_whole() {
    let card = fat16();
    let mut storage = mounted(&card);
    storage.make_directory("/sd/Sub Directory").unwrap();
    let longest = "ж".repeat(250);
    let mut expected = vec![longest.clone()];
    // The longest name makes the longest path that can still be written; a longer one can only come from
    // elsewhere.
    assert_eq!(storage.open(&format!("/sd/{}", "n".repeat(256)), OpenMode::Write), Err(StorageError::BadPath));
    save(&mut storage, &format!("/sd/Sub Directory/{longest}"), b"1").unwrap();
    for number in 0..21 {
        let name = format!("{}part {number:02}.gcode", "a rather long name of a ".repeat(number % 9));
        save(&mut storage, &format!("/sd/Sub Directory/{name}"), &content(number, number)).unwrap();
        expected.push(name);
    }
    let (mut entries, mut listed) = (heapless::Vec::new(), Vec::new());
    loop {
        storage.list("/sd/sub directory", listed.len(), &mut entries).unwrap();
        if entries.is_empty() {
            break;
        }
        listed.extend(entries.iter().cloned());
    }
    assert_eq!(listed.iter().map(|entry| entry.name.to_string()).collect::<Vec<_>>(), expected);
    assert!(listed.iter().all(|entry| !entry.is_directory && entry.attributes.archive && !entry.attributes.read_only));
    assert!(listed.iter().all(|entry| entry.written == FileTime::NO_CLOCK));
    assert_eq!(listed[5].size_bytes, 4);
    let path = "/sd/sub directory/PART 00.gcode";
    let facts = storage.facts(path).unwrap();
    assert_eq!((facts.size_bytes, facts.is_directory, facts.written), (0, false, FileTime::NO_CLOCK));
    save(&mut storage, path, b"longer").unwrap();
    assert!(storage.facts(path).unwrap().tag != facts.tag && storage.facts("/sd/sub directory").unwrap().is_directory);
    assert_eq!(storage.facts("/sd/none"), Err(StorageError::NotFound));
    // A long name is found from anywhere, and after a change as well.
    storage.remove(&format!("/sd/Sub Directory/{longest}")).unwrap();
    storage.list("/sd/Sub Directory", 3, &mut entries).unwrap();
    assert_eq!(entries[0].name.as_str(), expected[4]);
}

#[test]
fn an_open_file_stays_where_it_is() {
    let card = fat16();
    let mut storage = mounted(&card);
    save(&mut storage, "/sd/job.gcode", &content(1, 5_000)).unwrap();
    let job = storage.open("/sd/job.gcode", OpenMode::Read).unwrap();
    for path in ["/sd/job.gcode", "/sd/JOB.GCODE", "/sd/job~1.gco"] {
        assert_eq!(storage.remove(path), Err(StorageError::Busy));
        assert_eq!(storage.rename(path, "/sd/other"), Err(StorageError::Busy));
        assert_eq!(storage.open(path, OpenMode::Write), Err(StorageError::Busy));
        assert_eq!(storage.open(path, OpenMode::Read), Err(StorageError::Busy));
    }
    // Much happens around it meanwhile.
    storage.make_directory("/sd/d").unwrap();
    for number in 0..30 {
        save(&mut storage, &format!("/sd/d/another name {number}"), &content(number, 900)).unwrap();
    }
    storage.rename("/sd/d", "/sd/moved").unwrap();
    let mut bytes = vec![0; 6_000];
    assert_eq!(storage.read(job, &mut bytes), Ok(5_000));
    assert_eq!(bytes[..5_000], content(1, 5_000));
    storage.close(job).unwrap();
    storage.remove("/sd/job.gcode").unwrap();
    clean(&card);
}

#[test]
fn a_closed_file_is_not_another_one() {
    let card = fat16();
    let mut storage = mounted(&card);
    let upload = storage.open("/sd/upload", OpenMode::Write).unwrap();
    storage.mount().unwrap();
    let other = storage.open("/sd/other", OpenMode::Write).unwrap();
    assert_ne!(upload, other);
    assert_eq!(storage.write(upload, b"G28"), Err(StorageError::NotFound));
    storage.close(other).unwrap();
    assert_eq!(read(&card).tree["other"].content.as_deref(), Some(&[][..]));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let card = fat16();
    let mut storage = mounted(&card);
    storage.make_directory("/sd/d").unwrap();
    save(&mut storage, "/sd/d/f", b"1").unwrap();
    save(&mut storage, "/sd/kept", b"1").unwrap();
    let open = |storage: &mut Mounted, path| storage.open(path, OpenMode::Write).map(drop);
    assert_eq!(open(&mut storage, "/sd/d"), Err(StorageError::WrongKind));
    assert_eq!(open(&mut storage, "/sd/kept/f"), Err(StorageError::WrongKind));
    assert_eq!(open(&mut storage, "/sd/nosuch/f"), Err(StorageError::NotFound));
    assert_eq!(open(&mut storage, "/f"), Err(StorageError::NotFound));
    assert_eq!(open(&mut storage, "/sd/a:b"), Err(StorageError::BadPath));
    assert_eq!(storage.remove("/sd/d"), Err(StorageError::WrongKind));
    assert_eq!(storage.make_directory("/sd/KEPT"), Err(StorageError::Exists));
    assert_eq!(storage.rename("/sd/kept", "/sd/D"), Err(StorageError::Exists));
    assert_eq!(storage.rename("/sd/d", "/sd/d/e"), Err(StorageError::BadPath));
    assert_eq!(storage.rename("/sd/nosuch", "/sd/e"), Err(StorageError::NotFound));
    set_slot_byte(&card, b"KEPT       ", 11, 0x21);
    assert_eq!(open(&mut storage, "/sd/kept"), Err(StorageError::ReadOnly));
    assert_eq!(storage.remove("/sd/kept"), Err(StorageError::ReadOnly));
    assert_eq!(load(&mut storage, "/sd/kept").as_deref(), Ok(&b"1"[..]));
}

/// Blanks inside a short name: OS/2 made `EA DATA. SF`. Such a file can be listed, read and renamed, and then
/// written.
#[test]
fn a_name_that_only_old_systems_made_is_not_written_but_renamed() {
    let card = fat16();
    let mut storage = mounted(&card);
    save(&mut storage, "/sd/EA_DATA.SF", b"old").unwrap();
    set_slot_byte(&card, b"EA_DATA SF ", 2, b' ');
    assert_eq!(load(&mut storage, "/sd/EA DATA.SF").as_deref(), Ok(&b"old"[..]));
    assert_eq!(storage.open("/sd/EA DATA.SF", OpenMode::Append), Err(StorageError::Unsupported));
    storage.rename("/sd/EA DATA.SF", "/sd/ea data.sf").unwrap();
    assert_eq!(load(&mut storage, "/sd/EA DATA.SF").as_deref(), Ok(&b"old"[..]));
    clean(&card);
}

#[test]
fn a_damaged_file_is_told_when_it_is_opened() {
    let card = fat16();
    let mut storage = mounted(&card);
    save(&mut storage, "/sd/job", &content(1, 3_000)).unwrap();
    let good = card.volume_block(1);
    // Clusters 2 to 7; 4 leads back to 2, then to nothing, then out of the volume.
    for link in [2_u16, 0, 0xFFFF, 60_000] {
        let mut block = good;
        block[8..10].copy_from_slice(&link.to_le_bytes());
        card.set_volume_block(1, block);
        for mode in [OpenMode::Read, OpenMode::Append] {
            assert_eq!(storage.open("/sd/job", mode), Err(StorageError::Damaged), "{link:x}");
        }
    }
    card.set_volume_block(1, good);
    assert_eq!(load(&mut storage, "/sd/job"), Ok(content(1, 3_000)));
}

/// Another card may be in the slot by the time that the files of the one before are closed.
#[test]
fn nothing_of_a_card_that_is_gone_goes_to_the_next_one() {
    let card = fat16();
    let mut storage = mounted(&card);
    let file = storage.open("/sd/half.g", OpenMode::Write).unwrap();
    storage.write(file, &[b'x'; 700]).unwrap();
    storage.forget_card();
    assert_eq!(storage.write(file, b"more"), Err(StorageError::NotResponding));
    assert_eq!(storage.open("/sd/new.g", OpenMode::Write), Err(StorageError::NotResponding));
    storage.mount().unwrap();
    assert_eq!(storage.write(file, b"more"), Err(StorageError::NotFound));
    assert_eq!(load(&mut storage, "/sd/half.g"), Ok(Vec::new()), "its size was not written any more");
    save(&mut storage, "/sd/new.g", b"new").unwrap();
    assert_eq!(load(&mut storage, "/sd/new.g"), Ok(b"new".to_vec()));
    // A cluster that the entry did not know of yet is lost, as with a power cut.
    assert!(read(&card).lost <= 1);
}
