//! A directory's entries as the machine wants them.

use base::ports::{DirectoryEntry, FileAttributes, FileTime};
use card::fat::{Attributes, Name};
use card::volume::Facts;
use heapless::String;

/// The entry with this name.
pub(crate) fn listed(entry: &Facts, name: &Name) -> DirectoryEntry {
    let mut text = String::new();
    for letter in name.chars() {
        // The longest name fits.
        let _fits = text.push(letter);
    }
    let Facts { size_bytes, attributes, written } = *entry;
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
        written: FileTime {
            year: written.year(),
            month: written.month(),
            day: written.day(),
            hour: written.hour(),
            minute: written.minute(),
        },
    }
}
