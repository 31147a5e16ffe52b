//! Names on FAT16 and FAT32 volumes: directories are read and changed here, long file names included.
//!
//! Everything works on blocks of 512 bytes through [`Blocks`], allocates nothing, and believes nothing: a
//! damaged volume gives [`Error::Damaged`], never a hang or a panic. Contents of files are not written here,
//! and read only by a [`Reader`].
//!
//! Source: Microsoft Extensible Firmware Initiative FAT32 File System Specification, "FAT: General Overview
//! of On-Disk Format", version 1.03 (below: FAT 1.03), which the SD Physical Layer Specification, Part 2 File
//! System, builds on.
//!
//! # Names
//!
//! A name has at most 255 UTF-16 units. Names are the same without regard to case, and so are found and kept
//! apart; the case they were made with is kept. Case is folded for ASCII and for every other letter of the
//! basic plane that has exactly one capital which has exactly this small letter ([`same_name`]). Every entry
//! is also found by its short name (8.3).
//!
//! # What a power cut leaves
//!
//! A card writes a block whole or not at all. Every change here is ordered such that, whichever write is the
//! last, the volume mounts, no other file has changed, no two names stand for the same clusters, and a name
//! stands for all of its clusters or for none. At worst there are clusters without a name (space that a file
//! system check gives back), pieces of a long name that nothing follows (ignored by everyone, and used again
//! here), and tables of which the second copy is one block behind (everyone reads the first). In detail:
//!
//! - A new entry becomes visible with the one block that holds its short part, written last.
//! - A removed entry disappears with that block, written first; its clusters are freed after.
//! - A directory is whole before its parent names it; a cluster is zeroed before a directory grows by it.
//! - A moved entry changes its place in one write when both places lie in one block. Otherwise a note in the
//!   root directory says that it is under way, and [`Volume::settle`] completes it or takes it back: see the
//!   module `rename`.

mod cursor;
mod disk;
mod entry;
mod entry_slots;
mod geometry;
mod letter_case;
mod lookup;
mod name;
mod reader;
mod rename;
mod short_name;
mod slot;
mod table;
mod volume;

#[cfg(test)]
mod tests;

pub use entry::Entry;
pub(crate) use geometry::LARGER_THAN_PARTITION;
pub use geometry::{Kind, Volume};
pub use lookup::Listing;
pub use name::{Name, is_legal_name, same_name, stripped};
pub use reader::Reader;
pub use slot::{Attributes, Place, Stamp};

/// Bytes of a block.
pub const BLOCK_BYTES: usize = 512;

/// A block of the card.
pub type Block = [u8; BLOCK_BYTES];

/// Device with blocks, counted from the beginning of the card.
pub trait Blocks {
    /// Error of the device.
    type Error;

    /// Reads a block of the device.
    ///
    /// # Errors
    /// The device's own.
    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), Self::Error>;

    /// Writes a block: whole or not at all.
    ///
    /// # Errors
    /// The device's own.
    fn write(&mut self, number: u32, block: &Block) -> Result<(), Self::Error>;
}

/// Failure of an operation on the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The device's own error.
    Device(E),
    /// No FAT16 or FAT32 volume with blocks of 512 bytes; carries a description of the finding.
    NotFat(&'static str),
    /// A chain of clusters loops, ends too soon or leaves the volume, or a directory is longer than FAT
    /// allows.
    Damaged,
    /// No entry has this name.
    NotFound,
    /// An entry has this name already.
    Exists,
    /// A directory, where a file was expected.
    IsDirectory,
    /// A file, where a directory was expected.
    IsFile,
    /// The directory has entries.
    NotEmpty,
    /// The entry is marked read-only.
    ReadOnly,
    /// The name is empty, too long, or has a character that FAT does not allow.
    BadName,
    /// The directory would be moved into itself.
    IntoItself,
    /// No cluster is free.
    Full,
    /// The directory cannot take another entry: the root of a FAT16 volume has a fixed size, every other at
    /// most 65,536 slots.
    DirectoryFull,
}

/// Little-endian bytes at an offset; zero beyond the end.
#[must_use]
pub(crate) fn half(bytes: &[u8], at: usize) -> u16 {
    bytes.get(at..at + 2).and_then(|two| two.try_into().ok()).map_or(0, u16::from_le_bytes)
}

/// As [`half`], four bytes.
#[must_use]
pub(crate) fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from(half(bytes, at)) | u32::from(half(bytes, at + 2)) << 16
}

/// Writes bytes at an offset, all within the slice.
fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    if let Some(place) = bytes.get_mut(at..at + value.len()) {
        place.copy_from_slice(value);
    }
}
