//! A file that is written, through `embedded-sdmmc`. Bytes gather in a block, so that each block goes to the card
//! once however small the pieces are that it is written in.

use embedded_sdmmc::RawFile;
use heapless::Vec;

/// Bytes of a block.
const BLOCK: usize = 512;

/// An open file that may be written to.
pub(crate) struct Written {
    pub raw: RawFile,
    /// What comes at the file's offset, and has not filled its block yet.
    gathered: Vec<u8, BLOCK>,
    /// A write went wrong: the file may have more clusters than it says.
    pub has_failed: bool,
}

impl Written {
    pub const fn new(raw: RawFile) -> Self {
        Self { raw, gathered: Vec::new(), has_failed: false }
    }

    /// Bytes that are not part of the file yet.
    pub fn gathered(&self) -> u32 {
        self.gathered.len() as u32
    }

    /// Takes of these bytes what belongs to the block at this offset of the file: what is to be written now, if
    /// anything, and how many were taken. All of it is written at the offset, and then nothing is gathered.
    pub fn gather<'a>(&'a mut self, offset: u32, bytes: &'a [u8]) -> (Option<&'a [u8]>, usize) {
        let filled = (offset as usize + self.gathered.len()) % BLOCK;
        let taken = bytes.len().min(BLOCK - filled);
        let (piece, _) = bytes.split_at(taken);
        let ends_block = filled + taken == BLOCK;
        if self.gathered.is_empty() && ends_block {
            return (Some(piece), taken);
        }
        // What is gathered and what is taken lie in one block.
        let _fits = self.gathered.extend_from_slice(piece);
        (ends_block.then_some(self.gathered.as_slice()), taken)
    }

    /// What is gathered, to be written now.
    pub fn rest(&self) -> &[u8] {
        &self.gathered
    }

    /// It is written, or lost.
    pub fn forget(&mut self) {
        self.gathered.clear();
    }
}
