//! The storage port: names through [`card::fat`], contents through `embedded-sdmmc`.

use base::ports::{
    CardEvent, CardFacts, DirectoryEntry, FileFacts, FileHandle, FreeSpace, LIST_CHUNK, OpenMode, Storage, StorageError,
};
use card::fat::{Error as NameError, Name, Place, Stamp, Volume};
use card::volume::{Volume as Mounted, find_facts};
use embedded_sdmmc::{RawFile, RawVolume, TimeSource, VolumeIdx, VolumeManager};
use heapless::Vec;

use crate::device::{Card, Device, NotRead};
use crate::errors::{of_content, of_name};
use crate::mount::find_volume;
use crate::read_ahead::Ahead;
use crate::readers::{Reader, Readers};
use crate::sdmmc_device::{MAX_FILES, SdmmcDevice};
use crate::write_buffer::{Gathered, Written};

use listing::{Listed, facts_of, listed};
use opening::reader_of;

mod listing;
mod opening;
mod writing;

/// Directories open at once: the one that is left and the one that is entered.
const MAX_DIRECTORIES: usize = 2;
/// Blocks that most changes write: with room for them, and the card at rest, they wait for nothing.
const READY_ROOM: usize = 32;
/// Blocks of the allocation table that are counted in one go.
const COUNTED_BLOCKS: u32 = 16;
/// Directory in which the card appears in paths.
const MOUNT_POINT: &str = "sd";

type Manager<C, T> = VolumeManager<SdmmcDevice<C>, T, MAX_DIRECTORIES, MAX_FILES, 1>;

/// An open file with its handle.
struct Open {
    handle: FileHandle,
    place: Place,
    content: Content,
}

/// Use for which a file is open.
enum Content {
    Read(Reader),
    Written(Written),
}

impl Open {
    const fn is_written(&self) -> bool {
        matches!(self.content, Content::Written(_))
    }
}

/// Memory of what goes on with the card's files, apart from the [`CardStorage`], which is moved about.
#[derive(Debug, Default)]
pub struct Memory {
    gathered: Gathered,
    readers: Readers,
    listed: Option<Listed>,
}

impl Memory {
    /// Makes the memory of a card that nothing is known of.
    #[must_use]
    pub const fn new() -> Self {
        Self { gathered: Gathered::new(), readers: Readers::new(), listed: None }
    }
}

/// The card with its file system. `T` dates files.
pub struct CardStorage<'g, C: Card, T: TimeSource> {
    manager: Manager<C, T>,
    clock: T,
    raw_volume: Option<RawVolume>,
    open: Vec<Open, MAX_FILES>,
    readers: &'g mut Readers,
    next_handle: u8,
    listed: &'g mut Option<Listed>,
    /// The file that is played, and what is read ahead of it.
    ahead: Option<Ahead>,
    gathered: &'g mut Gathered,
    /// Number of changes of folders.
    changes: u32,
}

impl<'g, C: Card, T: TimeSource + Clone> CardStorage<'g, C, T> {
    /// Creates the storage without mounting the card.
    pub fn new(card: C, clock: T, memory: &'g mut Memory) -> Self {
        let Memory { gathered, readers, listed } = memory;
        let manager = Manager::new_with_limits(SdmmcDevice::new(card), clock.clone(), 1);
        Self {
            manager,
            clock,
            raw_volume: None,
            open: Vec::new(),
            readers,
            next_handle: 0,
            listed,
            ahead: None,
            gathered,
            changes: 0,
        }
    }

    /// Gives the volume back, so that somebody else may have the card: until it is mounted again whoever
    /// wants files is told that it is lent ([`StorageError::Lent`]).
    ///
    /// # Errors
    /// [`StorageError::Busy`] while files are open.
    pub fn unmount(&mut self) -> Result<(), StorageError> {
        if !self.open.is_empty() {
            return Err(StorageError::Busy);
        }
        *self.listed = None;
        self.ahead = None;
        self.readers.clear();
        self.card(C::unfollow);
        self.manager.device(|sdmmc| (sdmmc.volume, sdmmc.absent) = (None, StorageError::Lent));
        Ok(())
    }

    /// Runs `action` on the card itself.
    pub fn card<R>(&self, action: impl FnOnce(&mut C) -> R) -> R {
        self.manager.device(|sdmmc| action(sdmmc.card()))
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
        self.manager.device(|sdmmc| {
            let (volume, mut device) = sdmmc.names()?;
            action(volume, &mut device).map_err(of_name::<C>)
        })
    }

    /// Works on names as [`names`](Self::names) does, for a change of a directory.
    fn change<R>(
        &mut self,
        action: impl FnOnce(&mut Volume, &mut Device<'_, C>) -> Result<R, NameError<C::Error>>,
    ) -> Result<R, StorageError> {
        (*self.listed, self.changes) = (None, self.changes.wrapping_add(1));
        self.names(action)
    }

    /// Lets `action` read on a volume of either kind.
    fn reading<R>(
        &self,
        action: impl FnOnce(&mut Mounted, &mut Device<'_, C>) -> Result<R, NameError<C::Error>>,
    ) -> Result<R, StorageError> {
        self.manager.device(|sdmmc| {
            let (volume, mut device) = sdmmc.reading()?;
            action(volume, &mut device).map_err(of_name::<C>)
        })
    }

    /// A file that is only read, beside or not.
    fn reader(&mut self, file: FileHandle) -> Option<&mut Reader> {
        reader_of(&mut self.open, self.readers, file)
    }

    /// Reads on in a file that is only read.
    fn read_on(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        let Self { manager, readers, open, ahead, .. } = self;
        let Some(reader) = reader_of(open, readers, file) else { return Err(StorageError::NotFound) };
        let count = manager.device(|sdmmc| {
            let (volume, mut device) = sdmmc.reading()?;
            let count = reader.read(volume, &mut device, buffer).map_err(of_name::<C>)?;
            if let Some(ahead) = ahead.as_mut().filter(|ahead| ahead.file == file) {
                ahead.go_on(reader.offset, sdmmc);
            }
            Ok(count)
        })?;
        Ok(count)
    }

    /// Whether reading on takes no waiting. Missing blocks are asked for.
    fn can_read_on(&mut self, file: FileHandle) -> bool {
        let Self { manager, readers, open, ahead, .. } = self;
        let Some(reader) = reader_of(open, readers, file) else { return true };
        manager.device(|sdmmc| {
            if let Some(ahead) = ahead.as_mut().filter(|ahead| ahead.file == file) {
                if !ahead.leads_from(reader.offset) {
                    sdmmc.card().unfollow();
                    *ahead = Ahead::new(file, reader.reader, reader.offset);
                }
                ahead.go_on(reader.offset, sdmmc);
            }
            let Some((volume, mut device)) = sdmmc.names_at_hand() else { return true };
            let read = reader.reader.read(volume, &mut device, reader.offset, &mut [0]);
            !matches!(read, Err(NameError::Device(NotRead::Yet)))
        })
    }

    /// Keeps the card at rest while something reads and writes by turns. An earlier write that has failed is
    /// known by now: its writer was told, or everybody.
    fn at_rest<R>(&mut self, action: impl FnOnce(&mut Self) -> Result<R, StorageError>) -> Result<R, StorageError> {
        self.card(|card| card.hold());
        self.mend().and_then(|()| action(self))
    }

    /// Mends the volume after a write that has failed, as after a power cut: half-done changes are completed,
    /// once nobody writes any more who counts on what came after.
    fn mend(&mut self) -> Result<(), StorageError> {
        if self.card(|card| card.is_kept().is_ok()) || self.open.iter().any(Open::is_written) {
            return Ok(());
        }
        self.card(C::forgive);
        *self.listed = None;
        self.manager.device(|sdmmc| sdmmc.mend()).map_err(of_name::<C>)
    }

    fn written_or_none(&mut self, file: FileHandle) -> Result<RawFile, StorageError> {
        self.written(file).map(|written| written.raw)
    }

    fn written(&mut self, file: FileHandle) -> Result<&mut Written, StorageError> {
        self.manager.device(|sdmmc| sdmmc.volume.as_ref().map(drop).ok_or(sdmmc.absent))?;
        let open = self.open.iter_mut().find(|open| open.handle == file).ok_or(StorageError::NotFound)?;
        match &mut open.content {
            Content::Written(written) => Ok(written),
            Content::Read(_) => Err(StorageError::ReadOnly),
        }
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
}

impl<C: Card, T: TimeSource + Clone> Storage for CardStorage<'_, C, T> {
    /// Finds the card and its first partition, and completes what a power cut has interrupted. Files that
    /// were open are closed, as the card may be another one.
    fn mount(&mut self) -> Result<(), StorageError> {
        *self.listed = None;
        self.ahead = None;
        self.readers.clear();
        while let Some(open) = self.open.pop() {
            // The old card may be gone: that its files cannot be closed properly is no reason not to look for
            // a new one.
            let _gone = self.close_content(&open);
        }
        self.manager.device(|sdmmc| sdmmc.volume = None);
        if let Some(volume) = self.raw_volume.take() {
            // Closing would note the place where free clusters were last looked for, which need not be on the
            // same card.
            let _refused = self.manager.close_volume(volume);
        }
        self.manager.device(|sdmmc| {
            let card = sdmmc.card();
            let identified = card.identify().map_err(|error| C::reason(&error));
            let is_lent = identified == Err(StorageError::Lent);
            sdmmc.absent = if is_lent { StorageError::Lent } else { StorageError::NoCard };
            identified?;
            sdmmc.volume = Some(find_volume(sdmmc.card())?);
            Ok(())
        })?;
        if self.manager.device(|sdmmc| matches!(sdmmc.volume, Some(Mounted::Exfat(_)))) {
            return Ok(());
        }
        let opened = self.manager.open_raw_volume(VolumeIdx(0)).map_err(of_content::<C>);
        if opened.is_err() {
            self.manager.device(|sdmmc| sdmmc.volume = None);
        }
        self.raw_volume = Some(opened?);
        Ok(())
    }

    fn forget_card(&mut self) {
        *self.listed = None;
        self.manager.device(|sdmmc| (sdmmc.volume, sdmmc.absent) = (None, StorageError::NotResponding));
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let path = inside(path)?;
        if mode == OpenMode::Beside {
            return self.open_beside(path);
        }
        if self.open.is_full() {
            return Err(StorageError::TooManyOpen);
        }
        self.at_rest(|storage| {
            let handle = storage.new_handle();
            let open = if mode == OpenMode::Read {
                let reader = storage.open_reader(path, handle)?;
                Open { handle, place: reader.place, content: Content::Read(reader) }
            } else {
                let entry = storage.prepare(path, mode)?;
                storage.readers.forget(entry.place());
                let raw = storage.open_content(path, &entry)?;
                storage.manager.device(|sdmmc| sdmmc.keep(&entry));
                Open { handle, place: entry.place(), content: Content::Written(Written { raw, has_failed: false }) }
            };
            // The check above made sure of room.
            let _pushed = storage.open.push(open);
            Ok(handle)
        })
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        if self.reader(file).is_none() {
            return self.at_rest(|storage| {
                storage.settle_gathered()?;
                let raw = storage.written_or_none(file)?;
                storage.manager.read(raw, buffer).map_err(of_content::<C>)
            });
        }
        let mut count = 0;
        while let Some(rest) = buffer.get_mut(count..).filter(|rest| !rest.is_empty()) {
            match self.read_on(file, rest)? {
                0 => break,
                read => count += read,
            }
        }
        Ok(count)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        if self.reader(file).is_some() {
            return if bytes.is_empty() { Ok(()) } else { Err(StorageError::ReadOnly) };
        }
        self.written(file)?;
        // Writing an empty piece would take a cluster for the file.
        if bytes.is_empty() { Ok(()) } else { self.at_rest(|storage| storage.write_on(file, bytes)) }
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        if let Some(reader) = self.reader(file) {
            reader.offset = offset_bytes;
            return if offset_bytes <= reader.reader.size_bytes() { Ok(()) } else { Err(StorageError::BadPath) };
        }
        self.at_rest(|storage| {
            storage.settle_gathered()?;
            let raw = storage.written_or_none(file)?;
            storage.manager.file_seek_from_start(raw, offset_bytes).map_err(of_content::<C>)
        })
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        if let Some(reader) = self.reader(file) {
            return Ok(reader.reader.size_bytes());
        }
        let raw = self.written_or_none(file)?;
        let (length, offset) = (self.manager.file_length(raw), self.manager.file_offset(raw));
        let gathered = self.gathered.of(file).len() as u32;
        Ok(length.map_err(of_content::<C>)?.max(offset.map_err(of_content::<C>)? + gathered))
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        if self.ahead.as_ref().is_some_and(|ahead| ahead.file == file) {
            self.ahead = None;
            self.card(C::unfollow);
        }
        if self.readers.close(file) {
            return Ok(());
        }
        let place = self.open.iter().position(|open| open.handle == file).ok_or(StorageError::NotFound)?;
        let open = self.open.swap_remove(place);
        if open.is_written() {
            // The size in the directory has changed.
            *self.listed = None;
        }
        self.card(|card| card.hold());
        self.close_content(&open)
    }

    fn read_ahead(&mut self, file: FileHandle) {
        let Some(reader) = self.reader(file) else { return };
        let ahead = Ahead::new(file, reader.reader, reader.offset);
        self.ahead = Some(ahead);
        self.card(C::unfollow);
    }

    fn is_at_hand(&mut self, file: FileHandle) -> bool {
        self.can_read_on(file)
    }

    fn card_facts(&mut self) -> Option<CardFacts> {
        self.card(C::facts)
    }

    fn count_free(&mut self, free: &mut FreeSpace) -> Result<bool, StorageError> {
        self.names(|volume, device| {
            let cluster_bytes = u64::from(volume.cluster_bytes());
            free.total_bytes = u64::from(volume.clusters()) * cluster_bytes;
            let (count, next) = volume.count_free(device, free.next, COUNTED_BLOCKS)?;
            free.bytes += u64::from(count) * cluster_bytes;
            free.next = next.unwrap_or(0);
            Ok(next.is_none())
        })
    }

    fn take_event(&mut self) -> Option<CardEvent> {
        self.card(C::take_event)
    }

    fn is_ready(&mut self) -> bool {
        self.card(|card| card.is_ready(READY_ROOM))
    }

    fn can_write_on(&mut self, file: FileHandle, bytes: usize) -> bool {
        self.has_room_for(file, bytes)
    }

    fn changes(&mut self) -> u32 {
        self.changes
    }

    fn let_go(&mut self) {
        self.card(C::let_go);
    }

    fn between_steps(&mut self) {
        self.card(C::between_steps);
    }

    fn is_kept(&mut self) -> Result<bool, StorageError> {
        self.card(|card| card.is_kept()).map_err(|error| C::reason(&error))
    }

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        entries.clear();
        let mut next = self.listing(path, skip)?;
        let before = next;
        let mut name = Name::new();
        while !entries.is_full() {
            let Some(entry) = self.reading(|volume, device| next.next(volume, device, &mut name))? else { break };
            // The check above made sure of room.
            let _pushed = entries.push(listed(&entry, &name));
        }
        self.remember(path, [(skip, before), (skip + entries.len(), next)])
    }

    fn entry(&mut self, path: &str, skip: usize) -> Result<Option<DirectoryEntry>, StorageError> {
        let mut next = self.listing(path, skip)?;
        let before = next;
        let mut name = Name::new();
        let entry = self.reading(|volume, device| next.next(volume, device, &mut name))?;
        self.remember(path, [(skip, before), (skip + usize::from(entry.is_some()), next)])?;
        Ok(entry.map(|entry| listed(&entry, &name)))
    }

    fn facts(&mut self, path: &str) -> Result<FileFacts, StorageError> {
        let path = inside(path)?;
        self.reading(|volume, device| find_facts(volume, device, path)).map(|(facts, place)| facts_of(&facts, place))
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        let path = inside(path)?;
        self.at_rest(|storage| {
            let entry = storage.find_closed(path)?;
            storage.readers.forget(entry.place());
            storage.change(|volume, device| volume.remove(device, &entry))
        })
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        let (path, now) = (inside(path)?, self.now());
        self.at_rest(|storage| storage.change(|volume, device| volume.make_directory(device, path, now)).map(drop))
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        let (from, to) = (inside(from)?, inside(to));
        self.at_rest(|storage| {
            let entry = storage.find_closed(from)?;
            storage.readers.forget(entry.place());
            let to = to?;
            storage.change(|volume, device| volume.rename(device, &entry, to))
        })
    }
}

/// The part of a path behind the mount point.
fn inside(path: &str) -> Result<&str, StorageError> {
    let path = path.trim_start_matches('/');
    let (first, rest) = path.split_once('/').unwrap_or((path, ""));
    if first.eq_ignore_ascii_case(MOUNT_POINT) { Ok(rest) } else { Err(StorageError::NotFound) }
}
