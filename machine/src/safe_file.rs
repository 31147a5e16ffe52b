//! Replaces a file such that a power cut at any moment leaves its old content or its new, never a part of either.
//!
//! The new content is first written under a temporary name and ends with a mark: its length, its checksum and the name
//! it is meant for. Only when that file is closed is the real one overwritten from it, and then the temporary one is
//! removed. A temporary file with a valid mark is therefore a change that was decided and may be half copied: it is
//! copied again, at boot and before the next change. Without a valid mark the real file has not been touched.
//!
//! Renaming would be shorter, but not every storage can (the board's FAT cannot).

use core::fmt::Write as _;
use core::marker::PhantomData;

use heapless::{String, Vec};

use crate::ports::{FileHandle, OpenMode, Storage, StorageError};

/// Bytes moved in one step: a block of the card.
const BLOCK: usize = 512;
/// Longest name of a file, without its directory.
const NAME: usize = 24;
/// `; complete 0000001234 89ABCDEF config-override         ` and a line end.
const MARK: usize = 11 + 10 + 1 + 8 + 1 + NAME + 1;
const CARD: &str = "/sd/";

/// CRC-32 as of Ethernet and ZIP (IEEE 802.3), bit by bit: settings are small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sum(u32);

impl Sum {
    const EMPTY: Self = Self(u32::MAX);

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 ^= u32::from(*byte);
            for _ in 0..8 {
                self.0 = (self.0 >> 1) ^ if self.0 & 1 == 1 { 0xEDB8_8320 } else { 0 };
            }
        }
    }

    const fn value(self) -> u32 {
        !self.0
    }
}

/// New content on its way to the card.
#[derive(Debug)]
pub struct Draft<S> {
    temporary: &'static str,
    file: FileHandle,
    block: Vec<u8, BLOCK>,
    length: u32,
    sum: Sum,
    storage: PhantomData<fn(&mut S)>,
}

impl<S: Storage> Draft<S> {
    /// Begins a file under its temporary name. Finish what an earlier one may have left first: see [`unfinished`].
    pub fn begin(storage: &mut S, temporary: &'static str) -> Result<Self, StorageError> {
        let file = storage.open(temporary, OpenMode::Write)?;
        Ok(Self { temporary, file, block: Vec::new(), length: 0, sum: Sum::EMPTY, storage: PhantomData })
    }

    /// Takes the next bytes; true when a block went to the card, so that the caller can let others have a turn.
    pub fn write(&mut self, storage: &mut S, bytes: &[u8]) -> Result<bool, StorageError> {
        self.sum.add(bytes);
        self.length = self.length.saturating_add(u32::try_from(bytes.len()).map_err(|_| StorageError::Full)?);
        self.push(storage, bytes)
    }

    fn push(&mut self, storage: &mut S, bytes: &[u8]) -> Result<bool, StorageError> {
        let mut written = false;
        for byte in bytes {
            if self.block.push(*byte).is_err() {
                storage.write(self.file, &self.block)?;
                written = true;
                self.block.clear();
                // An empty block has room.
                let _ = self.block.push(*byte);
            }
        }
        Ok(written)
    }

    /// The content is complete: marks it for `/sd/<name>`. From here on the change is decided.
    pub fn finish(mut self, storage: &mut S, name: &str) -> Result<(), StorageError> {
        let mut mark: String<MARK> = String::new();
        let written = writeln!(mark, "; complete {:010} {:08X} {name:<NAME$}", self.length, self.sum.value());
        if written.is_err() || name.is_empty() {
            return Err(StorageError::BadPath);
        }
        self.push(storage, mark.as_bytes())?;
        storage.write(self.file, &self.block)?;
        storage.close(self.file)
    }

    /// Something went wrong: nothing has changed and nothing stays behind, if the storage still answers.
    pub fn give_up(self, storage: &mut S) {
        let _ = storage.close(self.file);
        let _ = storage.remove(self.temporary);
    }
}

/// A decided change that is being copied into place.
#[derive(Debug)]
pub struct Install<S> {
    temporary: &'static str,
    from: FileHandle,
    to: FileHandle,
    left: u32,
    storage: PhantomData<fn(&mut S)>,
}

/// The change that this temporary file holds, when it is whole; `None` when there is no such file or it is a part.
pub fn unfinished<S: Storage>(storage: &mut S, temporary: &'static str) -> Result<Option<Install<S>>, StorageError> {
    let from = match storage.open(temporary, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(None),
        opened => opened?,
    };
    let found = decided(storage, from);
    let to = match found {
        Ok(Some((left, path))) => storage.open(&path, OpenMode::Write).map(|to| Some((left, to))),
        Ok(None) => Ok(None),
        Err(error) => Err(error),
    };
    match to {
        Ok(Some((left, to))) => Ok(Some(Install { temporary, from, to, left, storage: PhantomData })),
        other => {
            storage.close(from)?;
            other.map(|_| None)
        }
    }
}

/// Length and destination of a whole draft; the file is then at its start again.
fn decided<S: Storage>(storage: &mut S, file: FileHandle) -> Result<Option<(u32, String<48>)>, StorageError> {
    let Some(length) = storage.size(file)?.checked_sub(MARK as u32) else { return Ok(None) };
    let (mut sum, mut left, mut block) = (Sum::EMPTY, length, [0; BLOCK]);
    while left > 0 {
        let piece = block.get_mut(..BLOCK.min(left as usize)).unwrap_or(&mut []);
        read_all(storage, file, piece)?;
        sum.add(piece);
        left -= piece.len() as u32;
    }
    let mut mark = [0; MARK];
    read_all(storage, file, &mut mark)?;
    storage.seek(file, 0)?;
    let Ok(mark) = core::str::from_utf8(&mark) else { return Ok(None) };
    let mut words = mark.strip_prefix("; complete ").unwrap_or("").split_ascii_whitespace();
    let same_length = words.next().and_then(|word| word.parse().ok()) == Some(length);
    let same_sum = words.next().and_then(|word| u32::from_str_radix(word, 16).ok()) == Some(sum.value());
    let (true, true, Some(name)) = (same_length, same_sum, words.next()) else { return Ok(None) };
    let mut path = String::new();
    // Four characters and a name fit.
    let fits = path.push_str(CARD).is_ok() && path.push_str(name).is_ok();
    Ok(fits.then_some((length, path)))
}

/// Fills the buffer; a file that ends before is damaged.
fn read_all<S: Storage>(storage: &mut S, file: FileHandle, mut buffer: &mut [u8]) -> Result<(), StorageError> {
    while !buffer.is_empty() {
        match storage.read(file, buffer)? {
            0 => return Err(StorageError::Device),
            count => buffer = buffer.get_mut(count..).unwrap_or(&mut []),
        }
    }
    Ok(())
}

impl<S: Storage> Install<S> {
    /// Copies one block; true when the change is in place and its temporary file gone.
    pub fn step(&mut self, storage: &mut S) -> Result<bool, StorageError> {
        let stepped = self.copy_block(storage);
        if stepped.is_err() {
            // The mark stays valid: the next boot or change copies again.
            let _ = storage.close(self.from);
            let _ = storage.close(self.to);
        }
        stepped
    }

    fn copy_block(&mut self, storage: &mut S) -> Result<bool, StorageError> {
        if self.left > 0 {
            let mut block = [0; BLOCK];
            let piece = block.get_mut(..BLOCK.min(self.left as usize)).unwrap_or(&mut []);
            read_all(storage, self.from, piece)?;
            storage.write(self.to, piece)?;
            self.left -= piece.len() as u32;
            return Ok(false);
        }
        storage.close(self.to)?;
        storage.close(self.from)?;
        storage.remove(self.temporary)?;
        Ok(true)
    }
}

#[cfg(test)]
mod tests;
