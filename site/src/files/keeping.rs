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
//!
//! An upload that its sender can go on with has a mark beside it while it comes: the SHA-256 that all of it
//! is to have. What is there of it stays on the card when it breaks off.

use base::paths::{CARD, Path};
use base::ports::{FileHandle, OpenMode, PATH_BYTES, Storage, StorageError};
use http::Status;

use super::place::OWN_FOLDER;
use super::refusal::Refusal;

/// Uploads at a time.
pub const UPLOADS: usize = 2;

/// Bytes of a digest.
pub const DIGEST_BYTES: usize = 32;
/// SHA-256 of a whole file.
pub type Digest = [u8; DIGEST_BYTES];

/// Part of an upload that has broken off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Digest that all of it is to have.
    pub digest: Digest,
    /// Bytes that are there.
    pub size: u32,
}

/// Names of an upload's files: the file that comes and its mark, the note of its path, the file whose place
/// it takes.
struct Names {
    new: &'static str,
    mark: &'static str,
    note: &'static str,
    old: &'static str,
}

const NAMES: [Names; UPLOADS] = [
    Names { new: "/sd/.velvet/upload0", mark: "/sd/.velvet/mark0", note: "/sd/.velvet/note0", old: "/sd/.velvet/old0" },
    Names { new: "/sd/.velvet/upload1", mark: "/sd/.velvet/mark1", note: "/sd/.velvet/note1", old: "/sd/.velvet/old1" },
];

fn names(place: usize) -> &'static Names {
    let [first, second] = &NAMES;
    if place == 0 { first } else { second }
}

/// Makes the file that an upload is written to, with the digest by which its sender can go on with it.
///
/// # Errors
/// Those of the card.
pub fn begin(place: usize, digest: Option<&Digest>, card: &mut impl Storage) -> Result<FileHandle, StorageError> {
    recover(place, false, card)?;
    make_folder(OWN_FOLDER, card)?;
    if let Some(digest) = digest {
        write_file(names(place).mark, &[digest], card)?;
    }
    card.open(names(place).new, OpenMode::Write)
}

/// Opens the file of an upload that has broken off, to write on behind so many bytes. None: it has another
/// size.
///
/// # Errors
/// Those of the card.
pub fn write_on(place: usize, size: u32, card: &mut impl Storage) -> Result<Option<FileHandle>, StorageError> {
    let file = card.open(names(place).new, OpenMode::Append)?;
    if card.size(file)? == size {
        return Ok(Some(file));
    }
    card.close(file)?;
    Ok(None)
}

/// Opens the file of an upload that is written, to read it.
///
/// # Errors
/// Those of the card.
pub fn read(place: usize, card: &mut impl Storage) -> Result<FileHandle, StorageError> {
    card.open(names(place).new, OpenMode::Beside)
}

/// Removes the mark of an upload: what is there of it does not outlive its end any more.
///
/// # Errors
/// Those of the card.
pub fn unmark(place: usize, card: &mut impl Storage) -> Result<(), StorageError> {
    let mark = names(place).mark;
    if is_there(mark, card)? { card.remove(mark) } else { Ok(()) }
}

/// Removes what uploads that a power cut has ended left behind, and puts in place what was whole. Leaves and
/// returns what is there of one that its sender can go on with, if that is to be kept.
///
/// # Errors
/// Those of the card.
pub fn recover(place: usize, keeps: bool, card: &mut impl Storage) -> Result<Option<Part>, StorageError> {
    let names = names(place);
    if keeps
        && !is_there(names.old, card)?
        && let Some(digest) = marked(names.mark, card)?
        && let Some(size) = size_of(names.new, card)?.filter(|size| *size > 0)
    {
        return Ok(Some(Part { digest, size }));
    }
    if is_there(names.old, card)?
        && let Some(path) = noted(names.note, card)?
        && !is_there(&path, card)?
    {
        let whole = if is_there(names.new, card)? { names.new } else { names.old };
        card.rename(whole, &path)?;
    }
    for left in [names.old, names.note, names.new, names.mark] {
        if is_there(left, card)? {
            card.remove(left)?;
        }
    }
    Ok(None)
}

/// Returns the size of a file; none if it is not there.
fn size_of(path: &str, card: &mut impl Storage) -> Result<Option<u32>, StorageError> {
    match card.facts(path) {
        Ok(facts) => Ok(Some(facts.size_bytes)),
        Err(StorageError::NotFound) => Ok(None),
        Err(error) => Err(error),
    }
}

fn is_there(path: &str, card: &mut impl Storage) -> Result<bool, StorageError> {
    size_of(path, card).map(|size| size.is_some())
}

/// Reads a small file of the board's own. Returns how many bytes; none if it is not there.
fn read_file(path: &str, bytes: &mut [u8], card: &mut impl Storage) -> Result<Option<usize>, StorageError> {
    let file = match card.open(path, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(None),
        opened => opened?,
    };
    let read = card.read(file, bytes);
    card.close(file)?;
    read.map(Some)
}

/// Reads the mark of an upload. None if it is not whole.
fn marked(mark: &str, card: &mut impl Storage) -> Result<Option<Digest>, StorageError> {
    let mut digest = [0; DIGEST_BYTES];
    Ok((read_file(mark, &mut digest, card)? == Some(DIGEST_BYTES)).then_some(digest))
}

/// Reads a note. None if it is not whole: then nothing has been moved.
fn noted(note: &str, card: &mut impl Storage) -> Result<Option<Path>, StorageError> {
    let mut text = [0; PATH_BYTES + 1];
    let Some(read) = read_file(note, &mut text, card)? else { return Ok(None) };
    let text = text.get(..read).and_then(|text| core::str::from_utf8(text).ok());
    Ok(text.and_then(|text| text.strip_suffix('\n')).and_then(|path| Path::try_from(path).ok()))
}

fn write_file(path: &str, pieces: &[&[u8]], card: &mut impl Storage) -> Result<(), StorageError> {
    let file = card.open(path, OpenMode::Write)?;
    let written = pieces.iter().try_for_each(|piece| card.write(file, piece));
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
                write_file(names.note, &[path.as_bytes(), b"\n"], card)?;
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
