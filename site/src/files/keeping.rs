//! Ways of an upload's file on the card: under a name of the board's own while it comes, then under its own.
//!
//! A file that is new is renamed. One that takes another's place does so in steps, such that after a power
//! cut at any moment one of both is there, once [`recover`] has run:
//!
//! 1. the path is noted in a file of its own;
//! 2. the old file is renamed, aside;
//! 3. the new one is renamed;
//! 4. the old one and the note are removed.
//!
//! The storage does its changes in this order on the card, and never tears a renaming.

use base::paths::{CARD, Path};
use base::ports::{FileHandle, OpenMode, PATH_BYTES, Storage, StorageError};
use http::Status;

use super::place::OWN_FOLDER;
use super::refusal::Refusal;

/// Uploads at a time.
pub const UPLOADS: usize = 2;

/// Names of an upload's files: the file that comes, the note of its path, the file whose place it takes.
struct Names {
    new: &'static str,
    note: &'static str,
    old: &'static str,
}

const NAMES: [Names; UPLOADS] = [
    Names { new: "/sd/.velvet/upload0", note: "/sd/.velvet/note0", old: "/sd/.velvet/old0" },
    Names { new: "/sd/.velvet/upload1", note: "/sd/.velvet/note1", old: "/sd/.velvet/old1" },
];

fn names(place: usize) -> &'static Names {
    let [first, second] = &NAMES;
    if place == 0 { first } else { second }
}

/// Makes the file that an upload is written to.
///
/// # Errors
/// Those of the card.
pub fn begin(place: usize, card: &mut impl Storage) -> Result<FileHandle, StorageError> {
    recover(place, card)?;
    make_folder(OWN_FOLDER, card)?;
    card.open(names(place).new, OpenMode::Write)
}

/// Removes what uploads that a power cut has ended left behind, and puts in place what was whole.
///
/// # Errors
/// Those of the card.
pub fn recover(place: usize, card: &mut impl Storage) -> Result<(), StorageError> {
    let names = names(place);
    if is_there(names.old, card)?
        && let Some(path) = noted(names.note, card)?
        && !is_there(&path, card)?
    {
        let whole = if is_there(names.new, card)? { names.new } else { names.old };
        card.rename(whole, &path)?;
    }
    for left in [names.old, names.note, names.new] {
        if is_there(left, card)? {
            card.remove(left)?;
        }
    }
    Ok(())
}

fn is_there(path: &str, card: &mut impl Storage) -> Result<bool, StorageError> {
    match card.facts(path) {
        Ok(_) => Ok(true),
        Err(StorageError::NotFound) => Ok(false),
        Err(error) => Err(error),
    }
}

/// Reads a note. None if it is not whole: then nothing has been moved.
fn noted(note: &str, card: &mut impl Storage) -> Result<Option<Path>, StorageError> {
    let file = match card.open(note, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(None),
        opened => opened?,
    };
    let mut text = [0; PATH_BYTES + 1];
    let read = card.read(file, &mut text);
    card.close(file)?;
    let text = text.get(..read?).and_then(|text| core::str::from_utf8(text).ok());
    Ok(text.and_then(|text| text.strip_suffix('\n')).and_then(|path| Path::try_from(path).ok()))
}

fn write_note(note: &str, path: &str, card: &mut impl Storage) -> Result<(), StorageError> {
    let file = card.open(note, OpenMode::Write)?;
    let written = card.write(file, path.as_bytes()).and_then(|()| card.write(file, b"\n"));
    card.close(file).and(written)
}

/// Makes a folder, and those above it, where they are missing.
fn make_folder(path: &str, card: &mut impl Storage) -> Result<(), StorageError> {
    let ends = path.match_indices('/').map(|(at, _)| at).chain([path.len()]).filter(|end| *end > CARD.len());
    for folder in ends.filter_map(|end| path.get(..end)) {
        if !is_there(folder, card)? {
            card.make_directory(folder)?;
        }
    }
    Ok(())
}

/// Step of a file on its way to its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// All of it is on its way to the card.
    Written,
    /// All of it is on the card.
    Kept,
    /// The path is noted, as another file has it.
    Noted,
    /// The other file is aside.
    Free,
    /// The new file has its name.
    Named,
    /// All changes are on their way to the card.
    Settled,
    /// The new file is there for good. Whether it has taken another's place stands in the upload.
    Done,
}

/// Takes the next step of the file that belongs at this path. Each is a change of a folder, or two.
///
/// # Errors
/// Why the file cannot have the name. What had it before has it.
pub fn go_on(place: usize, step: Step, path: &str, card: &mut impl Storage) -> Result<Step, Refusal> {
    let names = names(place);
    Ok(match step {
        Step::Written | Step::Settled if !card.is_kept()? => step,
        Step::Written => Step::Kept,
        Step::Settled => Step::Done,
        Step::Kept => match card.facts(path) {
            Err(StorageError::NotFound) => {
                let (folder, _) = path.rsplit_once('/').unwrap_or((CARD, ""));
                make_folder(folder, card)?;
                card.rename(names.new, path)?;
                Step::Settled
            }
            Ok(facts) if facts.is_directory => {
                return Err(Refusal::new(Status::Conflict, "there is a folder of this name"));
            }
            Ok(facts) if facts.is_read_only => return Err(StorageError::ReadOnly.into()),
            Ok(_) => {
                write_note(names.note, path, card)?;
                Step::Noted
            }
            Err(error) => return Err(error.into()),
        },
        Step::Noted => {
            card.rename(path, names.old)?;
            Step::Free
        }
        Step::Free => {
            if let Err(error) = card.rename(names.new, path) {
                // If this fails as well, the file is put back when the next upload begins.
                let _ = card.rename(names.old, path);
                return Err(error.into());
            }
            Step::Named
        }
        Step::Named => {
            card.remove(names.old)?;
            card.remove(names.note)?;
            Step::Settled
        }
        Step::Done => Step::Done,
    })
}
