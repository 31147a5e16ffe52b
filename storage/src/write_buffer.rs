//! Files that are written, through `embedded-sdmmc`. Bytes gather in a block, so that each block goes to the
//! card once however small the pieces are that it is written in.

use base::ports::FileHandle;
use embedded_sdmmc::RawFile;
use heapless::Vec;

/// Bytes of a block.
const BLOCK: usize = 512;

/// An open file that may be written to.
pub(crate) struct Written {
    pub raw: RawFile,
    /// Whether a write went wrong: the file may have more clusters than it says.
    pub has_failed: bool,
}

/// Bytes of the file written last that do not fill a block yet.
#[derive(Debug, Default)]
pub(crate) struct Gathered {
    file: Option<FileHandle>,
    bytes: Vec<u8, BLOCK>,
}

impl Gathered {
    /// Creates an empty buffer for bytes.
    #[must_use]
    pub const fn new() -> Self {
        Self { file: None, bytes: Vec::new() }
    }

    /// Returns the file whose bytes are gathered, if there are any.
    pub(crate) fn file(&self) -> Option<FileHandle> {
        self.file.filter(|_| !self.bytes.is_empty())
    }

    /// Returns this file's gathered bytes, to be written at the file's offset.
    pub(crate) fn of(&self, file: FileHandle) -> &[u8] {
        if self.file == Some(file) { &self.bytes } else { &[] }
    }

    /// Takes of these bytes what belongs to the block at this offset of the file: what is to be written now,
    /// if anything, and how many were taken. Nothing is gathered of another file.
    pub(crate) fn take<'a>(&'a mut self, file: FileHandle, offset: u32, bytes: &'a [u8]) -> (Option<&'a [u8]>, usize) {
        self.file = Some(file);
        let filled = (offset as usize + self.bytes.len()) % BLOCK;
        let taken = bytes.len().min(BLOCK - filled);
        let (piece, _) = bytes.split_at(taken);
        let ends_block = filled + taken == BLOCK;
        if self.bytes.is_empty() && ends_block {
            return (Some(piece), taken);
        }
        // The gathered and the new bytes lie in one block.
        let _fits = self.bytes.extend_from_slice(piece);
        (ends_block.then_some(self.bytes.as_slice()), taken)
    }

    /// Forgets the bytes, which are written, or lost.
    pub(crate) fn forget(&mut self) {
        self.bytes.clear();
    }
}
