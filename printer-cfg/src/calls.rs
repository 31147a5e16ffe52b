//! Macros under way: a stack, as macros call each other. The lines of each stand in one buffer, those of the
//! innermost behind those of its caller.

use core::ops::Range;

use base::sessions::Recipient;
use heapless::Vec;

use crate::index::Section;

/// Most macros that are called from each other.
pub const MOST_CALLS: usize = 12;

/// A macro that was rendered, and whose lines are carried out.
#[derive(Clone, Copy, Debug)]
pub struct Call {
    /// Section that it stands in.
    pub section: Section,
    /// Place of its first line in the buffer, of its next one, and of its end.
    pub begins: u16,
    next: u16,
    ends: u16,
    /// Recipient of what its lines say.
    pub to: Recipient,
    /// What the macro has replaced is called by the name it was given: names in the line mean what they mean
    /// without macros.
    pub is_plain: bool,
}

/// Calls that have not ended, the innermost last.
#[derive(Debug)]
pub(crate) struct Calls {
    calls: Vec<Call, MOST_CALLS>,
}

impl Calls {
    /// No macro is under way.
    pub const fn new() -> Self {
        Self { calls: Vec::new() }
    }

    /// Returns the number of calls.
    pub fn len(&self) -> usize {
        self.calls.len()
    }

    /// Whether there is room for one more.
    pub fn has_room(&self) -> bool {
        self.calls.len() < MOST_CALLS
    }

    /// Whether a macro is under way.
    pub fn has(&self, section: Section) -> bool {
        self.calls.iter().any(|call| call.section == section && !call.is_plain)
    }

    /// Returns the place behind the lines of all calls.
    pub fn end(&self) -> usize {
        self.calls.last().map_or(0, |call| usize::from(call.ends))
    }

    /// Adds a call whose lines stand behind those of the others.
    pub fn push(&mut self, section: Section, length: usize, to: Recipient, is_plain: bool) {
        let begins = self.end() as u16;
        // There is room, as the caller has looked.
        let _ = self.calls.push(Call { section, begins, next: begins, ends: begins + length as u16, to, is_plain });
    }

    /// Takes the next line of the innermost call, which is not empty; returns its bounds. None: it has ended.
    pub fn take_line(&mut self, lines: &[u8]) -> Option<Range<usize>> {
        let call = self.calls.last_mut()?;
        next_line(lines, &mut call.next, call.ends)
    }

    /// Returns the innermost call.
    pub fn last(&self) -> Option<Call> {
        self.calls.last().copied()
    }

    /// Ends the calls down to so many.
    pub fn cut(&mut self, count: usize) {
        self.calls.truncate(count);
    }
}

/// Returns the bounds of the next line that is not empty, between these places, and goes on behind it.
pub(crate) fn next_line(lines: &[u8], next: &mut u16, ends: u16) -> Option<Range<usize>> {
    loop {
        let (from, end) = (usize::from(*next), usize::from(ends));
        let rest = lines.get(from..end).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| *byte == b'\n');
        *next += length.map_or(rest.len(), |length| length + 1) as u16;
        let line = rest.get(..length.unwrap_or(rest.len())).unwrap_or(rest);
        let begins = from + (line.len() - line.trim_ascii_start().len());
        let line = line.trim_ascii();
        if !line.is_empty() {
            return Some(begins..begins + line.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_innermost_come_first() {
        let text = b"\n  A 1\n\nB\nC";
        let mut calls = Calls::new();
        calls.push(Section(1), 8, Recipient::All, false);
        assert_eq!(calls.take_line(text), Some(3..6));
        calls.push(Section(2), 3, Recipient::All, false);
        assert!(calls.has(Section(1)) && calls.has(Section(2)) && !calls.has(Section(3)));
        assert_eq!(calls.take_line(text), Some(8..9));
        assert_eq!(calls.take_line(text), Some(10..11));
        assert_eq!(calls.take_line(text), None);
        calls.cut(1);
        assert_eq!(calls.take_line(text), None);
        assert_eq!(calls.end(), 8);
    }
}
