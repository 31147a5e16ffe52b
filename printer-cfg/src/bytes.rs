//! Bytes of a file on the card, read in pieces.

use base::ports::{FileHandle, OpenMode, Storage, StorageError};

/// Bytes that are read at once.
const CHUNK: usize = 256;

/// Bytes of an open file, from a place on. The file is closed with it.
pub(crate) struct Bytes<'s, S: Storage> {
    storage: &'s mut S,
    file: FileHandle,
    chunk: [u8; CHUNK],
    /// Bytes of the chunk that were read, and the next of them.
    len: usize,
    next: usize,
    /// Offset of the chunk in the file.
    begins: u32,
    /// The first error of the card; nothing is read behind it.
    pub error: Option<StorageError>,
}

impl<'s, S: Storage> Bytes<'s, S> {
    /// Opens a file at an offset. Others may use it meanwhile.
    pub fn open(storage: &'s mut S, path: &str, offset: u32) -> Result<Self, StorageError> {
        let file = storage.open(path, OpenMode::Beside)?;
        if offset > 0
            && let Err(error) = storage.seek(file, offset)
        {
            // The file was only read: a failing close loses nothing.
            let _ = storage.close(file);
            return Err(error);
        }
        Ok(Self { storage, file, chunk: [0; CHUNK], len: 0, next: 0, begins: offset, error: None })
    }

    /// Returns the next byte without taking it; none at the end, and behind an error.
    pub fn peek(&mut self) -> Option<u8> {
        if self.next == self.len && self.error.is_none() {
            self.begins += self.len as u32;
            (self.next, self.len) = (0, 0);
            match self.storage.read(self.file, &mut self.chunk) {
                Ok(count) => self.len = count.min(CHUNK),
                Err(error) => self.error = Some(error),
            }
        }
        self.chunk.get(self.next).copied().filter(|_| self.next < self.len)
    }

    /// Takes the next byte.
    pub fn take(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.next += 1;
        Some(byte)
    }

    /// Returns the offset of the next byte in the file.
    pub const fn offset(&self) -> u32 {
        self.begins + self.next as u32
    }
}

impl<S: Storage> Drop for Bytes<'_, S> {
    fn drop(&mut self) {
        // The file was only read: a failing close loses nothing.
        let _ = self.storage.close(self.file);
    }
}
