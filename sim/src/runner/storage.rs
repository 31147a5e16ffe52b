//! A folder of the host as the machine's card. Names and errors are those of the board's card (crate
//! `storage`): the same without regard to case, legal as on FAT, and nothing is done to a file that is
//! open. The card has no short names.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use base::ports::{DirectoryEntry, FileAttributes, FileHandle, FileTime, LIST_CHUNK, OpenMode, Storage, StorageError};
use card::fat::{is_legal_name, same_name, stripped};

/// Number of files that can be open at once, as on the board.
const OPEN_FILES: usize = 7;
/// Number of further files that can be read beside.
const BESIDE: usize = 12;
/// Greatest number of block writes for making, closing, renaming or removing a file on a FAT32 card: tables
/// and folder (`tests/power_cuts.rs` counts them).
const FOLDER_WRITES: u32 = 6;

/// State of the card.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CardState {
    /// Card without a fault.
    #[default]
    Good,
    /// Slot without a card.
    Missing,
    /// Card without a file system.
    Unformatted,
    /// Card whose files open but cannot be read.
    Unreadable,
}

/// File that is open.
#[derive(Debug)]
struct Open {
    place: PathBuf,
    mode: OpenMode,
    file: File,
}

/// Card in a folder of the host.
#[derive(Debug)]
pub struct Card {
    root: PathBuf,
    state: CardState,
    open: [Option<Open>; OPEN_FILES + BESIDE],
    /// Blocks written, and the number permitted before the power goes.
    writes: u32,
    most_writes: Option<u32>,
    is_off: bool,
    /// Block writes since the machine last reported that it is alive, and the most there ever were.
    unseen: u32,
    most_unseen: u32,
}

fn translate(error: &Error) -> StorageError {
    match error.kind() {
        ErrorKind::NotFound => StorageError::NotFound,
        ErrorKind::AlreadyExists => StorageError::Exists,
        ErrorKind::IsADirectory | ErrorKind::NotADirectory | ErrorKind::DirectoryNotEmpty => StorageError::WrongKind,
        ErrorKind::StorageFull => StorageError::Full,
        _ => StorageError::Device,
    }
}

impl Card {
    /// Takes a folder as the card.
    pub fn new(root: &Path, state: CardState, most_writes: Option<u32>) -> Self {
        Self {
            root: root.to_owned(),
            state,
            open: Default::default(),
            writes: 0,
            most_writes,
            is_off: false,
            unseen: 0,
            most_unseen: 0,
        }
    }

    /// Returns the number of block writes so far, and whether the power went at one.
    pub const fn block_writes(&self) -> (u32, bool) {
        (self.writes, self.is_off)
    }

    /// Notes the machine's report that it is alive.
    pub const fn seen(&mut self) {
        self.unseen = 0;
    }

    /// Returns the most block writes between two reports of the machine that it is alive: on a slow card,
    /// each takes a quarter of a second.
    pub const fn most_unseen_writes(&self) -> u32 {
        self.most_unseen
    }

    const fn goes_unseen(&mut self, writes: u32) {
        self.unseen += writes;
        if self.unseen > self.most_unseen {
            self.most_unseen = self.unseen;
        }
    }

    /// Pulls the card out, or puts it in again.
    pub fn set_state(&mut self, state: CardState) {
        self.state = state;
    }

    fn usable(&self) -> Result<(), StorageError> {
        match self.state {
            CardState::Missing => Err(StorageError::NoCard),
            CardState::Unformatted => Err(StorageError::NoFileSystem),
            CardState::Good | CardState::Unreadable => Ok(()),
        }
    }

    /// Returns the part of a path behind the card's name.
    fn inside<'p>(&self, path: &'p str) -> Result<&'p str, StorageError> {
        self.usable()?;
        let path = path.trim_start_matches('/');
        let (first, rest) = path.split_once('/').unwrap_or((path, ""));
        if first.eq_ignore_ascii_case("sd") { Ok(rest.trim_end_matches('/')) } else { Err(StorageError::NotFound) }
    }

    /// Returns the host's path of an entry of the card, but none within `moved`; nothing outside the folder
    /// can be named.
    fn place(&self, inside: &str, moved: Option<&Path>) -> Result<PathBuf, StorageError> {
        let mut place = self.root.clone();
        for part in inside.split('/').filter(|part| !part.is_empty()) {
            if place.is_file() {
                return Err(StorageError::WrongKind);
            }
            let names = fs::read_dir(&place).map_err(|error| translate(&error))?;
            let mut names: Vec<_> = names.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
            names.sort();
            let exactly = names.iter().find(|name| stripped(name) == stripped(part));
            let found = exactly.or_else(|| names.iter().find(|name| same_name(name, part)));
            place.push(found.filter(|_| !stripped(part).is_empty()).ok_or(StorageError::NotFound)?);
            if moved == Some(&*place) {
                return Err(StorageError::BadPath);
            }
        }
        Ok(place)
    }

    /// Returns the host's path of a file or directory; the card itself is neither.
    fn entry(&self, path: &str) -> Result<PathBuf, StorageError> {
        match self.inside(path)? {
            "" => Err(StorageError::BadPath),
            inside => self.place(inside, None),
        }
    }

    /// Returns the host's path of an entry that is not open.
    fn closed(&self, path: &str) -> Result<PathBuf, StorageError> {
        let place = self.entry(path)?;
        let has = |open: &Open| open.place == place && open.mode != OpenMode::Beside;
        if self.open.iter().flatten().any(has) { Err(StorageError::Busy) } else { Ok(place) }
    }

    /// Returns the host's path of something new, which nothing but `moved` may have.
    fn new_place(&self, path: &str, moved: Option<&Path>) -> Result<PathBuf, StorageError> {
        let inside = self.inside(path)?;
        let (directory, name) = inside.rsplit_once('/').unwrap_or(("", inside));
        if name.is_empty() {
            return Err(StorageError::BadPath);
        }
        let directory = self.place(directory, moved.filter(|moved| moved.is_dir()))?;
        if directory.is_file() {
            return Err(StorageError::WrongKind);
        }
        if !is_legal_name(name) {
            return Err(StorageError::BadPath);
        }
        match self.place(inside, None) {
            Ok(taken) if Some(&*taken) != moved => Err(StorageError::Exists),
            _ => Ok(directory.join(stripped(name))),
        }
    }

    /// Returns the host's path of a file that nobody writes.
    fn read_by_others(&self, path: &str) -> Result<PathBuf, StorageError> {
        let place = self.entry(path)?;
        let writes = |open: &Open| open.place == place && matches!(open.mode, OpenMode::Write | OpenMode::Append);
        if self.open.iter().flatten().any(writes) { Err(StorageError::Busy) } else { Ok(place) }
    }

    /// Drops the reading beside of this file: it is found no more.
    fn forget_beside(&mut self, place: &Path) {
        let is_beside = |open: &Open| open.mode == OpenMode::Beside && open.place == place;
        self.open.iter_mut().filter(|slot| slot.as_ref().is_some_and(is_beside)).for_each(|slot| *slot = None);
    }

    fn opened(&mut self, file: FileHandle) -> Result<&mut Open, StorageError> {
        self.open.get_mut(usize::from(file.0)).and_then(Option::as_mut).ok_or(StorageError::NotFound)
    }

    fn file(&mut self, file: FileHandle) -> Result<&mut File, StorageError> {
        Ok(&mut self.opened(file)?.file)
    }
}

impl Storage for Card {
    fn mount(&mut self) -> Result<(), StorageError> {
        self.open = Default::default();
        self.usable()
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        self.inside(path)?;
        let slots = if mode == OpenMode::Beside { OPEN_FILES..OPEN_FILES + BESIDE } else { 0..OPEN_FILES };
        let slot = self.open[slots.clone()].iter().position(Option::is_none).ok_or(StorageError::TooManyOpen)?;
        let slot = slots.start + slot;
        let reads = matches!(mode, OpenMode::Read | OpenMode::Beside);
        let place = match self.closed(path) {
            Err(StorageError::NotFound) if !reads => self.new_place(path, None)?,
            Err(StorageError::Busy) if mode == OpenMode::Beside => self.read_by_others(path)?,
            found => found?,
        };
        if !reads {
            self.forget_beside(&place);
        }
        if place.is_dir() {
            return Err(StorageError::WrongKind);
        }
        if mode == OpenMode::Write {
            self.goes_unseen(FOLDER_WRITES);
        }
        let mut options = File::options();
        options.read(true).write(!reads);
        options.create(!reads).truncate(mode == OpenMode::Write);
        let mut file = options.open(&place).map_err(|error| translate(&error))?;
        if mode == OpenMode::Append {
            file.seek(SeekFrom::End(0)).map_err(|error| translate(&error))?;
        }
        self.open[slot] = Some(Open { place, mode, file });
        Ok(FileHandle(slot as u8))
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        match self.state {
            CardState::Unreadable => return Err(StorageError::Device),
            CardState::Missing => return Err(StorageError::NotResponding),
            _ => {}
        }
        self.file(file)?.read(buffer).map_err(|error| translate(&error))
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        let open = self.opened(file)?;
        if matches!(open.mode, OpenMode::Read | OpenMode::Beside) && !bytes.is_empty() {
            return Err(StorageError::ReadOnly);
        }
        if !bytes.is_empty() {
            if self.is_off || self.most_writes == Some(self.writes) {
                self.is_off = true;
                return Err(StorageError::NotResponding);
            }
            self.writes += bytes.len().div_ceil(512) as u32;
            self.goes_unseen(bytes.len().div_ceil(512) as u32);
        }
        self.file(file)?.write_all(bytes).map_err(|error| translate(&error))
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        if offset_bytes > self.size(file)? {
            return Err(StorageError::BadPath);
        }
        let moved = self.file(file)?.seek(SeekFrom::Start(u64::from(offset_bytes)));
        moved.map(drop).map_err(|error| translate(&error))
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        let facts = self.file(file)?.metadata().map_err(|error| translate(&error))?;
        u32::try_from(facts.len()).map_err(|_| StorageError::Unsupported)
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        let slot = self.open.get_mut(usize::from(file.0)).ok_or(StorageError::NotFound)?;
        let closed = slot.take().ok_or(StorageError::NotFound)?;
        if closed.mode == OpenMode::Write {
            self.goes_unseen(FOLDER_WRITES);
        }
        Ok(())
    }

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        entries.clear();
        let mut found: Vec<_> = fs::read_dir(self.place(self.inside(path)?, None)?)
            .and_then(|listing| listing.collect::<Result<Vec<_>, _>>())
            .map_err(|error| translate(&error))?;
        // The host lists in no particular order; runs must be repeatable.
        found.sort_by_key(fs::DirEntry::file_name);
        for entry in found.into_iter().skip(skip).take(LIST_CHUNK) {
            let facts = entry.metadata().map_err(|error| translate(&error))?;
            let mut name = heapless::String::new();
            for c in entry.file_name().to_string_lossy().chars() {
                if name.push(c).is_err() {
                    break;
                }
            }
            let size_bytes = if facts.is_dir() { 0 } else { u32::try_from(facts.len()).unwrap_or(u32::MAX) };
            // The host's dates would make runs differ.
            let attributes = FileAttributes { archive: facts.is_file(), ..FileAttributes::default() };
            let written = FileTime::NO_CLOCK;
            // The bound of `take` makes every entry fit.
            let _fits =
                entries.push(DirectoryEntry { name, size_bytes, is_directory: facts.is_dir(), attributes, written });
        }
        Ok(())
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        let place = self.closed(path)?;
        self.goes_unseen(FOLDER_WRITES);
        self.forget_beside(&place);
        let removed = if place.is_dir() { fs::remove_dir(place) } else { fs::remove_file(place) };
        removed.map_err(|error| translate(&error))
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        fs::create_dir(self.new_place(path, None)?).map_err(|error| translate(&error))
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        let from = self.closed(from)?;
        self.goes_unseen(FOLDER_WRITES);
        self.forget_beside(&from);
        let to = self.new_place(to, Some(&from))?;
        fs::rename(&from, &to).map_err(|error| translate(&error))?;
        // Files that are open in a directory move with it.
        for open in self.open.iter_mut().flatten() {
            if let Ok(rest) = open.place.strip_prefix(&from) {
                open.place = to.join(rest);
            }
        }
        Ok(())
    }

    fn between_steps(&mut self) {
        self.seen();
    }
}

#[cfg(test)]
mod tests;
