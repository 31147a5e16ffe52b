//! Test doubles for files and jobs: a card in memory, and sessions that listen.

use std::collections::{BTreeMap, BTreeSet};
use std::string::{String, ToString};
use std::vec::Vec;

use base::ports::{
    Calendar, Clock, DateTime, DirectoryEntry, FileAttributes, FileHandle, FileTime, LIST_CHUNK, OpenMode, Storage,
    StorageError,
};
use base::sessions::{Consoles, SessionProfile};
use base::sessions::{Inbox, Recipient, Reply, SessionId, Sessions};

/// Card with files in memory.
#[derive(Default)]
pub struct Card {
    files: BTreeMap<String, Vec<u8>>,
    directories: BTreeSet<String>,
    open: Vec<Option<(String, usize)>>,
    /// Whether reading fails from now on.
    pub fails: bool,
    /// Whether nothing more fits on the card.
    pub is_full: bool,
}

impl Card {
    pub fn with(files: &[(&str, &str)]) -> Self {
        let files = files.iter().map(|(path, text)| (path.to_string(), text.as_bytes().to_vec())).collect();
        Self { files, ..Self::default() }
    }

    pub fn put(&mut self, path: &str, content: &[u8]) {
        self.files.insert(path.to_string(), content.to_vec());
    }

    pub fn text(&self, path: &str) -> &str {
        core::str::from_utf8(&self.files[path]).unwrap()
    }

    pub fn open_files(&self) -> usize {
        self.open.iter().flatten().count()
    }

    fn place(&mut self, file: FileHandle) -> Result<&mut (String, usize), StorageError> {
        self.open.get_mut(usize::from(file.0)).and_then(Option::as_mut).ok_or(StorageError::NotFound)
    }
}

impl Storage for Card {
    fn mount(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        match mode {
            OpenMode::Read | OpenMode::Beside if !self.files.contains_key(path) => return Err(StorageError::NotFound),
            OpenMode::Write => drop(self.files.insert(path.to_string(), Vec::new())),
            OpenMode::Read | OpenMode::Beside | OpenMode::Append => {}
        }
        if mode != OpenMode::Beside && self.open.iter().flatten().any(|(open, _)| open == path) {
            return Err(StorageError::Busy);
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
        let rest = &self.files[&path][at..];
        let count = buffer.len().min(rest.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.place(file)?.1 += count;
        Ok(count)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        if self.is_full {
            return Err(StorageError::Full);
        }
        let (path, at) = self.place(file)?.clone();
        let content = self.files.entry(path).or_default();
        let overwritten = content.len().min(at + bytes.len());
        content.splice(at..overwritten, bytes.iter().copied());
        self.place(file)?.1 += bytes.len();
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
                name: name.as_str().try_into().unwrap(),
                size_bytes: size.unwrap_or(0),
                is_directory: size.is_none(),
                attributes: FileAttributes::default(),
                written: FileTime::NO_CLOCK,
            };
            entries.push(entry).unwrap();
        }
        Ok(())
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.files.remove(path).map(drop).ok_or(StorageError::NotFound)
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        if self.directories.insert(path.to_string()) { Ok(()) } else { Err(StorageError::Exists) }
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        if self.files.contains_key(to) {
            return Err(StorageError::Exists);
        }
        let content = self.files.remove(from).ok_or(StorageError::NotFound)?;
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
    fn now(&self) -> units::Micros {
        units::Micros(0)
    }
}

/// Two sessions, of which the first one asks.
pub struct Desk {
    pub sessions: Sessions,
    line: Line,
}

/// Other ends of the two sessions' lines.
struct Line {
    inboxes: [Inbox; 2],
    output: [Vec<u8>; 2],
}

impl Consoles for Line {
    fn sessions(&self) -> u8 {
        2
    }

    fn inbox(&self, session: SessionId) -> &Inbox {
        &self.inboxes[usize::from(session.0)]
    }

    fn profile(&self, _: SessionId) -> SessionProfile {
        SessionProfile::SERIAL
    }

    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize {
        self.output[usize::from(session.0)].extend(bytes);
        bytes.len()
    }
}

impl Desk {
    pub fn new() -> Self {
        let line = Line { inboxes: [Inbox::new(), Inbox::new()], output: [Vec::new(), Vec::new()] };
        let mut sessions = Sessions::new();
        sessions.configure(&line);
        Self { sessions, line }
    }

    /// Takes the text sent to the first session since the last call.
    pub fn heard(&mut self) -> String {
        self.sessions.flush(&mut self.line, units::Micros(0));
        String::from_utf8(std::mem::take(&mut self.line.output[0])).unwrap()
    }

    /// Returns the text that `says` sends to the first session.
    pub fn hears(&mut self, says: impl FnOnce(&mut Reply<'_>)) -> String {
        says(&mut Reply::new(&mut self.sessions, Recipient::Session(SessionId(0))));
        self.heard()
    }
}
