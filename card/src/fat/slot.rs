//! The 32 bytes of a directory's slot (FAT 1.03, "FAT 32 Byte Directory Entry Structure").

use super::geometry::Kind;
use super::{half, put};

/// Bytes of a slot.
pub(super) const SLOT_BYTES: usize = 32;
/// Slots of a block.
pub(super) const SLOTS_PER_BLOCK: u8 = 16;

/// A slot of a directory: an entry, a piece of a long name, or nothing.
pub(super) type Slot = [u8; SLOT_BYTES];

/// First byte of a free slot.
pub(super) const FREE: u8 = 0xE5;
/// First byte of a slot that is free like all that follow.
const END: u8 = 0;

/// Contents of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SlotKind {
    /// Free, like all slots behind it.
    End,
    Free,
    LongName,
    Entry,
}

/// Returns the contents of this slot. The lower six attribute bits tell a piece of a long name (FAT 1.03,
/// ATTR_LONG_NAME_MASK).
pub(super) fn kind_of(slot: &Slot) -> SlotKind {
    match (slot[0], slot[11] & 0x3F) {
        (END, _) => SlotKind::End,
        (FREE, _) => SlotKind::Free,
        (_, 0x0F) => SlotKind::LongName,
        _ => SlotKind::Entry,
    }
}

/// Place of a slot on the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Number of the block.
    pub block: u32,
    /// Index of the slot in the block, 0 to 15.
    pub slot: u8,
}

impl Place {
    /// Offset in the block in bytes.
    #[must_use]
    pub const fn offset_bytes(self) -> u32 {
        self.slot as u32 * SLOT_BYTES as u32
    }
}

/// Attribute bits of an entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes(pub u8);

impl Attributes {
    /// Must not be written or removed.
    pub const READ_ONLY: Self = Self(0x01);
    /// Not listed by DOS.
    pub const HIDDEN: Self = Self(0x02);
    /// Part of an operating system.
    pub const SYSTEM: Self = Self(0x04);
    /// Label of the volume.
    pub const LABEL: Self = Self(0x08);
    /// Directory rather than a file.
    pub const DIRECTORY: Self = Self(0x10);
    /// Changed since the last backup.
    pub const ARCHIVE: Self = Self(0x20);

    /// Whether one of these bits is set.
    #[must_use]
    pub const fn has(self, bits: Self) -> bool {
        self.0 & bits.0 != 0
    }
}

/// A date and a time as an entry has them: years from 1980 to 2107, two-second steps, no time zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Year since 1980 in bits 9 to 15, month in 5 to 8, day in 0 to 4. Zero: none.
    pub date: u16,
    /// Hour in bits 11 to 15, minute in 5 to 10, half the second in 0 to 4.
    pub time: u16,
}

impl Stamp {
    /// Year, 1980 to 2107.
    #[must_use]
    pub const fn year(self) -> u16 {
        1980 + (self.date >> 9)
    }

    /// Month; 0 where there is no date.
    #[must_use]
    pub const fn month(self) -> u8 {
        (self.date >> 5 & 15) as u8
    }

    /// Day of the month; 0 where there is no date.
    #[must_use]
    pub const fn day(self) -> u8 {
        (self.date & 31) as u8
    }

    /// Returns the hour, 0 to 23.
    #[must_use]
    pub const fn hour(self) -> u8 {
        (self.time >> 11) as u8
    }

    /// Returns the minute, 0 to 59.
    #[must_use]
    pub const fn minute(self) -> u8 {
        (self.time >> 5 & 63) as u8
    }
}

pub(super) fn short_name(slot: &Slot) -> [u8; 11] {
    let mut name = [0; 11];
    name.iter_mut().zip(slot).for_each(|(to, from)| *to = *from);
    name
}

/// Returns an entry's first cluster; only FAT32 has the upper half.
pub(super) fn cluster(slot: &Slot, kind: Kind) -> u32 {
    let low = u32::from(half(slot, 26));
    match kind {
        Kind::Fat16 => low,
        Kind::Fat32 => low | u32::from(half(slot, 20)) << 16,
    }
}

pub(super) fn set_cluster(slot: &mut [u8], cluster: u32) {
    put(slot, 20, &((cluster >> 16) as u16).to_le_bytes());
    put(slot, 26, &(cluster as u16).to_le_bytes());
}

/// Sets the times of creation and of the last write.
pub(super) fn set_stamps(slot: &mut [u8], now: Stamp) {
    put(slot, 14, &now.time.to_le_bytes());
    put(slot, 16, &now.date.to_le_bytes());
    put(slot, 18, &now.date.to_le_bytes());
    set_written(slot, now);
}

pub(super) fn set_written(slot: &mut [u8], now: Stamp) {
    put(slot, 22, &now.time.to_le_bytes());
    put(slot, 24, &now.date.to_le_bytes());
}

/// Creates an entry without clusters.
pub(super) fn new_slot(short_name: [u8; 11], case_bits: u8, attributes: Attributes, now: Stamp) -> Slot {
    let mut slot = [0; SLOT_BYTES];
    put(&mut slot, 0, &short_name);
    slot[11] = attributes.0;
    slot[12] = case_bits;
    set_stamps(&mut slot, now);
    slot
}
