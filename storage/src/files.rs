//! The storage port over both: names here, contents there.

use drivers::fat::{
    Attributes, Entry, Error as NameError, Listing, Name, Place, Reader, Stamp, Volume, first_partition,
};
use embedded_sdmmc::{
    Block, BlockIdx, Error, Mode, RawDirectory, RawFile, RawVolume, ShortFileName, TimeSource, VolumeIdx, VolumeManager,
};
use heapless::{String, Vec};
use machine::ports::{DirectoryEntry, FileHandle, LIST_CHUNK, OpenMode, PATH_BYTES, Storage, StorageError};

use crate::Card;
use crate::beside::{Beside, Readers};
use crate::errors::{of_content, of_name};
use crate::lens::{Device, Lens};
use crate::listing::listed;

/// Files open at once.
pub const MAX_FILES: usize = 5;
/// Directories open at once: the one that is left and the one that is entered.
const MAX_DIRECTORIES: usize = 2;
/// Where the card appears in paths.
const MOUNT_POINT: &str = "sd";

type Manager<C, T> = VolumeManager<Lens<C>, T, MAX_DIRECTORIES, MAX_FILES, 1>;

/// An open file.
#[derive(Clone, Copy)]
struct Open {
    handle: FileHandle,
    raw: RawFile,
    place: Place,
    /// It may be written to.
    writes: bool,
    /// A write went wrong: the file may have more clusters than it says.
    failed: bool,
}

/// A directory that is being listed, so that its next entries are found without reading it from its
/// beginning.
struct Listed {
    path: String<PATH_BYTES>,
    entries: usize,
    next: Listing,
}

/// The card with its file system. `T` dates files.
pub struct CardStorage<C: Card, T: TimeSource> {
    manager: Manager<C, T>,
    clock: T,
    raw_volume: Option<RawVolume>,
    open: Vec<Open, MAX_FILES>,
    readers: Readers,
    next_handle: u8,
    listed: Option<Listed>,
}

impl<C: Card, T: TimeSource + Clone> CardStorage<C, T> {
    /// Not mounted.
    pub fn new(card: C, clock: T) -> Self {
        let manager = Manager::new_with_limits(Lens::new(card), clock.clone(), 1);
        Self {
            manager,
            clock,
            raw_volume: None,
            open: Vec::new(),
            readers: Readers::default(),
            next_handle: 0,
            listed: None,
        }
    }

    /// The card itself.
    pub fn card<R>(&self, action: impl FnOnce(&mut C) -> R) -> R {
        self.manager.device(|lens| action(lens.card()))
    }

    fn now(&self) -> Stamp {
        let [time_low, time_high, date_low, date_high] = self.clock.get_timestamp().serialize_to_fat();
        Stamp { date: u16::from_le_bytes([date_low, date_high]), time: u16::from_le_bytes([time_low, time_high]) }
    }

    /// Lets `action` work on names. `embedded-sdmmc` forgets the block it had read.
    fn names<R>(
        &self,
        action: impl FnOnce(&mut Volume, &mut Device<'_, C>) -> Result<R, NameError<C::Error>>,
    ) -> Result<R, StorageError> {
        self.manager.device(|lens| {
            let (volume, mut device) = lens.names().ok_or(StorageError::NoCard)?;
            action(volume, &mut device).map_err(of_name::<C>)
        })
    }

    /// As [`names`](Self::names), for what changes a directory.
    fn change<R>(
        &mut self,
        action: impl FnOnce(&mut Volume, &mut Device<'_, C>) -> Result<R, NameError<C::Error>>,
    ) -> Result<R, StorageError> {
        self.listed = None;
        self.names(action)
    }

    /// The entry of a path, which no open file may have.
    fn find_closed(&self, path: &str) -> Result<Entry, StorageError> {
        let entry = self.names(|volume, device| volume.find(device, path))?;
        if self.open.iter().any(|open| open.place == entry.place()) { Err(StorageError::Busy) } else { Ok(entry) }
    }

    /// The file of this path as `mode` wants it: there, and empty if it is to be written anew.
    fn prepare(&mut self, path: &str, mode: OpenMode) -> Result<Entry, StorageError> {
        let now = self.now();
        let entry = match (self.find_closed(path), mode) {
            (Err(StorageError::NotFound), OpenMode::Write | OpenMode::Append) => {
                return self.change(|volume, device| volume.create(device, path, now));
            }
            (found, _) => found?,
        };
        match (entry.is_directory(), mode) {
            (true, _) => return Err(StorageError::WrongKind),
            (_, OpenMode::Read | OpenMode::Beside) => {}
            _ if entry.attributes().has(Attributes::READ_ONLY) => return Err(StorageError::ReadOnly),
            (_, OpenMode::Append) => self.names(|volume, device| volume.forget_free_count(device))?,
            (_, OpenMode::Write) => {
                self.change(|volume, device| volume.empty(device, &entry, now))?;
                return Ok(entry);
            }
        }
        self.names(|volume, device| volume.check(device, &entry))?;
        Ok(entry)
    }

    /// Opens a file beside whoever reads it.
    fn open_beside(&mut self, path: &str) -> Result<FileHandle, StorageError> {
        let entry = self.names(|volume, device| volume.find(device, path))?;
        if entry.is_directory() {
            return Err(StorageError::WrongKind);
        }
        if self.open.iter().any(|open| open.writes && open.place == entry.place()) {
            return Err(StorageError::Busy);
        }
        let handle = self.new_handle();
        self.readers.push(Beside { handle, place: entry.place(), reader: Reader::new(&entry), offset: 0 })?;
        Ok(handle)
    }

    /// Reads on beside.
    fn read_beside(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        let Self { manager, readers, .. } = self;
        let Some(beside) = readers.get(file) else { return Err(StorageError::NotFound) };
        let count = manager.device(|lens| {
            let (volume, mut device) = lens.names().ok_or(StorageError::NoCard)?;
            beside.reader.read(volume, &mut device, beside.offset, buffer).map_err(of_name::<C>)
        })?;
        beside.offset += count as u32;
        Ok(count)
    }

    /// Opens what a file contains, found by the short names along its path.
    fn open_content(&self, path: &str, file: &Entry, mode: OpenMode) -> Result<RawFile, StorageError> {
        let volume = self.raw_volume.ok_or(StorageError::NoCard)?;
        let mut directory = self.manager.open_root_dir(volume).map_err(of_content::<C>)?;
        let opened = self.enter(&mut directory, path).and_then(|()| {
            let name = self.short_name(directory, file)?;
            let mode = if mode == OpenMode::Read { Mode::ReadOnly } else { Mode::ReadWriteAppend };
            self.manager.open_file_in_dir(directory, name, mode).map_err(of_content::<C>)
        });
        self.close_directory(directory);
        opened
    }

    /// Goes from the root to the directory of a path.
    fn enter(&self, directory: &mut RawDirectory, path: &str) -> Result<(), StorageError> {
        for (end, _) in path.trim_end_matches('/').match_indices('/') {
            let parents = path.get(..end).unwrap_or("");
            if parents.is_empty() || parents.ends_with('/') {
                continue;
            }
            let entry = self.names(|volume, device| volume.find(device, parents))?;
            let name = self.short_name(*directory, &entry)?;
            let inner = self.manager.open_dir(*directory, name).map_err(of_content::<C>)?;
            self.close_directory(core::mem::replace(directory, inner));
        }
        Ok(())
    }

    fn close_directory(&self, directory: RawDirectory) {
        // It was opened by the caller; closing an open directory touches no card and cannot fail.
        let _closed = self.manager.close_dir(directory);
    }

    /// An entry's short name as `embedded-sdmmc` wants it, when that finds this entry by it. It does not
    /// where a damaged directory has the name twice, or as its label, nor for names with blanks inside, which
    /// only very old systems made.
    fn short_name(&self, directory: RawDirectory, entry: &Entry) -> Result<ShortFileName, StorageError> {
        let short_name = entry.short_name();
        let (stem, extension) = short_name.split_at(8);
        let mut text = String::<24>::new();
        for (point, part) in [("", stem), (".", extension)] {
            // Bytes above 7F stand for the characters of Latin 1 there: 22 bytes and a point fit.
            let _fits = text.push_str(if part.trim_ascii_end().is_empty() { "" } else { point });
            part.trim_ascii_end().iter().for_each(|byte| drop(text.push(char::from(*byte))));
        }
        let name = ShortFileName::create_from_str(&text).map_err(|_| StorageError::Unsupported)?;
        let found = self.manager.find_directory_entry(directory, name).map_err(of_content::<C>)?;
        let place = Place { block: found.entry_block.0, slot: (found.entry_offset / 32) as u8 };
        if place == entry.place() { Ok(name) } else { Err(StorageError::Damaged) }
    }

    fn opened(&mut self, file: FileHandle) -> Result<&mut Open, StorageError> {
        self.open.iter_mut().find(|open| open.handle == file).ok_or(StorageError::NotFound)
    }

    /// A handle that no open file has; one that was closed is not soon given again.
    fn new_handle(&mut self) -> FileHandle {
        loop {
            self.next_handle = self.next_handle.wrapping_add(1);
            let handle = FileHandle(self.next_handle);
            if self.open.iter().all(|open| open.handle != handle) && !self.readers.has(handle) {
                return handle;
            }
        }
    }

    fn close_content(&mut self, open: Open) -> Result<(), StorageError> {
        let closed = self.manager.close_file(open.raw).map_err(of_content::<C>);
        self.manager.device(|lens| lens.release(open.place));
        if open.failed {
            // As much as was written stays; the clusters that were taken for the rest are given back.
            self.names(|volume, device| volume.trim(device, open.place))?;
        }
        closed
    }

    /// `embedded-sdmmc` does not say why it found no room.
    fn why_full(&self) -> StorageError {
        match self.names(|volume, device| volume.has_free(device, 1)) {
            Ok(true) => StorageError::Device,
            Ok(false) => StorageError::Full,
            Err(error) => error,
        }
    }
}

impl<C: Card, T: TimeSource + Clone> Storage for CardStorage<C, T> {
    /// Finds the card and its first partition, and completes what a power cut has interrupted. What was open
    /// is closed, as it may be another card.
    fn mount(&mut self) -> Result<(), StorageError> {
        self.listed = None;
        self.readers.clear();
        while let Some(open) = self.open.pop() {
            // The old card may be gone: that its files cannot be closed properly is no reason not to look for
            // a new one.
            let _gone = self.close_content(open);
        }
        self.manager.device(|lens| lens.volume = None);
        if let Some(volume) = self.raw_volume.take() {
            // It would note where it looked for free clusters last, which need not be on the same card.
            let _refused = self.manager.close_volume(volume);
        }
        self.manager.device(|lens| {
            let reason = |error| C::reason(&error);
            lens.card().identify().map_err(reason)?;
            let mut table = [Block::new()];
            lens.card().read(&mut table, BlockIdx(0)).map_err(reason)?;
            let (first, blocks) = first_partition(&table[0]).map_err(|_| StorageError::NoFileSystem)?;
            let mut volume = Volume::open(&mut Device(lens.card()), first, blocks).map_err(of_name::<C>)?;
            volume.settle(&mut Device(lens.card())).map_err(of_name::<C>)?;
            lens.volume = Some(volume);
            Ok(())
        })?;
        let opened = self.manager.open_raw_volume(VolumeIdx(0)).map_err(of_content::<C>);
        if opened.is_err() {
            self.manager.device(|lens| lens.volume = None);
        }
        self.raw_volume = Some(opened?);
        Ok(())
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let path = inside(path)?;
        if mode == OpenMode::Beside {
            return self.open_beside(path);
        }
        if self.open.is_full() {
            return Err(StorageError::TooManyOpen);
        }
        let entry = self.prepare(path, mode)?;
        let writes = mode != OpenMode::Read;
        if writes {
            self.readers.forget(entry.place());
        }
        let raw = self.open_content(path, &entry, mode)?;
        self.manager.device(|lens| lens.keep(&entry));
        let handle = self.new_handle();
        // There is room, as was seen above.
        let _pushed = self.open.push(Open { handle, raw, place: entry.place(), writes, failed: false });
        Ok(handle)
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        if self.readers.has(file) {
            return self.read_beside(file, buffer);
        }
        let raw = self.opened(file)?.raw;
        self.manager.read(raw, buffer).map_err(of_content::<C>)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        if self.readers.has(file) {
            return if bytes.is_empty() { Ok(()) } else { Err(StorageError::ReadOnly) };
        }
        let raw = self.opened(file)?.raw;
        // Writing nothing would take a cluster for it.
        if bytes.is_empty() {
            return Ok(());
        }
        // The last free cluster would be taken for an empty file and then lost, as finding no further one is
        // an error there.
        let is_empty = self.manager.file_length(raw).map_err(of_content::<C>)? == 0;
        if is_empty && !self.names(|volume, device| volume.has_free(device, 2))? {
            return Err(StorageError::Full);
        }
        let written = self.manager.write(raw, bytes);
        if written.is_err() {
            self.opened(file)?.failed = true;
        }
        match written {
            Err(Error::DiskFull | Error::NotEnoughSpace) => Err(self.why_full()),
            written => written.map_err(of_content::<C>),
        }
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        if let Some(beside) = self.readers.get(file) {
            beside.offset = offset_bytes;
            return if offset_bytes <= beside.reader.size_bytes() { Ok(()) } else { Err(StorageError::BadPath) };
        }
        let raw = self.opened(file)?.raw;
        self.manager.file_seek_from_start(raw, offset_bytes).map_err(of_content::<C>)
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        if let Some(beside) = self.readers.get(file) {
            return Ok(beside.reader.size_bytes());
        }
        let raw = self.opened(file)?.raw;
        self.manager.file_length(raw).map_err(of_content::<C>)
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        if self.readers.close(file) {
            return Ok(());
        }
        let place = self.open.iter().position(|open| open.handle == file).ok_or(StorageError::NotFound)?;
        let open = self.open.swap_remove(place);
        // Its size in the directory has changed.
        self.listed = None;
        self.close_content(open)
    }

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        entries.clear();
        let inner = inside(path)?;
        let last = self.listed.take().filter(|last| last.path == path && last.entries == skip);
        let (mut to_skip, mut next) = match last {
            Some(last) => (0, last.next),
            None => (skip, self.names(|volume, device| volume.list(device, inner))?),
        };
        let mut name = Name::new();
        while !entries.is_full() {
            let Some(entry) = self.names(|volume, device| next.next(volume, device, &mut name))? else { break };
            if to_skip > 0 {
                to_skip -= 1;
            } else {
                // There is room, as was seen above.
                let _pushed = entries.push(listed(&entry, &name));
            }
        }
        let path = String::try_from(path).map_err(|_| StorageError::BadPath)?;
        self.listed = Some(Listed { path, entries: skip + entries.len(), next });
        Ok(())
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        let entry = self.find_closed(inside(path)?)?;
        self.readers.forget(entry.place());
        self.change(|volume, device| volume.remove(device, &entry))
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        let (path, now) = (inside(path)?, self.now());
        self.change(|volume, device| volume.make_directory(device, path, now)).map(drop)
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        let entry = self.find_closed(inside(from)?)?;
        self.readers.forget(entry.place());
        let to = inside(to)?;
        self.change(|volume, device| volume.rename(device, &entry, to))
    }
}

/// The part of a path behind the mount point.
fn inside(path: &str) -> Result<&str, StorageError> {
    let path = path.trim_start_matches('/');
    let (first, rest) = path.split_once('/').unwrap_or((path, ""));
    if first.eq_ignore_ascii_case(MOUNT_POINT) { Ok(rest) } else { Err(StorageError::NotFound) }
}
