//! The file of `[save_variables]`, in Klipper's own form: one section with a literal a line, sorted by name.
//! A power cut at any moment of writing leaves the old file or the new one.

use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use base::safe_file::{self, Draft};

use crate::option::Options;
use crate::store::{SCRATCH, Scratch};

/// Name of the file's one section.
pub const SECTION: &str = "Variables";

/// Reason for which a variable was not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSaved {
    /// The card has an error.
    Card(StorageError),
    /// A line of the file is longer than there is room for.
    Long,
}

impl NotSaved {
    /// Returns the reason in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Card(error) => error.text(),
            Self::Long => "a line of it has more than 1000 bytes",
        }
    }
}

impl From<StorageError> for NotSaved {
    fn from(error: StorageError) -> Self {
        Self::Card(error)
    }
}

/// Reads a variable into memory. False: there is none.
///
/// # Errors
/// Errors of the card; a missing file is none.
pub fn read<S: Storage>(storage: &mut S, path: &str, name: &str, into: &mut Scratch) -> Result<bool, StorageError> {
    let opened = match Options::of_file(storage, path, SECTION) {
        Err(StorageError::NotFound) => return Ok(false),
        opened => opened?,
    };
    let Some(mut options) = opened else { return Ok(false) };
    while options.go_on() {
        if options.key() == name {
            into.fill(options.value());
            return Ok(true);
        }
    }
    Ok(false)
}

/// Reads the name of the variable at a place into memory. False: there are not so many.
///
/// # Errors
/// Errors of the card; a missing file is none.
pub fn name_at<S: Storage>(
    storage: &mut S,
    path: &str,
    place: usize,
    into: &mut Scratch,
) -> Result<bool, StorageError> {
    let opened = match Options::of_file(storage, path, SECTION) {
        Err(StorageError::NotFound) => return Ok(false),
        opened => opened?,
    };
    let Some(mut options) = opened else { return Ok(false) };
    let mut left = place;
    while options.go_on() {
        if left == 0 {
            into.fill(options.key().bytes());
            return Ok(true);
        }
        left -= 1;
    }
    Ok(false)
}

/// Writes a variable into the file, which need not be there.
///
/// # Errors
/// Errors of the card; the file is the old one then.
pub fn save<S: Storage>(
    storage: &mut S,
    path: &str,
    (name, value): (&str, &str),
    line: &mut Scratch,
) -> Result<(), NotSaved> {
    safe_file::settle(storage, path)?;
    let old = match storage.open(path, OpenMode::Read) {
        Ok(file) => Some(file),
        Err(StorageError::NotFound) => None,
        Err(error) => return Err(error.into()),
    };
    let mut draft = match Draft::begin(storage, path) {
        Ok(draft) => draft,
        Err(error) => {
            close(storage, old);
            return Err(error.into());
        }
    };
    let written = write(storage, &mut draft, old, (name, value), line);
    close(storage, old);
    match written {
        Ok(()) => Ok(draft.finish(storage)?),
        Err(why) => {
            draft.give_up(storage);
            Err(why)
        }
    }
}

fn close<S: Storage>(storage: &mut S, file: Option<FileHandle>) {
    // The file was only read: a failing close loses nothing.
    let _ = file.map(|file| storage.close(file));
}

/// Writes the variables of the old file, and the new one in its place among them.
fn write<S: Storage>(
    storage: &mut S,
    draft: &mut Draft<S>,
    old: Option<FileHandle>,
    (name, value): (&str, &str),
    line: &mut Scratch,
) -> Result<(), NotSaved> {
    let mut put = |storage: &mut S, parts: [&str; 4]| {
        parts.into_iter().try_for_each(|part| draft.write(storage, part.as_bytes()).map(drop))
    };
    put(storage, ["[", SECTION, "]", "\n"])?;
    let (mut chunk, mut is_written) = ([0; 128], false);
    line.fill(core::iter::empty());
    while let Some(file) = old {
        let count = storage.read(file, &mut chunk)?;
        // The last line may lack its end.
        let bytes = if count == 0 { &b"\n"[..] } else { chunk.get(..count).unwrap_or(&[]) };
        for byte in bytes {
            if *byte != b'\n' {
                line.push(*byte);
                continue;
            }
            if line.is_cut() {
                return Err(NotSaved::Long);
            }
            let text = line.text().unwrap_or_default().trim();
            let known = text.split_once(['=', ':']).map(|(known, value)| (known.trim_end(), value.trim_start()));
            if let Some((known, kept)) = known.filter(|_| !text.starts_with(['[', '#', ';'])) {
                if !is_written && known >= name {
                    put(storage, [name, " = ", value, "\n"])?;
                    is_written = true;
                }
                if known != name {
                    put(storage, [known, " = ", kept, "\n"])?;
                }
            }
            line.fill(core::iter::empty());
        }
        if count == 0 {
            break;
        }
    }
    if !is_written {
        put(storage, [name, " = ", value, "\n"])?;
    }
    put(storage, ["\n", "", "", ""])?;
    debug_assert!(value.len() <= SCRATCH, "values come from there");
    Ok(())
}
