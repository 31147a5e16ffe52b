//! Calls of macros, for whoever has the macros and renders them.

use core::fmt::{self, Write as _};

use base::failure::Failure;
use gcode::{Block, Extended};

/// Name of a macro, cut to fit.
pub type MacroName = heapless::String<24>;

/// A line, or a code of it, that may call a macro.
#[derive(Clone, Copy, Debug)]
pub enum MacroCall<'a> {
    /// A command by name.
    Named(Extended<'a>),
    /// A code with its words.
    Coded(&'a Block<'a>),
}

impl MacroCall<'_> {
    /// Whether a code calls.
    #[must_use]
    pub const fn is_code(&self) -> bool {
        matches!(self, Self::Coded(_))
    }

    /// Returns the name of what is called.
    pub(super) fn name(&self) -> MacroName {
        let mut name = MacroName::new();
        // As much as fits; a code does.
        let _ = match self {
            Self::Named(command) => {
                let whole = command.name();
                name.push_str(whole.get(..whole.floor_char_boundary(name.capacity())).unwrap_or(whole)).is_ok()
            }
            Self::Coded(block) => block.code.is_some_and(|code| write!(name, "{code}").is_ok()),
        };
        name
    }
}

impl fmt::Display for MacroCall<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(command) => f.write_str(command.text()),
            Self::Coded(block) => write!(f, "{block}"),
        }
    }
}

/// Result of a call, and of the wish for the next line of macros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Called {
    /// Nothing: the name is no macro's; all macros have ended.
    Nothing,
    /// A macro, whose lines come next; a line.
    Macro {
        /// Neither does depend on the state of the machine.
        is_sure: bool,
    },
    /// A macro that the machine would refuse at any time.
    Refused(Failure),
    /// A macro that cannot be looked into now.
    Unknown(Failure),
}

/// Place of a line that a macro makes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MacroPlace {
    /// Name of the macro.
    pub name: MacroName,
    /// Number of the line among those that the macro makes, from 1.
    pub row: u16,
}
