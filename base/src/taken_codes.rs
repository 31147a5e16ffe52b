//! Codes that a feature has taken for its own, as far as every line has to know it.

use gcode::{Code, Letter};

/// Which codes a feature has to be asked about. One byte: every line looks at it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TakenCodes {
    /// No code is taken.
    #[default]
    None,
    /// Codes are taken, but none of G0 to G3, of which most lines are.
    ButMoves,
    /// Any code may be taken.
    Any,
}

impl TakenCodes {
    /// Whether a feature has to be asked about a code.
    #[must_use]
    pub const fn may_have(self, code: Code) -> bool {
        match self {
            Self::None => false,
            Self::ButMoves => !is_move(code),
            Self::Any => true,
        }
    }
}

/// Whether a code is one of G0 to G3.
#[must_use]
pub const fn is_move(code: Code) -> bool {
    matches!(code.letter, Letter::G) && code.number <= 3 && code.subcode == 0
}
