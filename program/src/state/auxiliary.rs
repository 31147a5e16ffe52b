//! Modal state beside the path: spindle, coolant, and whether the operator's overrides count.

use gcode::{Code, Letter};

use crate::action::Action;

/// State of the spindle (M3, M4, M5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spindle {
    /// Spindle stopped by M5.
    #[default]
    Stopped,
    /// Clockwise turning of M3.
    Clockwise,
    /// Counter-clockwise turning of M4.
    CounterClockwise,
}

impl Spindle {
    /// Returns the number of the M-code for the state.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::Stopped => 5,
            Self::Clockwise => 3,
            Self::CounterClockwise => 4,
        }
    }

    /// Returns the state that an M-code selects; `None` for any other code.
    pub(crate) const fn of(code: Code) -> Option<Self> {
        match (code.letter, code.number, code.subcode) {
            (Letter::M, 3, 0) => Some(Self::Clockwise),
            (Letter::M, 4, 0) => Some(Self::CounterClockwise),
            (Letter::M, 5, 0) => Some(Self::Stopped),
            _ => None,
        }
    }

    /// Whether both states turn, in opposite directions.
    pub(crate) fn is_against(self, other: Self) -> bool {
        self != Self::Stopped && self.reversed() == other
    }

    /// Returns the opposite direction; a stopped spindle stays stopped.
    #[must_use]
    pub(crate) const fn reversed(self) -> Self {
        match self {
            Self::Stopped => Self::Stopped,
            Self::Clockwise => Self::CounterClockwise,
            Self::CounterClockwise => Self::Clockwise,
        }
    }
}

/// Modes of spindle, coolant and overrides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Auxiliary {
    /// State of the spindle (M3, M4, M5).
    pub spindle: Spindle,
    /// Spindle speed S, kept across M5; `None` leaves the speed to the output's own value.
    pub speed: Option<f32>,
    /// Constant surface speed (G96): S is the surface's speed instead of the spindle's.
    pub surface_speed: bool,
    /// Mist coolant on (M7).
    pub mist: bool,
    /// Flood coolant on (M8).
    pub flood: bool,
    /// Whether the operator's override of feed rates counts (M48 to M50).
    pub feed_override: bool,
    /// Whether the operator's override of spindle speed counts (M48, M49, M51).
    pub spindle_override: bool,
}

impl Auxiliary {
    /// Returns the action that enables or disables overrides as the modes say.
    pub(crate) const fn overrides(&self) -> Action<'static> {
        Action::Overrides { feed: self.feed_override, spindle: self.spindle_override, hold: true }
    }

    /// Modes at boot and after M2.
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
