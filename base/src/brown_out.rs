//! State of the two supplies (brown-out detection), and the note on the card that tells the next start of a
//! fall.
//!
//! The note is a file of one block that is made beforehand and written in place, so that neither
//! allocation table nor directory is touched while the power goes.

use units::Micros;

use crate::failure::{ShortText, short};

use crate::falling_supply::FallingSupply;
use crate::ports::{FileHandle, OpenMode, Storage, StorageError};

/// Path of the note.
pub const PATH: &str = "/sd/brown-out.txt";
const BLOCK: usize = 512;
/// Beginnings of the note: nobody has been told of the fall yet, or somebody has.
const NEWS: &str = "new: ";
const TOLD: &str = "told: ";

/// State of the two supplies.
#[derive(Debug, Default)]
pub struct BrownOut {
    /// Time of the next look at a supply.
    pub due: Micros,
    /// Whether the next look is at the heaters' supply.
    pub heaters_turn: bool,
    /// The supply of motors.
    pub motors: FallingSupply,
    /// The supply of heaters.
    pub heaters: FallingSupply,
    /// Text on a fall that is to be kept once the motors stand.
    pub to_keep: Option<ShortText>,
    /// Open file of the note: closing it takes writes of its own, which have to wait until the power is
    /// there.
    file: Option<FileHandle>,
}

impl BrownOut {
    /// Closes the note once both supplies are as usual.
    pub fn look_after_note<S: Storage>(&mut self, storage: &mut S) {
        if self.file.is_some() && !self.motors.is_low() && !self.heaters.is_low() {
            self.close(storage);
        }
    }

    /// Keeps the fall that has waited for the machine to stand.
    pub fn stands<S: Storage>(&mut self, storage: &mut S) -> Result<(), StorageError> {
        self.to_keep.take().map_or(Ok(()), |event| self.keep(storage, event.as_str()))
    }

    /// Writes a fall over the note's block, if there is one.
    ///
    /// # Errors
    /// Errors of the card; a missing note or card is none.
    pub fn keep<S: Storage>(&mut self, storage: &mut S, event: &str) -> Result<(), StorageError> {
        self.close(storage);
        let opened = storage.open(PATH, OpenMode::Append);
        self.file = opened.ok();
        match opened.and_then(|file| put(storage, file, NEWS, event)) {
            Err(StorageError::NotFound | StorageError::NoCard) => Ok(()),
            other => other,
        }
    }

    fn close<S: Storage>(&mut self, storage: &mut S) {
        if let Some(file) = self.file.take() {
            // Errors are ignored: the note's block has been written.
            let _ = storage.close(file);
        }
    }
}

fn put<S: Storage>(storage: &mut S, file: FileHandle, state: &str, event: &str) -> Result<(), StorageError> {
    let mut block = [b' '; BLOCK];
    let text = state.bytes().chain(event.bytes()).chain([b'\n']);
    block.iter_mut().zip(text).for_each(|(to, byte)| *to = byte);
    storage.seek(file, 0)?;
    storage.write(file, &block)
}

/// Returns whether the note's block is there.
pub fn is_prepared<S: Storage>(storage: &mut S) -> bool {
    let Ok(file) = storage.open(PATH, OpenMode::Read) else { return false };
    let size = storage.size(file);
    // Errors are ignored: the file was only read.
    let _ = storage.close(file);
    size == Ok(BLOCK as u32)
}

/// Makes the note's block in its file, which is new.
///
/// # Errors
/// Errors of the card.
pub fn prepare<S: Storage>(storage: &mut S, file: FileHandle) -> Result<(), StorageError> {
    // The block is a variable: as the reference of a constant it would lie in flash.
    let blank = [b' '; BLOCK];
    storage.write(file, &blank)
}

/// Returns the fall that nobody has been told of yet.
pub fn news<S: Storage>(storage: &mut S) -> Option<ShortText> {
    let file = storage.open(PATH, OpenMode::Read).ok()?;
    let mut block = [0; BLOCK];
    let read = storage.read(file, &mut block);
    // Errors are ignored: the file was only read.
    let _ = storage.close(file);
    let text = core::str::from_utf8(block.get(..read.ok()?)?).ok()?;
    let event = text.strip_prefix(NEWS)?.lines().next()?.trim();
    Some(short(format_args!("{event}")))
}

/// Notes on the card that somebody has been told of the fall.
///
/// # Errors
/// Errors of the card.
pub fn told<S: Storage>(storage: &mut S, event: &str) -> Result<(), StorageError> {
    let file = storage.open(PATH, OpenMode::Append)?;
    put(storage, file, TOLD, event).and(storage.close(file))
}
