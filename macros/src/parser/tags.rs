//! Tags that wait for their ends.

use crate::fault::{Result, Words};
use crate::memory::Memory;
use crate::names::names;

/// Most tags within tags.
const MOST: usize = 16;

names! {
    /// Tags of Jinja2; what Klipper's macros do without is refused.
    Tag:
    If "if" (""), ElseIf "elif" (""), Else "else" (""), EndIf "endif" (""), For "for" (""), EndFor "endfor" (""),
    Set "set" (""), EndSet "endset" (""),
    Refused "macro" or "call" or "include" or "import" or "from" or "extends" or "block" or "filter" or "with"
        or "autoescape" or "print" or "raw" or "do" (""),
}

/// Kind of a tag that waits for its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// No tag: the template itself.
    Template,
    If,
    Else,
    For,
    ForElse,
    Set,
}

/// A tag that waits for its end.
#[derive(Clone, Copy, Debug)]
pub struct Open {
    pub kind: Kind,
    pub was_soft: bool,
    pub place: (u16, u16),
    /// Operand of the jump to what follows this branch; of `set` the code that stores.
    pub branch: u16,
    /// Operands of the jumps to the end, which hang on each other.
    pub ends: u16,
    /// First instruction of each turn; of `set` the length of the code that stores.
    pub again: u16,
}

impl Open {
    const TEMPLATE: Self = Self { kind: Kind::Template, was_soft: false, place: (1, 1), branch: 0, ends: 0, again: 0 };

    /// A tag that begins at a place.
    pub fn new(kind: Kind, place: (u16, u16), was_soft: bool) -> Self {
        Self { kind, place, was_soft, ..Self::TEMPLATE }
    }
}

/// Tags that wait for their ends, one within the other.
pub struct Tags {
    list: [Open; MOST],
    count: usize,
}

impl Tags {
    pub const NONE: Self = Self { list: [Open::TEMPLATE; MOST], count: 0 };

    /// Opens a tag within the innermost one.
    #[inline(never)]
    pub fn push(&mut self, memory: &Memory<'_>, open: Open) -> Result<()> {
        let Some(place) = self.list.get_mut(self.count) else { return memory.fail(Words::TooManyTags) };
        *place = open;
        self.count += 1;
        Ok(())
    }

    /// Takes the innermost tag, or the template itself.
    #[inline(never)]
    pub fn pop(&mut self) -> Open {
        let last = self.last();
        self.count = self.count.saturating_sub(1);
        last
    }

    /// The innermost tag, or the template itself.
    pub fn last(&self) -> Open {
        self.list.get(self.count.wrapping_sub(1)).copied().unwrap_or(Open::TEMPLATE)
    }

    /// Whether a loop is open.
    pub fn has_loop(&self) -> bool {
        self.list.iter().take(self.count).any(|open| open.kind == Kind::For)
    }
}
