//! Index, calls and delayed G-code together, and the memory that macros are rendered in.

use base::ports::Storage;
use base::sessions::Recipient;

use crate::calls::{Call, Calls};
use crate::delayed::Delayed;
use crate::index::{Index, Section, Use, hash};
use crate::looks::Looks;
use crate::option::{Name, Options};
use crate::scan::{self, Loaded, Trouble};
use crate::variables::Variables;

/// Longest value that is read whole, bytes: a variable, an option that a macro asks for.
pub const SCRATCH: usize = 1024;

/// Room for code, values and stack of a macro, bytes.
pub const CODE_BYTES: usize = 28 * 1024;
/// Room for the lines of all macros under way, bytes.
pub const LINES_BYTES: usize = 11 * 1024;

/// Memory of macros.
#[derive(Debug)]
pub struct Memory<'m> {
    /// Code, values and stack of the macro that is rendered; nothing is in it in between.
    pub code: &'m mut [u8],
    /// Lines of all macros under way.
    pub lines: &'m mut [u8],
    /// Text that was read last.
    pub text: &'m mut Scratch,
    /// Variables that were changed since the configuration was read.
    pub variables: &'m mut Variables,
    /// Contents of the configuration that are known, and changes of them.
    pub store: &'m mut Store,
}

/// A text that was read whole.
#[derive(Debug)]
pub struct Scratch {
    bytes: [u8; SCRATCH],
    len: usize,
    is_cut: bool,
}

impl Scratch {
    /// Makes a text without any byte.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; SCRATCH], len: 0, is_cut: false }
    }

    /// Takes a text in place of the one before. False: it is too long, and cut.
    pub fn fill(&mut self, text: impl Iterator<Item = u8>) -> bool {
        (self.len, self.is_cut) = (0, false);
        text.for_each(|byte| self.push(byte));
        !self.is_cut
    }

    /// Adds a byte, if there is room.
    pub fn push(&mut self, byte: u8) {
        match self.bytes.get_mut(self.len) {
            Some(place) => (*place, self.len) = (byte, self.len + 1),
            None => self.is_cut = true,
        }
    }

    /// Whether something did not fit.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Returns the bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }

    /// Returns the text; none if it is not Unicode.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        core::str::from_utf8(self.bytes()).ok()
    }
}

impl Default for Scratch {
    fn default() -> Self {
        Self::new()
    }
}

impl core::fmt::Write for Scratch {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        text.bytes().for_each(|byte| self.push(byte));
        Ok(())
    }
}

/// Contents of the configuration on the card, and the macros under way. All zero at first.
#[derive(Debug)]
pub struct Store {
    index: Index,
    calls: Calls,
    delayed: Delayed,
    looks: Looks,
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

impl Store {
    /// Nothing is known.
    #[must_use]
    pub const fn new() -> Self {
        Self { index: Index::new(), calls: Calls::new(), delayed: Delayed::new(), looks: Looks::new() }
    }

    // --- sections ---

    /// Reads a configuration anew. The caller forgets the variables that were changed.
    pub fn reload<S: Storage>(&mut self, storage: &mut S, path: &str, now_us: u64) -> Loaded {
        self.looks.lose();
        scan::scan((&mut self.index, &mut self.delayed), storage, path, now_us)
    }

    /// Returns the path of the file that has trouble.
    #[must_use]
    pub fn path_of(&self, trouble: &Trouble) -> &str {
        self.index.file(trouble.file)
    }

    /// Returns the path of the file that a section stands in.
    #[must_use]
    pub fn file_of(&self, section: Section) -> &str {
        self.index.file(self.index.place(section).0)
    }

    /// Returns the path of the configuration itself.
    #[must_use]
    pub fn main_file(&self) -> &str {
        self.index.file(0)
    }

    /// Returns the number of sections.
    #[must_use]
    pub fn sections(&self) -> usize {
        self.index.len()
    }

    /// Returns the section of a name; of several the last.
    #[must_use]
    pub fn section(&self, name: &str) -> Option<Section> {
        self.index.find(hash(name.bytes())).next()
    }

    /// Returns the section of a kind and a name: `gcode_macro`, `PRINT_START`.
    #[must_use]
    pub fn named(&self, kind: &str, name: &str) -> Option<Section> {
        self.index.find(hash(kind.bytes().chain([b' ']).chain(name.bytes()))).next()
    }

    /// Returns the macro that has given this name to what it has replaced.
    #[must_use]
    pub fn renamed(&self, name: &str) -> Option<Section> {
        self.index.renamed(hash(name.bytes()))
    }

    /// Whether a section, or an earlier one of its name, has a fact.
    #[must_use]
    pub fn has(&self, section: Section, fact: Use) -> bool {
        let mut next = Some(section);
        while let Some(section) = next {
            if self.index.has(section, fact) {
                return true;
            }
            next = self.index.before(section);
        }
        false
    }

    /// Whether an earlier section has the same name.
    #[must_use]
    pub fn is_repeated(&self, section: Section) -> bool {
        self.index.before(section).is_some()
    }

    /// Returns the macro of a number, counted from 0 in the order of the configuration. Of sections with the
    /// same name the last one is counted.
    #[must_use]
    pub fn macro_at(&self, number: u16) -> Option<Section> {
        let all = (0..self.index.len()).map(|place| Section(place as u16));
        let mut macros = all.filter(|section| self.index.has(*section, Use::Macro) && self.index.is_last(*section));
        macros.nth(usize::from(number))
    }

    /// Opens a section; its name is the key until the first option is read.
    ///
    /// # Errors
    /// Errors of the card; the file has changed.
    pub fn open<'s, S: Storage>(&self, section: Section, storage: &'s mut S) -> Result<Options<'s, S>, Trouble> {
        Options::open(&self.index, section, storage)
    }

    /// Reads an option, in a section or in an earlier one of its name. False: there is none; nothing is read.
    ///
    /// # Errors
    /// Errors of the card; the file has changed.
    pub fn read<S: Storage, R>(
        &self,
        (section, key): (Section, &str),
        storage: &mut S,
        read: impl FnOnce(&mut dyn Iterator<Item = u8>) -> R,
    ) -> Result<Option<R>, Trouble> {
        let mut next = Some(section);
        while let Some(section) = next {
            let mut options = self.open(section, storage)?;
            let mut is_there = false;
            while !is_there && options.go_on() {
                is_there = options.key() == key;
            }
            if is_there {
                let result = read(&mut options.value());
                return options
                    .error()
                    .map_or(Ok(Some(result)), |why| Err(Trouble::card(why, self.file_number(section))));
            }
            if let Some(why) = options.error() {
                return Err(Trouble::card(why, self.file_number(section)));
            }
            next = self.index.before(section);
        }
        Ok(None)
    }

    fn file_number(&self, section: Section) -> u8 {
        self.index.place(section).0
    }

    /// Returns the section that an option's value counts from.
    fn with_option<S: Storage>(&self, section: Section, key: &str, storage: &mut S) -> Option<Section> {
        let mut next = Some(section);
        while let Some(section) = next {
            let mut options = self.open(section, storage).ok()?;
            while options.go_on() {
                if options.key() == key {
                    return Some(section);
                }
            }
            next = self.index.before(section);
        }
        None
    }

    /// Returns the file, the line there and the blanks before it of a row of an option's value, rows from 1.
    pub fn line_of<S: Storage>(&self, section: Section, key: &str, row: u16, storage: &mut S) -> (&str, u16, u16) {
        let section = self.with_option(section, key, storage).unwrap_or(section);
        let (file, offset) = self.index.place(section);
        let path = self.index.file(file);
        let (mut line, mut indent) = (1, 0);
        if let Ok(mut options) = self.open(section, storage) {
            while options.go_on() {
                if options.key() == key {
                    (line, indent) = options.value().go_to(row);
                    break;
                }
            }
        }
        (path, line_at(storage, path, offset).saturating_add(line - 1), indent)
    }

    // --- calls ---

    /// Whether a macro is under way.
    #[must_use]
    pub fn is_called(&self, section: Section) -> bool {
        self.calls.has(section)
    }

    /// Returns the number of macros under way.
    #[must_use]
    pub fn calls(&self) -> usize {
        self.calls.len()
    }

    /// Whether there is room for one more macro under way.
    #[must_use]
    pub fn may_call(&self) -> bool {
        self.calls.has_room()
    }

    /// Returns the place behind the lines of all macros under way.
    #[must_use]
    pub fn lines_end(&self) -> usize {
        self.calls.end()
    }

    /// Adds a macro whose lines have been written behind those of the others.
    ///
    /// `is_plain`: names in them mean what they mean without macros.
    pub fn call(&mut self, section: Section, length: usize, to: Recipient, is_plain: bool) {
        self.calls.push(section, length, to, is_plain);
        self.looks.give_way(self.calls.end());
    }

    /// Returns the macros that a look ahead has entered.
    pub const fn looks(&mut self) -> &mut Looks {
        &mut self.looks
    }

    /// Takes the next line of the innermost macro; returns its bounds. None: it has ended.
    pub fn take_line(&mut self, lines: &[u8]) -> Option<core::ops::Range<usize>> {
        self.calls.take_line(lines)
    }

    /// Returns the innermost macro.
    #[must_use]
    pub fn innermost(&self) -> Option<Call> {
        self.calls.last()
    }

    /// Ends the macros under way down to so many.
    pub fn end_calls(&mut self, down_to: usize) {
        self.calls.cut(down_to);
    }

    // --- delayed G-code ---

    /// Sets when G-code is due; never if there is no time. False: too much of it waits.
    pub fn delay(&mut self, section: Section, due_us: Option<u64>) -> bool {
        self.delayed.set(section, due_us)
    }

    /// Whether G-code is due.
    #[must_use]
    pub fn is_due(&self, now_us: u64) -> bool {
        self.delayed.is_due(now_us)
    }

    /// Takes the G-code that has been due for longest.
    pub fn take_due(&mut self, now_us: u64) -> Option<Section> {
        self.delayed.take(now_us)
    }
}

/// Returns the number of the line that begins at an offset.
fn line_at<S: Storage>(storage: &mut S, path: &str, offset: u32) -> u16 {
    let Ok(mut bytes) = crate::bytes::Bytes::open(storage, path, 0) else { return 0 };
    let mut line: u16 = 1;
    while bytes.offset() < offset {
        match bytes.take() {
            Some(byte) => line = line.saturating_add(u16::from(byte == b'\n')),
            None => break,
        }
    }
    line
}

/// Returns the name behind the kind in a section's header: of `gcode_macro PRINT_START` the second word.
pub(crate) fn name_in(header: &str) -> &str {
    header.split_once([' ', '\t']).map_or(header, |(_, name)| name.trim())
}

impl Store {
    /// Reads the name of a section, without its kind.
    ///
    /// # Errors
    /// Errors of the card; the file has changed.
    pub fn name<S: Storage>(&self, section: Section, storage: &mut S) -> Result<Name, Trouble> {
        let options = self.open(section, storage)?;
        Ok(Name::try_from(name_in(options.name())).unwrap_or_default())
    }
}
