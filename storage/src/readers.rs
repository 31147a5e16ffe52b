//! Readers of files. Readers beside another user of an open file are many, each with its own way along its
//! clusters.

use base::ports::{FileHandle, StorageError};
use card::fat::{Blocks, Error, Place};
use card::volume::{FileReader, Volume};
use heapless::Vec;

/// Files read beside at once: one, and those that wait for their subroutines, which are four together; and
/// one for each of the eight connections of the web.
pub const MAX_BESIDE: usize = 12;

/// A file that is read.
#[derive(Debug)]
pub(crate) struct Reader {
    pub handle: FileHandle,
    pub place: Place,
    pub reader: FileReader,
    pub offset: u32,
}

impl Reader {
    /// Reads on, to the end of a block at most.
    pub fn read<B: Blocks>(
        &mut self,
        volume: &mut Volume,
        device: &mut B,
        buffer: &mut [u8],
    ) -> Result<usize, Error<B::Error>> {
        let count = self.reader.read(volume, device, self.offset, buffer)?;
        self.offset += count as u32;
        Ok(count)
    }
}

/// All readers beside others.
#[derive(Debug, Default)]
pub(crate) struct Readers(Vec<Reader, MAX_BESIDE>);

impl Readers {
    /// Makes a list of no readers.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Adds a reader.
    ///
    /// # Errors
    /// [`StorageError::TooManyOpen`].
    pub fn push(&mut self, reader: Reader) -> Result<(), StorageError> {
        self.0.push(reader).map_err(|_| StorageError::TooManyOpen)
    }

    /// Returns the reader of this handle.
    pub fn get(&mut self, file: FileHandle) -> Option<&mut Reader> {
        self.0.iter_mut().find(|reader| reader.handle == file)
    }

    /// Whether a reader has this handle.
    pub fn has(&self, file: FileHandle) -> bool {
        self.0.iter().any(|reader| reader.handle == file)
    }

    /// Closes the reader of this handle; returns false when there is none.
    pub fn close(&mut self, file: FileHandle) -> bool {
        let before = self.0.len();
        self.0.retain(|reader| reader.handle != file);
        self.0.len() < before
    }

    /// Closes the readers of an entry whose file is about to change.
    pub fn forget(&mut self, place: Place) {
        self.0.retain(|reader| reader.place != place);
    }

    /// Closes all readers.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}
