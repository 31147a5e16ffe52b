//! A folder of the host as the machine's card.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use machine::ports::{DirectoryEntry, FileHandle, LIST_CHUNK, OpenMode, StorageError};

/// How many files can be open at once, as on the board.
const OPEN_FILES: usize = 4;

/// What is wrong with the card.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CardState {
    /// Nothing.
    #[default]
    Good,
    /// There is none.
    Missing,
    /// It has no file system.
    Unformatted,
    /// Files open, but reading them fails.
    Unreadable,
}

/// The card.
#[derive(Debug)]
pub struct Card {
    root: PathBuf,
    state: CardState,
    open: [Option<File>; OPEN_FILES],
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
    /// This folder as the card.
    pub fn new(root: &Path, state: CardState) -> Self {
        Self { root: root.to_owned(), state, open: Default::default() }
    }

    fn usable(&self) -> Result<(), StorageError> {
        match self.state {
            CardState::Missing => Err(StorageError::NoCard),
            CardState::Unformatted => Err(StorageError::NoFileSystem),
            CardState::Good | CardState::Unreadable => Ok(()),
        }
    }

    /// The host's path of `/sd/...`; nothing outside the folder can be named.
    fn place(&self, path: &str) -> Result<PathBuf, StorageError> {
        self.usable()?;
        let inside = path.strip_prefix("/sd").ok_or(StorageError::NotFound)?;
        let parts = inside.split('/').filter(|part| !part.is_empty());
        let mut place = self.root.clone();
        for part in parts {
            if part == ".." || part == "." {
                return Err(StorageError::BadPath);
            }
            place.push(part);
        }
        Ok(place)
    }

    pub fn mount(&self) -> Result<(), StorageError> {
        self.usable()
    }

    pub fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let place = self.place(path)?;
        if place.is_dir() {
            return Err(StorageError::WrongKind);
        }
        let slot = self.open.iter().position(Option::is_none).ok_or(StorageError::TooManyOpen)?;
        let file = match mode {
            OpenMode::Read => File::open(&place),
            OpenMode::Write => File::create(&place),
            OpenMode::Append => File::options().append(true).create(true).open(&place),
        };
        self.open[slot] = Some(file.map_err(|error| translate(&error))?);
        Ok(FileHandle(slot as u8))
    }

    fn file(&mut self, file: FileHandle) -> Result<&mut File, StorageError> {
        self.open.get_mut(usize::from(file.0)).and_then(Option::as_mut).ok_or(StorageError::NotFound)
    }

    pub fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        if self.state == CardState::Unreadable {
            return Err(StorageError::Device);
        }
        self.file(file)?.read(buffer).map_err(|error| translate(&error))
    }

    pub fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        self.file(file)?.write_all(bytes).map_err(|error| translate(&error))
    }

    pub fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        let moved = self.file(file)?.seek(SeekFrom::Start(u64::from(offset_bytes)));
        moved.map(drop).map_err(|error| translate(&error))
    }

    pub fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        let facts = self.file(file)?.metadata().map_err(|error| translate(&error))?;
        u32::try_from(facts.len()).map_err(|_| StorageError::Unsupported)
    }

    pub fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        let slot = self.open.get_mut(usize::from(file.0)).ok_or(StorageError::NotFound)?;
        slot.take().map(drop).ok_or(StorageError::NotFound)
    }

    pub fn list(
        &self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        let mut found: Vec<_> = fs::read_dir(self.place(path)?)
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
            // `take` bounds it.
            let _fits = entries.push(DirectoryEntry { name, size_bytes, is_directory: facts.is_dir() });
        }
        Ok(())
    }

    pub fn remove(&self, path: &str) -> Result<(), StorageError> {
        let place = self.place(path)?;
        let removed = if place.is_dir() { fs::remove_dir(place) } else { fs::remove_file(place) };
        removed.map_err(|error| translate(&error))
    }

    pub fn make_directory(&self, path: &str) -> Result<(), StorageError> {
        fs::create_dir(self.place(path)?).map_err(|error| translate(&error))
    }

    pub fn rename(&self, from: &str, to: &str) -> Result<(), StorageError> {
        let (from, to) = (self.place(from)?, self.place(to)?);
        if to.exists() {
            return Err(StorageError::Exists);
        }
        fs::rename(from, to).map_err(|error| translate(&error))
    }
}
