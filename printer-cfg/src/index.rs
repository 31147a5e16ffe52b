//! Index of the sections: where each begins on the card. Names are not kept: sections are known by a number
//! that is made of the name, and the name is compared where the section is read.

use heapless::{String, Vec};

/// Most sections of a configuration with all that it includes.
pub(crate) const MOST_SECTIONS: usize = 256;
/// Most macros that rename what was there.
pub(crate) const MOST_RENAMED: usize = 48;
/// Room for the paths of the files, bytes.
pub(crate) const PATHS_BYTES: usize = 512;
/// Bits of an offset: the largest file has a megabyte.
const OFFSET_BITS: u32 = 20;
/// Largest size of one file, bytes.
pub(crate) const LARGEST_FILE: u32 = 1 << OFFSET_BITS;
/// Most files of a configuration, those included among them.
pub(crate) const MOST_FILES: usize = 64;

/// Number of a section in the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section(pub u16);

/// Facts about a section that are looked for often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// `[gcode_macro ...]`.
    Macro = 1,
    /// `[delayed_gcode ...]`.
    Delayed = 2,
    /// The section has options `variable_...`.
    Variables = 4,
}

/// Place of a section, and its name's number.
#[derive(Clone, Copy, Debug)]
struct Entry {
    hash: u32,
    /// Offset in the file, the file's number, and uses.
    place: u32,
}

/// A name under which what a macro has replaced still goes.
#[derive(Clone, Copy, Debug)]
struct Renamed {
    hash: u32,
    section: u16,
}

/// Sections of the configuration, in the order in which they were read.
#[derive(Debug)]
pub(crate) struct Index {
    entries: Vec<Entry, MOST_SECTIONS>,
    renamed: Vec<Renamed, MOST_RENAMED>,
    /// Paths of the files, each with a line's end.
    paths: String<PATHS_BYTES>,
}

/// Makes a number of a name: letters of either case count the same, and blanks as one.
pub(crate) fn hash(name: impl Iterator<Item = u8>) -> u32 {
    let mut hash = Hash::new();
    name.for_each(|byte| hash.add(byte));
    hash.value()
}

/// The number of a name that comes byte by byte (FNV-1a).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hash {
    value: u32,
    is_blank: bool,
}

impl Hash {
    /// Begins with no byte.
    pub const fn new() -> Self {
        Self { value: 0x811C_9DC5, is_blank: false }
    }

    /// Adds a byte of the name.
    pub fn add(&mut self, byte: u8) {
        if matches!(byte, b' ' | b'\t' | b'\r') {
            self.is_blank = true;
            return;
        }
        if core::mem::take(&mut self.is_blank) {
            self.mix(b' ');
        }
        self.mix(byte.to_ascii_uppercase());
    }

    fn mix(&mut self, byte: u8) {
        self.value = (self.value ^ u32::from(byte)).wrapping_mul(0x0100_0193);
    }

    /// Returns the number of the bytes so far.
    pub const fn value(self) -> u32 {
        self.value
    }
}

impl Index {
    /// No section is known.
    pub const fn new() -> Self {
        Self { entries: Vec::new(), renamed: Vec::new(), paths: String::new() }
    }

    /// Forgets all sections.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.renamed.clear();
        self.paths.clear();
    }

    /// Adds a file; returns its number. None: there is no room.
    pub fn add_file(&mut self, path: &str) -> Option<u8> {
        let number = self.paths.lines().count();
        if number >= MOST_FILES || self.paths.len() + path.len() + 1 > PATHS_BYTES {
            return None;
        }
        // There is room, as was looked.
        let _ = self.paths.push_str(path);
        let _ = self.paths.push('\n');
        Some(number as u8)
    }

    /// Returns the path of a file.
    pub fn file(&self, number: u8) -> &str {
        self.paths.lines().nth(usize::from(number)).unwrap_or("")
    }

    /// Paths of all files.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.paths.lines()
    }

    /// Adds a section. None: there is no room, or it begins too far behind.
    pub fn add(&mut self, hash: u32, file: u8, offset: u32) -> Option<Section> {
        if offset >= LARGEST_FILE {
            return None;
        }
        let number = self.entries.len() as u16;
        self.entries.push(Entry { hash, place: u32::from(file) << OFFSET_BITS | offset }).ok()?;
        Some(Section(number))
    }

    /// Notes a fact about a section.
    pub fn mark(&mut self, section: Section, fact: Use) {
        if let Some(entry) = self.entries.get_mut(usize::from(section.0)) {
            entry.place |= (fact as u32) << (OFFSET_BITS + 6);
        }
    }

    /// Whether a section has a fact.
    pub fn has(&self, section: Section, fact: Use) -> bool {
        self.entry(section).is_some_and(|entry| entry.place >> (OFFSET_BITS + 6) & fact as u32 != 0)
    }

    /// Notes the name under which what a macro has replaced still goes. False: there is no room.
    pub fn rename(&mut self, hash: u32, section: Section) -> bool {
        self.renamed.push(Renamed { hash, section: section.0 }).is_ok()
    }

    /// Returns the macro that has given this name to what it has replaced.
    pub fn renamed(&self, hash: u32) -> Option<Section> {
        self.renamed.iter().rev().find(|renamed| renamed.hash == hash).map(|renamed| Section(renamed.section))
    }

    /// Numbers of sections that a name's number belongs to, the last first: that one counts.
    pub fn find(&self, hash: u32) -> impl Iterator<Item = Section> + '_ {
        let found = move |(_, entry): &(usize, &Entry)| entry.hash == hash;
        self.entries.iter().enumerate().rev().filter(found).map(|(number, _)| Section(number as u16))
    }

    /// Returns the earlier section of the same name, whose options count where this one has none.
    pub fn before(&self, section: Section) -> Option<Section> {
        let hash = self.entry(section)?.hash;
        self.find(hash).find(|other| other.0 < section.0)
    }

    /// Whether no later section has the same name.
    pub fn is_last(&self, section: Section) -> bool {
        self.entry(section).is_some_and(|entry| self.find(entry.hash).next() == Some(section))
    }

    /// Returns the number of a section's file, and its offset there.
    pub fn place(&self, section: Section) -> (u8, u32) {
        let place = self.entry(section).map_or(0, |entry| entry.place);
        ((place >> OFFSET_BITS) as u8 & (MOST_FILES as u8 - 1), place & (LARGEST_FILE - 1))
    }

    /// Returns the number of sections.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    fn entry(&self, section: Section) -> Option<&Entry> {
        self.entries.get(usize::from(section.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_known_in_either_case_and_by_any_blanks() {
        let number = |name: &str| hash(name.bytes());
        assert_eq!(number("gcode_macro  PRINT_START "), number("GCODE_MACRO print_start"));
        assert_ne!(number("gcode_macro A B"), number("gcode_macro AB"));
    }

    #[test]
    fn the_last_section_of_a_name_counts_and_leads_to_the_one_before() {
        let mut index = Index::new();
        let file = index.add_file("/sd/a").unwrap();
        let [first, other, last] = [7, 8, 7].map(|hash| index.add(hash, file, hash * 10).unwrap());
        index.mark(first, Use::Variables);
        assert_eq!(index.find(7).next(), Some(last));
        assert_eq!((index.before(last), index.before(first), index.before(other)), (Some(first), None, None));
        assert!(index.has(first, Use::Variables) && !index.has(last, Use::Variables));
        assert_eq!((index.place(last), index.file(file)), ((file, 70), "/sd/a"));
    }

    #[test]
    fn what_there_is_no_room_for_is_refused() {
        let mut index = Index::new();
        assert_eq!(index.add(1, 0, LARGEST_FILE), None);
        assert!((0..MOST_SECTIONS as u32).all(|hash| index.add(hash, 63, LARGEST_FILE - 1).is_some()));
        assert_eq!(index.add(1, 0, 0), None);
        assert_eq!(index.place(Section(5)), (63, LARGEST_FILE - 1));
        assert!((0..MOST_RENAMED as u32).all(|hash| index.rename(hash, Section(0))) && !index.rename(1, Section(0)));
        assert!((0..MOST_FILES).all(|_| index.add_file("/f").is_some()) && index.add_file("/f").is_none());
    }
}
