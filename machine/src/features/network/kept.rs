//! Files of secrets on the card: read, replaced as a whole, and forgotten. None of it is in a hurry, so each
//! is there once in flash, and not at every call.

use base::ports::{OpenMode, Storage, StorageError};
use base::safe_file::{self, Draft};
use heapless::Vec;

/// Reads a file of at most so many bytes; `None` if there is none, or no card.
#[inline(never)]
pub(super) fn read<const N: usize>(storage: &mut impl Storage, path: &str) -> Result<Option<Vec<u8, N>>, StorageError> {
    match safe_file::settle(storage, path) {
        // A machine without a card has no secrets.
        Err(StorageError::NoCard | StorageError::NotResponding) => return Ok(None),
        settled => settled?,
    }
    let file = match storage.open(path, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(None),
        opened => opened?,
    };
    let mut bytes = [0; N];
    let count = storage.read(file, &mut bytes)?;
    storage.close(file)?;
    Ok(Vec::from_slice(bytes.get(..count).unwrap_or_default()).ok())
}

/// Writes a file in place of the one before, which is not to stay on the card at `before`.
#[inline(never)]
pub(super) fn write(storage: &mut impl Storage, path: &str, before: &str, bytes: &[u8]) -> Result<(), StorageError> {
    let mut draft = Draft::begin(storage, path)?;
    if let Err(error) = draft.write(storage, bytes) {
        draft.give_up(storage);
        return Err(error);
    }
    draft.finish(storage)?;
    remove(storage, before)
}

/// Removes a file, if it is there.
#[inline(never)]
pub(super) fn remove(storage: &mut impl Storage, path: &str) -> Result<(), StorageError> {
    match storage.remove(path) {
        Err(StorageError::NotFound) => Ok(()),
        removed => removed,
    }
}
