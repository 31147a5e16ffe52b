//! Power cuts on a card that loses everything after its n-th write.

use super::*;
use crate::ports::{DirectoryEntry, LIST_CHUNK};
use std::collections::BTreeMap;
use std::string::{String as Text, ToString};
use std::vec::Vec as List;

const TEMPORARY: &str = "/sd/settings.tmp";
const FILE: &str = "/sd/settings";

/// Files in memory. Every change of the card costs a write; after the last one nothing reaches the card any more.
#[derive(Clone, Default)]
struct Card {
    files: BTreeMap<Text, List<u8>>,
    open: List<Option<(Text, usize)>>,
    writes_left: Option<usize>,
    writes: usize,
}

impl Card {
    fn spend(&mut self) -> Result<(), StorageError> {
        if self.writes_left == Some(0) {
            return Err(StorageError::NotResponding);
        }
        self.writes_left = self.writes_left.map(|left| left - 1);
        self.writes += 1;
        Ok(())
    }

    fn place(&mut self, file: FileHandle) -> Result<&mut (Text, usize), StorageError> {
        self.open.get_mut(usize::from(file.0)).and_then(Option::as_mut).ok_or(StorageError::NotFound)
    }

    /// Switched on again.
    fn rebooted(&self) -> Self {
        Self { files: self.files.clone(), ..Self::default() }
    }
}

impl Storage for Card {
    fn mount(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        match mode {
            OpenMode::Read if !self.files.contains_key(path) => return Err(StorageError::NotFound),
            OpenMode::Read => {}
            _ => {
                self.spend()?;
                self.files.insert(path.to_string(), List::new());
            }
        }
        self.open.push(Some((path.to_string(), 0)));
        Ok(FileHandle(self.open.len() as u8 - 1))
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        let (path, at) = self.place(file)?.clone();
        let content = self.files.get(&path).ok_or(StorageError::NotFound)?;
        // As a card does: never more than to the end of a block.
        let count = buffer.len().min(content.len() - at).min(BLOCK - at % BLOCK);
        buffer[..count].copy_from_slice(&content[at..at + count]);
        self.place(file)?.1 += count;
        Ok(count)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        let path = self.place(file)?.0.clone();
        // Half a block may be there when the power goes.
        let half = bytes.len() / 2;
        let content =
            |card: &mut Self, bytes: &[u8]| card.files.entry(path.clone()).or_default().extend_from_slice(bytes);
        self.spend()?;
        content(self, &bytes[..half]);
        self.spend()?;
        content(self, &bytes[half..]);
        Ok(())
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        self.place(file)?.1 = offset_bytes as usize;
        Ok(())
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        let path = self.place(file)?.0.clone();
        Ok(self.files[&path].len() as u32)
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        self.spend()?;
        self.open[usize::from(file.0)].take().map(drop).ok_or(StorageError::NotFound)
    }

    fn list(&mut self, _: &str, _: usize, _: &mut Vec<DirectoryEntry, LIST_CHUNK>) -> Result<(), StorageError> {
        Err(StorageError::Unsupported)
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.spend()?;
        self.files.remove(path).map(drop).ok_or(StorageError::NotFound)
    }

    fn make_directory(&mut self, _: &str) -> Result<(), StorageError> {
        Err(StorageError::Unsupported)
    }

    fn rename(&mut self, _: &str, _: &str) -> Result<(), StorageError> {
        Err(StorageError::Unsupported)
    }
}

fn settle(card: &mut Card) -> Result<(), StorageError> {
    if let Some(mut install) = unfinished(card, TEMPORARY)? {
        while !install.step(card)? {}
    }
    Ok(())
}

fn replace(card: &mut Card, content: &[u8]) -> Result<(), StorageError> {
    settle(card)?;
    let mut draft = Draft::begin(card, TEMPORARY)?;
    for piece in content.chunks(100) {
        draft.write(card, piece)?;
    }
    draft.finish(card, "settings")?;
    settle(card)
}

fn content(seed: u8, length: usize) -> List<u8> {
    (0..length).map(|i| seed.wrapping_mul(31).wrapping_add(i as u8)).collect()
}

#[test]
fn the_sum_is_the_common_one() {
    let mut sum = Sum::EMPTY;
    sum.add(b"123456789");
    assert_eq!(sum.value(), 0xCBF4_3926);
}

#[test]
fn a_power_cut_at_any_write_leaves_the_old_file_or_the_new() {
    for (old, new) in [(700, 1_500), (1_500, 40), (0, 600), (512, 512)] {
        let (old, new) = (content(1, old), content(2, new));
        let mut before = Card::default();
        before.files.insert(FILE.into(), old.clone());
        let mut whole = before.clone();
        replace(&mut whole, &new).unwrap();
        assert_eq!(whole.files, BTreeMap::from([(FILE.to_string(), new.clone())]), "nothing else stays");
        let (mut olds, mut news) = (0, 0);
        for writes in 0..whole.writes {
            let mut card = Card { writes_left: Some(writes), ..before.clone() };
            assert!(replace(&mut card, &new).is_err());
            let mut card = card.rebooted();
            settle(&mut card).unwrap();
            let found = &card.files[FILE];
            assert!(*found == old || *found == new, "after {writes} writes: {} bytes", found.len());
            if *found == old { olds += 1 } else { news += 1 }
        }
        assert!(olds > 2 && news > 2, "{olds} {news}");
    }
}

/// The power may go again while the change is finished at boot.
#[test]
fn a_second_power_cut_while_recovering_changes_nothing_about_it() {
    let (old, new) = (content(3, 900), content(4, 1_300));
    let mut before = Card::default();
    before.files.insert(FILE.into(), old.clone());
    for first in 0..40 {
        let mut card = Card { writes_left: Some(first), ..before.clone() };
        let done = replace(&mut card, &new).is_ok();
        for second in 0..20 {
            let mut again = Card { writes_left: Some(second), ..card.rebooted() };
            let _ = settle(&mut again);
            let mut last = again.rebooted();
            settle(&mut last).unwrap();
            let found = &last.files[FILE];
            assert!(*found == new || (!done && *found == old), "after {first} and {second} writes");
        }
    }
}

#[test]
fn a_damaged_or_foreign_temporary_file_is_left_alone() {
    let mut card = Card::default();
    card.files.insert(FILE.into(), content(1, 10));
    card.files.insert(TEMPORARY.into(), content(9, 700));
    settle(&mut card).unwrap();
    assert_eq!(card.files[FILE], content(1, 10));
    replace(&mut card, &content(2, 600)).unwrap();
    let mut draft = Draft::begin(&mut card, TEMPORARY).unwrap();
    draft.write(&mut card, b"M92 X80\n").unwrap();
    draft.finish(&mut card, "settings").unwrap();
    card.files.get_mut(TEMPORARY).unwrap()[4] ^= 1;
    settle(&mut card).unwrap();
    assert_eq!(card.files[FILE], content(2, 600), "one wrong bit is no valid mark");
}
