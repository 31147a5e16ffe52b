//! Kinds of canned cycles (NIST RS-274/NGC, section 3.5.16, and LinuxCNC's G73 and G74).

use units::{Axis, Plane};

use crate::state::auxiliary::Spindle;

/// Canned cycle, done at each hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// G73: drilling in pecks, drawn back a little after each to break the chip.
    BreakChips,
    /// G74: tapping as G84, for a left-hand thread.
    TapLeft,
    /// G81: drilling in a single pass.
    Drill,
    /// G82: drilling in a single pass, with a dwell at the bottom.
    DrillAndDwell,
    /// G83: drilling in pecks, drawn out of the hole after each to clear chips.
    Peck,
    /// G84: tapping with a floating holder, out at the feed rate with the spindle reversed.
    Tap,
    /// G85: boring, in and out at the feed rate.
    Bore,
    /// G86: boring with a dwell, out with the spindle stopped.
    BoreAndStop,
    /// G88: boring with a dwell and a spindle stop, out by the operator's hand.
    BoreByHand,
    /// G89: boring as G85, with a dwell at the bottom.
    BoreAndDwell,
}

impl Cycle {
    /// Returns the cycle of a G-code's number.
    #[must_use]
    pub const fn from_g(number: u16) -> Option<Self> {
        Some(match number {
            73 => Self::BreakChips,
            74 => Self::TapLeft,
            81 => Self::Drill,
            82 => Self::DrillAndDwell,
            83 => Self::Peck,
            84 => Self::Tap,
            85 => Self::Bore,
            86 => Self::BoreAndStop,
            88 => Self::BoreByHand,
            89 => Self::BoreAndDwell,
            _ => return None,
        })
    }

    /// Returns the number of the cycle's G-code.
    #[must_use]
    pub const fn g(self) -> u16 {
        match self {
            Self::BreakChips => 73,
            Self::TapLeft => 74,
            Self::Drill => 81,
            Self::DrillAndDwell => 82,
            Self::Peck => 83,
            Self::Tap => 84,
            Self::Bore => 85,
            Self::BoreAndStop => 86,
            Self::BoreByHand => 88,
            Self::BoreAndDwell => 89,
        }
    }

    /// Whether the cycle needs a Q word, the depth of a peck.
    pub(crate) const fn pecks(self) -> bool {
        matches!(self, Self::BreakChips | Self::Peck)
    }

    /// Whether the cycle needs a P word, the dwell.
    pub(crate) const fn dwells(self) -> bool {
        matches!(self, Self::DrillAndDwell | Self::BoreAndDwell | Self::BoreAndStop | Self::BoreByHand)
    }

    /// Whether the cycle accepts a P word, the dwell.
    pub(crate) const fn may_dwell(self) -> bool {
        self.dwells() || self.pecks() || self.taps()
    }

    /// Whether the cycle taps: out at the feed rate, with the spindle reversed.
    pub(crate) const fn taps(self) -> bool {
        matches!(self, Self::Tap | Self::TapLeft)
    }

    /// Whether the spindle stands still on the way out.
    pub(crate) const fn stops_spindle(self) -> bool {
        matches!(self, Self::BoreAndStop | Self::BoreByHand)
    }

    /// Returns the spindle's direction on the way down; `None` leaves the direction to the program.
    pub(crate) const fn turning(self) -> Option<Spindle> {
        match self {
            Self::Tap => Some(Spindle::Clockwise),
            Self::TapLeft => Some(Spindle::CounterClockwise),
            _ => None,
        }
    }
}

/// Height to which a cycle leaves a hole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Retract {
    /// G98: height of the axis before the first cycle of the series, or R when R is further out.
    #[default]
    Initial,
    /// G99: height of the R word.
    RPlane,
}

/// Returns the axis that a cycle drills along: the axis across the plane.
pub(crate) const fn drilling_axis(plane: Plane) -> Axis {
    match plane {
        Plane::Xy => Axis::Z,
        Plane::Xz => Axis::Y,
        Plane::Yz => Axis::X,
    }
}
