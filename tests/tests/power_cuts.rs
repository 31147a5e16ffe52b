//! Settings are replaced on the board's own file system, and the power goes at every single block write.

use std::io::Cursor;

use machine::ports::{OpenMode, Storage, StorageError};
use machine::safe_file::{Draft, settle};
use storage::CardStorage;
use storage::ram::{RamCard, Standing};

/// The smallest FAT32 volume.
const VOLUME_BYTES: usize = 64 << 20;
const PATH: &str = "/sd/config-override";
const PREVIOUS: &str = "/sd/previous-config-override";

type Card = CardStorage<RamCard, Standing>;

fn formatted() -> RamCard {
    let mut image = Cursor::new(vec![0; VOLUME_BYTES]);
    fatfs::format_volume(&mut image, fatfs::FormatVolumeOptions::new().fat_type(fatfs::FatType::Fat32)).unwrap();
    RamCard::new(image.into_inner())
}

fn insert(disk: RamCard) -> Card {
    let mut card = CardStorage::new(disk, Standing);
    card.mount().unwrap();
    card
}

fn content(card: &mut Card, path: &str) -> Option<Vec<u8>> {
    let file = match card.open(path, OpenMode::Read) {
        Err(StorageError::NotFound) => return None,
        opened => opened.unwrap(),
    };
    let mut content = vec![0; card.size(file).unwrap() as usize];
    assert_eq!(card.read(file, &mut content), Ok(content.len()));
    card.close(file).unwrap();
    Some(content)
}

/// What M500 does.
fn save(card: &mut Card, content: &[u8]) -> Result<(), StorageError> {
    let mut draft = Draft::begin(card, PATH)?;
    for part in content.chunks(300) {
        draft.write(card, part)?;
    }
    draft.finish(card)
}

fn names(card: &mut Card) -> Vec<String> {
    let (mut names, mut entries) = (Vec::new(), heapless::Vec::new());
    while card.list("/sd", names.len(), &mut entries).is_ok() && !entries.is_empty() {
        names.extend(entries.iter().map(|entry| entry.name.to_string()));
    }
    names.sort();
    names
}

fn settings(steps_per_mm: u32, lines: usize) -> Vec<u8> {
    (0..lines).flat_map(|line| format!("M92 X{steps_per_mm} ; {line}\n").into_bytes()).collect()
}

#[test]
fn a_power_cut_at_any_block_write_leaves_the_old_settings_or_the_new() {
    let disk = formatted();
    let (old, new) = (settings(80, 60), settings(90, 110));
    save(&mut insert(disk.clone()), &old).unwrap();
    let whole = disk.powered_for(None);
    save(&mut insert(whole.clone()), &new).unwrap();
    let (mut olds, mut news) = (0, 0);
    for writes in 0..=whole.counts().writes {
        let cut = disk.powered_for(Some(writes));
        let saved = save(&mut insert(cut.clone()), &new);
        assert_eq!(saved.is_ok(), writes == whole.counts().writes, "after {writes} block writes");
        let mut card = insert(cut.powered_for(None));
        settle(&mut card, PATH).unwrap();
        let found = content(&mut card, PATH);
        match found {
            Some(found) if found == old => olds += 1,
            Some(found) if found == new => {
                assert_eq!(content(&mut card, PREVIOUS).as_deref(), Some(&old[..]), "after {writes} block writes");
                news += 1;
            }
            other => panic!("after {writes} block writes: {:?} bytes", other.map(|found| found.len())),
        }
        // And the card goes on as if nothing had been.
        save(&mut card, &old).unwrap();
        assert_eq!(content(&mut card, PATH).as_deref(), Some(&old[..]));
        assert_eq!(names(&mut card), ["config-override", "previous-config-override"]);
    }
    assert!(olds > 5 && news > 5, "{olds} old, {news} new");
}
