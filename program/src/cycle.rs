//! Which canned cycles there are (NIST RS-274/NGC, section 3.5.16, and LinuxCNC's G73 and G74).

use units::{Axis, Plane};

use crate::auxiliary::Spindle;

/// What is done at each hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// G73: peck by peck, drawn back a little after each, so that the chip breaks.
    BreakChips,
    /// G74: as G84, for a left-hand thread.
    TapLeft,
    /// G81: down at once.
    Drill,
    /// G82: down at once, and wait.
    DrillAndDwell,
    /// G83: peck by peck, each followed by a way out to clear the hole.
    Peck,
    /// G84: down, and out at the feed rate as the spindle turns the other way: for a tap in a floating
    /// holder.
    Tap,
    /// G85: down, and out at the feed rate too.
    Bore,
    /// G86: down, wait, and out with the spindle standing.
    BoreAndStop,
    /// G88: down, wait, stop the spindle, and out by the operator's hand.
    BoreByHand,
    /// G89: the same, with a wait at the bottom.
    BoreAndDwell,
}

impl Cycle {
    /// From the number of a G-code.
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

    /// The number of its G-code.
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

    /// It needs a Q.
    pub(crate) const fn pecks(self) -> bool {
        matches!(self, Self::BreakChips | Self::Peck)
    }

    /// It needs a P.
    pub(crate) const fn dwells(self) -> bool {
        matches!(self, Self::DrillAndDwell | Self::BoreAndDwell | Self::BoreAndStop | Self::BoreByHand)
    }

    /// It takes a P.
    pub(crate) const fn may_dwell(self) -> bool {
        self.dwells() || self.pecks() || self.taps()
    }

    /// It goes out at the feed rate as the spindle turns the other way.
    pub(crate) const fn taps(self) -> bool {
        matches!(self, Self::Tap | Self::TapLeft)
    }

    /// The spindle stands on the way out.
    pub(crate) const fn stops_spindle(self) -> bool {
        matches!(self, Self::BoreAndStop | Self::BoreByHand)
    }

    /// How the spindle turns on the way down, where that is not the program's to choose.
    pub(crate) const fn turning(self) -> Option<Spindle> {
        match self {
            Self::Tap => Some(Spindle::Clockwise),
            Self::TapLeft => Some(Spindle::CounterClockwise),
            _ => None,
        }
    }
}

/// Where a cycle leaves a hole to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Retract {
    /// G98: where the axis was before the first cycle of the series, or R where that is further out.
    #[default]
    Initial,
    /// G99: R.
    RPlane,
}

/// The axis that a cycle drills along: the one across the plane.
pub(crate) const fn drilling_axis(plane: Plane) -> Axis {
    match plane {
        Plane::Xy => Axis::Z,
        Plane::Xz => Axis::Y,
        Plane::Yz => Axis::X,
    }
}
