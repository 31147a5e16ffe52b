//! Which canned cycles there are (NIST RS-274/NGC, section 3.5.16, and LinuxCNC's G73).

use units::{Axis, Plane};

/// What is done at each hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// G73: peck by peck, drawn back a little after each, so that the chip breaks.
    BreakChips,
    /// G81: down at once.
    Drill,
    /// G82: down at once, and wait.
    DrillAndDwell,
    /// G83: peck by peck, each followed by a way out to clear the hole.
    Peck,
    /// G85: down, and out at the feed rate too.
    Bore,
    /// G89: the same, with a wait at the bottom.
    BoreAndDwell,
}

impl Cycle {
    /// From the number of a G-code.
    #[must_use]
    pub const fn from_g(number: u16) -> Option<Self> {
        Some(match number {
            73 => Self::BreakChips,
            81 => Self::Drill,
            82 => Self::DrillAndDwell,
            83 => Self::Peck,
            85 => Self::Bore,
            89 => Self::BoreAndDwell,
            _ => return None,
        })
    }

    /// The number of its G-code.
    #[must_use]
    pub const fn g(self) -> u16 {
        match self {
            Self::BreakChips => 73,
            Self::Drill => 81,
            Self::DrillAndDwell => 82,
            Self::Peck => 83,
            Self::Bore => 85,
            Self::BoreAndDwell => 89,
        }
    }

    /// It needs a Q.
    pub(crate) const fn pecks(self) -> bool {
        matches!(self, Self::BreakChips | Self::Peck)
    }

    /// It needs a P.
    pub(crate) const fn dwells(self) -> bool {
        matches!(self, Self::DrillAndDwell | Self::BoreAndDwell)
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
