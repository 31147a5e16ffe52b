//! A file that is read beside whoever else has it open.

use base::ports::{FileHandle, OpenMode, Storage, StorageError};

use super::card::{Mounted, content, fat16, fat32, mounted};
use crate::MAX_BESIDE;

fn put(storage: &mut Mounted, path: &str, bytes: &[u8]) {
    let file = storage.open(path, OpenMode::Write).unwrap();
    storage.write(file, bytes).unwrap();
    storage.close(file).unwrap();
}

fn rest(storage: &mut Mounted, file: FileHandle, at_a_time: usize) -> Vec<u8> {
    let (mut bytes, mut chunk) = (Vec::new(), vec![0; at_a_time]);
    loop {
        match storage.read(file, &mut chunk).unwrap() {
            0 => return bytes,
            count => bytes.extend_from_slice(&chunk[..count]),
        }
    }
}

#[test]
fn two_read_one_file_each_at_its_own_place() {
    for card in [fat16(), fat32()] {
        let (mut storage, bytes) = (mounted(&card), content(3, 20_000));
        put(&mut storage, "/sd/a job.g", &bytes);
        let player = storage.open("/sd/a job.g", OpenMode::Read).unwrap();
        let beside = storage.open("/sd/A JOB.g", OpenMode::Beside).unwrap();
        assert_eq!(storage.size(beside), Ok(20_000));
        let mut chunk = [0; 700];
        let (mut played, mut read) = (Vec::new(), Vec::new());
        for turn in 0..90 {
            let (file, kept) = if turn % 5 == 0 { (player, &mut played) } else { (beside, &mut read) };
            let count = storage.read(file, &mut chunk).unwrap();
            kept.extend_from_slice(&chunk[..count]);
        }
        assert!(read == bytes && bytes.starts_with(&played) && played.len() < bytes.len());
        played.extend(rest(&mut storage, player, 512));
        assert_eq!(played, bytes);
        for offset in [19_999, 0, 511, 512, 12_345, 20_000] {
            storage.seek(beside, offset).unwrap();
            assert_eq!(rest(&mut storage, beside, 300), bytes[offset as usize..], "from {offset}");
        }
        assert_eq!(storage.seek(beside, 20_001), Err(StorageError::BadPath));
        storage.close(beside).unwrap();
        assert_eq!(storage.read(beside, &mut chunk), Err(StorageError::NotFound));
        storage.close(player).unwrap();
    }
}

#[test]
fn it_is_in_nobodys_way_and_gone_when_the_file_changes() {
    type Change = fn(&mut Mounted);
    let changes: [(&str, Change); 4] = [
        ("written anew", |storage| put(storage, "/sd/a.g", b"other")),
        ("appended to", |storage| {
            let file = storage.open("/sd/a.g", OpenMode::Append).unwrap();
            storage.close(file).unwrap();
        }),
        ("removed", |storage| storage.remove("/sd/a.g").unwrap()),
        ("renamed", |storage| storage.rename("/sd/a.g", "/sd/b.g").unwrap()),
    ];
    for (what, change) in changes {
        let mut storage = mounted(&fat16());
        put(&mut storage, "/sd/a.g", b"G28\n");
        put(&mut storage, "/sd/other.g", b"G29\n");
        let beside = storage.open("/sd/a.g", OpenMode::Beside).unwrap();
        let other = storage.open("/sd/other.g", OpenMode::Beside).unwrap();
        change(&mut storage);
        assert_eq!(storage.read(beside, &mut [0; 8]), Err(StorageError::NotFound), "{what}");
        assert_eq!(storage.read(other, &mut [0; 8]), Ok(4), "{what}");
    }
    let mut storage = mounted(&fat16());
    put(&mut storage, "/sd/a.g", b"G28\n");
    let writer = storage.open("/sd/a.g", OpenMode::Append).unwrap();
    assert_eq!(storage.open("/sd/a.g", OpenMode::Beside), Err(StorageError::Busy), "it is being written");
    storage.close(writer).unwrap();
    let all: Vec<_> = (0..MAX_BESIDE).map(|_| storage.open("/sd/a.g", OpenMode::Beside).unwrap()).collect();
    assert_eq!(storage.open("/sd/a.g", OpenMode::Beside), Err(StorageError::TooManyOpen));
    assert!(storage.open("/sd/a.g", OpenMode::Read).is_ok(), "they take nobody's place");
    storage.mount().unwrap();
    assert_eq!(storage.read(all[0], &mut [0; 8]), Err(StorageError::NotFound), "it may be another card");
    assert_eq!(storage.open("/sd/no.g", OpenMode::Beside), Err(StorageError::NotFound));
    assert!(storage.open("/sd/", OpenMode::Beside).is_err());
}
