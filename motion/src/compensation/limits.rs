//! Limits of what a compensation may be, and the error of one beyond them.

use units::MOST_SIDE;

/// Most points of a grid.
pub const MOST_POINTS: usize = MOST_SIDE * MOST_SIDE;
/// The least distance of points, mm.
pub const LEAST_STEP: f64 = 1.0;
/// The greatest height, mm.
pub const MOST_HEIGHT: f64 = 25.0;
/// Greatest slope between neighbouring points.
pub const MOST_SLOPE: f64 = 0.25;
/// Greatest skew factor: more than six degrees are no machine's skew but a measurement gone wrong.
pub const MOST_SKEW: f64 = 0.1;

/// Reason for which a compensation is not put in force. The previous compensation stays in force.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub enum CompensationError {
    /// Only possible while nothing moves and nothing is queued.
    Busy,
    /// Points along X or Y: 2 to [`MOST_SIDE`].
    Count,
    /// The first point is not a place.
    Place,
    /// More points along a side than its interpolation has.
    Interpolation {
        /// Most points along a side.
        most: usize,
    },
    /// Points lie nearer than [`LEAST_STEP`].
    Spacing,
    /// The height of this point, counted from 0, is no number.
    NotMeasured {
        /// Index of the point, from 0.
        point: usize,
    },
    /// The height of this point is beyond [`MOST_HEIGHT`].
    TooHigh {
        /// Index of the point, from 0.
        point: usize,
    },
    /// The slope from its neighbour to this point is beyond [`MOST_SLOPE`].
    TooSteep {
        /// Index of the point, from 0.
        point: usize,
    },
    /// The plane is steeper than [`MOST_SLOPE`].
    PlaneSteep,
    /// The plane is beyond [`MOST_HEIGHT`] at the origin.
    PlaneHigh,
    /// Fading must end above where it begins.
    FadeOrder,
    /// Fading must take at least this many mm for heights as great as these.
    FadeShort {
        /// Least length of the fading, mm.
        least_mm: f32,
    },
    /// A skew factor is beyond [`MOST_SKEW`].
    Skew,
}

impl core::fmt::Display for CompensationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Busy => f.write_str("the machine is moving"),
            Self::Count => write!(f, "a grid has 2 to {MOST_SIDE} points along X and along Y"),
            Self::Interpolation { most } => {
                write!(f, "this interpolation takes at most {most} points along X and along Y: see [bed mesh]")
            }
            Self::Place => f.write_str("the grid begins nowhere: its first point is not a number"),
            Self::Spacing => write!(f, "points of a grid must be at least {LEAST_STEP} mm apart"),
            Self::NotMeasured { point } => write!(f, "the height of point {} is not a number", point + 1),
            Self::TooHigh { point } => write!(f, "point {} is more than {MOST_HEIGHT} mm off", point + 1),
            Self::TooSteep { point } => write!(
                f,
                "the bed rises by more than {} % between point {} and the one before it: measure again",
                MOST_SLOPE * 100.0,
                point + 1
            ),
            Self::PlaneSteep => write!(f, "the plane rises by more than {} %: measure again", MOST_SLOPE * 100.0),
            Self::PlaneHigh => write!(f, "the plane is more than {MOST_HEIGHT} mm off at X0 Y0"),
            Self::FadeOrder => f.write_str("fading must end above the height at which it begins"),
            Self::FadeShort { least_mm } => {
                write!(f, "with heights as great as these, fading must take at least {least_mm:.1} mm")
            }
            Self::Skew => write!(f, "a skew factor lies between -{MOST_SKEW} and {MOST_SKEW}"),
        }
    }
}
