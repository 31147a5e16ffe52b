//! Marks in what a session says whose peer is a program: one byte behind the answer to each of its lines,
//! when the line is done, and whether it was refused; and one before news, which answer none of them. Text
//! has none of these bytes.

use core::fmt::{self, Write};

/// The line is done (ACK of ASCII).
pub const DONE: u8 = 0x06;
/// The line is done, and was refused (NAK of ASCII).
pub const REFUSED: u8 = 0x15;

/// What follows, up to the end of its line, is news for everybody and answers no line (BEL of ASCII).
pub const NEWS: u8 = 0x07;

/// State of the marks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Marks {
    /// Whether the session has marks.
    is_on: bool,
    /// Whether a line has been taken and is not answered.
    owes: bool,
    /// Whether it was refused.
    is_refused: bool,
}

impl Marks {
    /// Starts with no answer owed.
    pub(super) const fn new(is_on: bool) -> Self {
        Self { is_on, owes: false, is_refused: false }
    }

    /// Whether the session has marks.
    pub(super) const fn are_on(self) -> bool {
        self.is_on
    }

    /// Notes that a line has been taken.
    pub(super) const fn owe(&mut self) {
        self.owes = true;
    }

    /// Notes that the line is refused.
    pub(super) const fn refuse(&mut self) {
        self.is_refused = true;
    }

    /// Returns the mark that is due, as the line is answered.
    pub(super) const fn settle(&mut self) -> Option<u8> {
        let mark = if self.is_refused { REFUSED } else { DONE };
        let is_due = self.is_on && self.owes;
        (self.owes, self.is_refused) = (false, false);
        if is_due { Some(mark) } else { None }
    }
}

/// Text without marks in it.
pub(super) struct Unmarked<'o, W>(pub(super) &'o mut W);

impl<W: Write> Write for Unmarked<'_, W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let marks = [char::from(DONE), char::from(REFUSED), char::from(NEWS)];
        text.split(marks).try_for_each(|piece| self.0.write_str(piece))
    }
}
