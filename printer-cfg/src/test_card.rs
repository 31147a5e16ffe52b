//! A card in memory, for tests.

use base::ports::{
    DirectoryEntry, FileAttributes, FileFacts, FileHandle, FileTime, LIST_CHUNK, OpenMode, Storage, StorageError,
};
use std::collections::BTreeMap;
use std::string::String;
use std::vec::Vec;

/// Files by their paths, and those that are open.
#[derive(Default)]
pub struct Card {
    pub files: BTreeMap<String, Vec<u8>>,
    open: Vec<Option<(String, usize)>>,
}

impl Card {
    pub fn with(files: &[(&str, &str)]) -> Self {
        let files = files.iter().map(|(path, text)| (String::from(*path), text.as_bytes().to_vec())).collect();
        Self { files, open: Vec::new() }
    }

    pub fn text(&self, path: &str) -> &str {
        std::str::from_utf8(&self.files[path]).unwrap()
    }

    /// Number of files that were not closed.
    pub fn left_open(&self) -> usize {
        self.open.iter().flatten().count()
    }
}

impl Storage for Card {
    fn mount(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let at = match mode {
            OpenMode::Read | OpenMode::Beside if !self.files.contains_key(path) => return Err(StorageError::NotFound),
            OpenMode::Read | OpenMode::Beside => 0,
            OpenMode::Write => {
                self.files.insert(path.into(), Vec::new());
                0
            }
            OpenMode::Append => self.files.entry(path.into()).or_default().len(),
        };
        self.open.push(Some((path.into(), at)));
        Ok(FileHandle(self.open.len() as u8 - 1))
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        let (path, at) = self.open[usize::from(file.0)].as_mut().unwrap();
        let rest = &self.files[path][*at..];
        // In odd pieces, as a card may give them.
        let count = rest.len().min(buffer.len()).min(37);
        buffer[..count].copy_from_slice(&rest[..count]);
        *at += count;
        Ok(count)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        let (path, _) = self.open[usize::from(file.0)].as_ref().unwrap();
        self.files.get_mut(path).unwrap().extend_from_slice(bytes);
        Ok(())
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        let (path, at) = self.open[usize::from(file.0)].as_mut().unwrap();
        *at = (offset_bytes as usize).min(self.files[path].len());
        Ok(())
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        let (path, _) = self.open[usize::from(file.0)].as_ref().unwrap();
        Ok(self.files[path].len() as u32)
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        self.open[usize::from(file.0)] = None;
        Ok(())
    }

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        let names = self.files.iter().filter_map(|(file, bytes)| {
            Some((file.strip_prefix(path)?.strip_prefix('/').filter(|name| !name.contains('/'))?, bytes.len()))
        });
        // A directory is not sorted.
        let names: Vec<_> = names.collect();
        for (name, size) in names.into_iter().rev().skip(skip).take(LIST_CHUNK) {
            let entry = DirectoryEntry {
                name: heapless::String::try_from(name).unwrap(),
                size_bytes: size as u32,
                is_directory: false,
                attributes: FileAttributes::default(),
                written: FileTime::NO_CLOCK,
            };
            drop(entries.push(entry));
        }
        Ok(())
    }

    fn facts(&mut self, path: &str) -> Result<FileFacts, StorageError> {
        let bytes = self.files.get(path).ok_or(StorageError::NotFound)?;
        let size_bytes = bytes.len() as u32;
        Ok(FileFacts { size_bytes, is_directory: false, is_read_only: false, written: FileTime::NO_CLOCK, tag: 0 })
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.files.remove(path).map(drop).ok_or(StorageError::NotFound)
    }

    fn make_directory(&mut self, _: &str) -> Result<(), StorageError> {
        Err(StorageError::Unsupported)
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        let bytes = self.files.remove(from).ok_or(StorageError::NotFound)?;
        self.files.insert(to.into(), bytes);
        Ok(())
    }
}
