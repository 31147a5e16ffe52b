//! Options of a section, one after the other, and their values byte by byte.

use base::ports::{Storage, StorageError};
use heapless::String;

use crate::index::{Hash, Index, Section, hash};
use crate::lines::{Begins, Lines};
use crate::scan::Trouble;

/// Longest key of an option, and name of a section, bytes.
const KEY_BYTES: usize = 96;
/// Key of an option, in lower case; name of a section, as it is written.
pub type Name = String<KEY_BYTES>;

/// Options of a section, in the order in which they are written.
pub struct Options<'s, S: Storage> {
    lines: Lines<'s, S>,
    key: Name,
    /// Blanks before the present option; lines behind more of them belong to its value.
    indent: Option<u16>,
    /// Whether the present line has not been read to its end.
    in_line: bool,
    /// Beginning of a line that has been read and belongs to no value.
    begun: Option<Begins>,
    /// The bracket of the next section's header has been read.
    at_header: bool,
}

impl<'s, S: Storage> Options<'s, S> {
    /// Opens a section of the configuration.
    ///
    /// # Errors
    /// Errors of the card; another section stands there than the index knows.
    pub(crate) fn open(index: &Index, section: Section, storage: &'s mut S) -> Result<Self, Trouble> {
        let (file, offset) = index.place(section);
        let lines = Lines::open(storage, index.file(file), offset, true);
        let mut options = Self::of(lines.map_err(|why| Trouble::card(why, file))?);
        let header = options.header().ok_or(Trouble::changed(file))?;
        if options.offsets()[0] != offset || index.find(header).all(|known| known != section) {
            return Err(Trouble::changed(file));
        }
        Ok(options)
    }

    /// Opens a file, and looks for its first section of this name. None: there is no such section.
    ///
    /// # Errors
    /// Errors of the card.
    pub(crate) fn of_file(storage: &'s mut S, path: &str, name: &str) -> Result<Option<Self>, StorageError> {
        let wanted = hash(name.bytes());
        let mut options = Self::of(Lines::open(storage, path, 0, false)?);
        while let Some(header) = options.header() {
            if header == wanted {
                return Ok(Some(options));
            }
        }
        options.error().map_or(Ok(None), Err)
    }

    /// Opens a file at the beginning of a line.
    ///
    /// # Errors
    /// Errors of the card.
    pub(crate) fn scan(storage: &'s mut S, path: &str, offset: u32) -> Result<Self, StorageError> {
        Lines::open(storage, path, offset, true).map(Self::of)
    }

    const fn of(lines: Lines<'s, S>) -> Self {
        Self { lines, key: Name::new(), indent: None, in_line: false, begun: None, at_header: false }
    }

    /// Goes to the next section, reads its header, and returns its name's number.
    pub(crate) fn header(&mut self) -> Option<u32> {
        // Of the options before it nothing is wanted.
        while !self.at_header {
            if !self.go_on() && !self.at_header {
                return None;
            }
        }
        (self.at_header, self.indent) = (false, None);
        self.key.clear();
        let mut hash = Hash::new();
        while let Some(byte) = self.lines.byte() {
            if byte == b']' {
                self.lines.skip();
                return Some(hash.value());
            }
            hash.add(byte);
            // A longer name is none that anybody asks for.
            let _ = self.key.push(char::from(byte));
        }
        None
    }

    /// Returns the offset of the present line in the file, and that of the next one.
    pub(crate) const fn offsets(&self) -> [u32; 2] {
        [self.lines.at, self.lines.offset()]
    }

    /// Goes to the next option. False: there is none.
    pub fn go_on(&mut self) -> bool {
        while !self.at_header {
            if core::mem::take(&mut self.in_line) {
                self.lines.skip();
            }
            let begins = self.begun.take().unwrap_or_else(|| self.lines.begin());
            match begins {
                Begins::End => {
                    self.begun = Some(begins);
                    return false;
                }
                Begins::Blank | Begins::Comment => {}
                Begins::Text { indent } if self.indent.is_some_and(|key| indent > key) => self.in_line = true,
                Begins::Text { indent } => {
                    self.indent = Some(indent);
                    match self.read_key() {
                        Some(true) => return true,
                        Some(false) => {}
                        None => return false,
                    }
                }
            }
        }
        false
    }

    /// Reads a key. None: a header follows; false: the line has no key.
    fn read_key(&mut self) -> Option<bool> {
        self.key.clear();
        while let Some(byte) = self.lines.byte() {
            match byte {
                b'[' if self.key.is_empty() => {
                    self.at_header = true;
                    return None;
                }
                b':' | b'=' => {
                    self.in_line = true;
                    let length = self.key.trim_end().len();
                    self.key.truncate(length);
                    return Some(true);
                }
                // A longer key is none that anybody asks for.
                byte => drop(self.key.push(char::from(byte.to_ascii_lowercase()))),
            }
        }
        Some(false)
    }

    /// Returns the key of the present option.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Returns the name of the section, until an option is read.
    pub fn name(&self) -> &str {
        &self.key
    }

    /// Returns the value of the present option, to be read once.
    pub const fn value(&mut self) -> Value<'_, 's, S> {
        Value { options: self, lines: 0, row: 1, is_begun: false, indent: 0 }
    }

    /// Returns the error of the card that has ended the options.
    pub(crate) const fn error(&self) -> Option<StorageError> {
        self.lines.error()
    }
}

/// Value of an option, byte by byte: of several lines what follows the key's own line, each without the
/// blanks around it.
pub struct Value<'o, 's, S: Storage> {
    options: &'o mut Options<'s, S>,
    /// Ends of lines that count once something follows.
    lines: u16,
    /// Row of the value that is read, from 1.
    row: u16,
    /// Something of the present line was given.
    is_begun: bool,
    /// Blanks before the present line.
    indent: u16,
}

impl<S: Storage> Value<'_, '_, S> {
    /// Takes the next line, if it belongs to the value.
    fn next_line(&mut self) -> bool {
        loop {
            let begins = self.options.lines.begin();
            match begins {
                Begins::Blank => self.lines = self.lines.saturating_add(1),
                Begins::Comment => {}
                Begins::Text { indent } if indent > self.options.indent.unwrap_or(0) => {
                    self.lines = self.lines.saturating_add(1);
                    (self.options.in_line, self.is_begun, self.indent) = (true, false, indent);
                    return true;
                }
                Begins::Text { .. } | Begins::End => {
                    self.options.begun = Some(begins);
                    return false;
                }
            }
        }
    }

    /// Reads on to a row of the value; returns which line that is from the section's first on, and the blanks
    /// before it.
    pub(crate) fn go_to(&mut self, row: u16) -> (u16, u16) {
        while self.row < row && self.next().is_some() {}
        (self.options.lines.number, self.indent)
    }
}

impl<S: Storage> Iterator for Value<'_, '_, S> {
    type Item = u8;

    fn next(&mut self) -> Option<u8> {
        loop {
            if self.lines > 0 && self.options.in_line {
                self.lines -= 1;
                self.row = self.row.saturating_add(1);
                return Some(b'\n');
            }
            if self.options.in_line {
                match self.options.lines.byte() {
                    Some(b' ' | b'\t' | b'\r') if !self.is_begun => continue,
                    Some(byte) => {
                        self.is_begun = true;
                        return Some(byte);
                    }
                    None => self.options.in_line = false,
                }
            }
            if self.options.begun.is_some() || !self.next_line() {
                return None;
            }
        }
    }
}
