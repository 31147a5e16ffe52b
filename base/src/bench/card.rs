//! Card with files in memory, which may fail, fill up, or lose everything after its n-th write.

use std::collections::{BTreeMap, BTreeSet};

use units::Micros;

use crate::ports::{
    Calendar, Clock, DateTime, DirectoryEntry, FileAttributes, FileFacts, FileHandle, FileTime, LIST_CHUNK, OpenMode,
    Storage, StorageError,
};

/// Bytes of a block: a read never goes beyond the end of one.
const BLOCK: usize = 512;

/// Card with files in memory.
#[derive(Clone, Debug, Default)]
pub struct Card {
    /// Files by name.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Paths of all folders but the card itself.
    pub directories: BTreeSet<String>,
    pub(crate) open: Vec<Option<(String, usize)>>,
    /// Whether reading fails from now on.
    pub fails: bool,
    /// Whether nothing more fits on the card.
    pub is_full: bool,
    /// File that cannot be changed.
    pub read_only: Option<&'static str>,
    /// Name that cannot be given to a file.
    pub no_room_for: Option<&'static str>,
    /// Changes that still reach the card; none: all of them.
    pub writes_left: Option<usize>,
    /// Number of changes so far.
    pub writes: usize,
    /// Number of changes of folders so far.
    pub changes: u32,
}

impl Card {
    /// Makes a card with these texts in files.
    #[must_use]
    pub fn with(files: &[(&str, &str)]) -> Self {
        let files = files.iter().map(|(path, text)| (path.to_string(), text.as_bytes().to_vec())).collect();
        Self { files, ..Self::default() }
    }

    /// Puts a file on the card.
    pub fn put(&mut self, path: &str, content: &[u8]) {
        self.files.insert(path.to_string(), content.to_vec());
    }

    /// Returns the text in a file.
    #[must_use]
    pub fn text(&self, path: &str) -> &str {
        core::str::from_utf8(&self.files[path]).expect("a text")
    }

    /// Returns the number of files that are open.
    #[must_use]
    pub fn open_files(&self) -> usize {
        self.open.iter().flatten().count()
    }

    /// Returns the card after a restart.
    #[must_use]
    pub fn rebooted(&self) -> Self {
        Self { files: self.files.clone(), directories: self.directories.clone(), ..Self::default() }
    }

    fn spend(&mut self) -> Result<(), StorageError> {
        if self.writes_left == Some(0) {
            return Err(StorageError::NotResponding);
        }
        self.writes_left = self.writes_left.map(|left| left - 1);
        self.writes += 1;
        Ok(())
    }

    fn place(&mut self, file: FileHandle) -> Result<&mut (String, usize), StorageError> {
        self.open.get_mut(usize::from(file.0)).and_then(Option::as_mut).ok_or(StorageError::NotFound)
    }

    /// Writes bytes at the file's offset.
    fn put_down(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        let (path, at) = self.place(file)?.clone();
        let content = self.files.entry(path).or_default();
        let overwritten = content.len().min(at + bytes.len());
        content.splice(at..overwritten, bytes.iter().copied());
        self.place(file)?.1 += bytes.len();
        Ok(())
    }
}

impl Storage for Card {
    fn mount(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let reads = matches!(mode, OpenMode::Read | OpenMode::Beside);
        let exists = self.files.contains_key(path);
        if reads && !exists {
            return Err(StorageError::NotFound);
        }
        if !reads && self.read_only == Some(path) {
            return Err(StorageError::ReadOnly);
        }
        if mode != OpenMode::Beside && self.open.iter().flatten().any(|(open, _)| open == path) {
            return Err(StorageError::Busy);
        }
        if mode == OpenMode::Write || mode == OpenMode::Append && !exists {
            self.spend()?;
            self.changes += 1;
            self.put(path, b"");
        }
        let end = if mode == OpenMode::Append { self.files.get(path).map_or(0, Vec::len) } else { 0 };
        self.open.push(Some((path.to_string(), end)));
        Ok(FileHandle(self.open.len() as u8 - 1))
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        if self.fails {
            return Err(StorageError::Device);
        }
        let (path, at) = self.place(file)?.clone();
        let content = self.files.get(&path).ok_or(StorageError::NotFound)?;
        let rest = content.get(at..).unwrap_or(&[]);
        let count = buffer.len().min(rest.len()).min(BLOCK - at % BLOCK);
        buffer[..count].copy_from_slice(&rest[..count]);
        self.place(file)?.1 += count;
        Ok(count)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        if self.is_full {
            return Err(StorageError::Full);
        }
        // Half of it may be there when the power goes.
        let (first, second) = bytes.split_at(bytes.len() / 2);
        self.spend()?;
        self.put_down(file, first)?;
        self.spend()?;
        self.put_down(file, second)
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

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        if self.fails || path != "/sd" && !self.directories.contains(path) {
            return Err(if self.fails { StorageError::Device } else { StorageError::NotFound });
        }
        let start = format!("{path}/");
        let below = |name: &String| name.strip_prefix(&start).filter(|name| !name.contains('/')).map(str::to_string);
        let directories = self.directories.iter().filter_map(below).map(|name| (name, None));
        let files = self.files.iter().filter_map(|(name, content)| Some((below(name)?, Some(content.len() as u32))));
        for (name, size) in directories.chain(files).skip(skip).take(LIST_CHUNK) {
            let entry = DirectoryEntry {
                name: name.as_str().try_into().expect("a name that fits"),
                size_bytes: size.unwrap_or(0),
                is_directory: size.is_none(),
                attributes: FileAttributes::default(),
                written: FileTime::NO_CLOCK,
            };
            entries.push(entry).expect("room for a chunk");
        }
        Ok(())
    }

    fn facts(&mut self, path: &str) -> Result<FileFacts, StorageError> {
        let is_directory = path == "/sd" || self.directories.contains(path);
        let content = if is_directory { &Vec::new() } else { self.files.get(path).ok_or(StorageError::NotFound)? };
        let hash = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3);
        let (size_bytes, tag) = (content.len() as u32, content.iter().fold(1, hash));
        let is_read_only = self.read_only == Some(path);
        Ok(FileFacts { size_bytes, is_directory, is_read_only, written: FileTime::NO_CLOCK, tag })
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.spend()?;
        self.changes += 1;
        if self.directories.contains(path) {
            let start = format!("{path}/");
            let is_empty = !self.files.keys().chain(&self.directories).any(|name| name.starts_with(&start));
            let _was_there = is_empty && self.directories.remove(path);
            return if is_empty { Ok(()) } else { Err(StorageError::WrongKind) };
        }
        self.files.remove(path).map(drop).ok_or(StorageError::NotFound)
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        self.changes += 1;
        if self.directories.insert(path.to_string()) { Ok(()) } else { Err(StorageError::Exists) }
    }

    fn changes(&mut self) -> u32 {
        self.changes
    }

    /// Neither name is lost on the way: that is the storage's promise.
    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        if self.no_room_for == Some(to) {
            return Err(StorageError::Full);
        }
        if self.files.contains_key(to) {
            return Err(StorageError::Exists);
        }
        if !self.files.contains_key(from) {
            return Err(StorageError::NotFound);
        }
        self.spend()?;
        self.changes += 1;
        let content = self.files.remove(from).unwrap_or_default();
        self.files.insert(to.to_string(), content);
        Ok(())
    }
}

impl Calendar for Card {
    fn date(&self) -> DateTime {
        DateTime::UNSET
    }

    fn set_date(&mut self, _: DateTime) -> bool {
        false
    }
}

impl Clock for Card {
    fn now(&self) -> Micros {
        Micros(0)
    }
}
