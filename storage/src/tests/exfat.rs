//! A card with exFAT: all of it is read, and nothing is written.

use base::ports::{OpenMode, Storage, StorageError};

use super::maker::{content, volume};
use crate::ram::{RamCard, Standing};

#[test]
fn it_is_listed_and_read_and_says_what_to_do_to_write() {
    let card = RamCard::new(volume(&[("config.ini", b"[general]")]));
    let mut storage = crate::CardStorage::new(card.clone(), Standing, Box::leak(Box::default()));
    storage.mount().unwrap();
    let (mut names, mut entries) = (Vec::new(), heapless::Vec::new());
    loop {
        storage.list("/sd", names.len(), &mut entries).unwrap();
        if entries.is_empty() {
            break;
        }
        names.extend(entries.iter().map(|entry| entry.name.to_string()));
    }
    assert_eq!(names.len(), 25);
    let file = storage.open("/sd/SCATTERED.G", OpenMode::Read).unwrap();
    storage.read_ahead(file);
    let mut bytes = vec![0; 20_000];
    assert_eq!(storage.read(file, &mut bytes), Ok(9_000));
    assert_eq!(bytes[..9_000], content(9_000));
    storage.seek(file, 8_999).unwrap();
    assert_eq!(storage.read(file, &mut bytes), Ok(1));
    let beside = storage.open("/sd/folder/inner.g", OpenMode::Beside).unwrap();
    assert_eq!((storage.size(beside), storage.read(beside, &mut bytes)), (Ok(4), Ok(4)));
    assert_eq!(storage.open("/sd/folder", OpenMode::Read), Err(StorageError::WrongKind));
    for mode in [OpenMode::Write, OpenMode::Append] {
        assert_eq!(storage.open("/sd/new.g", mode), Err(StorageError::Exfat));
        assert_eq!(storage.open("/sd/config.ini", mode), Err(StorageError::Exfat));
    }
    assert_eq!(storage.remove("/sd/config.ini"), Err(StorageError::Exfat));
    assert_eq!(storage.rename("/sd/config.ini", "/sd/a"), Err(StorageError::Exfat));
    assert_eq!(storage.make_directory("/sd/a"), Err(StorageError::Exfat));
    assert_eq!(card.counts().writes, 0);
}
