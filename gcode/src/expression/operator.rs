//! Operators between values: arithmetic, comparisons, logic.

use super::{EQUAL, truth};
use crate::error::Problem;

/// Operator between two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Power,
    Times,
    Over,
    Modulo,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterOrEqual,
    Less,
    LessOrEqual,
    And,
    Or,
    ExclusiveOr,
}

impl Operator {
    /// Returns the operator that a text begins with, in either case, and its length: quicker than a search.
    pub(super) fn at_start(text: &[u8]) -> Option<(Self, usize)> {
        let letter = |at: usize| text.get(at).map_or(0, u8::to_ascii_uppercase);
        Some(match (letter(0), letter(1)) {
            (b'*', b'*') => (Self::Power, 2),
            (b'*', _) => (Self::Times, 1),
            (b'/', _) => (Self::Over, 1),
            (b'+', _) => (Self::Plus, 1),
            (b'-', _) => (Self::Minus, 1),
            (b'E', b'Q') => (Self::Equal, 2),
            (b'N', b'E') => (Self::NotEqual, 2),
            (b'G', b'T') => (Self::Greater, 2),
            (b'G', b'E') => (Self::GreaterOrEqual, 2),
            (b'L', b'T') => (Self::Less, 2),
            (b'L', b'E') => (Self::LessOrEqual, 2),
            (b'O', b'R') => (Self::Or, 2),
            (b'A', b'N') if letter(2) == b'D' => (Self::And, 3),
            (b'M', b'O') if letter(2) == b'D' => (Self::Modulo, 3),
            (b'X', b'O') if letter(2) == b'R' => (Self::ExclusiveOr, 3),
            _ => return None,
        })
    }

    /// Number of different ranks.
    pub(super) const RANKS: usize = 5;

    /// Higher ranks are done first.
    pub(super) const fn rank(self) -> u8 {
        match self {
            Self::Power => 5,
            Self::Times | Self::Over | Self::Modulo => 4,
            Self::Plus | Self::Minus => 3,
            Self::Equal | Self::NotEqual | Self::Greater | Self::GreaterOrEqual | Self::Less | Self::LessOrEqual => 2,
            Self::And | Self::Or | Self::ExclusiveOr => 1,
        }
    }

    pub(super) fn of(self, a: f64, b: f64) -> Result<f64, Problem> {
        let (is_a, is_b) = (a != 0.0, b != 0.0);
        Ok(match self {
            Self::Power if a < 0.0 && libm::floor(b) != b => return Err(Problem::NotFinite),
            Self::Power => {
                let power = libm::pow(a, b);
                if !power.is_finite() {
                    return Err(Problem::NotFinite);
                }
                power
            }
            Self::Times => a * b,
            Self::Over | Self::Modulo if !is_b => return Err(Problem::DivisionByZero),
            Self::Over => a / b,
            Self::Modulo => {
                let rest = libm::fmod(a, b);
                if rest < 0.0 { rest + libm::fabs(b) } else { rest }
            }
            Self::Plus => a + b,
            Self::Minus => a - b,
            Self::Equal => truth(libm::fabs(a - b) < EQUAL),
            Self::NotEqual => truth(libm::fabs(a - b) >= EQUAL),
            Self::Greater => truth(a > b),
            Self::GreaterOrEqual => truth(a >= b),
            Self::Less => truth(a < b),
            Self::LessOrEqual => truth(a <= b),
            Self::And => truth(is_a && is_b),
            Self::Or => truth(is_a || is_b),
            Self::ExclusiveOr => truth(is_a != is_b),
        })
    }
}
