//! Lines of a configuration file as Klipper reads them: `#` begins a comment anywhere, `;` behind a blank or
//! at the beginning, blanks around a line do not count, and lines of the block that `SAVE_CONFIG` has
//! written begin with `#*#`.

use base::ports::{Storage, StorageError};
use heapless::Vec;

use crate::bytes::Bytes;

/// Blanks within a line that stay as they are; more become spaces.
const MOST_BLANKS: usize = 16;

/// Beginning of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begins {
    /// The file ends here.
    End,
    /// The line is empty, or nothing but a `#` comment: it counts as an empty line of a value.
    Blank,
    /// The line is a `;` comment, which does not count at all.
    Comment,
    /// There is something in it, behind so many blanks.
    Text { indent: u16 },
}

/// Lines of a file.
pub(crate) struct Lines<'s, S: Storage> {
    bytes: Bytes<'s, S>,
    /// Whether `#` and `;` within a line begin a comment.
    cuts_comments: bool,
    /// Number of the present line, from 1 where reading began, and its offset in the file.
    pub number: u16,
    pub at: u32,
    /// Blanks that count only when something follows, and how many of them were given.
    blanks: Vec<u8, MOST_BLANKS>,
    given: usize,
    spaces: u16,
    /// The byte that follows the blanks.
    held: Option<u8>,
}

impl<'s, S: Storage> Lines<'s, S> {
    /// Opens a file at the offset of a line.
    pub fn open(storage: &'s mut S, path: &str, offset: u32, cuts_comments: bool) -> Result<Self, StorageError> {
        let bytes = Bytes::open(storage, path, offset)?;
        Ok(Self { bytes, cuts_comments, number: 0, at: offset, blanks: Vec::new(), given: 0, spaces: 0, held: None })
    }

    /// Returns the offset of the next byte in the file.
    pub const fn offset(&self) -> u32 {
        self.bytes.offset()
    }

    /// Returns the error of the card that has ended the lines.
    pub const fn error(&self) -> Option<StorageError> {
        self.bytes.error
    }

    /// Begins the next line: takes its blanks, and what makes it none.
    pub fn begin(&mut self) -> Begins {
        (self.number, self.at) = (self.number.saturating_add(1), self.bytes.offset());
        self.blanks.clear();
        (self.given, self.spaces, self.held) = (0, 0, None);
        let mut indent = 0;
        loop {
            match self.bytes.peek() {
                None => return Begins::End,
                Some(b'\n') => {
                    self.bytes.take();
                    return Begins::Blank;
                }
                Some(b' ' | b'\t' | b'\r') => {
                    self.bytes.take();
                    indent += 1;
                }
                Some(b'#') => {
                    if self.is_saved() {
                        indent = 0;
                        continue;
                    }
                    self.skip();
                    return Begins::Blank;
                }
                Some(b';') => {
                    self.skip();
                    return Begins::Comment;
                }
                Some(_) => return Begins::Text { indent },
            }
        }
    }

    /// Takes `#*#` and the blank behind it. False, and a part of it may be gone, where the line has none.
    fn is_saved(&mut self) -> bool {
        for wanted in *b"#*#" {
            if self.bytes.peek() != Some(wanted) {
                return false;
            }
            self.bytes.take();
        }
        if self.bytes.peek() == Some(b' ') {
            self.bytes.take();
        }
        true
    }

    /// Skips the rest of the line, and its end.
    pub fn skip(&mut self) {
        while !matches!(self.bytes.take(), None | Some(b'\n')) {}
    }

    /// Gives the next byte of the line. None at its end, which is taken.
    pub fn byte(&mut self) -> Option<u8> {
        if let Some(blank) = self.blanks.get(self.given).copied().filter(|_| self.held.is_some()) {
            self.given += 1;
            return Some(blank);
        }
        if self.held.is_some() && self.spaces > 0 {
            self.spaces -= 1;
            return Some(b' ');
        }
        if let Some(held) = self.held.take() {
            self.blanks.clear();
            self.given = 0;
            return Some(held);
        }
        loop {
            match self.bytes.take()? {
                b'\n' => return None,
                b'#' if self.cuts_comments => break,
                b';' if self.cuts_comments && !self.blanks.is_empty() => break,
                blank @ (b' ' | b'\t' | b'\r') => {
                    if self.blanks.push(blank).is_err() {
                        self.spaces = self.spaces.saturating_add(1);
                    }
                }
                byte if self.blanks.is_empty() => return Some(byte),
                byte => {
                    self.held = Some(byte);
                    return self.byte_of_blanks();
                }
            }
        }
        self.skip();
        None
    }

    fn byte_of_blanks(&mut self) -> Option<u8> {
        self.given = 1;
        self.blanks.first().copied()
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;
    use std::vec::Vec;

    use super::*;
    use crate::test_card::Card;

    /// Returns what is left of each line; none where it counts for nothing.
    fn read(text: &str, cuts_comments: bool) -> Vec<Option<String>> {
        let mut card = Card::with(&[("/sd/a", text)]);
        let mut lines = Lines::open(&mut card, "/sd/a", 0, cuts_comments).unwrap();
        let mut all = Vec::new();
        loop {
            match lines.begin() {
                Begins::End => return all,
                Begins::Blank => all.push(Some(String::new())),
                Begins::Comment => all.push(None),
                Begins::Text { .. } => {
                    let bytes: Vec<u8> = core::iter::from_fn(|| lines.byte()).collect();
                    all.push(Some(String::from_utf8(bytes).unwrap()));
                }
            }
        }
    }

    #[test]
    fn comments_and_blanks_are_cut_as_klipper_cuts_them() {
        let text = "a: 1 # no\n\n# no\n; no\n  b; c ;no\r\nd   e\t f  \n#*# g = 1\nlast";
        let all: Vec<_> = read(text, true).into_iter().map(|line| line.unwrap_or_else(|| "-".into())).collect();
        assert_eq!(all, ["a: 1", "", "", "-", "b; c", "d   e\t f", "g = 1", "last"]);
    }

    #[test]
    fn a_file_of_saved_variables_has_no_comments_within_its_lines() {
        assert_eq!(read("a = 'x # y ; z'\n", false), [Some("a = 'x # y ; z'".into())]);
    }

    #[test]
    fn many_blanks_stay_as_many() {
        let text = std::format!("a{}b", " ".repeat(40));
        assert_eq!(read(&text, true), [Some(text.clone())]);
    }
}
