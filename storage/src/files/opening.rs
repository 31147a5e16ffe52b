//! Opening files: finding them, making them, and giving them to readers and writers.

use base::ports::{FileHandle, OpenMode, StorageError};
use card::fat::{Attributes, Entry, Name, Place};
use card::volume::{FileReader, Listing, find_file};
use embedded_sdmmc::{Mode, RawDirectory, RawFile, ShortFileName, TimeSource};
use heapless::{String, Vec};

use super::listing::Listed;
use super::{CardStorage, Content, Open, inside};
use crate::device::Card;
use crate::errors::of_content;
use crate::readers::{Reader, Readers};
use crate::sdmmc_device::{MAX_FILES, SHIFT};

impl<C: Card, T: TimeSource + Clone> CardStorage<'_, C, T> {
    /// The entry of a path, which no open file may have.
    pub(super) fn find_closed(&self, path: &str) -> Result<Entry, StorageError> {
        let entry = self.names(|volume, device| volume.find(device, path))?;
        if self.open.iter().any(|open| open.place == entry.place()) { Err(StorageError::Busy) } else { Ok(entry) }
    }

    /// The file of this path as `mode` wants it: there, and empty if it is to be written anew.
    pub(super) fn prepare(&mut self, path: &str, mode: OpenMode) -> Result<Entry, StorageError> {
        let now = self.now();
        let entry = match (self.find_closed(path), mode) {
            (Err(StorageError::NotFound), OpenMode::Write | OpenMode::Append) => {
                return self.change(|volume, device| volume.create(device, path, now));
            }
            (found, _) => found?,
        };
        if entry.is_directory() {
            return Err(StorageError::WrongKind);
        }
        if entry.attributes().has(Attributes::READ_ONLY) {
            return Err(StorageError::ReadOnly);
        }
        if mode == OpenMode::Write {
            self.change(|volume, device| volume.empty(device, &entry, now))?;
            return Ok(entry);
        }
        self.names(|volume, device| volume.forget_free_count(device))?;
        self.names(|volume, device| volume.check(device, &entry))?;
        Ok(entry)
    }

    /// Opens a file beside whoever reads it.
    pub(super) fn open_beside(&mut self, path: &str) -> Result<FileHandle, StorageError> {
        let (reader, place) = self.reading(|volume, device| find_file(volume, device, path))?;
        if self.open.iter().any(|open| open.is_written() && open.place == place) {
            return Err(StorageError::Busy);
        }
        let handle = self.new_handle();
        self.readers.push(Reader { handle, place, reader, offset: 0 })?;
        Ok(handle)
    }

    /// The file of this path, which nobody has open, to be read.
    pub(super) fn open_reader(&mut self, path: &str, handle: FileHandle) -> Result<Reader, StorageError> {
        let (reader, place) = self.reading(|volume, device| find_file(volume, device, path))?;
        if self.open.iter().any(|open| open.place == place) {
            return Err(StorageError::Busy);
        }
        if matches!(reader, FileReader::Fat(_)) {
            self.names(|volume, device| {
                let entry = volume.find(device, path)?;
                volume.check(device, &entry)
            })?;
        }
        Ok(Reader { handle, place, reader, offset: 0 })
    }

    /// Opens what a file contains, found by the short names along its path.
    pub(super) fn open_content(&self, path: &str, file: &Entry) -> Result<RawFile, StorageError> {
        let volume = self.raw_volume.ok_or(StorageError::NoCard)?;
        let mut directory = self.manager.open_root_dir(volume).map_err(of_content::<C>)?;
        let opened = self.enter(&mut directory, path).and_then(|()| {
            let name = self.short_name(directory, file)?;
            self.manager.open_file_in_dir(directory, name, Mode::ReadWriteAppend).map_err(of_content::<C>)
        });
        self.close_directory(directory);
        opened
    }

    /// Goes from the root to the directory of a path.
    pub(super) fn enter(&self, directory: &mut RawDirectory, path: &str) -> Result<(), StorageError> {
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

    pub(super) fn close_directory(&self, directory: RawDirectory) {
        // The directory was opened by the caller; closing an open directory touches no card and cannot fail.
        let _closed = self.manager.close_dir(directory);
    }

    /// An entry's short name as `embedded-sdmmc` wants it, when `embedded-sdmmc` finds this entry by that
    /// name. The search fails where a damaged directory has the name twice, or as its label, nor for names
    /// with blanks inside, which only very old systems made.
    pub(super) fn short_name(&self, directory: RawDirectory, entry: &Entry) -> Result<ShortFileName, StorageError> {
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
        let place = Place { block: found.entry_block.0.wrapping_sub(SHIFT), slot: (found.entry_offset / 32) as u8 };
        if place == entry.place() { Ok(name) } else { Err(StorageError::Damaged) }
    }

    /// Returns where a directory goes on behind so many entries.
    pub(super) fn listing(&mut self, path: &str, skip: usize) -> Result<Listing, StorageError> {
        let inner = inside(path)?;
        let last = self.listed.take().filter(|last| last.path == path);
        let known = last.and_then(|last| last.places.into_iter().find(|(passed, _)| *passed == skip));
        if let Some((_, next)) = known {
            return Ok(next);
        }
        let mut next = self.reading(|volume, device| Listing::start(volume, device, inner))?;
        let mut name = Name::new();
        for _ in 0..skip {
            if self.reading(|volume, device| next.next(volume, device, &mut name))?.is_none() {
                break;
            }
        }
        Ok(next)
    }

    /// Remembers where a directory goes on.
    pub(super) fn remember(&mut self, path: &str, places: [(usize, Listing); 2]) -> Result<(), StorageError> {
        let path = String::try_from(path).map_err(|_| StorageError::BadPath)?;
        *self.listed = Some(Listed { path, places });
        Ok(())
    }
}

/// A file that is only read, beside or not.
pub(super) fn reader_of<'a>(
    open: &'a mut Vec<Open, MAX_FILES>,
    readers: &'a mut Readers,
    file: FileHandle,
) -> Option<&'a mut Reader> {
    match open.iter_mut().find(|open| open.handle == file).map(|open| &mut open.content) {
        Some(Content::Read(reader)) => Some(reader),
        Some(Content::Written(_)) => None,
        None => readers.get(file),
    }
}
