//! Macros that a look ahead at a file has entered. Their lines stand at the end of the buffer, those of the
//! innermost first, as long as macros under way leave them there: they have the buffer first.

use core::ops::Range;

use heapless::Vec;

use crate::calls::{MOST_CALLS, next_line};
use crate::index::Section;

/// A macro that was entered: its name, a line's end, its lines.
#[derive(Clone, Copy, Debug)]
struct Entered {
    section: Section,
    begins: u16,
    next: u16,
    ends: u16,
    is_plain: bool,
    is_sure: bool,
}

/// A line of a macro that was entered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LookedAt {
    /// Bounds of the line in the buffer.
    pub line: Range<usize>,
    /// Bounds of the macro's name.
    pub name: Range<usize>,
    /// Number of the line among those that the macro makes, from 1.
    pub row: u16,
    /// The line does not depend on the state of the machine.
    pub is_sure: bool,
}

/// Macros entered by a look ahead, the innermost last.
#[derive(Debug)]
pub struct Looks {
    entered: Vec<Entered, MOST_CALLS>,
    /// Macros under way have taken the memory.
    is_lost: bool,
    /// The file has changed variables, which is not followed.
    pub changes_variables: bool,
}

impl Looks {
    /// No macro was entered.
    pub(crate) const fn new() -> Self {
        Self { entered: Vec::new(), is_lost: false, changes_variables: false }
    }

    /// Forgets all, for another file.
    pub fn clear(&mut self) {
        self.entered.clear();
        (self.is_lost, self.changes_variables) = (false, false);
    }

    /// Drops the macros that were entered, as their lines are gone.
    pub fn lose(&mut self) {
        self.is_lost |= !self.entered.is_empty();
        self.entered.clear();
    }

    /// Whether the macros were dropped since this was asked last.
    pub const fn take_lost(&mut self) -> bool {
        core::mem::replace(&mut self.is_lost, false)
    }

    /// Drops the macros whose lines do not end before the lines of macros under way.
    pub(crate) fn give_way(&mut self, end: usize) {
        if self.entered.last().is_some_and(|innermost| end > usize::from(innermost.begins)) {
            self.lose();
        }
    }

    /// Returns the end of the room that is left before the lines, in a buffer of this length.
    #[must_use]
    pub fn room_ends(&self, length: usize) -> usize {
        self.entered.last().map_or(length, |innermost| usize::from(innermost.begins))
    }

    /// Whether there is room for one more.
    #[must_use]
    pub fn may_enter(&self) -> bool {
        !self.entered.is_full()
    }

    /// Whether a macro was entered and has not ended.
    #[must_use]
    pub fn has(&self, section: Section) -> bool {
        self.entered.iter().any(|entered| entered.section == section && !entered.is_plain)
    }

    /// Whether names in the innermost macro mean what they mean without macros.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.entered.last().is_some_and(|innermost| innermost.is_plain)
    }

    /// Whether the lines so far do not depend on the state of the machine.
    #[must_use]
    pub fn are_sure(&self) -> bool {
        self.entered.last().is_none_or(|innermost| innermost.is_sure)
    }

    /// Enters a macro whose name, of this length, and lines stand between these places.
    pub fn enter(&mut self, section: Section, place: Range<usize>, name: usize, (is_plain, is_sure): (bool, bool)) {
        let (begins, ends) = (place.start as u16, place.end as u16);
        let next = begins.saturating_add(name as u16 + 1);
        let is_sure = is_sure && self.are_sure();
        // There is room, as the caller has looked.
        let _ = self.entered.push(Entered { section, begins, next, ends, is_plain, is_sure });
    }

    /// Takes the next line; macros without one have ended. None: all have.
    pub fn take_line(&mut self, lines: &[u8]) -> Option<LookedAt> {
        while let Some(innermost) = self.entered.last_mut() {
            let begins = usize::from(innermost.begins);
            if let Some(line) = next_line(lines, &mut innermost.next, innermost.ends) {
                let is_end = |byte: &&u8| **byte == b'\n';
                let before = lines.get(begins..line.start).unwrap_or(&[]);
                let name = before.iter().position(|byte| *byte == b'\n').unwrap_or(0);
                let row = before.iter().filter(is_end).count() as u16;
                return Some(LookedAt { line, name: begins..begins + name, row, is_sure: innermost.is_sure });
            }
            self.entered.pop();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_innermost_come_first_with_their_number_and_name() {
        let text = b"......IN\nX\nOUTER\n\n  A 1\n\nB";
        let mut looks = Looks::new();
        assert_eq!(looks.room_ends(text.len()), text.len());
        looks.enter(Section(1), 11..text.len(), 5, (false, true));
        let first = looks.take_line(text).unwrap();
        assert_eq!(
            (&text[first.line], &text[first.name], first.row, first.is_sure),
            (&b"A 1"[..], &b"OUTER"[..], 2, true)
        );
        assert_eq!(looks.room_ends(text.len()), 11);
        looks.enter(Section(2), 6..11, 2, (false, false));
        assert!(looks.has(Section(1)) && looks.has(Section(2)) && !looks.has(Section(3)));
        let inner = looks.take_line(text).unwrap();
        assert_eq!((&text[inner.line], &text[inner.name], inner.row, inner.is_sure), (&b"X"[..], &b"IN"[..], 1, false));
        let last = looks.take_line(text).unwrap();
        assert_eq!((&text[last.line], last.row, last.is_sure), (&b"B"[..], 4, true));
        assert_eq!((looks.take_line(text), looks.may_enter()), (None, true));
    }

    #[test]
    fn macros_under_way_take_the_memory() {
        let mut looks = Looks::new();
        looks.enter(Section(1), 50..100, 1, (true, true));
        assert!(looks.is_plain() && !looks.has(Section(1)), "what has been replaced is no call of the macro");
        looks.give_way(50);
        assert!(!looks.take_lost());
        looks.give_way(51);
        assert!(looks.take_lost() && !looks.take_lost() && looks.room_ends(100) == 100);
        looks.lose();
        assert!(!looks.take_lost(), "there was nothing to lose");
    }
}
