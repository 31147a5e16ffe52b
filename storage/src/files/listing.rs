//! A directory's entries as the machine wants them.

use base::ports::{DirectoryEntry, FileAttributes, FileFacts, FileTime, PATH_BYTES};
use card::fat::{Attributes, Name, Place, Stamp};
use card::volume::{Facts, Listing};
use heapless::String;

/// A directory that is being listed, so that its next entries are found without reading it from its
/// beginning, and those that were found last as well.
#[derive(Debug)]
pub(super) struct Listed {
    pub path: String<PATH_BYTES>,
    /// Numbers of entries that were passed, and where it goes on behind them: before what was found last, and
    /// behind it.
    pub places: [(usize, Listing); 2],
}

/// The entry with this name.
pub(super) fn listed(entry: &Facts, name: &Name) -> DirectoryEntry {
    let mut text = String::new();
    for letter in name.chars() {
        // The longest name fits.
        let _fits = text.push(letter);
    }
    let Facts { size_bytes, attributes, written, .. } = *entry;
    let is_directory = attributes.has(Attributes::DIRECTORY);
    DirectoryEntry {
        name: text,
        size_bytes: if is_directory { 0 } else { size_bytes },
        is_directory,
        attributes: FileAttributes {
            read_only: attributes.has(Attributes::READ_ONLY),
            hidden: attributes.has(Attributes::HIDDEN),
            system: attributes.has(Attributes::SYSTEM),
            archive: attributes.has(Attributes::ARCHIVE),
        },
        written: time_of(written),
    }
}

/// The properties of an entry at this place.
pub(super) fn facts_of(entry: &Facts, place: Place) -> FileFacts {
    let Facts { size_bytes, attributes, written, .. } = *entry;
    let numbers = [
        u32::from(written.date) << 16 | u32::from(written.time),
        size_bytes,
        place.block,
        u32::from(place.slot),
        entry.first,
    ];
    // FNV-1a: entries that differ have different numbers, mostly, and nobody gains by making them alike.
    let tag = numbers
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .fold(0xCBF2_9CE4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3));
    let is_directory = attributes.has(Attributes::DIRECTORY);
    FileFacts {
        size_bytes: if is_directory { 0 } else { size_bytes },
        is_directory,
        is_read_only: attributes.has(Attributes::READ_ONLY),
        written: time_of(written),
        tag,
    }
}

fn time_of(written: Stamp) -> FileTime {
    FileTime {
        year: written.year(),
        month: written.month(),
        day: written.day(),
        hour: written.hour(),
        minute: written.minute(),
    }
}
