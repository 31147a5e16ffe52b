//! Files on the card, for the machine's sessions: the current directory, uploads, the file commands, long
//! listings, and the configuration file.

pub mod card_facts;
pub mod commands;
pub mod config_edit;
pub mod copying;
pub mod editing;
pub mod editor;
pub mod editor_commands;
pub mod listings;
pub mod logs;
pub mod program_files;
mod transfer;
mod upload;
mod ymodem;

use base::paths::{CARD, Path, absolute};
use base::ports::{Storage, StorageError};
use base::sessions::SessionId;
use heapless::Vec;

pub use transfer::{Progress, Transfers};
pub use upload::NotSaved;
use upload::Upload;

/// Current directory, and files in progress.
#[derive(Debug)]
pub struct Files {
    /// Directory that relative names start from, the same for every session.
    directory: Path,
    /// File being uploaded (M28).
    upload: Option<Upload>,
    /// File being edited (`ed`).
    pub editing: Option<editing::Editing>,
    /// Files that consoles send as bytes.
    pub transfers: Transfers,
}

impl Default for Files {
    fn default() -> Self {
        // The card's name fits into a path.
        Self {
            directory: Path::try_from(CARD).unwrap_or_default(),
            upload: None,
            editing: None,
            transfers: Transfers::default(),
        }
    }
}

impl Files {
    /// Returns the current directory.
    #[must_use]
    pub const fn directory(&self) -> &Path {
        &self.directory
    }

    /// Returns whether this session's lines are text for a file, or for the editor.
    #[must_use]
    pub fn takes_lines_of(&self, session: SessionId) -> bool {
        self.uploads_from(session) || self.edits_from(session)
    }

    /// Returns whether this session edits a file.
    #[must_use]
    pub fn edits_from(&self, session: SessionId) -> bool {
        self.editing.as_ref().is_some_and(|editing| editing.from == session)
    }

    /// Makes a name relative to the current directory absolute. A path that does not fit becomes empty, which
    /// no file has.
    #[must_use]
    pub fn absolute(&self, name: &str) -> Path {
        absolute(&self.directory, name)
    }

    /// `cd`: makes this directory the current one.
    ///
    /// # Errors
    /// When there is no such directory; nothing has changed then.
    pub fn change_directory(&mut self, path: Path, storage: &mut impl Storage) -> Result<(), StorageError> {
        storage.list(&path, 0, &mut Vec::new())?;
        self.directory = path;
        Ok(())
    }
}
