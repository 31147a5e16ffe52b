//! A file or a directory as an operation has found it.

use super::cursor::Cursor;
use super::geometry::Kind;
use super::slot::{Attributes, Place, Slot, Stamp, cluster, short_name};
use super::{Volume, half, word};

/// A file or a directory.
#[derive(Clone, Debug)]
pub struct Entry {
    pub(super) slot: Slot,
    pub(super) place: Place,
    /// First slot of the entry: the beginning of its long name, if it has one.
    pub(super) first: Cursor,
    kind: Kind,
}

impl Entry {
    pub(super) const fn new(volume: &Volume, slot: Slot, place: Place, first: Cursor) -> Self {
        Self { slot, place, first, kind: volume.kind }
    }

    /// Returns the slot with the short name.
    #[must_use]
    pub const fn place(&self) -> Place {
        self.place
    }

    /// Returns the short name: eight bytes and three, filled up with blanks.
    #[must_use]
    pub fn short_name(&self) -> [u8; 11] {
        short_name(&self.slot)
    }

    /// The bits of Windows NT that say which parts of a short name are meant in small letters, as they stand
    /// in the entry.
    #[must_use]
    pub const fn case_bits(&self) -> u8 {
        self.slot[12]
    }

    /// Returns the attribute bits.
    #[must_use]
    pub const fn attributes(&self) -> Attributes {
        Attributes(self.slot[11])
    }

    /// Returns whether the entry is a directory.
    #[must_use]
    pub const fn is_directory(&self) -> bool {
        self.attributes().has(Attributes::DIRECTORY)
    }

    /// Returns the size in bytes; of a directory zero.
    #[must_use]
    pub fn size_bytes(&self) -> u32 {
        word(&self.slot, 28)
    }

    /// Returns the time of the last write.
    #[must_use]
    pub fn written(&self) -> Stamp {
        Stamp { date: half(&self.slot, 24), time: half(&self.slot, 22) }
    }

    /// Returns the first cluster; zero when there is none.
    #[must_use]
    pub fn cluster(&self) -> u32 {
        cluster(&self.slot, self.kind)
    }
}
