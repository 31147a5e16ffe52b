//! Settings are replaced on the board's own file system, and the power goes at every single block write.
//!
//! The card is a FAT32 volume in memory; `embedded-sdmmc` writes it exactly as the firmware does. A block is written
//! whole or not at all, as cards promise.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::rc::Rc;

use embedded_sdmmc::filesystem::ToShortFileName;
use embedded_sdmmc::{
    Block, BlockCount, BlockDevice, BlockIdx, Error, Mode, RawFile, RawVolume, TimeSource, Timestamp, VolumeIdx,
    VolumeManager,
};
use machine::ports::{DirectoryEntry, FileHandle, LIST_CHUNK, OpenMode, Storage, StorageError};
use machine::safe_file::{Draft, unfinished};

/// The smallest FAT32 volume.
const VOLUME_BYTES: usize = 64 << 20;
const BLOCK: usize = 512;
const TEMPORARY: &str = "/sd/override.tmp";
const NAME: &str = "config-override";

#[derive(Debug)]
struct PowerIsGone;

impl std::fmt::Display for PowerIsGone {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the power is gone")
    }
}

impl std::error::Error for PowerIsGone {}

/// A formatted volume, what has been written over it, and how many writes are left before the power goes.
#[derive(Clone)]
struct Disk {
    formatted: Rc<Vec<u8>>,
    written: Rc<RefCell<BTreeMap<u32, [u8; BLOCK]>>>,
    writes: Rc<RefCell<(u32, Option<u32>)>>,
}

impl Disk {
    fn formatted() -> Self {
        let mut image = Cursor::new(vec![0; VOLUME_BYTES]);
        fatfs::format_volume(&mut image, fatfs::FormatVolumeOptions::new().fat_type(fatfs::FatType::Fat32)).unwrap();
        Self { formatted: Rc::new(image.into_inner()), written: Rc::default(), writes: Rc::default() }
    }

    /// The same content, with power for this many writes.
    fn powered_for(&self, writes: Option<u32>) -> Self {
        let written = Rc::new(RefCell::new(self.written.borrow().clone()));
        Self { formatted: self.formatted.clone(), written, writes: Rc::new(RefCell::new((0, writes))) }
    }

    fn count(&self) -> u32 {
        self.writes.borrow().0
    }
}

/// A partition table whose only partition is the volume, from block 1 on.
fn partition_table() -> [u8; BLOCK] {
    let mut table = [0; BLOCK];
    table[446 + 4] = 0x0C;
    table[446 + 8..446 + 12].copy_from_slice(&1_u32.to_le_bytes());
    table[446 + 12..446 + 16].copy_from_slice(&((VOLUME_BYTES / BLOCK) as u32).to_le_bytes());
    table[510..].copy_from_slice(&[0x55, 0xAA]);
    table
}

impl BlockDevice for Disk {
    type Error = PowerIsGone;

    fn read(&self, blocks: &mut [Block], start: BlockIdx) -> Result<(), PowerIsGone> {
        for (number, block) in (start.0..).zip(blocks) {
            block.contents = match (number.checked_sub(1), self.written.borrow().get(&number)) {
                (_, Some(written)) => *written,
                (None, None) => partition_table(),
                (Some(place), None) => {
                    let at = place as usize * BLOCK;
                    self.formatted[at..at + BLOCK].try_into().unwrap()
                }
            };
        }
        Ok(())
    }

    fn write(&self, blocks: &[Block], start: BlockIdx) -> Result<(), PowerIsGone> {
        for (number, block) in (start.0..).zip(blocks) {
            let (count, left) = &mut *self.writes.borrow_mut();
            if *left == Some(0) {
                return Err(PowerIsGone);
            }
            *left = left.map(|left| left - 1);
            *count += 1;
            self.written.borrow_mut().insert(number, block.contents);
        }
        Ok(())
    }

    fn num_blocks(&self) -> Result<BlockCount, PowerIsGone> {
        Ok(BlockCount((VOLUME_BYTES / BLOCK) as u32 + 1))
    }
}

struct NoClock;

impl TimeSource for NoClock {
    fn get_timestamp(&self) -> Timestamp {
        Timestamp { year_since_1970: 51, zero_indexed_month: 0, zero_indexed_day: 0, hours: 0, minutes: 0, seconds: 0 }
    }
}

/// The card as the firmware opens it: short names, one directory.
struct Card {
    manager: VolumeManager<Disk, NoClock, 4, 4, 1>,
    volume: RawVolume,
    files: [Option<RawFile>; 4],
}

fn refuse(error: Error<PowerIsGone>) -> StorageError {
    match error {
        Error::NotFound => StorageError::NotFound,
        Error::DeviceError(_) => StorageError::NotResponding,
        // What the library makes of a device error while it looks for room.
        Error::DiskFull => StorageError::Full,
        other => panic!("the file system is damaged: {other:?}"),
    }
}

impl Card {
    fn insert(disk: Disk) -> Self {
        let manager = VolumeManager::new_with_limits(disk, NoClock, 1);
        let volume = manager.open_raw_volume(VolumeIdx(0)).unwrap();
        Self { manager, volume, files: [None; 4] }
    }

    fn in_root<R>(
        &mut self,
        path: &str,
        action: impl FnOnce(&mut Self, embedded_sdmmc::RawDirectory, &str) -> Result<R, Error<PowerIsGone>>,
    ) -> Result<R, StorageError> {
        let name = path.strip_prefix("/sd/").unwrap().to_ascii_uppercase();
        let (stem, extension) = name.rsplit_once('.').unwrap_or((&name, ""));
        let short = format!("{}.{extension}", &stem[..stem.len().min(8)]);
        let root = self.manager.open_root_dir(self.volume).map_err(refuse)?;
        let result = action(self, root, short.trim_end_matches('.'));
        self.manager.close_dir(root).map_err(refuse)?;
        result.map_err(refuse)
    }

    fn raw(&self, file: FileHandle) -> Result<RawFile, StorageError> {
        self.files[usize::from(file.0)].ok_or(StorageError::NotFound)
    }

    fn content(&mut self, path: &str) -> Option<Vec<u8>> {
        let file = self.open(path, OpenMode::Read).ok()?;
        let mut content = vec![0; self.size(file).unwrap() as usize];
        let mut at = 0;
        while at < content.len() {
            at += self.read(file, &mut content[at..]).unwrap();
        }
        self.close(file).unwrap();
        Some(content)
    }
}

impl Storage for Card {
    fn mount(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let slot = self.files.iter().position(Option::is_none).ok_or(StorageError::TooManyOpen)?;
        let mode = match mode {
            OpenMode::Read => Mode::ReadOnly,
            OpenMode::Write => Mode::ReadWriteCreateOrTruncate,
            OpenMode::Append => Mode::ReadWriteCreateOrAppend,
        };
        let file = self.in_root(path, |card, root, name| {
            card.manager.open_file_in_dir(root, name.to_short_filename().unwrap(), mode)
        })?;
        self.files[slot] = Some(file);
        Ok(FileHandle(slot as u8))
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        self.manager.read(self.raw(file)?, buffer).map_err(refuse)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        self.manager.write(self.raw(file)?, bytes).map_err(refuse)
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        self.manager.file_seek_from_start(self.raw(file)?, offset_bytes).map_err(refuse)
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        self.manager.file_length(self.raw(file)?).map_err(refuse)
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        let raw = self.raw(file)?;
        self.files[usize::from(file.0)] = None;
        self.manager.close_file(raw).map_err(refuse)
    }

    fn list(
        &mut self,
        _: &str,
        _: usize,
        _: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        Err(StorageError::Unsupported)
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.in_root(path, |card, root, name| card.manager.delete_entry_in_dir(root, name.to_short_filename().unwrap()))
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

/// What M500 does.
fn save(card: &mut Card, content: &[u8]) -> Result<(), StorageError> {
    settle(card)?;
    let mut draft = Draft::begin(card, TEMPORARY)?;
    for part in content.chunks(300) {
        draft.write(card, part)?;
    }
    draft.finish(card, NAME)?;
    settle(card)
}

fn settings(steps_per_mm: u32, lines: usize) -> Vec<u8> {
    (0..lines).flat_map(|line| format!("M92 X{steps_per_mm} ; {line}\n").into_bytes()).collect()
}

#[test]
fn a_power_cut_at_any_block_write_leaves_the_old_settings_or_the_new() {
    let disk = Disk::formatted();
    let (old, new) = (settings(80, 60), settings(90, 110));
    save(&mut Card::insert(disk.clone()), &old).unwrap();
    let whole = disk.powered_for(None);
    save(&mut Card::insert(whole.clone()), &new).unwrap();
    let (mut olds, mut news) = (0, 0);
    for writes in 0..=whole.count() {
        let cut = disk.powered_for(Some(writes));
        let saved = save(&mut Card::insert(cut.clone()), &new);
        assert_eq!(saved.is_ok(), writes == whole.count(), "after {writes} block writes");
        let mut card = Card::insert(cut.powered_for(None));
        settle(&mut card).unwrap();
        let found = card.content("/sd/config-override");
        match found {
            Some(found) if found == old => olds += 1,
            Some(found) if found == new => news += 1,
            other => panic!("after {writes} block writes: {:?} bytes", other.map(|found| found.len())),
        }
        // And the card goes on as if nothing had been.
        save(&mut card, &old).unwrap();
        assert_eq!(card.content("/sd/config-override").as_deref(), Some(&old[..]));
        assert_eq!(card.content(TEMPORARY), None);
    }
    assert!(olds > 5 && news > 5, "{olds} old, {news} new");
}
