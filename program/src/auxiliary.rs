//! Modes beside the path: what turns and flows, and whether the operator's overrides count.

use gcode::{Code, Letter};

use crate::action::Action;

/// How the spindle turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spindle {
    /// M5.
    #[default]
    Stopped,
    /// M3.
    Clockwise,
    /// M4.
    CounterClockwise,
}

impl Spindle {
    /// The number of its M-code.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::Stopped => 5,
            Self::Clockwise => 3,
            Self::CounterClockwise => 4,
        }
    }

    /// What its M-code says; none of any other.
    pub(crate) const fn of(code: Code) -> Option<Self> {
        match (code.letter, code.number, code.subcode) {
            (Letter::M, 3, 0) => Some(Self::Clockwise),
            (Letter::M, 4, 0) => Some(Self::CounterClockwise),
            (Letter::M, 5, 0) => Some(Self::Stopped),
            _ => None,
        }
    }

    /// Whether it turns, and another way than this, which turns too.
    pub(crate) fn is_against(self, other: Self) -> bool {
        self != Self::Stopped && self.reversed() == other
    }

    /// The other way.
    #[must_use]
    pub(crate) const fn reversed(self) -> Self {
        match self {
            Self::Stopped => Self::Stopped,
            Self::Clockwise => Self::CounterClockwise,
            Self::CounterClockwise => Self::Clockwise,
        }
    }
}

/// The modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Auxiliary {
    /// M3, M4, M5.
    pub spindle: Spindle,
    /// S, which M5 keeps; before the first one it turns with its output's own value.
    pub speed: Option<f32>,
    /// G96: S is the speed of the surface, not that of the spindle.
    pub surface_speed: bool,
    /// M7.
    pub mist: bool,
    /// M8.
    pub flood: bool,
    /// M48, M50: the operator's override of feed rates counts.
    pub feed_override: bool,
    /// M48, M51: that of the spindle's speed counts.
    pub spindle_override: bool,
}

impl Auxiliary {
    /// The operator's overrides count as the modes say.
    pub(crate) const fn overrides(&self) -> Action<'static> {
        Action::Overrides { feed: self.feed_override, spindle: self.spindle_override, hold: true }
    }

    /// As at boot, and after M2.
    pub const START: Self = Self {
        spindle: Spindle::Stopped,
        speed: None,
        surface_speed: false,
        mist: false,
        flood: false,
        feed_override: true,
        spindle_override: true,
    };
}
