//! Files on the card, for whoever talks to the machine: the current directory, uploads, the file commands,
//! long listings, and the configuration file.

pub mod commands;
pub mod config_edit;
pub(crate) mod copying;
pub mod kept;
pub mod listings;
pub mod logs;
pub mod paths;
pub mod safe_file;
mod transfer;
mod upload;
mod ymodem;

#[cfg(test)]
pub(crate) mod bench;

use heapless::Vec;

use crate::ports::{Storage, StorageError};
pub use paths::{CARD, CONFIG_PATH, OVERRIDE_PATH, Path, override_path};
pub(crate) use transfer::Transfers;
use upload::Upload;

/// Where names start from, and what is being uploaded.
#[derive(Debug)]
pub struct Files {
    /// The directory that relative names start from, the same for every session.
    directory: Path,
    /// The file being uploaded (M28).
    upload: Option<Upload>,
    /// What a console sends as bytes.
    pub(crate) transfers: Transfers,
}

impl Default for Files {
    fn default() -> Self {
        // The card's name fits.
        Self { directory: Path::try_from(CARD).unwrap_or_default(), upload: None, transfers: Transfers::default() }
    }
}

impl Files {
    /// The directory that names start from.
    #[must_use]
    pub const fn directory(&self) -> &Path {
        &self.directory
    }

    /// A name relative to the current directory, made absolute. One that does not fit becomes empty, which no
    /// file has.
    #[must_use]
    pub fn absolute(&self, name: &str) -> Path {
        paths::absolute(&self.directory, name)
    }

    /// `cd`: names start from this directory from now on.
    ///
    /// # Errors
    /// When there is no such directory; nothing has changed then.
    pub fn change_directory(&mut self, path: Path, storage: &mut impl Storage) -> Result<(), StorageError> {
        storage.list(&path, 0, &mut Vec::new())?;
        self.directory = path;
        Ok(())
    }
}
