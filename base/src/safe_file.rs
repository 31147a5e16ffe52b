//! Replaces a file such that a power cut at any moment leaves its old content or its new, never a part of
//! either, and keeps the old one.
//!
//! For `config.ini`, in its directory:
//!
//! 1. the new content is written to `draft-config.ini`, which counts for nothing;
//! 2. once whole and closed, it is renamed to `new-config.ini`: the change is decided;
//! 3. `config.ini` is renamed to `previous-config.ini`;
//! 4. `new-config.ini` is renamed to `config.ini`.
//!
//! A file `new-...` is therefore a whole file that waits for the last two steps. Code that wants to read or
//! replace the real one takes them first: [`settle`]. The storage guarantees that a power cut does not tear
//! the renaming itself ([`Storage::rename`]).

use core::fmt::Write as _;
use core::marker::PhantomData;

use heapless::Vec;

use super::paths::Path;
use crate::ports::{FileHandle, OpenMode, Storage, StorageError};

/// Bytes moved in one step: a block of the card.
const BLOCK: usize = 512;

/// Beginnings of the names of the file's companions.
const DRAFT: &str = "draft-";
const NEW: &str = "new-";
const PREVIOUS: &str = "previous-";

/// Returns the path of a companion.
fn beside(path: &str, beginning: &str) -> Result<Path, StorageError> {
    let (directory, name) = path.rsplit_once('/').ok_or(StorageError::BadPath)?;
    let mut companion = Path::new();
    write!(companion, "{directory}/{beginning}{name}").map_err(|_| StorageError::BadPath)?;
    Ok(companion)
}

/// Opens a file and closes it again; false if there is none.
fn can_open<S: Storage>(storage: &mut S, path: &str, mode: OpenMode) -> Result<bool, StorageError> {
    match storage.open(path, mode) {
        Err(StorageError::NotFound) => Ok(false),
        opened => storage.close(opened?).map(|()| true),
    }
}

fn remove_if_there<S: Storage>(storage: &mut S, path: &str) -> Result<(), StorageError> {
    match storage.remove(path) {
        Err(StorageError::NotFound) => Ok(()),
        removed => removed,
    }
}

/// New content on its way to the card.
#[derive(Debug)]
pub struct Draft<S> {
    path: Path,
    file: FileHandle,
    block: Vec<u8, BLOCK>,
    storage: PhantomData<fn(&mut S)>,
}

impl<S: Storage> Draft<S> {
    /// Begins new content for the file of this path, which need not be there.
    pub fn begin(storage: &mut S, path: &str) -> Result<Self, StorageError> {
        settle(storage, path)?;
        let file = storage.open(&beside(path, DRAFT)?, OpenMode::Write)?;
        let path = Path::try_from(path).map_err(|_| StorageError::BadPath)?;
        Ok(Self { path, file, block: Vec::new(), storage: PhantomData })
    }

    /// Takes the next bytes; true when a block went to the card, so that the caller can let others have a
    /// turn.
    pub fn write(&mut self, storage: &mut S, bytes: &[u8]) -> Result<bool, StorageError> {
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

    /// Puts the complete content in place. After an error the file is as it was.
    pub fn finish(self, storage: &mut S) -> Result<(), StorageError> {
        storage.between_steps();
        let mut replacing = self.close(storage)?;
        loop {
            storage.between_steps();
            if replacing.step(storage)? {
                return Ok(());
            }
        }
    }

    /// Closes the complete content, for a caller that lets others have a turn between the steps of
    /// [`Replacing`].
    pub fn close(self, storage: &mut S) -> Result<Replacing, StorageError> {
        let written = storage.write(self.file, &self.block);
        let closed = written.and(storage.close(self.file));
        if closed.is_err() {
            discard(storage, &self.path);
        }
        closed.map(|()| Replacing { path: self.path, next: 0 })
    }

    /// Gives the content up after an error: nothing has changed and nothing stays behind, if the storage
    /// still answers.
    pub fn give_up(self, storage: &mut S) {
        // Errors are ignored: the content is not wanted.
        let _ = storage.close(self.file);
        discard(storage, &self.path);
    }
}

/// Complete content on its way to become the file: in steps of some block writes each.
#[derive(Debug)]
pub struct Replacing {
    path: Path,
    next: u8,
}

impl Replacing {
    /// Takes the next step; true when the file is in place. Errors come before the change is decided; then
    /// the file is as it was.
    pub fn step<S: Storage>(&mut self, storage: &mut S) -> Result<bool, StorageError> {
        let done = self.take_step(storage);
        if done.is_err() {
            discard(storage, &self.path);
        }
        self.next += 1;
        done
    }

    fn take_step<S: Storage>(&self, storage: &mut S) -> Result<bool, StorageError> {
        let path = &self.path;
        match self.next {
            0 => {
                if can_open(storage, path, OpenMode::Read)? {
                    // Refused if the file is marked read-only, or open.
                    can_open(storage, path, OpenMode::Append)?;
                    remove_if_there(storage, &beside(path, PREVIOUS)?)?;
                }
            }
            1 => storage.rename(&beside(path, DRAFT)?, &beside(path, NEW)?)?,
            2 => {
                if can_open(storage, path, OpenMode::Read)? {
                    storage.rename(path, &beside(path, PREVIOUS)?)?;
                }
            }
            _ => {
                storage.rename(&beside(path, NEW)?, path)?;
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// Removes content that has not become the file, unless the file is not there without it.
fn discard<S: Storage>(storage: &mut S, path: &str) {
    let is_there = can_open(storage, path, OpenMode::Read) == Ok(true);
    for companion in [Some(DRAFT), is_there.then_some(NEW)].into_iter().flatten() {
        // An error is under way already, and the remains count for nothing, or for the content that was to be
        // saved.
        let _ = beside(path, companion).and_then(|companion| storage.remove(&companion));
    }
}

/// Puts a decided change of this file in place, if a power cut has left one. To be called before the file is
/// read or replaced.
pub fn settle<S: Storage>(storage: &mut S, path: &str) -> Result<(), StorageError> {
    let new = beside(path, NEW)?;
    if !can_open(storage, &new, OpenMode::Read)? {
        return Ok(());
    }
    if can_open(storage, path, OpenMode::Read)? {
        let previous = beside(path, PREVIOUS)?;
        remove_if_there(storage, &previous)?;
        storage.between_steps();
        storage.rename(path, &previous)?;
        storage.between_steps();
    }
    storage.rename(&new, path)?;
    storage.between_steps();
    Ok(())
}

/// Removes the file's former content.
pub fn forget_previous<S: Storage>(storage: &mut S, path: &str) -> Result<(), StorageError> {
    remove_if_there(storage, &beside(path, PREVIOUS)?)
}

/// Removes the file, and a change of it that waits. The previous content stays.
pub fn remove<S: Storage>(storage: &mut S, path: &str) -> Result<(), StorageError> {
    settle(storage, path)?;
    remove_if_there(storage, path)
}

#[cfg(test)]
mod tests;
